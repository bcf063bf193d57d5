"""From a system's connections to numbers: which signals fit one another, and how the inputs of a slave follow from outputs."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from types import MappingProxyType
from typing import NoReturn

import numpy as np

from gyro_cosim.component.units import Unit

from ..errors import WiringError, unknown
from ..slaves import Signal, Slave, Value
from ..systems import Connection, System, SystemComponent
from ..systems.courses import Course
from ..systems.quantities import between

# What each type accepts besides itself; all of it exact.
_WIDER = {"real": ("integer",), "integer": ("enumeration",), "enumeration": ("integer",)}
_KIND_OF_TYPE = {
    "Real": "real", "Float64": "real", "Float32": "real", "Boolean": "boolean", "String": "string", "Binary": "binary",
    "Enumeration": "enumeration",
}  # fmt: skip


@dataclass(frozen=True)
class Transfer:
    """An input is factor * output + offset, or, where there is a table, the number that the table gives for the output."""

    factor: float = 1.0
    offset: float = 0.0
    table: Mapping[float, float] | None = None


def transfer(wire: Connection, a: Signal, b: Signal) -> Transfer:
    """How the value of output `a` becomes that of input `b`; WiringError where types or units do not fit."""
    start, end = ".".join(wire.start), ".".join(wire.end)
    tables = [dict(hop.table) for hop in wire.conversions if hop.table]
    if tables:
        return Transfer(table=_composed(tables, wire, start, end, a, b))
    if a.type != b.type and a.type not in _WIDER.get(b.type, ()):
        raise WiringError(f"types must fit: {start} is {_article(a.type)}, {end} {_article(b.type)}")
    _refuse_unknown_units(wire, a, b)
    factor, offset, present = 1.0, 0.0, a.measure

    def turn(target: Unit | None) -> None:
        nonlocal factor, offset, present
        if target is None:
            return
        try:
            scale, shift = between(present, target)
        except ValueError:
            was = present.name if present is not None else a.unit
            raise WiringError(f"units must fit: {start} is in {was!r}, {end} in {target.name!r}") from None
        factor, offset, present = factor * scale, offset * scale + shift, target

    for hop in wire.conversions:
        turn(hop.start)
        target = b.measure if hop.end is None and hop is wire.conversions[-1] else hop.end
        if hop.suppress:
            present = target
        else:
            turn(target)
        if (hop.factor, hop.offset) != (1.0, 0.0):
            if a.type != "real":
                _fail(wire, f"a linear transformation must be of a real, {start} is {_article(a.type)}")
            factor, offset = factor * hop.factor, offset * hop.factor + hop.offset
    turn(b.measure)
    return Transfer(factor, offset)


def _refuse_unknown_units(wire: Connection, a: Signal, b: Signal) -> None:
    """Two units that differ must both be known, unless the connection says that none is to be converted."""
    stated = (
        (a.measure, b.measure)
        if not wire.conversions
        else (a.measure or wire.conversions[0].start, b.measure or wire.conversions[-1].end)
    )
    if a.unit and b.unit and a.unit != b.unit and None in stated and not any(hop.suppress for hop in wire.conversions):
        nobody = a.unit if stated[0] is None else b.unit
        _fail(wire, f"unknown unit {nobody!r}, and the units differ ({a.unit!r}, {b.unit!r})")


def _article(kind: str) -> str:
    return f"{'an' if kind[0] in 'aei' else 'a'} {kind}"


def _fail(wire: Connection, why: str) -> NoReturn:
    raise WiringError(f"connection {'.'.join(wire.start)} -> {'.'.join(wire.end)}: {why}")


def _composed(
    tables: Sequence[dict[float, float]], wire: Connection, start: str, end: str, a: Signal, b: Signal
) -> dict[float, float]:
    for signal, name in ((a, start), (b, end)):
        if signal.type not in ("boolean", "integer", "enumeration"):
            raise WiringError(f"connection {start} -> {end}: a mapping must be of whole numbers, {name} is {signal.type}")
    if any((hop.factor, hop.offset) != (1.0, 0.0) for hop in wire.conversions):
        raise WiringError(f"connection {start} -> {end}: mappings and linear transformations must not be mixed")
    found = tables[0]
    for table in tables[1:]:
        found = {source: table[middle] for source, middle in found.items() if middle in table}
    return found


def connections(system: System, slaves: Sequence[Slave]) -> list[Connection]:
    """The system's connections, with those of whole arrays taken apart: y -> u means y[1] -> u[1] and so on."""
    elements: dict[tuple[str, str], list[str]] = {}
    for slave in slaves:
        for signal in (*slave.inputs, *slave.outputs):
            if signal.name.endswith("]"):
                elements.setdefault((slave.name, signal.name[: signal.name.rindex("[")]), []).append(signal.name)
    if not elements:
        return list(system.connections)
    wires = []
    for wire in system.connections:
        starts, ends = elements.get(wire.start), elements.get(wire.end)
        if starts is None and ends is None:
            wires.append(wire)
            continue
        sizes = [len(names) if names else 1 for names in (starts, ends)]
        if starts is None or ends is None or sizes[0] != sizes[1]:
            _fail(wire, f"arrays must have the same number of elements, got {sizes[0]} and {sizes[1]}")
        for a, b in zip(starts or (), ends or (), strict=True):
            wires.append(replace(wire, start=(wire.start[0], a), end=(wire.end[0], b)))
    return wires


