"""The slaves of a system, opened and wired: whose output feeds which input, in which unit, in which order."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from itertools import pairwise
from time import perf_counter
from types import TracebackType

import numpy as np

from component.units import compatible, power_pair, unit
from cosim.catalogue import unknown
from cosim.errors import WiringError
from cosim.slaves import Slave
from cosim.system import Connection, PowerBond, System


@dataclass(frozen=True)
class Bond:
    """A power bond in terms of the network: places of its two signals in Y, and of the inputs they feed.

    motion, effort : places in Y; motion times effort is the power into the slave that sends `motion`.
    motion_input, effort_input : (slave, place in its u) that each of them feeds.
    """

    name: str
    motion: int
    effort: int
    motion_input: tuple[int, int]
    effort_input: tuple[int, int]


class _Inputs:
    """How the inputs of one slave follow from all outputs.

    joined : (place in Y, place in u, factor, offset) of each connected input.
    start : shape (n_u,), what unconnected inputs keep.
    """

    def __init__(self, joined: list[tuple[int, int, float, float]], start: np.ndarray) -> None:
        self.joined, self.start = joined, start
        self._source, self._into = _slice([wire[0] for wire in joined]), _slice([wire[1] for wire in joined])
        self._scale, self._offset = np.array([wire[2] for wire in joined]), np.array([wire[3] for wire in joined])
        self._scaled, self._shifted = bool((self._scale != 1.0).any()), bool(self._offset.any())
        self._whole = len(joined) == start.size and not self._shifted
        self._template = np.vstack([start, np.zeros((2, start.size))])

    def of(self, C: np.ndarray) -> np.ndarray:
        """U, shape (m, n_u), from C, shape (m, n_Y), m = 1 (values only) or 3."""
        part = C[:, self._source]
        if self._scaled:
            part = part * self._scale
        if self._whole:
            return part.copy()  # never a view: the caller may keep it
        U = self._template[: len(C)].copy()
        U[:, self._into] = part
        if self._shifted:
            U[0, self._into] += self._offset
        return U


def _slice(places: list[int]) -> slice | np.ndarray:
    """`places` as a slice where they follow one another, which numpy serves without copying."""
    if places and places == list(range(places[0], places[0] + len(places))):
        return slice(places[0], places[0] + len(places))
    return np.array(places, dtype=int)


class Network:
    """Slaves in system order with their wiring. Y, shape (n_Y,), holds the outputs of all slaves one after another.

    names, units : of Y, as `component.variable`.
    slices : the part of Y that belongs to each slave.
    do_step_s : seconds each slave has spent in steps since initialize().
    order : slave indices such that one pass of outputs in this order is consistent, sources before what feeds through.
    """

    def __init__(self, system: System, slaves: Sequence[Slave]) -> None:
        self.system, self.slaves = system, tuple(slaves)
        place = {s.name: i for i, s in enumerate(self.slaves)}
        ends = np.cumsum([0, *(len(s.outputs) for s in self.slaves)])
        self.slices = tuple(slice(int(a), int(b)) for a, b in pairwise(ends))
        self.names = tuple(f"{s.name}.{y.name}" for s in self.slaves for y in s.outputs)
        self.units = tuple(y.unit for s in self.slaves for y in s.outputs)
        self.values = tuple(s.start_values(part.values) for s, part in zip(self.slaves, system.parts, strict=True))
        self._inputs: list[_Inputs] = []
        wires = {c.end: c for c in system.connections}
        self.feeds: dict[int, list[tuple[int, int]]] = {}  # place in Y -> the (slave, place in u) it feeds
        for i, slave in enumerate(self.slaves):
            joined = []
            for j, signal in enumerate(slave.inputs):
                wire = wires.pop((slave.name, signal.name), None)
                if wire is not None:
                    source = self._place(wire, place)
                    self.feeds.setdefault(source, []).append((i, j))
                    joined.append((source, j, *_conversion(wire, self.units[source], signal.unit)))
            start = np.array([self.values[i].get(s.name, s.start or 0.0) for s in slave.inputs])
            self._inputs.append(_Inputs(joined, start))
        for end, _ in wires.items():
            slave = self.slaves[place[end[0]]]
            raise unknown(f"input of {slave.name!r}:", end[1], [s.name for s in slave.inputs])
        self.do_step_s = [0.0] * len(self.slaves)
        self.order = self._evaluation_order()
        self.bonds = self._bonds(place)

    def _place(self, wire: Connection, place: Mapping[str, int]) -> int:
        """Where the source of a connection stands in Y."""
        i = place[wire.start[0]]
        names = [y.name for y in self.slaves[i].outputs]
        if wire.start[1] not in names:
            raise unknown(f"output of {wire.start[0]!r}:", wire.start[1], names)
        return self.slices[i].start + names.index(wire.start[1])

    def inputs(self, i: int, C: np.ndarray) -> np.ndarray:
        """The input polynomial U, shape (m, n_u), of slave i from C, shape (m, n_Y): value and derivatives of all outputs."""
        return self._inputs[i].of(C)

    def wires(self, i: int) -> list[tuple[int, int, float, float]]:
        """The connected inputs of slave i: place in Y of the source, place in u, factor and offset between their units."""
        return self._inputs[i].joined

    def start_inputs(self, i: int) -> np.ndarray:
        """The start values of slave i's inputs, shape (n_u,), which unconnected ones keep."""
        return self._inputs[i].start.copy()

    def outputs(self, Y: np.ndarray, t: float) -> np.ndarray:
        """All outputs at t (s), consistent with the inputs they cause; Y, which may be old, is written in place."""
        row = Y[None, :]  # a view: an output written below is seen by those after it
        for i in self.order:
            Y[self.slices[i]] = self.slaves[i].output(self._inputs[i].of(row)[0], t)
        return Y

    def step(self, i: int, U: np.ndarray, t: float, h: float) -> None:
        """Step slave i from t over h (s) under U, shape (3, n_u); the time it takes is added to `do_step_s`."""
        began = perf_counter()
        self.slaves[i].step(U, t, h)
        self.do_step_s[i] += perf_counter() - began

    def initialize(self, t: float, stop: float) -> np.ndarray:
        """Start every slave at t (s); returns the first Y."""
        self.do_step_s = [0.0] * len(self.slaves)
        for slave, values in zip(self.slaves, self.values, strict=True):
            slave.initialize(values, t, stop)
        return self.outputs(np.zeros(len(self.names)), t)

    def sequence(self, names: Sequence[str] = ()) -> tuple[int, ...]:
        """Slave indices in the order in which Gauss-Seidel steps them: as given, else the order of evaluation."""
        if not names:
            return self.order
        known = [s.name for s in self.slaves]
        for name in names:
            if name not in known:
                raise unknown("component in the sequence:", name, known)
        if sorted(names) != sorted(known):
            raise ValueError(f"sequence must name every component once, got {','.join(names)} for {','.join(known)}")
        return tuple(known.index(name) for name in names)

    def close(self) -> None:
        """Close every slave."""
        for slave in self.slaves:
            slave.close()

    def __enter__(self) -> "Network":
        return self

    def __exit__(self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None) -> None:
        self.close()

    def _evaluation_order(self) -> tuple[int, ...]:
        """Slaves sorted so that whatever feeds through comes after its sources; ties in system order.

        WiringError where signals depend on themselves without delay, with the loop spelled out.
        """
        needs: dict[int, list[int]] = {}  # output -> outputs it depends on directly, through its own slave's inputs
        for source, targets in self.feeds.items():
            for i, j in targets:
                for row in np.flatnonzero(self.slaves[i].feedthrough[:, j]):
                    needs.setdefault(self.slices[i].start + int(row), []).append(source)
        loop = _cycle(needs)
        if loop:
            path = " -> ".join(self.names[k] for k in reversed(loop))
            raise WiringError(f"system {self.system.name!r} must have no algebraic loop, has {path}")
        owner = np.repeat(np.arange(len(self.slaves)), [len(s.outputs) for s in self.slaves])
        after = {int(owner[y]): {int(owner[s]) for s in sources} for y, sources in needs.items()}
        for y, sources in needs.items():
            after[int(owner[y])] |= {int(owner[s]) for s in sources}
        order: list[int] = []
        left = list(range(len(self.slaves)))
        while left:
            ready = next((i for i in left if after.get(i, set()) - {i} <= set(order)), None)
            if ready is None:  # no signal depends on itself, but slaves do: sweep often enough for every chain
                return (*order, *left * (len(left) + 1))
            order.append(ready)
            left.remove(ready)
        return tuple(order)

    def _bonds(self, place: Mapping[str, int]) -> tuple[Bond, ...]:
        """The system's power bonds; where it states none, the pairs of connections whose units leave no doubt."""
        stated = self.system.bonds or _detected(self.system, dict(zip(self.names, self.units, strict=True)))
        bonds = []
        for bond in stated:
            ends = {}
            for role, signal, other in (("motion", bond.motion, bond.effort), ("effort", bond.effort, bond.motion)):
                name = ".".join(signal)
                if name not in self.names:
                    raise unknown("signal of a power bond:", name, self.names)
                k = self.names.index(name)
                target = [t for t in self.feeds.get(k, []) if t[0] == place.get(other[0])]
                if not target:
                    raise WiringError(f"power bond: {role} {name} must be connected to {other[0]!r}")
                ends[role] = (k, target[0])
            (motion, motion_input), (effort, effort_input) = ends["motion"], ends["effort"]
            label = f"{bond.motion[0]}.{bond.motion[1]} x {bond.effort[0]}.{bond.effort[1]}"
            bonds.append(Bond(label, motion, effort, motion_input, effort_input))
        return tuple(bonds)


