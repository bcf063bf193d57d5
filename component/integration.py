"""The time integration of a component: one internal step as a CasADi function, and how steps make up a length of time.

    x_next = step(x, U, p, tau, h)

U, shape (n_u, 3), holds value, first and second derivative of the inputs at the start of the macro step; tau (s) is the
time since then at which the internal step starts and h (s) its length:

    u(t) = U0 + U1 t + U2 t^2 / 2,    tau <= t <= tau + h.

A state of x_next that is smaller than AT_REST is 0: a linear system that decays would else reach subnormal numbers, with which
processors count many times slower (docs/decisions/0011-mathematics-of-our-own.md).

`step` runs here and becomes C code inside the FMU. How doStep uses it stands in do_step.py.
"""

import math
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from typing import Any

import casadi as ca
import numpy as np

from .methods import METHODS as METHODS

__all__ = [
    "INPUT_DEGREE", "METHODS", "ErrorControl", "InternalStep", "Progress", "StepError", "advance", "easy_fraction",
    "first_sample", "input_at", "is_straight", "pieces", "step_function", "substeps", "whole_step",
]  # fmt: skip

INPUT_DEGREE = 2  # highest degree of the input polynomial
AT_REST = 1e-100  # in SI units no state means anything there; products of two such numbers are still far from underflow
LEVELS = 20  # with error control the smallest internal step is the piece / 2^LEVELS
SMALL_MODEL = 1000  # instructions of rhs up to which an explicit step is one straight run of them
EXPLICIT = ("rk4",)
NEARLY = 1 + 1e-9  # a step so much longer than the longest one is not cut
CUTS = 5  # an internal step is cut into 1, 2, 4, 8 or 16 equal steps where a component says how long one may be
SAME_TIME = 1e-9  # fraction of the sample period within which two instants are one


class StepError(ArithmeticError):
    """A step that gives no finite state, or whose tolerance cannot be met; the state before it is still good."""


@dataclass(frozen=True)
class Progress:
    """What the integration carries from one macro step to the next, besides x.

    Attributes
    ----------
    samples : int
        Index of the next sample instant.
    step : float
        Length (s) to try first under error control.
    """

    samples: int = 0
    step: float = math.inf


def step_function(rhs: ca.Function, method: str, longest_step: ca.Function | None = None) -> ca.Function:
    """Make the function `step` of the module's docstring.

    Parameters
    ----------
    rhs : casadi.Function
        (x, u, p) -> x', shapes (n_x,), (n_u,), (n_p,) -> (n_x,).
    method : str
        A key of METHODS.
    longest_step : casadi.Function, optional
        (x, u, p) -> s. A longer internal step is cut into the least power of 2, up to 16, of equal steps within it.

    Returns
    -------
    casadi.Function
        (x, U, p, tau, h) -> x_next, shapes (n_x,), (n_u, 3), (n_p,), (), () -> (n_x,).
    """
    whole = whole_step(rhs, method)
    if longest_step is None:
        return whole
    x, U, p, tau, h = arguments = [ca.MX.sym(whole.name_in(i), *whole.size_in(i)) for i in range(5)]
    cut = [whole]
    for level in range(1, CUTS):
        n, end = 2**level, x
        for i in range(n):
            end = whole(end, U, p, tau + i * h / n, h / n)
        cut.append(ca.Function(f"step_{n}", arguments, [end]))
    longest = longest_step(x, U[:, 0], p) * NEARLY
    level = sum(h > 2**k * longest for k in range(CUTS - 1))  # none for NaN
    choose = ca.Function.conditional("choose", cut[:-1], cut[-1])
    end = choose(level, *arguments)
    return ca.Function("step", arguments, [end], ["x", "U", "p", "tau", "h"], ["x_next"])


def is_straight(rhs: ca.Function, method: str) -> bool:
    """Whether `whole_step` is one straight run of operations: an explicit step of a small model."""
    return method in EXPLICIT and rhs.is_a("SXFunction") and rhs.n_instructions() <= SMALL_MODEL


def whole_step(rhs: ca.Function, method: str) -> ca.Function:
    """`step_function` without cutting."""
    n_x, n_u, n_p = (rhs.size1_in(i) for i in range(3))
    symbol = ca.SX if rhs.is_a("SXFunction") else ca.MX

    def symbols(kind: Any) -> list[Any]:
        shapes = (("x", n_x, 1), ("U", n_u, INPUT_DEGREE + 1), ("p", n_p, 1), ("tau", 1, 1), ("h", 1, 1))
        return [kind.sym(*shape) for shape in shapes]

    x, U, p, tau, h = symbols(symbol)
    labels = ["x", "U", "p", "tau", "h"], ["x_next"]
    if n_x == 0:
        return ca.Function("step", [x, U, p, tau, h], [x], *labels)
    s = symbol.sym("s")  # 0..1 over the internal step, so that one integrator serves every h
    t = tau + s * h
    u = U[:, 0] + U[:, 1] * t + U[:, 2] * t**2 / 2
    ode = h * ca.densify(rhs(x, u, p))
    problem = {"x": x, "t": s, "p": ca.veccat(U, p, tau, h), "ode": ca.cse(ode) if symbol is ca.SX else ode}
    scaled = METHODS[method].step(problem)
    if is_straight(rhs, method):
        scaled = scaled.expand()
    x, U, p, tau, h = arguments = symbols(ca.SX if scaled.is_a("SXFunction") else ca.MX)
    end = ca.densify(scaled(x, ca.veccat(U, p, tau, h)))
    end = ca.if_else(ca.fabs(end) < AT_REST, 0, end)
    if scaled.is_a("SXFunction"):
        end = ca.cse(end)
    return ca.Function("step", arguments, [end], *labels)


