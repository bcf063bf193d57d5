"""Macro steps that adapt to an error estimate, with rollback.

- "doubling": the step is done once whole and once in halves; the difference over 2^order - 1 estimates the error of the
  halves, which are kept. Costs three steps for two.
- "energy": the residual power of the power bonds at the end of the step against the largest power seen (ECCO). Costs nothing
  but sees only what crosses a bond.

The next step is h min(3, max(1/5, 0.9 err^(-1/(order + 1)))), err relative to the tolerance.
Source: Sadjina et al., Energy conservation and power bonds in co-simulations (2016).
"""

from dataclasses import dataclass
from typing import Literal

import numpy as np

from ..coupling import Algorithm, History, Iterated, Jacobi
from ..coupling.base import Used, discard_all, go_back, require_restore, save_all
from ..errors import ConvergenceError
from ..network import Network
from .energy import residual_power

Step = tuple[float, float, np.ndarray, Used]  # h, t after it, Y there, inputs used


@dataclass(frozen=True)
class Adaptive:
    """tolerance : relative to the largest size of each coupled output ("doubling") or of the power ("energy").

    smallest, largest : bounds of the macro step (s); ConvergenceError where even the smallest is not good enough.
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


class Controller:
    """Chooses the macro steps of one run; `rejections` counts those that were taken back."""

    def __init__(self, how: Adaptive, network: Network, algorithm: Algorithm, step: float, stop: float) -> None:
        require_restore(network, "an adaptive macro step")
        if isinstance(algorithm, Jacobi) and algorithm.nepce:
            raise ValueError("NEPCE needs even macro steps and cannot be combined with an adaptive one")
        if how.estimate == "energy" and not network.bonds:
            raise ValueError("the energy estimate needs a power bond, the system has none")
        if how.estimate == "energy" and isinstance(algorithm, Iterated):
            raise ValueError(
                f"the energy estimate sees no error of {algorithm.name!r}, whose inputs agree with the outputs at the end"
            )
        self._how, self._network, self._algorithm, self._stop = how, network, algorithm, stop
        self._next = min(step, how.largest)
        self._size = np.zeros(len(network.coupled))
        self._power = 0.0
        self.rejections = 0

    def advance(self, history: History) -> list[Step]:
        """The next accepted step, as one or two steps that follow one another."""
        t = history.t[0]
        states = save_all(self._network)
        try:
            while True:
                left = self._stop - t
                h = left if self._next > left * (1 - 1e-9) else min(self._next, left / 2 if self._next > left / 2 else self._next)
                end = self._stop if h == left else t + h
                steps, error = (self._doubled if self._how.estimate == "doubling" else self._weighed)(history, h, end, states)
                factor = min(3.0, max(0.2, 0.9 * max(error, 1e-12) ** (-1 / (self._algorithm.order + 1))))
                self._next = min(h * factor, self._how.largest)
                if error <= 1.0:
                    return steps
                self.rejections += 1
                if self._next < self._how.smallest:
                    raise ConvergenceError(
                        f"the macro step at t = {t:.9g} s must reach the tolerance {self._how.tolerance:g} before its "
                        f"smallest size of {self._how.smallest:g} s, estimate {error * self._how.tolerance:.3g} over {h:g} s"
                    )
                go_back(self._network, states)
        finally:
            discard_all(self._network, states)

    def _doubled(self, history: History, h: float, end: float, states: list[object]) -> tuple[list[Step], float]:
        """Two half steps, and the estimate from the whole one."""
        network, coupled = self._network, self._network.coupled
        whole, _ = self._algorithm.advance(network, history, h)
        go_back(network, states)
        half, used = self._algorithm.advance(network, history, h / 2)
        middle = history.t[0] + h / 2
        ahead = History(history.t[0], history.Y[0], history.held)
        ahead.t, ahead.Y, ahead.jacobian = list(history.t), list(history.Y), history.jacobian
        ahead.push(middle, half)
        both, used_then = self._algorithm.advance(network, ahead, h / 2)
        history.iterations += ahead.iterations
        self._size = np.maximum(self._size, np.maximum(np.abs(both[coupled]), np.abs(history.Y[0][coupled])))
        difference = np.abs(both - whole)[coupled] / np.where(self._size > 0.0, self._size, 1.0)
        error = float(np.max(difference, initial=0.0)) / (2**self._algorithm.order - 1) / self._how.tolerance
        return [(h / 2, middle, half, used), (h / 2, end, both, used_then)], error

    def _weighed(self, history: History, h: float, end: float, states: list[object]) -> tuple[list[Step], float]:
        """One step, and the estimate from its residual power."""
        Y, used = self._algorithm.advance(self._network, history, h)
        residual, power = residual_power(self._network, Y, used, h)
        self._power = max(self._power, float(np.max(power)))
        error = float(np.max(residual)) / (self._power or 1.0) / self._how.tolerance
        return [(h, end, Y, used)], error
