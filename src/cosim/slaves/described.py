"""A slave that only says what it is: to look at a system without loading the code of its FMUs."""

from collections.abc import Mapping, Sequence
from types import MappingProxyType

import numpy as np

from ..systems import catalogue
from .base import Clocked, Slave
from .description import SlaveDescription
from .signal import Given, Value
from .tick import Tick


class DescribedSlave(Clocked):
    """Has a description and cannot run."""

    def __init__(self, name: str, description: SlaveDescription) -> None:
        self.name, self.description = name, description

    def begin(self, values: Mapping[str, Value], t: float, stop: float) -> None:
        """Never."""
        raise self._asleep()

    def finish(self) -> None:
        """Never."""
        raise self._asleep()

    def output(self, u: np.ndarray, t: float) -> np.ndarray:
        """Never."""
        raise self._asleep()

    def step(self, U: np.ndarray, t: float, h: float) -> None:
        """Never."""
        raise self._asleep()

    def expect(self, ticks: Sequence[Tick]) -> None:
        """Never."""
        raise self._asleep()

    def take_ticks(self) -> Sequence[Tick]:
        """Never."""
        raise self._asleep()

    def close(self) -> None:
        """Nothing is held."""

    def _asleep(self) -> RuntimeError:
        return RuntimeError(f"component {self.name!r} is only described here, it cannot run")


def described_slave(
    name: str, source: str, implementation: str = "", values: Mapping[str, Given] = MappingProxyType({})
) -> Slave:
    """The slave `name` of a source as far as it can be told without running foreign code.

    Parameters
    ----------
    name : str
        What it is called.
    source : str
        An FMU, of which modelDescription.xml is read and no binary is loaded, a unit elsewhere, which is asked, or a catalogue
        name, whose component is made.
    implementation : str
        The interface of an FMU; else the one that it runs by.
    values : mapping
        What it is given; structural parameters among it decide on sizes of arrays.
    """
    if source.startswith(("process:", "tcp://")):
        from .processes.remote import RemoteSlave

        return RemoteSlave(name, source)
    if source.endswith(".fmu"):
        from .exchange.abilities import integrated
        from .fmi.description import read
        from .fmi.signals import described
        from .fmi.structure import configured

        model = configured(read(source, implementation), name, values)
        return DescribedSlave(name, integrated(described(model), model) if model.exchanged else described(model))
    from .in_process import ComponentSlave

    return ComponentSlave(name, catalogue.component(source))
