"""How long the next macro step may be: a controller of the step, from error estimates alone; it knows no network.

With err the estimate of a step relative to the tolerance and k = order + 1 that of the error of one step,

    h_next = h s err_n^(-a / k) err_(n-1)^(b / k),        s = 0.9, a = 0.7, b = 0.4,

a proportional-integral controller: it looks at the trend and not at the last step alone, so that the step settles where it is
just short enough, in place of growing until it is taken back. After a step that was taken back there is no trend, so that
a = 1, b = 0 for it, and the step after that does not grow.
Source: Gustafsson, Control-theoretic techniques for stepsize selection in explicit Runge-Kutta methods, ACM TOMS 17 (1991);
Hairer and Wanner, Solving Ordinary Differential Equations II, section IV.2.
"""

from dataclasses import dataclass, replace

SAFETY = 0.9
LEAST, MOST = 0.2, 3.0  # bounds of one change of the step
FLOOR = 1e-10  # an error estimate below it says that there is none to speak of
LEAST_BEFORE = 1e-4  # what the step before counts at least: a moment without error is no trend
MOST_REJECTIONS = 20  # of one step, one after the other


@dataclass(frozen=True)
class StepControl:
    """The state of the controller; a value, to which accepted() and rejected() give the next.

    Parameters
    ----------
    order : int
        Of the algorithm; the error of one step is of order + 1.
    integral, proportional : float
        The exponents a and b; 1 and 0 make it the elementary controller, which looks at the last step alone.
    before : float
        The estimate of the accepted step before, relative to the tolerance; 0 where there is none.
    rejections : int
        How often the present step has been taken back.
    """

    order: int
    integral: float = 0.7
    proportional: float = 0.4
    before: float = 0.0
    rejections: int = 0

    def accepted(self, error: float) -> tuple[float, "StepControl"]:
        """The factor to the next step after one with this estimate, at most 1, that stands; and the controller after it."""
        k, error = self.order + 1, max(error, FLOOR)
        factor = error ** (-1.0 / k)
        if self.before > 0.0 and not self.rejections:
            factor = error ** (-self.integral / k) * self.before ** (self.proportional / k)
        after = replace(self, before=max(error, LEAST_BEFORE), rejections=0)
        return _bounded(SAFETY * factor, 1.0 if self.rejections else MOST), after

    def rejected(self, error: float) -> tuple[float, "StepControl"]:
        """The factor to the same step, shorter, after an estimate above 1; and the controller after it."""
        return _bounded(SAFETY * error ** (-1 / (self.order + 1)), SAFETY), replace(self, rejections=self.rejections + 1)


def _bounded(factor: float, most: float) -> float:
    return min(most, max(LEAST, factor)) if factor == factor else LEAST
