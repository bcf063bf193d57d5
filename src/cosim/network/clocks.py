"""Ticks on their way from component to component: each at its own time, with the values that change with it.

A component steps before those whose clocks it ticks, so that they hear of a tick in the step in which it happens. Where clocks
tick one another in a circle, somebody has stepped already: that tick comes at the beginning of the next step.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from ..errors import WiringError
from ..slaves import Slave, Tick, clocked
from ..systems import Connection
from .inputs import Inputs
from .loops import strong_components


@dataclass(frozen=True)
class ClockWire:
    """From the output clock `start` of slave `source` to the input clock `end` of slave `into`."""

    source: int
    start: str
    into: int
    end: str


class ClockWires:
    """The connections between clocks; true where there are any.

    wires : by the place where they end, (component, variable); those of clocks are taken out of it, their values stay.

    """

    def __init__(self, slaves: Sequence[Slave], wires: dict[tuple[str, str], Connection]) -> None:
        self._slaves, place = slaves, {s.name: i for i, s in enumerate(slaves)}
        found: list[ClockWire] = []
        everything = dict(wires)
        for i, slave in enumerate(slaves):
            for name in slave.description.clock_inputs:
                wire = wires.pop((slave.name, name), None)
                if wire is not None:
                    _refuse_unheard(wire, slave)
                    found.append(ClockWire(_source(wire, slaves, place), wire.start[1], i, name))
        self._from: dict[int, list[ClockWire]] = {}
        for one in found:
            self._from.setdefault(one.source, []).append(one)
        self._drives = {(one.source, one.into): _driven(one.source, one.into, slaves, everything) for one in found}
        self._needs = {i: [one.source for one in found if one.into == i] for i in range(len(slaves))}

    def __bool__(self) -> bool:
        return bool(self._from)

    def ordered(self, order: Sequence[int]) -> tuple[int, ...]:
        """All slaves in this order, but those that tick clocks before those that have them."""
        return tuple(i for group in strong_components(order, self._needs) for i in group) if self else tuple(order)

    def late(self, order: Sequence[int]) -> list[str]:
        """To be told: the connections whose ticks come with the next step where slaves step in this order."""
        rank = {i: k for k, i in enumerate(order)}
        return [
            f"connection {self._spelled(one)}: clocks tick one another in a circle, these ticks come at the communication point "
            "that follows"
            for some in self._from.values()
            for one in some
            if rank[one.source] >= rank[one.into]
        ]

    def _spelled(self, one: ClockWire) -> str:
        return f"{self._slaves[one.source].name}.{one.start} -> {self._slaves[one.into].name}.{one.end}"

    def begin(self) -> None:
        """A run begins: from now on ticks are noted."""
        for i, some in self._from.items():
            slave = clocked(self._slaves[i])
            for one in some:
                if slave is None or clocked(self._slaves[one.into]) is None:
                    raise WiringError(f"connection {self._spelled(one)}: clocks tick in event mode, which the FMU refuses")
            if slave is not None:
                slave.take_ticks()

    def pass_on(self, i: int, inputs: Sequence[Inputs], slices: Sequence[slice]) -> None:
        """What slave i has ticked, to those whose clocks these are. inputs, slices : of each slave, as in the network."""
        if i not in self._from:
            return
        source = clocked(self._slaves[i])
        assert source is not None
        for tick in source.take_ticks():
            for k in dict.fromkeys(one.into for one in self._from[i]):
                clocks = tuple(one.end for one in self._from[i] if one.into == k and one.start in tick.clocks)
                receiver = clocked(self._slaves[k])
                if clocks and receiver is not None:
                    numbers, texts = self._drives[i, k]
                    by_clock = receiver.description.clocked
                    places = [j for j, name in numbers.items() if set(clocks) & set(by_clock[name])]
                    told = {end: tick.texts[start] for end, start in texts.items() if set(clocks) & set(by_clock[end])}
                    Y = np.zeros(slices[-1].stop)
                    Y[slices[i]] = tick.y
                    receiver.expect([Tick(tick.t, clocks, (), tuple(inputs[k].some(places, Y, tick.t)), told)])


def _source(wire: Connection, slaves: Sequence[Slave], place: Mapping[str, int]) -> int:
    """The slave whose clock a connection begins at."""
    start, end = ".".join(wire.start), ".".join(wire.end)
    i = place[wire.start[0]]
    if wire.start[1] not in slaves[i].description.clock_outputs:
        raise WiringError(f"connection {start} -> {end}: {end} is a clock, {start} must be an output clock and is none")
    _refuse_unheard(wire, slaves[i])
    return i


def _refuse_unheard(wire: Connection, slave: Slave) -> None:
    if clocked(slave) is None:
        start, end = ".".join(wire.start), ".".join(wire.end)
        raise WiringError(f"connection {start} -> {end}: clocks of {slave.name!r} cannot be connected, since it runs elsewhere")


def _driven(
    source: int, into: int, slaves: Sequence[Slave], wires: Mapping[tuple[str, str], Connection]
) -> tuple[dict[int, str], dict[str, str]]:
    """The clocked inputs of one slave that another feeds: place in u -> name, and text input -> text output."""
    name, d = slaves[into].name, slaves[into].description
    fed = {end for (owner, end), wire in wires.items() if owner == name and wire.start[0] == slaves[source].name}
    numbers = {j: s.name for j, s in enumerate(d.inputs) if s.name in d.clocked and s.name in fed}
    texts = {s.name: wires[name, s.name].start[1] for s in d.text_inputs if s.name in d.clocked and s.name in fed}
    return numbers, texts
