"""A table of our numbers beside others'."""

import re
from dataclasses import dataclass

__all__ = ["Line", "Quantity", "Table"]


@dataclass(frozen=True)
class Quantity:
    """A quantity with its unit, how it is written, and by how much we may differ.

    within : in the quantity's unit, or of their value where `relative`.
    """

    name: str
    form: str
    within: float
    relative: bool = False


@dataclass(frozen=True)
class Line:
    """One case: for each quantity (ours, theirs); `within` where it is not the table's."""

    what: str
    pairs: tuple[tuple[float, float], ...]
    within: tuple[float, ...] = ()


@dataclass(frozen=True)
class Table:
    """Where the numbers are from, what is compared, the cases; `compact` writes ours / theirs into one cell."""

    source: str
    quantities: tuple[Quantity, ...]
    lines: tuple[Line, ...]
    compact: bool = False

    def misses(self) -> list[str]:
        """What differs by more than it may, one text each."""
        found = []
        for line in self.lines:
            limits = line.within or tuple(q.within for q in self.quantities)
            for q, (ours, theirs), within in zip(self.quantities, line.pairs, limits, strict=True):
                if not abs(ours - theirs) <= within * (abs(theirs) if q.relative else 1.0):
                    found.append(f"{line.what}: {q.name} must be {theirs:{q.form}} within {within:g}, got {ours:{q.form}}")
        return found

    def markdown(self) -> str:
        """The source, and a table: for each quantity ours, theirs, the difference."""
        heads = ["case", *(head for q in self.quantities for head in self._heads(q))]
        rows = [[line.what, *(c for q, pair in zip(self.quantities, line.pairs, strict=True) for c in self._cells(q, *pair))]
                for line in self.lines]  # fmt: skip
        drawn = (f"| {' | '.join(row)} |" for row in (heads, ["---"] * len(heads), *rows))
        return "\n".join([f"Theirs: {self.source}.", "", *drawn]) + "\n"

    def _heads(self, q: Quantity) -> list[str]:
        if self.compact:
            return [f"{q.name}: ours / theirs"]
        return [f"{q.name}: ours" if q.name else "ours", "theirs", "difference"]

    def _cells(self, q: Quantity, ours: float, theirs: float) -> list[str]:
        if self.compact:
            return [f"{ours:{q.form}} / {theirs:{q.form}}"]
        apart = f"{100 * (ours - theirs) / theirs:+.2f} %" if q.relative else f"{ours - theirs:+{q.form}}"
        return [f"{ours:{q.form}}", f"{theirs:{q.form}}", re.sub(r"^[+-](0\.?0*)( %)?$", r"\1\2", apart)]
