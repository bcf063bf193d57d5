"""A table of a vehicle file, read key by key: each has a unit and a rule; what nobody has asked for is unknown.

Every refusal is one line: file, key, rule, value.
"""

import difflib
import math
import re
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from typing import Any

from gyro_cosim.component import Variable, parameter
from gyro_cosim.component.units import quantity, unit

from .values import ZERO, Value, formula, is_literal

__all__ = ["Book", "Section", "Vector"]

_NAME = re.compile(r"[A-Za-z][A-Za-z0-9_]*")
_REQUIRED: Any = object()


@dataclass(frozen=True)
class Vector:
    """Values along x, y and z."""

    x: Value
    y: Value
    z: Value

    def of(self, s: Mapping[str, Any]) -> tuple[Any, Any, Any]:
        """The three, for numbers or symbols of the parameters."""
        return self.x.of(s), self.y.of(s), self.z.of(s)

    @property
    def is_zero(self) -> bool:
        """Whether all three are the constant 0."""
        return self.x.is_zero and self.y.is_zero and self.z.is_zero


class Book:
    """A file while it is read: its name for messages, and the rows of the parameters found so far, by name."""

    def __init__(self, file: str) -> None:
        self.file = file
        self.rows: dict[str, Variable] = {}

    def error(self, key: str, rule: str, value: Any = _REQUIRED) -> ValueError:
        """The refusal of a key."""
        return ValueError(f"{self.file}: {key} {rule}" + ("" if value is _REQUIRED else f", got {value!r}"))

    def unknown(self, key: str, what: str, name: str, known: Iterable[str]) -> ValueError:
        """The refusal of a name that is not there, with the nearest one that is."""
        names = sorted(known)
        near = difflib.get_close_matches(name, names, 1)
        hint = f"did you mean {near[0]!r}?" if near else f"known: {', '.join(names) or 'none'}"
        return ValueError(f"{self.file}: {key}: unknown {what} {name!r}; {hint}")

    def add(self, key: str, row: Variable) -> None:
        """Take a parameter in; refuses a second one of that name."""
        if row.name in self.rows:
            raise self.error(key, f"makes a parameter {row.name!r}, which is there already: rename one")
        self.rows[row.name] = row

    def number(self, value: Value) -> float:
        """A value at the start."""
        return float(value.of({name: row.start for name, row in self.rows.items()}))

    def section(self, path: str, data: Any, *, prefix: str = "", source: str = "vehicle file") -> "Section":
        """A table at `path`; parameters that its literals make are called `prefix`_key."""
        return Section(self, path, data, prefix, source)


