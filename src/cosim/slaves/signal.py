"""A variable as the master sees it, and what values it takes."""

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Literal

from gyro_cosim.component.units import Unit

from ..systems.quantities import Quantity, meaning, parsed

Type = Literal["real", "integer", "boolean", "enumeration", "string", "binary"]
Text = str | bytes  # of a string, of a binary
Scalar = float | Text
Given = str | float | bool | bytes | Quantity | Sequence[str | float | bool | bytes]  # what a system may say
Value = Scalar | tuple[Scalar, ...]  # what a slave is told

_TRUTH = {"true": 1.0, "1": 1.0, "false": 0.0, "0": 0.0}


@dataclass(frozen=True)
class Signal:
    """A variable as the master sees it: numbers in `unit` (empty where the component states none).

    smooth : may be extrapolated; where False (integers, booleans, enumerations, discrete reals) it is always held.
    type : integers, booleans and enumerations are carried as numbers, exact in float64.
    definition : what `unit` means where the component says so itself; else component.units knows it, or nobody does.
    items : names and numbers of an enumeration. shape : of an array, which takes as many values; () for a scalar.
    display : the unit in which people read it, where the component says one. nominal : its usual size.
    """

    name: str
    kind: Literal["input", "output", "parameter", "state"]
    unit: str = ""
    start: float | None = None
    min: float | None = None
    max: float | None = None
    meaning: str = ""
    smooth: bool = True
    type: Type = "real"
    definition: Unit | None = None
    items: tuple[tuple[str, int], ...] = ()
    shape: tuple[int, ...] = ()
    display: str = ""
    nominal: float | None = None

    @property
    def measure(self) -> Unit | None:
        """What its unit means; None where nothing is known of it."""
        return meaning(self.unit, self.definition)

    def value(self, given: Given) -> Value:
        """`given`, a number, text with an optional unit, ..., in the signal's unit and checked against its bounds.

        An array takes a sequence, or text with blanks between the elements; one value serves them all.
        """
        if not self.shape:
            return self._scalar(given)
        if isinstance(given, str) and self.type != "string":
            given = given.split()
        elements = [given] if isinstance(given, str | float | int | bytes | Quantity) else list(given)
        size = math.prod(self.shape)
        if len(elements) == 1:
            elements *= size
        if len(elements) != size:
            raise ValueError(f"must have {size} values ({' x '.join(map(str, self.shape))}), got {len(elements)}")
        return tuple(self._scalar(element) for element in elements)

    def _scalar(self, given: object) -> Scalar:
        if self.type == "string":
            if not isinstance(given, str):
                raise ValueError(f"must be text, got {given!r}")
            return given
        if self.type == "binary":
            try:
                return given if isinstance(given, bytes) else bytes.fromhex(str(given))
            except ValueError:
                raise ValueError(f"must be bytes in hexadecimal digits, got {given!r}") from None
        if self.type == "real":
            return self._bounded(self._number(given), given)
        names = dict(self.items)
        if isinstance(given, str) and self.type == "enumeration" and given in names:
            return float(names[given])
        if isinstance(given, str) and self.type == "boolean":
            if given.strip().lower() not in _TRUTH:
                raise ValueError(f"must be true or false, got {given!r}")
            return _TRUTH[given.strip().lower()]
        try:
            number = self._number(given)
        except ValueError:
            if self.type == "enumeration":
                raise ValueError(f"must be one of {', '.join(names) or 'the numbers of its type'}, got {given!r}") from None
            raise
        if not number.is_integer() or (self.type == "boolean" and number not in (0.0, 1.0)):
            rule = {"boolean": "true or false", "integer": "a whole number", "enumeration": "an item or its number"}[self.type]
            raise ValueError(f"must be {rule}, got {given}")
        if abs(number) > 2.0**53:
            raise ValueError(f"must be at most 2^53 in size to be carried exactly, got {given}")
        if names and number not in names.values():
            raise ValueError(f"must be one of {', '.join(f'{n} ({k})' for n, k in self.items)}, got {given}")
        return self._bounded(number, given)

    def _number(self, given: object) -> float:
        if isinstance(given, bytes) or not isinstance(given, str | float | int | Quantity):
            raise ValueError(f"must be a number, got {given!r}")
        unit = self.measure
        if isinstance(given, str):
            given = parsed(given, self.unit, unit)
        return given.expressed(unit) if isinstance(given, Quantity) else float(given)

    def _bounded(self, number: float, given: object) -> float:
        shown = number if isinstance(given, Quantity) else given
        unit = "" if self.unit in ("", "1") else f" {self.unit}"
        if not math.isfinite(number):
            raise ValueError(f"must be finite, got {shown}")
        if self.min is not None and number < self.min:
            raise ValueError(f"must be at least {self.min:g}{unit}, got {shown}")
        if self.max is not None and number > self.max:
            raise ValueError(f"must be at most {self.max:g}{unit}, got {shown}")
        return number


FAR = 5.0  # times the usual size, or less than this part of it


def told_unit(signal: Signal, given: object) -> str:
    """What a number without a unit means in the unit in which people read it, where it looks as if that one was meant.

    It does where the number is more than FAR times away from the usual size (the start value, else the nominal one) and
    would be nearer to it in the display unit. Empty otherwise, and where a unit was written.

    Parameters
    ----------
    signal : Signal
        What gets the value.
    given : object
        A number, or its text.
    """
    try:
        number = float(given) if isinstance(given, str | int | float) and not isinstance(given, bool) else 0.0
    except ValueError:
        return ""  # with a unit, or no number
    usual = abs(signal.start or signal.nominal or 0.0)
    own, shown = signal.measure, meaning(signal.display) if signal.display not in ("", signal.unit) else None
    if not number or not usual or own is None or shown is None or own.dimension != shown.dimension:
        return ""
    factor = shown.factor / own.factor
    away, meant = (abs(math.log(abs(value) / usual)) for value in (number, number * factor))
    if away <= math.log(FAR) or meant >= away:
        return ""
    return f"{number:g} {signal.unit} = {number / factor:.5g} {signal.display}"
