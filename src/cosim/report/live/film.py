"""What viewers of a run are shown: rows in single precision, fewer as they become many. One thread writes, any number read."""

from dataclasses import dataclass, field

import numpy as np

__all__ = ["Cursor", "Film", "Frame"]

ROWS = 4096  # rows, at most
NUMBERS = 4_000_000  # of all rows together, at most


@dataclass
class _Reel:
    """Rows up to `filled`, which never change any more; when there are too many, another reel takes its place."""

    stride: int
    t: np.ndarray
    values: np.ndarray
    filled: int = 0


@dataclass(frozen=True)
class Cursor:
    """How far a viewer has seen: rows of a reel."""

    reel: _Reel = field(repr=False)
    seen: int


@dataclass(frozen=True)
class Frame:
    """New rows: times (s), shape (n,), values, shape (n, m). anew : they take the place of all that were shown before."""

    t: np.ndarray
    values: np.ndarray
    anew: bool


class Film:
    """Rows of a run.

    Parameters
    ----------
    columns : int
        Numbers in a row, m.
    every : int
        Of the run's points only every so many hold all numbers.
    """

    def __init__(self, columns: int, every: int = 1) -> None:
        self._size = int(np.clip(NUMBERS // max(1, columns), 64, ROWS))
        self._reel = _Reel(every, np.empty(self._size), np.empty((self._size, columns), dtype=np.float32))

    def add(self, k: int, t: np.ndarray, rows: np.ndarray) -> None:
        """Points k, k + 1, ... of the run: times t (s), shape (n,), values, shape (n, m)."""
        while True:
            reel = self._reel
            chosen = slice((-k) % reel.stride, None, reel.stride)
            times = t[chosen]
            first, last = reel.filled, reel.filled + times.size
            if last <= self._size:
                break
            self._reel = self._thinner(reel)
        reel.t[first:last] = times
        with np.errstate(over="ignore"):  # what is too large for single precision is drawn as infinite, that is, not at all
            reel.values[first:last] = rows[chosen]
        reel.filled = last  # last of all: readers look at this first

    def _thinner(self, reel: _Reel) -> _Reel:
        """Every other row of a reel. The first row is that of point 0, so the others stay on multiples of the new stride."""
        half = slice(0, reel.filled, 2)
        made = _Reel(2 * reel.stride, np.empty_like(reel.t), np.empty_like(reel.values), (reel.filled + 1) // 2)
        made.t[: made.filled], made.values[: made.filled] = reel.t[half], reel.values[half]
        return made

    def since(self, cursor: Cursor | None) -> tuple[Frame, Cursor]:
        """What a viewer has not seen, who was last at `cursor`; None: who has seen nothing. May be called in any thread."""
        reel = self._reel
        filled = reel.filled
        anew = cursor is None or cursor.reel is not reel
        first = 0 if cursor is None or cursor.reel is not reel else cursor.seen
        return Frame(reel.t[first:filled], reel.values[first:filled], anew), Cursor(reel, filled)
