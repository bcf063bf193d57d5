"""Slaves: components between communication points. The master cannot tell one kind from another."""

from cosim import catalogue
from cosim.slaves.base import RawFmi2, Signal, Slave

__all__ = ["RawFmi2", "Signal", "Slave", "open_fmu", "open_slave"]


def open_slave(name: str, source: str, *, in_process: bool = False, isolate: bool = False) -> Slave:
    """The slave `name` for a source: an FMU file, or a catalogue name whose FMU is built when it is needed.

    With `in_process` a component of the catalogue runs in this process instead; an FMU file stays an FMU.
    With `isolate` an FMU runs in a process of its own, and cannot take this one down.
    """
    if source.endswith(".fmu"):
        return _isolated(name, source) if isolate else open_fmu(name, source)
    if in_process:
        from cosim.slaves.in_process import ComponentSlave

        return ComponentSlave(name, catalogue.component(source))
    location = str(catalogue.fmu(source))
    return _isolated(name, location) if isolate else open_fmu(name, location)


def _isolated(name: str, location: str) -> Slave:
    from cosim.slaves.isolated import IsolatedSlave

    return IsolatedSlave(name, location)


def open_fmu(name: str, location: str) -> Slave:
    """The slave `name` for the FMU at `location`, `FILE` or `ARCHIVE#MEMBER`; ValueError if it cannot be used."""
    from cosim.slaves.description import read
    from cosim.slaves.fmi2 import Fmi2Slave
    from cosim.slaves.fmi3 import Fmi3Slave

    description = read(location)
    return (Fmi3Slave if description.version == "3" else Fmi2Slave)(name, location, description)
