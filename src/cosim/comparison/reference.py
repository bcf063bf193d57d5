"""Does a run agree with a reference? Signal by signal within a band: yes, no, or it cannot be decided.

At every time of the reference the run's signal must come as near as a share of the reference's largest value, at that time or,
where the band has a width in time, at most so much earlier or later. At a time that the reference holds twice, a jump, either
value counts.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from gyro_cosim.component.units import quantity

from ..systems import System
from ..systems.quantities import between, meaning
from ..systems.series import read_table
from ..trajectory import Trajectory

REST = 1e-9  # what never exceeds this is at rest


@dataclass(frozen=True)
class Band:
    """What a signal may differ by.

    Parameters
    ----------
    share : float
        Of the reference's largest value.
    time : float
        Either way, s.
    """

    share: float = 1e-3
    time: float = 0.0

    def __post_init__(self) -> None:
        if not (0.0 < self.share < float("inf") and 0.0 <= self.time < float("inf")):
            raise ValueError(f"a band must have a positive share and no negative time, got {self.share:g} and {self.time:g} s")

    @classmethod
    def of(cls, text: str) -> "Band":
        """The band in "1e-3", "0.1 %" or "1e-3, 5 ms"."""
        words = text.split(",")
        if len(words) > 2:
            raise ValueError(f"a band must be SHARE or SHARE,TIME, got {text!r}")
        return cls(quantity(words[0], "1"), quantity(words[1], "s") if len(words) == 2 else 0.0)


@dataclass(frozen=True)
class Agreement:
    """How a signal agrees with its reference.

    Parameters
    ----------
    name, unit : str
        Of the signal.
    distance : float
        The largest distance to the reference beyond its width in time, over the reference's largest value.
    at : float
        Where that is, s.
    inside : bool
        Whether it stays within the band.
    """

    name: str
    unit: str
    distance: float
    at: float
    inside: bool


@dataclass(frozen=True)
class Judgement:
    """A run against a reference.

    Parameters
    ----------
    signals : tuple of Agreement
        Of all signals that both have.
    missing : tuple of str
        Names of the reference that the run has no signal of.
    span : (float, float)
        From when to when they could be compared, s.
    undecided : str
        Why it cannot be decided, or empty.
    """

    signals: tuple[Agreement, ...]
    missing: tuple[str, ...]
    span: tuple[float, float]
    undecided: str = ""

    @property
    def verdict(self) -> bool | None:
        """Whether the run agrees; None where that cannot be decided."""
        if any(not signal.inside for signal in self.signals):
            return False
        return None if self.undecided else True


def read_reference(file: str | Path, system: System) -> Mapping[str, tuple[np.ndarray, np.ndarray, str]]:
    """Signal -> times (s), values and unit (empty where none is stated) of a .csv file; of one component by `variable` alone."""
    t, names, units, values = read_table(file, f"reference {str(file)!r}")
    if not names:
        raise ValueError(f"reference {str(file)!r} must have a column besides time")
    return {system.full(n): (t, values[:, k], u) for k, (n, u) in enumerate(zip(names, units, strict=True))}


def judged(run: Trajectory, reference: Mapping[str, tuple[np.ndarray, np.ndarray, str]], band: Band) -> Judgement:
    """Compare a run with a reference.

    Parameters
    ----------
    run : Trajectory
        The results.
    reference : mapping
        As read_reference() gives it.
    band : Band
        What they may differ by.
    """
    found: list[Agreement] = []
    missing = tuple(name for name in reference if name not in run.names)
    moves, span = False, (float(run.t[0]), float(run.t[-1]))
    for name, (t, values, unit) in reference.items():
        if name in missing:
            continue
        values = _in_unit(values, unit, run.unit(name), name)
        slack = 1e-9 * (span[1] - span[0])
        common = (t >= span[0] - slack) & (t <= span[1] + slack)
        span_of = t[common]
        if not span_of.size or span_of[-1] <= span_of[0]:
            return Judgement(
                tuple(found), missing, span, f"the reference of {name} and the run have less than two times in common"
            )
        found.append(_agreement(name, run, t[common], values[common], band))
        moves = moves or float(np.ptp(values[common])) > REST or float(np.ptp(np.interp(t[common], run.t, run[name]))) > REST
    times = [t for name, (t, _, _) in reference.items() if name not in missing]
    if times:
        span = max(span[0], float(times[0][0])), min(span[1], float(times[0][-1]))
    why = "" if moves else "no signal in common moves" if found else "the run has none of the reference's signals"
    return Judgement(tuple(found), missing, span, why)


def _in_unit(values: np.ndarray, unit: str, own: str, name: str) -> np.ndarray:
    if not unit or unit == own:
        return values
    try:
        factor, offset = between(meaning(unit), meaning(own))
    except ValueError as error:
        raise ValueError(f"reference of {name}: {error}") from None
    return values * factor + offset


def _agreement(name: str, run: Trajectory, t: np.ndarray, values: np.ndarray, band: Band) -> Agreement:
    own = run[name]
    size = float(np.abs(values).max())
    size = size if size > REST else max(float(np.abs(own).max()), REST)
    low, high = _hull(run.t, own, t, band.time)
    distance = np.maximum(np.maximum(low - values, values - high), 0.0)
    distance[np.isnan(distance)] = np.inf
    same = np.flatnonzero(np.diff(t) == 0.0)
    for k in same:  # either side of a jump will do
        distance[k] = distance[k + 1] = min(distance[k], distance[k + 1])
    worst = int(np.argmax(distance))
    share = float(distance[worst]) / size
    quiet = float(np.abs(own).max()) <= REST and float(np.abs(values).max()) <= REST
    return Agreement(name, run.unit(name), share, float(t[worst]), quiet or share <= band.share)


def _hull(own_t: np.ndarray, own: np.ndarray, t: np.ndarray, width: float) -> tuple[np.ndarray, np.ndarray]:
    """Least and largest value of a signal within `width` (s) of each t, in lines between its points."""
    middle = np.interp(t, own_t, own)
    if not width:
        return middle, middle.copy()
    ends = np.array([np.interp(t - width, own_t, own), middle, np.interp(t + width, own_t, own)])
    low, high = ends.min(axis=0), ends.max(axis=0)
    first, last = np.searchsorted(own_t, t - width), np.searchsorted(own_t, t + width, "right")
    for k in np.flatnonzero(last > first):
        inside = own[first[k] : last[k]]
        low[k], high[k] = min(low[k], inside.min()), max(high[k], inside.max())
    return low, high


def in_words(judgement: Judgement, file: str, band: Band, most: int = 10) -> Sequence[str]:
    """The judgement in words, signals outside first."""
    width = f", {band.time:g} s either way" if band.time else ""
    words = {True: "yes", False: "no", None: "cannot be decided"}[judgement.verdict]
    outside = [s for s in sorted(judgement.signals, key=lambda s: -s.distance) if not s.inside]
    lines = [f"  {s.name}: {s.distance:.3g} of the largest value away, at t = {s.at:.6g} s" for s in outside[:most]]
    if len(outside) > most:
        lines.append(f"  and {len(outside) - most} more")
    if judgement.missing:
        lines.append(f"  not in the run: {', '.join(judgement.missing[:most])}")
    of = f"{len(judgement.signals)} signals from t = {judgement.span[0]:g} s to {judgement.span[1]:g} s"
    why = f": {judgement.undecided}" if judgement.verdict is None else ""
    return [f"agrees with {file} within {band.share:g} of the largest value{width} ({of})? {words}{why}", *lines]
