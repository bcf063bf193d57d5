"""Whether an output fits an input, and what number becomes of it there: types, units, transformations, tables."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import NoReturn

from gyro_cosim.component.units import Unit

from ..errors import WiringError, unknown
from ..slaves import Signal
from ..systems import Connection, Conversion
from ..systems.quantities import between

# What each type accepts besides itself; all of it exact.
_WIDER = {"real": ("integer",), "integer": ("enumeration",), "enumeration": ("integer",)}
_NUMBERS = {"real", "integer", "boolean", "enumeration"}


@dataclass(frozen=True)
class Transfer:
    """An input is factor * output + offset, or, where there is a table, the number that the table gives for the output.

    whole : the input, where it is an integer, enumeration or boolean and takes the nearest whole number.
    """

    factor: float = 1.0
    offset: float = 0.0
    table: Mapping[float, float] | None = None
    whole: Signal | None = None


def transfer(wire: Connection, a: Signal, b: Signal) -> Transfer:
    """How the value of output `a` becomes that of input `b`; WiringError where types or units do not fit."""
    start, end = ".".join(wire.start), ".".join(wire.end)
    if any(hop.items for hop in wire.conversions):
        return Transfer(table=_named(wire, start, end, a, b))
    tables = [dict(hop.table) for hop in wire.conversions if hop.table]
    if tables:
        return Transfer(table=_composed(tables, wire, start, end, a, b))
    whole = None
    if a.type != b.type and a.type not in _WIDER.get(b.type, ()):
        if not _NUMBERS.issuperset((a.type, b.type)) or not any(_linear(hop) for hop in wire.conversions):
            hint = "; a LinearTransformation can join them" if _NUMBERS.issuperset((a.type, b.type)) else ""
            raise WiringError(f"types must fit: {start} is {article(a.type)}, {end} {article(b.type)}{hint}")
        whole = b if b.type != "real" else None
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
            whole = b if b.type != "real" else None
            factor, offset = factor * hop.factor, offset * hop.factor + hop.offset
    turn(b.measure)
    return Transfer(factor, offset, whole=whole)


def _linear(hop: Conversion) -> bool:
    return hop.explicit or (hop.factor, hop.offset) != (1.0, 0.0)


def _refuse_unknown_units(wire: Connection, a: Signal, b: Signal) -> None:
    """Two units that differ must both be known, unless the connection says that none is to be converted."""
    stated = (
        (a.measure, b.measure)
        if not wire.conversions
        else (a.measure or wire.conversions[0].start, b.measure or wire.conversions[-1].end)
    )
    if a.unit and b.unit and a.unit != b.unit and None in stated and not any(hop.suppress for hop in wire.conversions):
        nobody = a.unit if stated[0] is None else b.unit
        fail(wire, f"unknown unit {nobody!r}, and the units differ ({a.unit!r}, {b.unit!r})")


def article(kind: str) -> str:
    return f"{'an' if kind[0] in 'aei' else 'a'} {kind}"


def fail(wire: Connection, why: str) -> NoReturn:
    raise WiringError(f"connection {'.'.join(wire.start)} -> {'.'.join(wire.end)}: {why}")


def _composed(
    tables: Sequence[dict[float, float]], wire: Connection, start: str, end: str, a: Signal, b: Signal
) -> dict[float, float]:
    if a.type not in _NUMBERS - {"real"}:
        raise WiringError(f"connection {start} -> {end}: a mapping must be of whole numbers, {start} is {article(a.type)}")
    if b.type not in _NUMBERS:
        raise WiringError(f"connection {start} -> {end}: a mapping must be to numbers, {end} is {article(b.type)}")
    if any(_linear(hop) for hop in wire.conversions):
        raise WiringError(f"connection {start} -> {end}: mappings and linear transformations must not be mixed")
    found = tables[0]
    for table in tables[1:]:
        found = {source: table[middle] for source, middle in found.items() if middle in table}
    for target in found.values() if b.type != "real" else ():
        try:
            b.value(target)
        except ValueError as error:
            raise WiringError(f"connection {start} -> {end}: a mapping's target {error}") from None
    return found


def _named(wire: Connection, start: str, end: str, a: Signal, b: Signal) -> dict[float, float]:
    """The table of numbers of a mapping from items of one enumeration to those of another."""
    for signal, name in ((a, start), (b, end)):
        if signal.type != "enumeration":
            fail(wire, f"a mapping of items must be between enumerations, {name} is {article(signal.type)}")
    if any(hop.table or _linear(hop) for hop in wire.conversions):
        fail(wire, "a mapping of items and other transformations must not be mixed")
    tables = [dict(hop.items) for hop in wire.conversions if hop.items]
    found = tables[0]
    for table in tables[1:]:
        found = {source: table[middle] for source, middle in found.items() if middle in table}
    sources, targets = dict(a.items), dict(b.items)
    for source, target in found.items():
        for item, known, name in ((source, sources, start), (target, targets, end)):
            if item not in known:
                fail(wire, str(unknown(f"item of {name}:", item, known)))
    return {float(sources[source]): float(targets[target]) for source, target in found.items()}
