"""Where a system is described, and where its components come from.

plan            a system: components, connections, values; it loads nothing
catalogue       what is installed: components, systems, exporters
archive         files from elsewhere, which are not trusted
quantities      what units and types two signals may have to be joined
"""

from .plan import Connection, Hop, Part, Port, PowerBond, StopWhen, System

__all__ = ["Connection", "Hop", "Part", "Port", "PowerBond", "StopWhen", "System"]
