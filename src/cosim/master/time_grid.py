"""The communication points of a run with even macro steps: start + n h with whole n, the last one on the end exactly."""

from dataclasses import dataclass

import numpy as np


@dataclass(frozen=True)
class TimeGrid:
    """`n` macro steps of `step` (s) from `start` to `stop` (s); the last may be shorter."""

    start: float
    stop: float
    step: float
    n: int

    @classmethod
    def over(cls, step: float, stop: float, start: float = 0.0) -> "TimeGrid":
        """The grid of a run; ValueError names what is wrong with it."""
        return cls(start, stop, step, macro_steps(step, stop, start))

    @property
    def last(self) -> float:
        """Length (s) of the last step."""
        left = self.stop - (self.start + (self.n - 1) * self.step)
        rounding = 4 * np.finfo(float).eps * abs(self.start)  # far from 0 the times themselves are rounded
        return self.step if abs(left - self.step) <= 1e-9 * self.step + rounding else left

    @property
    def even(self) -> int:
        """How many steps have the full length: all, or all but the last."""
        return self.n if self.last == self.step else self.n - 1

    def time(self, k: int) -> float:
        """The time (s) after k steps."""
        return self.stop if k == self.n else self.start + k * self.step

    def times(self, k: np.ndarray) -> np.ndarray:
        """The same for many k, shape (m,)."""
        t = self.start + k * self.step
        t[k == self.n] = self.stop
        return t

    def length(self, k: int) -> float:
        """The length (s) of step k = 1, 2, ..., n."""
        return self.last if k == self.n else self.step


def macro_steps(step: float, stop: float, start: float = 0.0) -> int:
    """How many macro steps of `step` lead from `start` to `stop` (s); the last may be shorter, so that it ends there exactly."""
    if not np.isfinite(start):
        raise ValueError(f"`start` must be finite, got {start:g} s")
    if not (np.isfinite(stop) and stop > start):
        rule = "positive" if start == 0.0 else f"after `start` at {start:g} s"
        raise ValueError(f"`stop` must be {rule}, got {stop:g} s")
    if not (np.isfinite(step) and step > 0.0):
        raise ValueError(f"`step` must be positive, got {step:g} s")
    length = stop - start
    if step > length * (1 + 1e-9):
        raise ValueError(f"`step` must be at most the run's length of {length:g} s, got {step:g} s")
    rounding = 4 * np.finfo(float).eps * abs(start)  # far from 0 the times themselves are rounded
    if step < 4 * rounding:
        raise ValueError(f"`step` must be told apart from rounding at `start` = {start:g} s, got {step:g} s")
    return max(1, int(np.ceil(length / step - 1e-9 - rounding / step)))
