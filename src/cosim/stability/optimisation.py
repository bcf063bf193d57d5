"""The best parameters within bounds, by the exact gradient of what a release costs."""

from dataclasses import dataclass

import numpy as np

from .release import Release

UNSETTLED = 100.0  # log of the cost (s) of what never comes to rest: a step that leads there is taken back
AT_BOUND = 1e-6  # relative distance from a bound within which a parameter lies on it


@dataclass(frozen=True, eq=False)
class Optimum:
    """q, shape (n_q,), and the criterion there (log of the cost, or smoothed growth in 1/s).

    at_bound : the parameters that lie on a bound, as "component.parameter lowest" or "... highest".
    found : the criterion that each start led to. evaluations : of criterion and gradient, for each start.
    """

    q: np.ndarray
    criterion: float
    at_bound: tuple[str, ...]
    found: tuple[float, ...]
    evaluations: tuple[int, ...]


def optimum(release: Release, bounds: np.ndarray, *, starts: int = 3, level: float | None = None) -> Optimum:
    """Minimise the cost of `release`, or where `level` (s) is given its smoothed growth, over the free parameters.

    bounds : lowest and highest value of each, all positive, shape (n_q, 2).
    starts : from how many places to begin: the system's own values, then evenly spaced ones between the two ends' corners.
    L-BFGS-B over the logarithms of q, so that parameters of any unit are of one size.
    """
    from scipy.optimize import minimize

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
        return (float(np.log(J)), slope * q / J) if np.isfinite(J) else (UNSETTLED, np.zeros(q.size))

    others = (edges[:, 0] + part * (edges[:, 1] - edges[:, 0]) for part in np.arange(1, starts) / starts)
    results = [minimize(criterion, u, jac=True, method="L-BFGS-B", bounds=edges) for u in (np.log(q0), *others)]
    best = min(results, key=lambda result: result.fun)
    if not best.fun < UNSETTLED:
        raise ValueError(f"the release of system {release.rest.system.name!r} must come to rest at one of the {starts} starts")
    at_bound = [
        f"{name} {side}"
        for name, u, ends in zip(names, best.x, edges, strict=True)
        for side, edge in zip(("lowest", "highest"), ends, strict=True)
        if abs(u - edge) < AT_BOUND
    ]
    return Optimum(
        np.clip(np.exp(best.x), *bounds.T), float(best.fun), tuple(at_bound),
        tuple(float(r.fun) for r in results), tuple(int(r.nfev) for r in results),
    )  # fmt: skip
