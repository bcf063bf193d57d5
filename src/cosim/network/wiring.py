"""A system's connections and values beside its slaves: arrays taken apart, connectors compared, what fits nothing refused."""

from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np

from ..errors import WiringError, unknown
from ..slaves import Slave, Value
from ..systems import Connection, System, SystemComponent
from .joining import article, fail

_KIND_OF_TYPE = {
    "Real": "real", "Float64": "real", "Float32": "real", "Boolean": "boolean", "String": "string", "Binary": "binary",
    "Enumeration": "enumeration", "Clock": "clock",
}  # fmt: skip


def connections(system: System, slaves: Sequence[Slave]) -> list[Connection]:
    """The system's connections, with those of whole arrays taken apart: y -> u means y[1] -> u[1] and so on.

    An array is a variable of FMI 3.0, or all variables of FMI 2.0 that are called `y[1]`, `y[2]`, ... or `y[1,1]`, ...
    """
    arrays: list[dict[tuple[str, str], dict[tuple[int, ...], str]]] = []
    for end in ("outputs", "inputs"):
        elements: dict[tuple[str, str], dict[tuple[int, ...], str]] = {}
        for slave in slaves:
            for signal in (*getattr(slave, end), *getattr(slave.description, f"text_{end}")):
                base, place = element(signal.name)
                if place:
                    elements.setdefault((slave.name, base), {})[place] = signal.name
        arrays.append(elements)
    if not any(arrays):
        return list(system.connections)
    wires = []
    for wire in system.connections:
        starts, ends = arrays[0].get(wire.start), arrays[1].get(wire.end)
        if starts is None and ends is None:
            wires.append(wire)
            continue
        shapes = [_shape(found) for found in (starts, ends)]
        if starts is None or ends is None or shapes[0] != shapes[1]:
            fail(wire, f"arrays must have the same shape, got {shapes[0]} and {shapes[1]}")
        for a, b in zip(sorted(starts), sorted(ends), strict=True):
            wires.append(replace(wire, start=(wire.start[0], starts[a]), end=(wire.end[0], ends[b])))
    return wires


def element(name: str) -> tuple[str, tuple[int, ...]]:
    """The array's name and the place of an element in it, of `y[1,2]` y and (1, 2); no place where it is no element."""
    base, bracket, inside = name.removesuffix("]").rpartition("[")
    if not (name.endswith("]") and bracket and base):
        return name, ()
    try:
        return base, tuple(int(index) for index in inside.split(","))
    except ValueError:
        return name, ()


def _shape(elements: Mapping[tuple[int, ...], str] | None) -> str:
    """In words, such as "2 x 3"."""
    if elements is None:
        return "a scalar"
    sizes = [str(len(set(places))) for places in zip(*elements, strict=False)]
    return " x ".join(sizes) if len(elements) == np.prod([int(n) for n in sizes]) else f"{len(elements)} elements"


def check_ports(part: SystemComponent, slave: Slave) -> None:
    """WiringError where the component behind a connector is not what the system file says of it."""
    d = slave.description
    signals = {"input": (*d.inputs, *d.text_inputs), "output": (*d.outputs, *d.text_outputs)}
    clocks = {"input": d.clock_inputs, "output": d.clock_outputs}
    named = (*d.clock_inputs, *d.clock_outputs, *(k for k, kind in d.excluded.items() if kind.startswith("Clock")))
    own = list(dict.fromkeys(named))
    for name, port in part.ports.items():
        where = f"connector {part.name}.{name}"
        for clock in port.clocks:
            if clock not in own:
                raise unknown(f"clock of {where}:", clock, own)
            if name in d.clocked and clock not in d.clocked[name]:
                raise WiringError(f"{where} must have the clocks {', '.join(d.clocked[name])}, the system file says {clock}")
        if name in d.excluded or (name in clocks.get(port.kind, ()) and port.type in ("", "Clock")):
            continue  # what is excluded is refused where it is connected
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
            raise WiringError(f"{where} must be {article(signal.type)} as in the FMU, the system file says {port.type}")
        if port.unit is not None and signal.measure is not None and port.unit.dimension != signal.measure.dimension:
            raise WiringError(f"{where} must have a unit that fits {signal.unit!r}, the system file says {port.unit.name!r}")


def refuse_excluded(wire: Connection, end: int, slave: Slave) -> None:
    """WiringError for a connection to something that takes no part in connections."""
    component, variable = (wire.start, wire.end)[end]
    kind = slave.description.excluded.get(variable)
    if kind is not None:
        fail(wire, f"{component}.{variable} is a {kind}, which takes no part in connections")
    if variable in (slave.description.clock_outputs, slave.description.clock_inputs)[end]:
        fail(wire, f"types must fit: {component}.{variable} is a clock, the other end is none")
    texts = (slave.description.text_outputs, slave.description.text_inputs)[end]
    if text := next((s for s in texts if s.name == variable), None):
        fail(wire, f"types must fit: {component}.{variable} is a {text.type}, the other end is none")


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


def sub_steps(slaves: Sequence[Slave], given: Mapping[str, int]) -> list[int]:
    """In how many parts each slave does a macro step; ValueError for what is given wrongly."""
    known = [s.name for s in slaves]
    for name, parts in given.items():
        if name not in known:
            raise unknown("component with sub-steps:", name, known)
        if parts < 1 or parts != int(parts):
            raise ValueError(f"sub-steps of {name!r} must be a whole number of at least 1, got {parts!r}")
    return [int(given.get(name, 1)) for name in known]


def sequence(slaves: Sequence[Slave], names: Sequence[str]) -> tuple[int, ...]:
    """The places of the slaves that are named, which must be all."""
    known = [s.name for s in slaves]
    for name in names:
        if name not in known:
            raise unknown("component in the sequence:", name, known)
    if sorted(names) != sorted(known):
        raise ValueError(f"sequence must name every component once, got {','.join(names)} for {','.join(known)}")
    return tuple(known.index(name) for name in names)
