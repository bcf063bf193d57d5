"""Numbers in units that only a foreign file defines, and how one unit turns into another."""

import math
import re
from dataclasses import dataclass, replace

from gyro_cosim.component.units import BASE, Unit
from gyro_cosim.component.units import unit as known_unit

_QUANTITY = re.compile(r"\s*([-+]?(?:\d+\.?\d*|\.\d+)(?:[eE][-+]?\d+)?|[-+]?inf|[-+]?nan)\s*(\S*)\s*", re.IGNORECASE)


@dataclass(frozen=True)
class Quantity:
    """`factor` times (`value` in `unit`, expressed in the unit of what takes it) + `offset`; unit None: already in it.

    suppressed : the number is taken as it is, whatever the units.
    unknown : name of a unit that nobody defines; such a number fits where no unit is stated, or this one.
    """

    value: float
    unit: Unit | None = None
    factor: float = 1.0
    offset: float = 0.0
    suppressed: bool = False
    unknown: str = ""

    def expressed(self, target: Unit | None) -> float:
        """The number in `target`; ValueError if the units do not fit."""
        if self.unknown and target is not None and target.name != self.unknown and not self.suppressed:
            raise ValueError(f"unit {self.unknown!r} is defined nowhere and cannot be expressed in {target.name!r}")
        factor, offset = (1.0, 0.0) if self.suppressed else between(self.unit, target)
        number = self.value if (factor, offset) == (1.0, 0.0) else self.value * factor + offset
        return number if (self.factor, self.offset) == (1.0, 0.0) else self.factor * number + self.offset

    def through(self, factor: float, offset: float, target: Unit | None, *, suppress: bool = False) -> "Quantity":
        """The same after a connection into something in unit `target` (None: not known yet) with a linear transformation."""
        if target is not None:
            number = factor * (self.value if suppress else self.expressed(target)) + offset
            return Quantity(number, target)
        return replace(
            self, factor=factor * self.factor, offset=factor * self.offset + offset, suppressed=suppress or self.suppressed
        )


def meaning(name: str, definition: Unit | None = None) -> Unit | None:
    """What a unit's name means: its definition where the file gives one, else what the package knows; None: nothing."""
    if definition is not None or not name:
        return definition
    try:
        return known_unit(name)
    except ValueError:
        return None


def defined(name: str, attributes: dict[str, str]) -> Unit:
    """The unit that a BaseUnit element defines: value in SI = factor * value + offset (FMI 2.0 and 3.0, SSP).

    ValueError if it makes none.
    """
    exponents = tuple(int(attributes.get(base, "0")) for base in BASE)
    factor, offset = float(attributes.get("factor", "1")), float(attributes.get("offset", "0"))
    if not (math.isfinite(factor) and factor != 0.0 and math.isfinite(offset)):
        raise ValueError(f"unit {name!r} must have a finite factor other than 0 and a finite offset, got {factor:g}, {offset:g}")
    return Unit(name, factor, exponents, offset)


def between(source: Unit | None, target: Unit | None) -> tuple[float, float]:
    """Factor and offset from one unit to another; 1 and 0 where either is not known. ValueError if they do not fit."""
    if source is None or target is None or source == target:
        return 1.0, 0.0
    if source.dimension != target.dimension:
        raise ValueError(f"unit {source.name!r} cannot be expressed in {target.name!r}")
    if (source.factor, source.offset) == (target.factor, target.offset):
        return 1.0, 0.0
    return source.factor / target.factor, (source.offset - target.offset) / target.factor


def parsed(text: str, name: str, own: Unit | None) -> Quantity:
    """The quantity in `text` ("200rpm", "0.3") for something in the unit called `name`, which means `own`."""
    match = _QUANTITY.fullmatch(text)
    if match is None:
        raise ValueError(f"must be a number, perhaps with a unit, got {text!r}")
    number, given = float(match[1]), match[2]
    if not given or given == name:
        return Quantity(number)
    unit = known_unit(given)
    if own is None and name:
        raise ValueError(f"must be in its own unit {name!r}, of which nothing more is known, got {text!r}")
    return Quantity(number, unit, suppressed=False) if own is not None else _pure(number, unit, text)


def _pure(number: float, unit: Unit, text: str) -> Quantity:
    """A number for something that states no unit: only a pure number fits."""
    if any(unit.dimension):
        raise ValueError(f"must be a plain number, since no unit is stated for it, got {text!r}")
    return Quantity(number * unit.factor)
