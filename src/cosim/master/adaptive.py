"""Macro steps that adapt to an error estimate, with rollback.

- "doubling": the step is done once whole and once in halves; the difference over 2^order - 1 estimates the error of the
  halves, which are kept. Costs three steps for two.
- "energy": the residual power of the power bonds at the end of the step against the largest power seen (ECCO). Costs nothing
  but sees only what crosses a bond.

How the next step follows from the estimate stands in step_control.py.

The tolerance is one of each step by itself. What the errors of all steps come to at the end of the run is another number, larger
or smaller as the system keeps or forgets them: gyro_cosim.accuracy.global_error estimates it.

An FMU's own limits are kept: one that takes steps of one length only is refused, and one with steps of a fixed length inside gets
whole numbers of them.
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
from .step_control import MOST_REJECTIONS, StepControl

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
    integral, proportional : float
        Exponents of the controller, see StepControl.

    Raises
    ------
    ValueError
        Names what is wrong.
    """

    tolerance: float = 1e-4
    estimate: Literal["doubling", "energy"] = "doubling"
    smallest: float = 1e-9
    largest: float = float("inf")
    integral: float = 0.7
    proportional: float = 0.4

    def __post_init__(self) -> None:
        if not self.tolerance > 0.0:
            raise ValueError(f"tolerance must be positive, got {self.tolerance!r}")
        if self.estimate not in ("doubling", "energy"):
            raise ValueError(f"estimate must be doubling or energy, got {self.estimate!r}")
        if not 0.0 < self.smallest <= self.largest:
            raise ValueError(f"macro steps must have 0 < smallest <= largest, got {self.smallest!r} and {self.largest!r}")
        if not (0.0 < self.integral <= 1.0 and 0.0 <= self.proportional < self.integral):
            raise ValueError(
                f"exponents must have 0 <= proportional < integral <= 1, got {self.proportional!r} and {self.integral!r}"
            )

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
        self._inside, self._whose = fixed_step(network)
        self._parts = 2 if how.estimate == "doubling" else 1
        self._control = StepControl(min(algorithm.order, best_order(network)), how.integral, how.proportional)
        self._next = min(step, how.largest)
        self._size = np.zeros(len(network.coupled))
        self._power = 0.0

    def advance(self, history: History, memory: Memory, until: float = float("inf")) -> tuple[list[Taken], int]:
        """The next accepted step, as one or two steps that follow one another, and how many were taken back before it.

        until : where it ends at the latest, s.
        """
        t, wasted = history.t[0], 0
        estimate = self._doubled if self._how.estimate == "doubling" else self._weighed
        with save_all(self._network, "an adaptive macro step") as before:
            while True:
                stop = min(self._stop, until)
                left = stop - t
                h = self._length(left)
                end = stop if h == left else t + h
                steps, error = estimate(history, h, end, before, memory)
                if error <= 1.0:
                    rejections = self._control.rejections
                    factor, self._control = self._control.accepted(error)
                    self._next = min(h * factor, self._how.largest)
                    length, after, step = steps[0]
                    return [(length, after, replace(step, passes=step.passes + wasted)), *steps[1:]], rejections
                factor, self._control = self._control.rejected(error)
                wasted += sum(step.passes for _, _, step in steps)
                memory = steps[-1][2].memory
                self._refuse_to_shrink(t, h, error, h * factor)
                self._next = h * factor
                before.go_back()

    def _length(self, left: float) -> float:
        """The next step, s: as the controller says, in whole numbers of a fixed step inside, with no tiny rest before the end."""
        h, whole = self._next, self._inside * self._parts
        if whole:
            h = max(1, int(h / whole * (1 + 1e-9))) * whole
        if h > left * (1 - 1e-9):
            return left
        if h <= left / 2:
            return h
        half = left / 2
        return max(1, int(half / whole * (1 + 1e-9))) * whole if whole else half

    def _refuse_to_shrink(self, t: float, h: float, error: float, wanted: float) -> None:
        """ConvergenceError where the step cannot become any shorter."""
        reached = f"estimate {error * self._how.tolerance:.3g} over {h:g} s"
        must = f"the macro step at t = {t:.9g} s must reach the tolerance {self._how.tolerance:g} before"
        whole = self._inside * self._parts
        if whole and h <= whole * (1 + 1e-9):
            raise ConvergenceError(
                f"{must} the fixed internal step of {self._whose!r}, {self._inside:g} s, forbids it, {reached}"
            )
        smallest = max(self._how.smallest, 64 * np.finfo(float).eps * abs(t))  # times are rounded, too
        if wanted < smallest:
            raise ConvergenceError(f"{must} its smallest size of {smallest:g} s, {reached}")
        if self._control.rejections >= MOST_REJECTIONS:
            raise ConvergenceError(f"{must} it has been shortened {MOST_REJECTIONS} times, {reached}")

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
        error = float(np.max(difference, initial=0.0)) / (2**self._control.order - 1) / self._how.tolerance
        return [(h / 2, middle, first), (h / 2, end, second)], error

    def _weighed(self, history: History, h: float, end: float, before: Saved, memory: Memory) -> tuple[list[Taken], float]:
        """One step, and the estimate from its residual power."""
        step = self._algorithm.advance(self._network, history, h, memory)
        residual, power = residual_power(self._network, step.Y, step.used, h)
        self._power = max(self._power, float(np.max(power)))
        error = float(np.max(residual)) / (self._power or 1.0) / self._how.tolerance
        return [(h, end, step)], error


def fixed_step(network: Network) -> tuple[float, str]:
    """The longest fixed internal step (s) of a slave, which macro steps must be whole numbers of, and whose; 0 if none has one.

    ValueError where a slave takes macro steps of one length only, or two fixed steps do not fit into one another.
    """
    found: list[tuple[float, str]] = []
    for slave in network.slaves:
        d = slave.description
        if not d.variable_steps:
            raise ValueError(
                f"an adaptive macro step needs components that take steps of any length, {slave.name!r} says "
                "canHandleVariableCommunicationStepSize = false"
            )
        if d.fixed_step > 0.0:
            found.append((d.fixed_step, slave.name))
    longest, whose = max(found, default=(0.0, ""))
    for step, name in found:
        if abs(longest / step - round(longest / step)) > 1e-6:
            raise ValueError(
                f"an adaptive macro step needs fixed internal steps that divide one another: {name!r} has {step:g} s, "
                f"{whose!r} {longest:g} s"
            )
    return longest, whose
