"""Where a system is described, and where its components come from.

plan            a system: components, connections, values; it loads nothing
elements        what it is made of
catalogue       what is installed: components, systems, exporters
archive         files from elsewhere, which are not trusted
courses         known functions of time: what follows a time series or a ramp
series          time series of a file as inputs
riding          what of a unit's inertia its carrier holds
scenario        what happens during a run by plan
quantities      what units and types two signals may have to be joined
"""

from .elements import Connection, Conversion, Exchange, Port, PowerBond, StopWhen, SystemComponent
from .plan import System
from .scenario import Event, Scenario
from .series import InputSeries

__all__ = [
    "Connection", "Conversion", "Event", "Exchange", "InputSeries", "Port", "PowerBond", "Scenario", "StopWhen", "System",
    "SystemComponent",
]  # fmt: skip
