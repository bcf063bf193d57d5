"""Where a system is described, and where its components come from.

plan            a system: components, connections, values; it loads nothing
elements        what it is made of
catalogue       what is installed: components, systems, exporters
archive         files from elsewhere, which are not trusted
quantities      what units and types two signals may have to be joined
"""

from .elements import Connection, Conversion, Exchange, Port, PowerBond, StopWhen, SystemComponent
from .plan import System

__all__ = ["Connection", "Conversion", "Exchange", "Port", "PowerBond", "StopWhen", "System", "SystemComponent"]
