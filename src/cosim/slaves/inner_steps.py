"""The steps of a slave's own integrator: what it reaches between communication points, kept where somebody asks for it."""

from abc import ABC, abstractmethod
from collections.abc import Sequence
from typing import Any

import numpy as np

from .signal import Signal


class InnerSteps:
    """What a slave has reached at the end of each step of its own; of steps that were taken back nothing is left.

    A chain in which each point knows the one before: to go back to any point takes no time, in whatever order.

    signals : of which the values are.
    """

    def __init__(self, signals: Sequence[Signal]) -> None:
        self.signals = tuple(signals)
        self._newest: Any = None  # (the point before, t, values)

    def add(self, t: float, values: Sequence[float]) -> None:
        """The slave is at t (s), where the signals have these values."""
        self._newest = self._newest, t, tuple(values)

    def mark(self) -> Any:
        """Where they are now, for go_back()."""
        return self._newest

    def go_back(self, mark: Any = None) -> None:
        """As if nothing had come since mark() gave `mark`; None: nothing at all."""
        self._newest = mark

    def arrays(self) -> tuple[np.ndarray, np.ndarray]:
        """Times (s), shape (n,), and values, shape (n, number of signals)."""
        times, rows, point = [], [], self._newest
        while point is not None:
            point, t, values = point
            times.append(t)
            rows.append(values)
        return np.array(times[::-1]), np.array(rows[::-1], dtype=float).reshape(len(rows), len(self.signals))


class Following(ABC):
    """A slave that may tell the steps of its own integrator; ask with steps_of()."""

    @property
    @abstractmethod
    def inner_signals(self) -> tuple[Signal, ...]:
        """What it can tell at each of them; nothing where it tells none."""

    @abstractmethod
    def follow(self) -> InnerSteps:
        """Tell them from the next begin() on; what it gives is filled as the run goes on, and emptied by begin()."""


def steps_of(slave: object) -> InnerSteps | None:
    """The steps of the integrator of `slave`, to be told from its next begin() on; None where it does not tell them."""
    return slave.follow() if isinstance(slave, Following) and slave.inner_signals else None
