"""Strings and binaries on their way from component to component: at communication points, unchanged, never within a step."""

from collections.abc import Callable, Mapping, Sequence
from typing import NoReturn

from ..errors import WiringError
from ..slaves import Signal, Slave, Text, texting
from ..systems import Connection
from .loops import strong_components

ROUNDS = 3  # of texts and numbers at one communication point, where one follows from the other


class TextWires:
    """The connections between texts.

    Parameters
    ----------
    slaves : sequence of Slave
        The components, opened.
    wires : mapping of (str, str) to Connection
        By where they end. Those between texts are taken out.

    Raises
    ------
    WiringError
        Something else than a text, or a text of the other kind, ends or begins one.
    """

    def __init__(self, slaves: Sequence[Slave], wires: dict[tuple[str, str], Connection]) -> None:
        self._slaves = slaves
        outputs = {(s.name, y.name): (i, k, y) for i, s in enumerate(slaves) for k, y in enumerate(s.description.text_outputs)}
        self._into: dict[int, list[tuple[int, int, str]]] = {}  # slave -> source's slave, place among its texts, input's name
        for i, slave in enumerate(slaves):
            for signal in slave.description.text_inputs:
                wire = wires.pop((slave.name, signal.name), None)
                if wire is not None:
                    source, place = _source(wire, signal, outputs, slaves)
                    self._into.setdefault(i, []).append((source, place, signal.name))
        needs = {i: [source for source, _, _ in ends] for i, ends in self._into.items()}
        self._order = [i for group in strong_components(range(len(slaves)), needs) for i in group if i in self._into]

    def __bool__(self) -> bool:
        return bool(self._into)

    def settle(self, t: float, evaluate: Callable[[], object]) -> None:
        """Pass texts on at t (s); where that changes one, `evaluate` the numbers again, a few times at most."""
        for _ in range(ROUNDS if self._into else 0):
            if not self.exchange(t):
                return
            evaluate()

    def exchange(self, t: float) -> bool:
        """Pass every text on once, sources first, at t (s); whether one has changed."""
        changed = False
        for i in self._order:
            told: dict[int, tuple[Text, ...]] = {}
            given: dict[str, Text] = {}
            for source, place, name in self._into[i]:
                if source not in told:
                    slave = texting(self._slaves[source])
                    told[source] = () if slave is None else slave.texts(t)
                given[name] = told[source][place]
            receiver = texting(self._slaves[i])
            changed = (receiver is not None and receiver.give_texts(given, t)) or changed
        return changed


def _source(
    wire: Connection, b: Signal, outputs: Mapping[tuple[str, str], tuple[int, int, Signal]], slaves: Sequence[Slave]
) -> tuple[int, int]:
    """Slave and place among its texts that a connection to the text `b` begins at."""
    start, end = ".".join(wire.start), ".".join(wire.end)
    if wire.start not in outputs:
        others = [y for s in slaves if s.name == wire.start[0] for y in s.outputs if y.name == wire.start[1]]
        if others:
            _refuse(start, others[0], end, b)
        raise WiringError(f"connection {start} -> {end}: it must begin at an output, {start} is none")
    i, place, a = outputs[wire.start]
    if a.type != b.type:
        _refuse(start, a, end, b)
    if any(hop.table or hop.items or hop.explicit or (hop.factor, hop.offset) != (1.0, 0.0) for hop in wire.conversions):
        raise WiringError(f"connection {start} -> {end}: a {a.type} must be passed on as it is, without a transformation")
    return i, place


def _refuse(start: str, a: Signal, end: str, b: Signal) -> NoReturn:
    raise WiringError(f"types must fit: {start} is of type {a.type}, {end} of type {b.type}")