def _conversion(wire: Connection, source: str, target: str) -> tuple[float, float]:
    """Factor and offset from one unit to the other; none where either side states no unit."""
    if not source or not target or source == target:
        return 1.0, 0.0
    a, b = ".".join(wire.start), ".".join(wire.end)
    try:
        if not compatible(source, target):
            raise WiringError(f"units must fit: {a} is in {source!r}, {b} in {target!r}")
    except WiringError:
        raise
    except ValueError as error:
        raise WiringError(f"connection {a} -> {b}: {error}, and the units differ ({source!r}, {target!r})") from None
    x, y = unit(source), unit(target)
    return x.factor / y.factor, (x.offset - y.offset) / y.factor


def _detected(system: System, units: Mapping[str, str]) -> tuple[PowerBond, ...]:
    """Bonds between two components that are joined by just one connection each way whose units multiply to a power."""
    found = []
    between: dict[tuple[str, str], list[Connection]] = {}
    for wire in system.connections:
        between.setdefault((wire.start[0], wire.end[0]), []).append(wire)
    for (a, b), there in between.items():
        back = between.get((b, a), [])
        if a < b or len(there) != 1 or len(back) != 1:
            continue
        units_of = [units[".".join(wire.start)] for wire in (there[0], back[0])]
        try:
            fits = all(units_of) and power_pair(*units_of)
        except ValueError:  # a foreign unit says nothing
            continue
        if fits:
            motion_first = unit(units_of[0]).dimension[0] == 0  # a motion has no mass in its unit
            motion, effort = (there[0], back[0]) if motion_first else (back[0], there[0])
            found.append(PowerBond(motion.start, effort.start))
    return tuple(found)


def _cycle(needs: Mapping[int, Sequence[int]]) -> list[int]:
    """A cycle of the graph node -> nodes, first and last the same; empty if there is none. Iterative depth-first search."""
    done: set[int] = set()
    for root in needs:
        path, stack = [root], [iter(needs.get(root, ()))]
        while stack and root not in done:
            for node in stack[-1]:
                if node in path:
                    return [*path[path.index(node) :], node]
                if node not in done:
                    path.append(node)
                    stack.append(iter(needs.get(node, ())))
                    break
            else:
                done.add(path.pop())
                stack.pop()
    return []
