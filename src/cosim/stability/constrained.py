"""The best parameters within bounds and limits, by exact gradients; and the front where one limit is moved.

    minimise f(q)   subject to   g_i(q) <= limit_i,   lowest <= q <= highest

by sequential quadratic programming (SLSQP; Kraft 1988) over u = log q, so that parameters of any unit are of one size. Its first
step knows no curvature and would leap from one valley into another: so it runs in a box of e^(+-1) about where it is, moved
until the optimum lies inside. Functions give value and slope by q together, and are not computed twice in one place.
What is found is a local optimum: give several starts, and look at a grid where it matters.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from itertools import pairwise
from typing import Any

import numpy as np

__all__ = ["Design", "Limit", "constrained_optimum", "pareto_front"]

Function = Callable[[np.ndarray], tuple[float, np.ndarray]]
KEPT = 1e-6  # by how much a limit may be passed and still counts as kept
BOX = 1.0  # of log q, to each side
MOST_BOXES, MOST_ITERATIONS = 12, 10  # iterations in each box


@dataclass(frozen=True, eq=False)
class Limit:
    """What must not be passed.

    Parameters
    ----------
    name
        Of the quantity.
    function
        q, shape (n_q,), to the value and its slope by q, shape (n_q,); best of a size near 1.
    largest
        The value that is allowed.
    """

    name: str
    function: Function
    largest: float


@dataclass(frozen=True, eq=False)
class Design:
    """The best place that any start led to.

    Parameters
    ----------
    q
        The parameters, shape (n_q,).
    criterion
        There; infinite where no start led to a place that keeps all limits.
    values
        Limit -> its value there.
    evaluations
        Of the criterion, over all starts.
    failures
        Why a search ended without an optimum, one text for each such start.
    """

    q: np.ndarray
    criterion: float
    values: dict[str, float]
    evaluations: int
    failures: tuple[str, ...]


class _Remembered:
    """A function of u = log q that is not computed twice in one place."""

    def __init__(self, function: Function) -> None:
        self.function, self.evaluations = function, 0
        self._u: np.ndarray = np.array([])
        self._last = (np.inf, np.array([]))

    def __call__(self, u: np.ndarray) -> tuple[float, np.ndarray]:
        if not np.array_equal(u, self._u):
            q = np.exp(u)
            value, slope = self.function(q)
            self._u, self._last, self.evaluations = u.copy(), (float(value), np.asarray(slope) * q), self.evaluations + 1
        return self._last


def constrained_optimum(
    criterion: Function, bounds: np.ndarray, starts: Sequence[np.ndarray], limits: Sequence[Limit] = ()
) -> Design:
    """Minimise a criterion within bounds and limits.

    Parameters
    ----------
    criterion
        q, shape (n_q,), to the value and its slope, shape (n_q,).
    bounds
        Lowest and highest value of each parameter, all positive, shape (n_q, 2).
    starts
        Where the searches begin, each of shape (n_q,); what lies outside the bounds is moved onto them.
    limits
        What must not be passed.

    Returns
    -------
    Design

    Raises
    ------
    ValueError
        For bounds that are not positive, finite and in rising order, and where there is no start.
    """
    from scipy.optimize import minimize

    bounds = np.asarray(bounds, dtype=float)
    rows = bounds if bounds.ndim == 2 and bounds.shape[1] == 2 else np.zeros((1, 2))
    if not np.all((rows[:, 0] > 0.0) & (rows[:, 0] < rows[:, 1]) & np.isfinite(rows[:, 1])):
        raise ValueError(f"`bounds` must hold lowest and highest of each parameter, rising and positive, got {bounds.tolist()}")
    if not len(starts):
        raise ValueError("`starts` must hold at least one place to begin, got none")
    f, edges, failures = _Remembered(criterion), np.log(bounds), []
    g = [_Remembered(limit.function) for limit in limits]
    kept: list[dict[str, Any]] = [
        {"type": "ineq", "fun": lambda u, h=h, limit=limit: limit.largest - h(u)[0], "jac": lambda u, h=h: -h(u)[1]}
        for h, limit in zip(g, limits, strict=True)
    ]
    best: tuple[float, np.ndarray] = (np.inf, np.clip(np.log(starts[0]), *edges.T))
    for k, start in enumerate(starts, 1):
        u = np.clip(np.log(start), *edges.T)
        for _ in range(MOST_BOXES):
            box = np.clip(np.stack([u - BOX, u + BOX], axis=1), edges[:, :1], edges[:, 1:])
            options = {"maxiter": MOST_ITERATIONS, "ftol": 1e-6}
            result = minimize(f, u, jac=True, method="SLSQP", bounds=box, constraints=kept, options=options)
            moved, u = np.abs(result.x - u).max(), np.clip(result.x, *box.T)
            if moved < 0.99 * BOX and result.success:
                break
        else:
            failures.append(f"start {k}: {result.message}")
        if all(h(u)[0] <= limit.largest + KEPT for h, limit in zip(g, limits, strict=True)) and f(u)[0] < best[0]:
            best = (f(u)[0], u)
    q = np.exp(best[1])
    values = {limit.name: float(limit.function(q)[0]) for limit in limits}
    return Design(q, best[0], values, f.evaluations, tuple(failures))


def pareto_front(
    criterion: Function,
    bounds: np.ndarray,
    starts: Callable[[float], Sequence[np.ndarray]],
    limits: Sequence[Limit],
    along: Sequence[float],
) -> list[Design]:
    """Move the first limit along rising values: what does it cost to keep it closer?

    From the loosest to the closest: each search begins where its neighbour ended, and at starts of its own.

    Parameters
    ----------
    criterion, bounds, limits
        As for `constrained_optimum`.
    starts
        A value of the first limit to the places to begin.
    along
        Values of the first limit, rising.

    Returns
    -------
    list of Design
        One for each value; the criterion is infinite where no search kept all limits.

    Raises
    ------
    ValueError
        Where the values do not rise, and as `constrained_optimum`.
    """
    if not limits or any(b <= a for a, b in pairwise(along)):
        raise ValueError(f"`along` must hold rising values of the first of `limits`, got {list(along)}")
    designs: list[Design] = []
    for value in reversed(along):
        moved = [Limit(limits[0].name, limits[0].function, value), *limits[1:]]
        near = [design.q for design in designs if np.isfinite(design.criterion)][-1:]
        designs.append(constrained_optimum(criterion, bounds, [*near, *starts(value)], moved))
    return designs[::-1]
