"""What a figure of several runs shows, before it is drawn: which lines, in which units, thinned so that no peak is lost."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from gyro_cosim.component.units import compatible, convert

from ..trajectory import Trajectory

MOST_ROWS = 4000  # of a line that are all drawn: an .svg of more is large, and nobody sees them
TIME = "time"


@dataclass(frozen=True, eq=False)
class Line:
    """One line: its run's label, x and y, shape (k,) each; NaN where there is a gap."""

    label: str
    x: np.ndarray
    y: np.ndarray


@dataclass(frozen=True)
class Panel:
    """The lines of one signal, with its name and unit."""

    name: str
    unit: str
    lines: tuple[Line, ...]


@dataclass(frozen=True)
class Overlay:
    """What is drawn of several runs.

    Parameters
    ----------
    over, unit : str
        What lies on the x axis: "time", or a signal; and its unit.
    panels : tuple of Panel
        One a signal.
    labels : tuple of str
        Of the runs.
    notes : tuple of str
        What the lines do not show: gaps, rows that are left out, runs without a signal.
    """

    over: str
    unit: str
    panels: tuple[Panel, ...]
    labels: tuple[str, ...]
    notes: tuple[str, ...]

    @classmethod
    def of(cls, runs: Mapping[str, Trajectory], names: Sequence[str], over: str = TIME) -> "Overlay":
        """Signals of runs, each over time or over another signal.

        Parameters
        ----------
        runs : mapping of str to Trajectory
            Label -> run, in the order in which they are drawn.
        names : sequence of str
            Of the signals, each of at least one run.
        over : str
            "time", or a signal of every run.

        Returns
        -------
        Overlay

        Raises
        ------
        ValueError
            A run without rows, one that lacks the signal on the x axis, and units that do not fit.
        """
        notes: list[str] = []
        for label, run in runs.items():
            if not len(run):
                raise ValueError(f"{label!r} must hold at least one row, holds none")
            if over != TIME and over not in run.names:
                raise ValueError(f"every run must have the signal on the x axis, {label!r} has no {over!r}")
        x_unit = "s" if over == TIME else _unit(runs, over)
        xs = {label: run.t if over == TIME else _in(run, over, x_unit, label) for label, run in runs.items()}
        panels = []
        for name in names:
            unit, lines = _unit(runs, name), []
            for label, run in runs.items():
                if name not in run.names:
                    notes.append(f"{label} has no {name}")
                    continue
                y = np.where(np.isfinite(xs[label]), _in(run, name, unit, label), np.nan)
                gaps = y.size - int(np.isfinite(y).sum())
                if gaps:
                    notes.append(f"{name} of {label} is not finite in {gaps:,} of {y.size:,} rows: its line has gaps there")
                kept = thinned_rows(xs[label], y)
                lines.append(Line(label, xs[label][kept], np.where(np.isfinite(y), y, np.nan)[kept]))
            panels.append(Panel(name, unit, tuple(lines)))
        longest = max(map(len, runs.values()))
        if longest > MOST_ROWS:
            every = group_of(longest)
            notes.append(f"of more than {MOST_ROWS:,} rows only the first, last, least and greatest of every {every:,} are drawn")
        return cls(over, x_unit, tuple(panels), tuple(runs), tuple(notes))


def _unit(runs: Mapping[str, Trajectory], name: str) -> str:
    """The unit of a signal in the first run that knows one."""
    return next((run.unit(name) for run in runs.values() if name in run.names and run.unit(name)), "")


def _in(run: Trajectory, name: str, unit: str, label: str) -> np.ndarray:
    """A signal in a unit, shape (n,)."""
    own = run.unit(name)
    if own in ("", unit):
        return np.asarray(run[name], dtype=float)
    if not _fit(own, unit):
        raise ValueError(f"{name!r} must have units that fit in all files, is in {unit} and, in {label!r}, in {own}")
    at_0, at_1 = convert(0.0, own, unit), convert(1.0, own, unit)
    return np.asarray(at_0 + (at_1 - at_0) * run[name])


def _fit(a: str, b: str) -> bool:
    try:
        return compatible(a, b)
    except ValueError:  # a unit that nobody knows
        return False


def group_of(rows: int, most: int = MOST_ROWS) -> int:
    """How many rows one group of thinned ones has."""
    return -(-rows // (most // 6))


def thinned_rows(x: np.ndarray, y: np.ndarray, most: int = MOST_ROWS) -> np.ndarray:
    """Which rows of a line to draw so that it looks as if all were.

    Parameters
    ----------
    x, y : ndarray, shape (n,)
        The line; NaN where there is a gap.
    most : int
        How many rows to keep at most, about; all where there are no more.

    Returns
    -------
    ndarray of int, shape (k,)
        In rising order: of every group of rows the first, the last, those with the least and greatest x and y, and one of a gap.
    """
    n = y.size
    if n <= most:
        return np.arange(n)
    kept: list[int] = []
    group = group_of(n, most)
    for start in range(0, n, group):
        part = slice(start, min(start + group, n))
        kept += [part.start, part.stop - 1]
        for values in (x[part], y[part]):
            finite = np.isfinite(values)
            if finite.any():
                kept += [
                    start + int(np.where(finite, values, np.inf).argmin()),
                    start + int(np.where(finite, values, -np.inf).argmax()),
                ]
            if not finite.all():
                kept.append(start + int(finite.argmin()))
    return np.unique(kept)
