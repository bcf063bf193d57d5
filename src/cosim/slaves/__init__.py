"""Slaves: components between communication points. The master cannot tell one kind from another."""

from pathlib import Path

from cosim import catalogue
from cosim.slaves.base import Signal, Slave

__all__ = ["Signal", "Slave", "open_slave"]


def open_slave(name: str, source: str, *, in_process: bool = False) -> Slave:
    """The slave `name` for a source: an FMU file, or a catalogue name whose FMU is built when it is needed.

    With `in_process` a component of the catalogue runs in this process instead; an FMU file stays an FMU.
    """
    if source.endswith(".fmu"):
        from cosim.slaves.fmi2 import Fmi2Slave

        return Fmi2Slave(name, Path(source))
    if in_process:
        from cosim.slaves.in_process import ComponentSlave

        return ComponentSlave(name, catalogue.component(source))
    from cosim.slaves.fmi2 import Fmi2Slave

    return Fmi2Slave(name, catalogue.fmu(source))
