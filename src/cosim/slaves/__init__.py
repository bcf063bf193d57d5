"""Slaves: components between communication points. The master cannot tell one kind from another.

base            the interface, with the order of calls; description, signal: the values in it
inner_steps     the steps of a slave's own integrator, where somebody asks for them
opening         from a source to a slave
in_process      a component of this process
fmi/            FMUs
processes/      what runs elsewhere
"""

from .base import (
    Clocked,
    Counts,
    Restorable,
    Serializable,
    Slave,
    StateSpace,
    clocked,
    counts,
    linearisation,
    restorable,
    serializable,
    texting,
    tunable,
)  # fmt: skip
from .description import SlaveDescription
from .inner_steps import InnerSteps, steps_of
from .opening import open_fmu, open_slave
from .signal import Signal, Text, Value
from .tick import Tick

__all__ = [
    "Clocked",
    "Counts",
    "InnerSteps",
    "Restorable",
    "Serializable",
    "Signal",
    "Slave",
    "SlaveDescription",
    "StateSpace",
    "Text",
    "Tick",
    "Value",
    "clocked",
    "counts",
    "linearisation",
    "open_fmu",
    "open_slave",
    "restorable",
    "serializable",
    "steps_of",
    "texting",
    "tunable",
]  # fmt: skip