def check_ports(part: SystemComponent, slave: Slave) -> None:
    """WiringError where the component behind a connector is not what the system file says of it."""
    signals = {"input": slave.inputs, "output": slave.outputs}
    for name, port in part.ports.items():
        where = f"connector {part.name}.{name}"
        if name in slave.description.excluded:
            continue  # refused where it is connected
        if port.kind not in signals:
            signal = slave.description.settable.get(name)
        else:
            matching = [s for s in signals[port.kind] if s.name == name or s.name.startswith(f"{name}[")]
            if not matching:
                other = "output" if port.kind == "input" else "input"
                if any(s.name == name for s in signals[other]):
                    raise WiringError(f"{where} must be an {other} as in the FMU, the system file says {port.kind}")
                raise unknown(f"{port.kind} of {part.name!r} ({part.source}):", name, [s.name for s in signals[port.kind]])
            signal = matching[0]
        if signal is None:
            continue
        kind = _KIND_OF_TYPE.get(port.type, "integer") if port.type else signal.type
        if kind != signal.type:
            raise WiringError(f"{where} must be {_article(signal.type)} as in the FMU, the system file says {port.type}")
        if port.unit is not None and signal.measure is not None and port.unit.dimension != signal.measure.dimension:
            raise WiringError(f"{where} must have a unit that fits {signal.unit!r}, the system file says {port.unit.name!r}")


def refuse_excluded(wire: Connection, end: int, slave: Slave) -> None:
    """WiringError for a connection to something that takes no part in connections."""
    component, variable = (wire.start, wire.end)[end]
    kind = slave.description.excluded.get(variable)
    if kind is not None:
        _fail(wire, f"{component}.{variable} is a {kind}, which takes no part in connections")


def start_inputs(slave: Slave, values: Mapping[str, Value]) -> np.ndarray:
    """What the inputs have where nothing drives them, shape (n_u,): given values, of an array as a whole too, or their own."""
    start = []
    for signal in slave.inputs:
        given = values.get(signal.name, signal.start or 0.0)
        base = signal.name[: signal.name.rindex("[")] if signal.name.endswith("]") else ""
        if signal.name not in values and base in values:
            whole = values[base]
            elements = [s.name for s in slave.inputs if s.name.startswith(f"{base}[")]
            given = whole[elements.index(signal.name)] if isinstance(whole, tuple) else whole
        start.append(given)
    return np.array(start, dtype=float)


class Inputs:
    """How the inputs of one slave follow from all outputs.

    joined : (place in Y, place in u, factor, offset) of each connected input; factor 1, offset 0 where a table is in between.
    tables : place in u -> table of the inputs that have one.
    start : shape (n_u,), what unconnected inputs keep.
    courses : place in u -> what an unconnected input follows instead.
    """

    def __init__(
        self, wires: Sequence[tuple[int, int, Transfer]], start: np.ndarray, courses: Mapping[int, Course] = MappingProxyType({})
    ) -> None:
        self._wires, self.courses = tuple(wires), courses
        self.joined = [(k, j, t.factor, t.offset) for k, j, t in wires]
        self.tables = {j: t.table for _, j, t in wires if t.table is not None}
        self.start = start
        self._source, self._into = _slice([wire[0] for wire in wires]), _slice([wire[1] for wire in wires])
        self._scale, self._offset = np.array([w[2] for w in self.joined]), np.array([w[3] for w in self.joined])
        self._scaled, self._shifted = bool((self._scale != 1.0).any()), bool(self._offset.any())
        self._followed = tuple(courses.items())
        self._whole = len(wires) == start.size and not self._shifted and not self.tables
        self._template = np.vstack([start, np.zeros((2, start.size))])

    def following(self, courses: Mapping[int, Course]) -> "Inputs":
        """The same with courses, by place in u."""
        return Inputs(self._wires, self.start, courses) if courses else self

    def altered(self, changes: Mapping[int, tuple[float, float]]) -> "Inputs":
        """The same with connected inputs, by place in u, made factor * what comes + value."""
        wires = []
        for k, j, given in self._wires:
            factor, value = changes.get(j, (1.0, 0.0))
            table = None if factor == 0.0 else given.table
            wires.append((k, j, Transfer(given.factor * factor, given.offset * factor + value, table)))
        return Inputs(wires, self.start, self.courses)

    def at_rest(self, t: float) -> np.ndarray:
        """What unconnected inputs are at t (s), shape (n_u,)."""
        u = self.start.copy()
        for j, course in self._followed:
            u[j] = course.at(t)
        return u

    def of(self, C: np.ndarray, t: float = 0.0, h: float = 0.0) -> np.ndarray:
        """U, shape (m, n_u), from C, shape (m, n_Y), m = 1 (values only) or 3, over h (s) from t (s) on.

        No -0.0 is in it: a derivative that is zero must not differ from one that is not set."""
        part = C[:, self._source]
        if self._scaled:
            part = part * self._scale
        part = part + 0.0  # not a view, either: the caller may keep it
        if self._whole:
            return part
        U = self._template[: len(C)].copy()
        U[:, self._into] = part
        if self._shifted:
            U[0, self._into] += self._offset
        for j, course in self._followed:
            if len(C) > 1 and h > 0.0:
                U[0, j], U[1, j] = course.over(t, h)
            else:
                U[0, j] = course.at(t)
        for j, table in self.tables.items():
            if U[0, j] not in table:
                raise WiringError(f"a mapping between connectors must have an entry for {U[0, j]:g}")
            U[0, j] = table[U[0, j]]
        return U


def _slice(places: list[int]) -> slice | np.ndarray:
    """`places` as a slice where they follow one another, which numpy serves without copying."""
    if places and places == list(range(places[0], places[0] + len(places))):
        return slice(places[0], places[0] + len(places))
    return np.array(places, dtype=int)
