"""The best parameters within bounds, by the exact gradient of what a release costs."""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from .release import Release

TAKEN_BACK = 100.0  # how far above the start's a step counts in the search that leads to where nothing comes to rest
AT_BOUND = 1e-6  # relative distance from a bound within which a parameter lies on it


@dataclass(frozen=True, eq=False)
class _Found:
    """What a search led to: u (logarithms of q), the criterion there, its evaluations, and why it is no optimum, if so."""

    u: np.ndarray
    criterion: float
    evaluations: int
    failure: str


@dataclass(frozen=True, eq=False)
class Optimum:
    """The best place that any start led to.

    Parameters
    ----------
    q
        The parameters, shape (n_q,), in their own units.
    criterion
        There: the logarithm of the cost in s, or the smoothed growth in 1/s where a level was given.
    at_bound
        The parameters that lie on a bound, as "component.parameter lowest" or "... highest".
    criteria
        What each start led to; infinite where nothing on its way comes to rest.
    evaluations
        Of criterion and gradient, for each start.
    not_converged
        Why the search from a start ended without an optimum, one text for each such start; its criterion still counts.
    """

    q: np.ndarray
    criterion: float
    at_bound: tuple[str, ...]
    criteria: tuple[float, ...]
    evaluations: tuple[int, ...]
    not_converged: tuple[str, ...]


def optimum(release: Release, bounds: np.ndarray, *, starts: int = 3, level: float | None = None) -> Optimum:
    """Minimise the cost of `release`, or where `level` is given its smoothed growth, over the free parameters.

    L-BFGS-B over the logarithms of q, so that parameters of any unit are of one size. A step that leads to where nothing comes
    to rest is taken back.

    Parameters
    ----------
    release
        What is let go, and what of it counts.
    bounds
        Lowest and highest value of each free parameter, all positive, shape (n_q, 2).
    starts
        From how many places to begin: the system's own values, then evenly spaced ones between the two ends' corners.
    level
        That of `Release.smoothed_growth`, s.

    Returns
    -------
    Optimum

    Raises
    ------
    ValueError
        For bounds that do not hold the system's own values, and where no start comes to rest.
    """
    names, q0 = release.rest.free, release.rest.q0
    bounds = np.asarray(bounds, dtype=float)
    if bounds.shape != (len(names), 2):
        raise ValueError(f"`bounds` must hold lowest and highest value of each of {', '.join(names)}, got shape {bounds.shape}")
    for name, (low, high), start in zip(names, bounds, q0, strict=True):
        if not 0.0 < low < high < np.inf:
            raise ValueError(f"bounds of {name!r} must be positive, finite and in rising order, got {low:g} and {high:g}")
        if not low * (1 - AT_BOUND) <= start <= high * (1 + AT_BOUND):
            raise ValueError(f"{name!r} must begin within its bounds of {low:g} and {high:g}, got {start:g}")
    if starts < 1:
        raise ValueError(f"`starts` must be at least 1, got {starts}")
    edges = np.log(bounds)

    def criterion(u: np.ndarray) -> tuple[float, np.ndarray]:
        q = np.exp(u)
        if level is not None:
            s, slope = release.smoothed_growth(q, level)
            return s, slope * q
        J, slope, _ = release.gradient(q)
        return (float(np.log(J)), slope * q / J) if np.isfinite(J) else (np.inf, np.zeros(q.size))

    corners = (edges[:, 0] + share * (edges[:, 1] - edges[:, 0]) for share in np.arange(1, starts) / starts)
    results = [_search(criterion, u, edges) for u in (np.log(q0), *corners)]
    best = min(results, key=lambda result: result.criterion)
    if not np.isfinite(best.criterion):
        raise ValueError(f"the release of system {release.rest.system.name!r} must come to rest at one of the {starts} starts")
    at_bound = [
        f"{name} {side}"
        for name, u, ends in zip(names, best.u, edges, strict=True)
        for side, edge in zip(("lowest", "highest"), ends, strict=True)
        if abs(u - edge) < AT_BOUND
    ]
    return Optimum(
        q=np.clip(np.exp(best.u), *bounds.T),
        criterion=best.criterion,
        at_bound=tuple(at_bound),
        criteria=tuple(result.criterion for result in results),
        evaluations=tuple(result.evaluations for result in results),
        not_converged=tuple(f"start {k}: {result.failure}" for k, result in enumerate(results, 1) if result.failure),
    )


def _search(criterion: Callable[[np.ndarray], tuple[float, np.ndarray]], start: np.ndarray, edges: np.ndarray) -> _Found:
    """L-BFGS-B from `start` within `edges`, shape (n_q, 2); where the start itself never comes to rest there is no way down."""
    from scipy.optimize import minimize

    first, _ = criterion(start)
    if not np.isfinite(first):
        return _Found(start, np.inf, 1, "its release never comes to rest")

    def finite(u: np.ndarray) -> tuple[float, np.ndarray]:
        """For the line search, which cannot interpolate infinity."""
        value, slope = criterion(u)
        return (value, slope) if np.isfinite(value) else (first + TAKEN_BACK, slope)

    result = minimize(finite, start, jac=True, method="L-BFGS-B", bounds=edges)
    return _Found(result.x, float(result.fun), 1 + int(result.nfev), "" if result.success else str(result.message))
