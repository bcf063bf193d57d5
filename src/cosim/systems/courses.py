"""Known functions of time: what an open input or a parameter follows when a time series or a scenario says so.

A course is piecewise linear and continuous from the right. It may jump: where it does, `at` gives the value after the jump,
and a macro step that a jump falls into still ends with the value before it. So a jump takes effect at the first communication
point at or after its time.
"""

from bisect import bisect_left, bisect_right
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

ROUNDING = 1e-14  # share of a time by which a communication point may miss it


@dataclass(frozen=True)
class Piece:
    """Linear from `first` at `begin` (s) to `last` at the next piece's begin, `end` (s, infinite for the last one)."""

    begin: float
    end: float
    first: float
    last: float

    @property
    def rests(self) -> bool:
        """Whether it is constant."""
        return self.first == self.last

    def at(self, t: float) -> float:
        """The value at t (s), which lies in it."""
        if self.rests or t <= self.begin:
            return self.first
        return (
            self.last if t >= self.end else self.first + (self.last - self.first) * ((t - self.begin) / (self.end - self.begin))
        )

    def part(self, begin: float, end: float) -> "Piece":
        """What of it lies in [begin, end]."""
        begin, end = max(begin, self.begin), min(end, self.end)
        return Piece(begin, end, self.at(begin), self.at(end))


class Course:
    """Pieces that follow one another, the first from minus infinity on.

    jumps : times (s) at which the value jumps.
    """

    def __init__(self, pieces: Sequence[Piece]) -> None:
        joined: list[Piece] = []
        for piece in pieces:
            if joined and joined[-1].rests and piece.rests and joined[-1].first == piece.first:
                joined[-1] = Piece(joined[-1].begin, piece.end, piece.first, piece.last)
            else:
                joined.append(piece)
        self.pieces = tuple(joined)
        self._begins = [piece.begin for piece in joined]
        joints = zip(self.pieces, self.pieces[1:], strict=False)
        self.jumps = tuple(after.begin for before, after in joints if before.last != after.first)

    @classmethod
    def constant(cls, value: float) -> "Course":
        """The same value at all times."""
        return cls([Piece(-np.inf, np.inf, value, value)])

    @classmethod
    def through(cls, t: Sequence[float], values: Sequence[float], *, held: bool) -> "Course":
        """Through values at times t (s) that never fall, at least one; a time that stands twice is a jump.

        held : keep each value up to the next time instead of going there in a line. The ends are kept before and after.
        """
        pieces = [Piece(-np.inf, t[0], values[0], values[0])]
        for k in range(len(t) - 1):
            if t[k + 1] > t[k]:
                pieces.append(Piece(t[k], t[k + 1], values[k], values[k] if held else values[k + 1]))
        return cls([*pieces, Piece(t[-1], np.inf, values[-1], values[-1])])

    def at(self, t: float) -> float:
        """The value at t (s), after a jump there."""
        return self.pieces[self._place(t)].at(t)

    def _place(self, t: float) -> int:
        """The piece that t (s) lies in; a begin that it misses by rounding counts as reached."""
        return bisect_right(self._begins, t + ROUNDING * abs(t)) - 1

    def over(self, t: float, h: float) -> tuple[float, float]:
        """Value and slope of the line that a step of h (s) from t (s) follows: to the value at its end, but for jumps inside."""
        first, end = self._place(t), t + h
        last = max(first, bisect_left(self._begins, end - ROUNDING * abs(end)) - 1)
        value, reached = self.pieces[first].at(t), self.pieces[last].at(end)
        if any(self.pieces[k].last != self.pieces[k + 1].first for k in range(first, last)):
            parts = [piece.part(t, end) for piece in self.pieces[first : last + 1]]
            reached = value + sum(part.last - part.first for part in parts)
        return value, (reached - value) / h if reached != value else 0.0

    def still_until(self, t: float) -> float:
        """Up to which time (s) the value at t (s) stays the same; t itself where it changes from there on."""
        k = self._place(t)
        if not self.pieces[k].rests:
            return t
        return self.pieces[k].end

    def followed_by(self, time: float, pieces: Sequence[Piece]) -> "Course":
        """This course up to `time` (s), then `pieces`, the first of which begins there and the last of which has no end."""
        before = [piece.part(-np.inf, time) for piece in self.pieces if piece.begin < time]
        return Course([*before, *pieces])

    def after(self, time: float) -> list[Piece]:
        """Its pieces from `time` (s) on."""
        return [piece.part(time, np.inf) for piece in self.pieces if piece.end > time]