class Section:
    """One table. Keys are taken by `text`, `value`, `vector`, ...; `end` refuses what is left."""

    def __init__(self, book: Book, path: str, data: Any, prefix: str, source: str) -> None:
        if not isinstance(data, dict):
            raise book.error(path, "must be a table", data)
        self.book, self.path, self.data, self.prefix = book, path, data, prefix
        self.asked: set[str] = set()
        self.taken: dict[str, Any] = {}
        self.inherited: dict[str, Any] = {}
        self.source = self.text("source", source)
        self.what = self.text("meaning", prefix.replace("_", " "))

    def has(self, key: str) -> bool:
        """Whether the key is given."""
        self.asked.add(key)
        return key in self.data or key in self.inherited

    def inherit(self, other: "Section") -> None:
        """What this table does not say is as the other one, read before, has it: the same parameters."""
        self.inherited = {key: value for key, value in other.taken.items() if key not in ("source", "meaning", "like")}

    def key(self, name: str) -> str:
        """A key's whole path."""
        return f"{self.path}.{name}" if self.path else name

    def error(self, name: str, rule: str, value: Any = _REQUIRED) -> ValueError:
        """The refusal of a key of this table."""
        return self.book.error(self.key(name), rule, value)

    def text(self, name: str, default: str = _REQUIRED, among: Iterable[str] | None = None) -> str:
        """A text, one of `among` where that is given."""
        given = self._given(name, default)
        if not isinstance(given, str):
            raise self.error(name, "must be a text", given)
        if among is not None and given not in among and given is not default:
            raise self.book.unknown(self.key(name), "choice", given, among)
        return given

    def flag(self, name: str, default: bool) -> bool:
        """true or false."""
        given = self._given(name, default)
        if not isinstance(given, bool):
            raise self.error(name, "must be true or false", given)
        return given

    def count(self, name: str, default: int, most: int) -> int:
        """A whole number from 0 to `most`."""
        given = self._given(name, default)
        if isinstance(given, bool) or not isinstance(given, int) or not 0 <= given <= most:
            raise self.error(name, f"must be a whole number from 0 to {most}", given)
        return given

    def names(self, name: str, default: list[str] = _REQUIRED) -> list[str]:
        """A list of texts."""
        given = self._given(name, default)
        if not isinstance(given, list) or not all(isinstance(one, str) for one in given):
            raise self.error(name, "must be a list of names", given)
        return given

    def value(self, name: str, unit_: str, *, least: float | None = None, above: float | None = None,
              default: Value = _REQUIRED, meaning: str = "", under: str = "") -> Value:  # fmt: skip
        """A literal or a formula in the unit `unit_` (SI), at least `least` or above `above` at the start."""
        given = self._given(name, default)
        if isinstance(given, Value):
            return given
        value = self._read(name, given, unit_, least if least is not None else above, meaning, under)
        self._check(name, value, given, unit_, least, above)
        self.taken[name] = value
        return value

    def vector(self, name: str, unit_: str, axes: str = "xyz", *, needed: str = "", least: float | None = None,
               above: float | None = None, names: Mapping[str, str] | None = None) -> Vector:  # fmt: skip
        """A table { x = ..., y = ..., z = ... } of some axes; those not given are 0, those in `needed` must be."""
        table = self._given(name, {} if not needed else _REQUIRED)
        if isinstance(table, Vector):
            return table
        part = self._part(name, table)
        values = {}
        for axis in axes:
            if axis in needed and axis not in table:
                raise part.error(axis, "must be given")
            under = (names or {}).get(axis, f"{name}_{axis}")
            values[axis] = part.value(axis, unit_, least=least, above=above, default=ZERO, meaning=f"along {axis}", under=under)
        part.asked -= {"source", "meaning"}
        part.end()
        found = Vector(*(values.get(axis, ZERO) for axis in "xyz"))
        self.taken[name] = found
        return found

    def table(self, name: str, keys: Iterable[str]) -> "Section":
        """A table in this one, of some keys, which the caller takes; parameters of its literals have this one's names."""
        part = self._part(name, self._given(name, {}))
        for key in part.data:
            if key not in keys:
                raise self.book.unknown(self.key(name), "key", key, keys)
        return part

    def pairs(self, name: str) -> Any:
        """A list of pairs, or None where it is not given."""
        given = self._given(name, None)
        if given is None or not isinstance(given, list):
            if given is None or type(given).__name__ == "Curve":
                return given
            raise self.error(name, "must be a list of pairs", given)
        if not all(isinstance(one, list) and len(one) == 2 for one in given):
            raise self.error(name, "must be a list of pairs", given)
        return given

    def reading(self, name: str, given: Any, unit_: str, under: str, meaning: str) -> Value:
        """A literal or formula that stands in a list under `name`; its parameter is called `under`."""
        return self._read(name, given, unit_, None, meaning, under)

    def _part(self, name: str, data: Any) -> "Section":
        part = Section(self.book, self.key(name), data, "", self.source)
        part.prefix, part.what = self.prefix, f"{self.what}: {name.replace('_', ' ')}" if self.what else name
        return part

    def end(self) -> None:
        """Refuse keys that nobody has asked for."""
        for name in self.data:
            if name not in self.asked:
                raise self.book.unknown(self.path or "file", "key", name, self.asked)

    def _given(self, name: str, default: Any) -> Any:
        self.asked.add(name)
        if name not in self.data and default is _REQUIRED and name not in self.inherited:
            raise self.error(name, "must be given")
        self.taken[name] = self.data.get(name, self.inherited.get(name, default))
        return self.taken[name]

    def _read(self, name: str, given: Any, unit_: str, least: float | None, meaning: str, under: str) -> Value:
        if isinstance(given, int | float) and not isinstance(given, bool):
            if given != 0 and unit_ != "1":
                raise self.error(name, f'must have a unit, such as "{given:g} {unit_}"', given)
            given = repr(given) if unit_ == "1" else "0"
            if given in ("0", "0.0"):
                return ZERO
        if not isinstance(given, str):
            raise self.error(name, f'must be a text such as "1 {unit_}"', given)
        if is_literal(given):
            own = "_".join(part for part in (self.prefix, under or name) if part)
            row = self._row(name, own, given, unit_, least, meaning or name.replace("_", " "))
            self.book.add(self.key(name), row)
            return formula(own)
        try:
            value = formula(given)
        except ValueError as error:
            raise self.error(name, str(error), given) from None
        for used in value.names:
            if used not in self.book.rows:
                raise self.book.unknown(self.key(name), "parameter", used, self.book.rows)
        try:
            dimension = value.dimension({used: self.book.rows[used].unit for used in value.names})
        except ValueError as error:
            raise self.error(name, str(error), given) from None
        if not value.is_zero and dimension != (*unit(unit_).dimension[:-1], 0):
            raise self.error(name, f"must be in {unit_}", given)
        return value

    def _row(self, name: str, own: str, given: str, unit_: str, least: float | None, meaning: str) -> Variable:
        number, used = self.measured(name, given, unit_)
        what = f"{self.what}: {meaning}" if self.what else meaning
        display = used if used not in ("", unit_) else None
        low = least if least is not None and number >= least else None
        return parameter(own, number, unit_, what, source=self.source, min=low, display_unit=display)

    def measured(self, name: str, given: str, unit_: str) -> tuple[float, str]:
        """(number in SI, unit as written) of a literal."""
        bare = re.fullmatch(r"\s*[-+0-9.eE]+\s*", given) is not None
        try:
            number = quantity(given, unit_)
        except ValueError as error:
            raise self.error(name, str(error)) from None
        if bare and unit_ != "1" and number != 0.0:
            raise self.error(name, f'must have a unit, such as "{given.strip()} {unit_}"', given)
        if not math.isfinite(number):
            raise self.error(name, "must be finite", given)
        used = re.sub(r"^\s*[-+]?(\d+\.?\d*|\.\d+)([eE][-+]?\d+)?\s*", "", given).strip()
        return number, used

    def _check(self, name: str, value: Value, given: Any, unit_: str, least: float | None, above: float | None) -> None:
        try:
            number = self.book.number(value)
        except ZeroDivisionError:
            raise self.error(name, "must not divide by 0", given) from None
        shown = "" if unit_ == "1" else f" {unit_}"
        if least is not None and number < least:
            raise self.error(name, f"must be at least {least:g}{shown}", given)
        if above is not None and not number > above:
            raise self.error(name, f"must be more than {above:g}{shown}", given)


def check_name(book: Book, path: str, name: str) -> None:
    """Refuse a name that cannot be part of a signal's name."""
    if not _NAME.fullmatch(name):
        raise book.error(path, "must be a name of letters, digits and _, beginning with a letter", name)
