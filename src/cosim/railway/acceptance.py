"""A run judged as EN 14363 judges a test run: one table of quantities by section of track, each with filter, limit and place. SI.

    Y/Q, sum Y          20 Hz low pass, sliding mean over 2 m every 0.5 m; percentiles 0.15 and 99.85, the larger in size
    Q                   20 Hz low pass; 99.85 %
    unloading           1 - Q / Q0 of the same signal, 99.85 %; the limit is that of twisted track
    Y_qst, Q_qst        in curves: 20 Hz low pass, median; so y''_qst of the car body
    y'', z''            of the car body at its centre of gravity, along and square to its floor: 0.4 to 10 Hz; percentiles, r.m.s.
    stability           sum Y within 2 Hz of its strongest frequency, r.m.s. over 100 m; the limit is half that of sum Y
    T gamma             wear number, mean; has no limit
    N_MV, C_Cy, C_Cz    comfort by EN 12299 over the whole run: mean comfort of 60 windows of 5 s, worst window across, upwards

Of a section only samples count whose window lies within it and whose filter has settled. A value above its limit is *exceeded*
wherever it comes from; one below is *kept* only where the run passed the section whole, else *not decidable*. Behind a derailment
nothing counts.

Q0 is a wheel's load where the record begins, which must be straight track. What is felt along the floor is the derivative of the
velocity across the track, the turning of the track, and gravity's share: y'' = dv_y/dt + kappa s'^2 + g sin(cant + roll).

The standard was not at hand: filters and percentiles are those of a public course page on UIC 518 and EN 14363 (gensys.se), the
limits those for passenger vehicles as the literature gives them. Limits are data (limits.py); give those of your own code.
"""

from dataclasses import dataclass
from typing import Any

import numpy as np

from ..trajectory import Trajectory
from .assessment import Assessment
from .limits import Limits
from .quantities import ALL
from .record import EXCEEDED, KEPT, OPEN, Record, Row, UnfitError

__all__ = ["EXCEEDED", "Acceptance", "judge"]


@dataclass(frozen=True)
class Acceptance:
    """What a run says of one vehicle, quantity by quantity.

    Parameters
    ----------
    vehicle
        Its name.
    rows
        In the order of the module's docstring, section by section.
    """

    vehicle: str
    rows: tuple[Row, ...]

    def count(self, verdict: str) -> int:
        """How many rows have this verdict."""
        return sum(row.verdict == verdict for row in self.rows)

    @property
    def title(self) -> str:
        """In a line."""
        counts = (f"{self.count(KEPT)} limits kept", f"{self.count(EXCEEDED)} exceeded", f"{self.count(OPEN)} not decidable")
        return f"{self.vehicle} by EN 14363 and EN 12299: {', '.join(counts)}"

    @property
    def lines(self) -> list[str]:
        """In words: how many limits are kept, and each that is exceeded."""
        return [self.title, *(f"    exceeded: {_sentence(row)}" for row in self.rows if row.verdict == EXCEEDED)]

    head = ("quantity", "section", "s, m", "value", "limit", "unit", "verdict", "where", "filter")

    @property
    def cells(self) -> list[tuple[str, ...]]:
        """The rows as text, forces in kN."""
        made: list[tuple[str, ...]] = []
        for row in self.rows:
            part, (scale, unit) = row.section, _shown(row)
            section = ("all", "") if part is None else (part.short, f"{part.begin:.0f}..{part.end:.0f}")
            where = row.reason or row.place + (f", {row.at:.1f} m" if row.at == row.at else "")
            values = _number(scale * row.value), _number(scale * row.limit), unit, row.verdict
            made.append((f"{row.quantity} {row.statistic}", *section, *values, where, row.filter))
        return made

    def document(self) -> dict[str, Any]:
        """As JSON holds it: None for NaN."""
        return {"vehicle": self.vehicle, "rows": [_entry(row) for row in self.rows]}


def _shown(row: Row) -> tuple[float, str]:
    """Scale and unit for people: forces in kN, a wear number in N."""
    return (1e-3, "kN") if row.unit == "N" and row.limit == row.limit else (1.0, row.unit.removeprefix("1"))


def _sentence(row: Row) -> str:
    where = f" in the {row.section.words} from {row.section.begin:.1f} to {row.section.end:.1f} m" if row.section else ""
    scale, unit = _shown(row)
    unit = f" {unit}" if unit else ""
    value, limit = _number(scale * row.value), _number(scale * row.limit)
    return f"{row.quantity} ({row.statistic}) {value}{unit}, limit {limit}{unit}, {row.place}{where}"


def _entry(row: Row) -> dict[str, Any]:
    part = row.section
    begin, end, words = (None, None, "all") if part is None else (part.begin, part.end, part.words)
    return {
        "quantity": row.quantity, "statistic": row.statistic, "filter": row.filter,
        "section": words, "from_m": begin, "to_m": end, "place": row.place, "at_m": _finite(row.at),
        "value": _finite(row.value), "limit": _finite(row.limit), "unit": row.unit, "verdict": row.verdict, "reason": row.reason,
    }  # fmt: skip


def _number(value: float) -> str:
    return f"{value:.3g}" if value == value else ""


def _finite(value: float) -> float | None:
    return value if np.isfinite(value) else None


def judge(trajectory: Trajectory, found: Assessment, limits: Limits | None = None) -> Acceptance:
    """Judge a run.

    Parameters
    ----------
    trajectory
        Of the run.
    found
        What `assess` found of the vehicle in it.
    limits
        Those of the standard otherwise.

    Returns
    -------
    Acceptance
        A quantity whose signals were not recorded, or too coarsely for its filter, has one row, not decidable, that says so.
    """
    try:
        run = Record(trajectory, found, limits or Limits())
    except UnfitError as error:
        return Acceptance(found.vehicle, (Row("all", "", "", None, "", np.nan, np.nan, "", np.nan, OPEN, str(error)),))
    rows: list[Row] = []
    for part in ALL:
        rows += part(run)
    return Acceptance(found.vehicle, tuple(rows))