def input_at(U: np.ndarray, tau: float) -> np.ndarray:
    """The inputs, shape (n_u,), at offset `tau` (s) of the polynomial `U`, shape (n_u, 3)."""
    return U[:, 0] + U[:, 1] * tau + U[:, 2] * (tau * tau) / 2


def substeps(length: float, internal_step: float) -> int:
    """How many equal internal steps cover `length` (s), none longer than `internal_step` but for rounding."""
    return max(1, math.ceil(length / internal_step - 1e-9))


def easy_fraction(order: int) -> float:
    """Fraction of the allowed error below which the next internal step may be twice as long: half of what it grows by."""
    return 0.5 ** (order + 2)


def first_sample(period: float | None, t: float) -> int:
    """Index of the first sample instant k * period at or after `t` (s)."""
    return 0 if period is None else math.ceil(t / period - SAME_TIME)


def pieces(t: float, h: float, period: float | None, samples: int) -> Iterator[tuple[float, float, int]]:
    """The macro step from t to t + h (s), cut at sample instants: (offset, length, number of samples before it).

    A sample stands at the start of the piece that begins at its instant; one at the end of the macro step belongs to the next.
    `period` (s) is None without samples, `samples` the index of the next one.
    """
    if period is None:
        yield 0.0, h, 0
        return
    near, done, due = SAME_TIME * period, 0.0, 0
    while done < h:
        instant = samples * period - t
        if instant <= done + near:
            samples, due = samples + 1, due + 1
            continue
        end = instant if instant < h - near else h
        yield done, end - done, due
        done, due = end, 0


def advance(
    one: "InternalStep", x: np.ndarray, tau: float, length: float, *, internal_step: float,
    control: "ErrorControl | None" = None, first: float = math.inf,
) -> tuple[np.ndarray, float]:  # fmt: skip
    """Integrate over a piece of a macro step.

    Without error control the internal steps are equal. With it they are length / 2^level, and each is compared with two of half
    its length, which are kept; the level rises where they differ by more than allowed and falls where it could.

    Parameters
    ----------
    one : callable
        one(x, tau, h) returns x after an internal step, shape (n_x,), and leaves its argument alone.
    x : array, shape (n_x,)
        States at the start of the piece.
    tau, length : float
        Where in the macro step the piece starts, and how long it is (s).
    internal_step : float
        Longest internal step (s); with error control the first length tried after the start of the run.
    control : ErrorControl, optional
        What decides on the internal steps.
    first : float
        Length (s) to try first: what the call before returned; infinite at the start of the run.

    Returns
    -------
    x : array, shape (n_x,)
        States at the end of the piece.
    first : float
        Length (s) to try first next time.

    Raises
    ------
    StepError
        If no finite state is reached, or the tolerance cannot be met.
    """
    if control is None:
        n = substeps(length, internal_step)
        h = length / n
        for i in range(n):
            x = one(x, tau + i * h, h)
        if not np.all(np.isfinite(x)):
            raise StepError("the step gives no finite state")
        return x, first

    level, done = 0, 0
    first = internal_step if math.isinf(first) else first
    while length / 2.0**level > first * (1 + 1e-9) and level < LEVELS:
        level += 1
    while done < 2**level:
        h = length / 2.0**level
        at = tau + done * h
        whole = one(x, at, h)
        two = one(one(x, at, h / 2), at + h / 2, h / 2)
        error = float(np.max(np.abs(two - whole) / (control.nominal + np.abs(two)), initial=0.0))
        if error <= control.allowed:
            easy = error < control.allowed * easy_fraction(control.order)
            x, first, done = two, 2 * h if easy else h, done + 1
            if easy and level > 0 and done % 2 == 0:
                level, done = level - 1, done // 2
        elif level == LEVELS:
            finite = bool(np.all(np.isfinite(two)))
            raise StepError("the tolerance cannot be met" if finite else "the step gives no finite state")
        else:
            level, done = level + 1, done * 2
    return x, first


InternalStep = Callable[[np.ndarray, float, float], np.ndarray]


@dataclass(frozen=True, eq=False)
class ErrorControl:
    """What decides whether an internal step is good.

    Attributes
    ----------
    order : int
        The method's order of accuracy.
    tolerance : float
        Relative error of an internal step.
    nominal : array, shape (n_x,)
        Usual sizes of the states: an error counts relative to nominal plus actual size.
    """

    order: int
    tolerance: float
    nominal: np.ndarray

    @property
    def allowed(self) -> float:
        """Largest difference between one step and two of half its length; their error is 2^order - 1 times smaller."""
        return self.tolerance * (2.0**self.order - 1.0)
