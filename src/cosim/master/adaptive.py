"""Macro steps that adapt to an error estimate, with rollback.

- "doubling": the step is done once whole and once in halves; the difference over 2^order - 1 estimates the error of the
  halves, which are kept. Costs three steps for two.
- "energy": the residual power of the power bonds at the end of the step against the largest power seen (ECCO). Costs nothing
  but sees only what crosses a bond.

The next step is h min(3, max(1/5, 0.9 err^(-1/(order + 1)))), err relative to the tolerance.
Source: Sadjina et al., Energy conservation and power bonds in co-simulations (2016).
"""

from dataclasses import dataclass, replace
from typing import Literal

import numpy as np

from ..coupling import Algorithm, History, Memory, Nepce, Step
from ..coupling.base import Saved, best_order, require_restore, save_all
from ..coupling.iterated import Repeated
from ..errors import ConvergenceError
from ..network import Network
from .energy import residual_power

Taken = tuple[float, float, Step]  # h (s), the time (s) after it, and what the step came to


@dataclass(frozen=True)
class Adaptive:
    """Macro steps that adapt to an error estimate.

    Parameters
    ----------
    tolerance : float
        Of each step, relative to the largest size of each coupled output ("doubling") or of the power ("energy").
    estimate : {"doubling", "energy"}
        See the module's docstring.
    smallest, largest : float
        Bounds of the macro step, s; ConvergenceError where even the smallest is not good enough.

    Raises
    ------
    ValueError
        Names what is wrong.
    """

    tolerance: float = 1e-4
    estimate: Literal["doubling", "energy"] = "doubling"
    smallest: float = 1e-9
    largest: float = float("inf")

    def __post_init__(self) -> None:
        if not self.tolerance > 0.0:
            raise ValueError(f"tolerance must be positive, got {self.tolerance!r}")
        if self.estimate not in ("doubling", "energy"):
            raise ValueError(f"estimate must be doubling or energy, got {self.estimate!r}")
        if not 0.0 < self.smallest <= self.largest:
            raise ValueError(f"macro steps must have 0 < smallest <= largest, got {self.smallest!r} and {self.largest!r}")

    @property
    def meaning(self) -> str:
        """What the tolerance is of, in words."""
        if self.estimate == "energy":
            return (
                f"tolerance {self.tolerance:g}: of each macro step, the residual power of every power bond at its end against "
                "the largest power so far; what crosses no bond is not looked at"
            )
        return (
            f"tolerance {self.tolerance:g}: of each macro step, its own estimated error in every coupled output against "
            "the largest size of that output so far; the errors of the steps add up, so it is no bound on that of the result"
        )


class Controller:
    """Chooses the macro steps of one run."""

    def __init__(self, how: Adaptive, network: Network, algorithm: Algorithm, step: float, stop: float) -> None:
        require_restore(network, "an adaptive macro step")
        if isinstance(algorithm, Nepce):
            raise ValueError("NEPCE needs even macro steps and cannot be combined with an adaptive one")
        if how.estimate == "energy" and not network.bonds:
            raise ValueError("the energy estimate needs a power bond, the system has none")
        if how.estimate == "energy" and isinstance(algorithm, Repeated):
            raise ValueError(
                f"the energy estimate sees no error of {algorithm.name!r}, whose inputs agree with the outputs at the end"
            )
        self._how, self._network, self._algorithm, self._stop = how, network, algorithm, stop
        self._order = min(algorithm.order, best_order(network))
        self._next = min(step, how.largest)
        self._size = np.zeros(len(network.coupled))
        self._power = 0.0

    def advance(self, history: History, memory: Memory, until: float = float("inf")) -> tuple[list[Taken], int]:
        """The next accepted step, as one or two steps that follow one another, and how many were taken back before it.

        until : where it ends at the latest, s.
        """
        t, rejections, wasted = history.t[0], 0, 0
        estimate = self._doubled if self._how.estimate == "doubling" else self._weighed
        with save_all(self._network, "an adaptive macro step") as before:
            while True:
                stop = min(self._stop, until)
                left = stop - t
                h = left if self._next > left * (1 - 1e-9) else min(self._next, left / 2 if self._next > left / 2 else self._next)
                end = stop if h == left else t + h
                steps, error = estimate(history, h, end, before, memory)
                factor = min(3.0, max(0.2, 0.9 * max(error, 1e-12) ** (-1 / (self._order + 1))))
                self._next = min(h * factor, self._how.largest)
                if error <= 1.0:
                    length, after, step = steps[0]
                    return [(length, after, replace(step, passes=step.passes + wasted)), *steps[1:]], rejections
                rejections, wasted = rejections + 1, wasted + sum(step.passes for _, _, step in steps)
                memory = steps[-1][2].memory
                if self._next < self._how.smallest:
                    raise ConvergenceError(
                        f"the macro step at t = {t:.9g} s must reach the tolerance {self._how.tolerance:g} before its "
                        f"smallest size of {self._how.smallest:g} s, estimate {error * self._how.tolerance:.3g} over {h:g} s"
                    )
                before.go_back()

    def _doubled(self, history: History, h: float, end: float, before: Saved, memory: Memory) -> tuple[list[Taken], float]:
        """Two half steps, and the estimate from the whole one."""
        network, coupled = self._network, self._network.coupled
        whole = self._algorithm.advance(network, history, h, memory)
        before.go_back()
        first = self._algorithm.advance(network, history, h / 2, whole.memory)
        middle = history.t[0] + h / 2
        second = self._algorithm.advance(network, history.push(middle, first.Y), h / 2, first.memory)
        first = replace(first, passes=whole.passes + first.passes)
        self._size = np.maximum(self._size, np.maximum(np.abs(second.Y[coupled]), np.abs(history.Y[0][coupled])))
        difference = np.abs(second.Y - whole.Y)[coupled] / np.where(self._size > 0.0, self._size, 1.0)
        error = float(np.max(difference, initial=0.0)) / (2**self._order - 1) / self._how.tolerance
        return [(h / 2, middle, first), (h / 2, end, second)], error

    def _weighed(self, history: History, h: float, end: float, before: Saved, memory: Memory) -> tuple[list[Taken], float]:
        """One step, and the estimate from its residual power."""
        step = self._algorithm.advance(self._network, history, h, memory)
        residual, power = residual_power(self._network, step.Y, step.used, h)
        self._power = max(self._power, float(np.max(power)))
        error = float(np.max(residual)) / (self._power or 1.0) / self._how.tolerance
        return [(h, end, step)], error
