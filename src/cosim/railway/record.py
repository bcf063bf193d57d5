"""A run as its quantities are judged: on even times up to a derailment, its sections of track, rows and verdicts. SI units."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field

import numpy as np

from ..trajectory import Trajectory
from .assessment import DISTANCE, Assessment
from .filters import CUT_OFF, WINDOW
from .limits import Limits
from .track_sections import Section, sections

__all__ = [
    "EXCEEDED", "HIGH", "KEPT", "LOAD", "OPEN", "RING", "Found", "Record", "Row", "UnfitError", "everywhere", "largest", "median",
    "percentile", "rms", "somewhere", "worst",
]  # fmt: skip

EVERY, LOW, HIGH = 0.5, 0.15, 99.85  # m; percentiles
RING = 2.0 / CUT_OFF  # s from the ends of the record until the low pass has settled
LOAD = "_vertical_force"
KEPT, EXCEEDED, OPEN = "kept", "exceeded", "not decidable"


@dataclass(frozen=True)
class Row:
    """One value.

    Parameters
    ----------
    quantity, statistic, filter
        What it is, such as "Y/Q", "99.85 %", "20 Hz, 2 m".
    section
        Of the track; None for the whole run.
    place, at
        Wheel, pair or body, and where along the track, m; NaN where it stands for all of the section.
    value, unit, limit
        In the unit; NaN for a value that there is not, and for no limit.
    verdict
        "kept", "exceeded", "not decidable", or empty without a limit.
    reason
        Why it is not decidable.
    """

    quantity: str
    statistic: str
    filter: str
    section: Section | None
    place: str
    at: float
    value: float
    unit: str
    limit: float
    verdict: str
    reason: str = ""


class UnfitError(ValueError):
    """A record that no filter can take."""


@dataclass
class Record:
    """A record on even times up to a derailment, its sections, and what was filtered of it."""

    trajectory: Trajectory
    found: Assessment
    limits: Limits
    t: np.ndarray = field(init=False)
    s: np.ndarray = field(init=False)
    parts: tuple[Section, ...] = field(init=False)

    def __post_init__(self) -> None:
        t, vehicle = self.trajectory.t, self.found.vehicle
        end = self.found.verdict.t if self.found.verdict.derailed else t[-1]
        before = t < end if self.found.verdict.derailed else t <= end
        end = t[before][-1] if before.any() else end
        if before.sum() <= 100 or before.sum() <= 3 * CUT_OFF * (end - t[0]):
            rate = before.sum() / max(end - t[0], 1e-9)
            raise UnfitError(f"{before.sum()} points, {rate:.3g} a second, are too few for a low pass of {CUT_OFF:g} Hz")
        if f"{vehicle}.curvature" not in self.trajectory.names:
            raise UnfitError(f"{vehicle}.curvature was not recorded, so there are no sections of track")
        self.t = np.linspace(t[0], end, int(before.sum()))
        self.s = self.signal(DISTANCE)
        if not np.all(np.diff(self.s) > 0.0):
            raise UnfitError("the vehicle did not move forward all the time")
        parts = sections(self.s, self.signal("curvature"))
        lost = self.found.verdict.derailed
        self.parts = (
            *parts[:-1],
            Section(parts[-1].kind, parts[-1].begin, parts[-1].end, parts[-1].curvature, parts[-1].whole and not lost),
        )

    def has(self, *names: str) -> bool:
        return all(f"{self.found.vehicle}.{name}" in self.trajectory.names for name in names)

    def signal(self, name: str) -> np.ndarray:
        return np.asarray(np.interp(self.t, self.trajectory.t, self.trajectory[f"{self.found.vehicle}.{name}"]))

    def within(self, part: Section, ring: float) -> np.ndarray:
        """Which samples lie in a section and `ring` seconds from the ends of the record."""
        here, settled = (
            (self.s >= part.begin) & (self.s <= part.end),
            (self.t >= self.t[0] + ring) & (self.t <= self.t[-1] - ring),
        )
        return np.asarray(here & settled)

    def places(self, part: Section) -> np.ndarray:
        """Every 0.5 m of a section where a window of 2 m lies in it, and in what the low pass has settled on."""
        inside = self.s[self.within(part, RING)]
        if inside.size == 0:
            return np.empty(0)
        return np.arange(max(part.begin, inside[0]) + WINDOW / 2, min(part.end, inside[-1]) - WINDOW / 2 + 1e-9, EVERY)

    def load(self, wheel: str) -> float:
        """Q0, NaN where the record does not begin on straight track."""
        return float(self.signal(wheel + LOAD)[0]) if self.parts[0].kind == "straight" else np.nan

    def judged(
        self, name: tuple[str, str, str], part: Section | None, best: "Found", unit: str, limit: float, open_: str = ""
    ) -> Row:
        """A row; open_: why a value that keeps its limit decides nothing."""
        value = best.value
        if np.isnan(limit) and not open_:
            verdict, reason = "", ""
        elif np.isnan(value) or np.isnan(limit):
            verdict, reason = OPEN, open_ or best.reason
        elif value > limit:
            verdict, reason = EXCEEDED, ""
        elif open_ or (part is not None and not part.whole):
            verdict, reason = OPEN, open_ or "the run ends or begins in it"
        else:
            verdict, reason = KEPT, ""
        return Row(*name, part, best.place, best.at, value, unit, limit, verdict, reason)


@dataclass(frozen=True)
class Found:
    """The worst value of several places."""

    place: str
    at: float
    value: float
    reason: str = "too short"


def worst(
    values: Mapping[str, np.ndarray], at: np.ndarray, size: Callable[[np.ndarray], float], peak: Callable[[np.ndarray], int]
) -> Found:
    """Of signals at the same places: the one whose size is largest; NaN where there is none, or one that is not finite."""
    if at.size == 0:
        return Found("", np.nan, np.nan)
    for place, signal in values.items():
        if not np.all(np.isfinite(signal)):
            return Found(place, np.nan, np.nan, "not finite")
    place = max(values, key=lambda name: size(values[name]))
    return Found(place, float(at[peak(values[place])]), size(values[place]))


def percentile(signal: np.ndarray) -> float:
    return float(np.abs(np.percentile(signal, [LOW, HIGH])).max())


def largest(signal: np.ndarray) -> int:
    return int(np.argmax(np.abs(signal)))


def median(signal: np.ndarray) -> float:
    return abs(float(np.median(signal)))


def rms(signal: np.ndarray) -> float:
    return float(np.sqrt(np.mean(signal**2)))


def somewhere(signal: np.ndarray) -> int:
    return 0


def everywhere(found: Found) -> Found:
    """The same without a place along the track: it stands for all of its section."""
    return Found(found.place, np.nan, found.value, found.reason)
