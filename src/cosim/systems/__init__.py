"""Where a system is described, and where its components come from.

plan            a system: components, connections, values; it loads nothing
catalogue       what is installed: components, systems, exporters
archive         files from elsewhere, which are not trusted
quantities      what units and types two signals may have to be joined
"""

from .plan import Connection, Conversion, Exchange, Port, PowerBond, StopWhen, System, SystemComponent

__all__ = ["Connection", "Conversion", "Exchange", "Port", "PowerBond", "StopWhen", "System", "SystemComponent"]
