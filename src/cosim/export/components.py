"""The components of a system that becomes one FMU: what each is, and whether the kernel can run them."""

from dataclasses import dataclass
from typing import cast

import numpy as np

from ..network import Network
from ..slaves import SlaveDescription
from ..slaves.exchange.slave import ExchangeSlave
from ..slaves.fmi.clocks import time_based
from ..slaves.fmi.description import Description, read
from ..slaves.fmi.fmu import FmuSlave
from ..slaves.fmi.rows import Row
from ..slaves.fmi.signals import by_variable, described
from ..slaves.fmi.structure import STRUCTURAL
from ..slaves.fmi.unpacked import FmuCache
from ..slaves.signal import Scalar
from ..systems import System

__all__ = ["Packed", "packed", "refuse_what_the_kernel_cannot"]

GIVEN = ("Real", "Float64", "Integer", "Int32", "Boolean", "String", "Enumeration")


@dataclass(frozen=True, eq=False)
class Packed:
    """A component as the FMU of the system holds it.

    Parameters
    ----------
    name : str
        What the system calls it.
    location : str
        Of its FMU, `FILE` or `ARCHIVE#MEMBER`.
    linked : bool
        Its sources are compiled in; else its FMU is carried as a file.
    model : Description
        Of its FMU.
    slave : SlaveDescription
        The same as the master sees it.
    given : tuple of (Row, number or text)
        What the system gives it before it starts.
    connected : tuple of int
        Places among its inputs of those that something is connected to.
    """

    name: str
    location: str
    linked: bool
    model: Description
    slave: SlaveDescription
    given: tuple[tuple[Row, Scalar], ...]
    connected: tuple[int, ...]

    @property
    def feeds_through(self) -> bool:
        """Whether an output depends directly on a connected input."""
        return bool(self.slave.feedthrough[:, list(self.connected)].any())

    @property
    def unconnected(self) -> tuple[int, ...]:
        """Places among its inputs of the others."""
        return tuple(int(j) for j in np.setdiff1d(np.arange(len(self.slave.inputs)), self.connected))


def packed(system: System, network: Network) -> tuple[Packed, ...]:
    """The components of `system`, wired as `network` is.

    Parameters
    ----------
    system : System
        What is packed.
    network : Network
        Its slaves, opened.

    Returns
    -------
    tuple of Packed
        In the order of the system.

    Raises
    ------
    ValueError
        A value is given to a variable that the FMU cannot hand on.
    """
    cache = FmuCache()
    found = []
    for i, component in enumerate(system.components):
        location = cache.location(component.source)
        model = read(location)
        if model.version == "1":
            rule = "must be an FMU of FMI 2.0 or 3.0 to be packed into one"
            raise ValueError(f"component {component.name!r} {rule}, {component.source!r} is of FMI 1.0")
        given: list[tuple[Row, Scalar]] = []
        for row, values in by_variable({row.name: row for row in model.rows}, network.values[i]):
            if row.causality == STRUCTURAL:
                rule = "a packed system must leave structural parameters as they are, this one is given a value"
                raise ValueError(f"{component.name}.{row.name}: {rule}")
            if row.shape or row.type not in GIVEN:
                kind = f"array of {row.type}" if row.shape else row.type
                rule = f"values of a packed system must be of {', '.join(GIVEN)}"
                raise ValueError(f"{component.name}.{row.name}: {rule}, this is {kind}")
            given.append((row, cast(Scalar, values[0])))
        connected = tuple(wire[1] for wire in network.wires(i))
        linked = not component.source.endswith(".fmu")
        found.append(Packed(component.name, location, linked, model, described(model), tuple(given), connected))
    return tuple(found)


def refuse_what_the_kernel_cannot(system: System, network: Network) -> None:
    """ValueError, in one line, for a system that the inner loop cannot run as it is.

    Parameters
    ----------
    system : System
        What is packed.
    network : Network
        Its slaves, opened.

    Raises
    ------
    ValueError
        Names the component, the rule and what it has instead.
    """
    what = f"system {system.name!r} as one FMU"
    for component in system.components:
        if component.source.startswith(("process:", "tcp://")):
            raise ValueError(f"{what}: every component must be an FMU or come from one, {component.name!r} is {component.source}")
    for slave in network.slaves:
        if isinstance(slave, ExchangeSlave):
            rule = "every component must run by Co-Simulation, for the whole holds no integrator"
            raise ValueError(f"{what}: {rule}, {slave.name!r} runs by Model Exchange")
        own = time_based(slave.model) if isinstance(slave, FmuSlave) and slave.description.counts_events else []
        if own:
            raise ValueError(f"{what}: nothing ticks clocks in it, {slave.name!r} has {own[0].name!r}")
    if network.clocks:
        raise ValueError(f"{what}: nothing ticks clocks in it, some are connected")
    network.refuse_loops()
    if not network.one_pass:
        raise ValueError(f"{what}: outputs must be consistent after one evaluation of each component, they need more")
    if network.tabled:
        raise ValueError(f"{what}: connections must be factors and offsets, one is a mapping table")
    if network.held.size:
        name = network.names[int(network.held[0])]
        raise ValueError(f"{what}: outputs must be continuous, {name} is held between its changes")
    for slave in network.slaves:
        for signal in (*slave.inputs, *slave.outputs):
            if signal.type != "real" or signal.name.endswith("]"):
                kind = "an element of an array" if signal.name.endswith("]") else signal.type
                raise ValueError(f"{what}: inputs and outputs must be real scalars, {slave.name}.{signal.name} is {kind}")
