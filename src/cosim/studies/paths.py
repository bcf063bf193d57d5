"""Studies of a system as a whole, from the monolith: roots over a parameter, decay of the slowest root, best value."""

from collections.abc import Mapping

import numpy as np

from cosim.monolith import Monolith
from cosim.system import System


def roots(system: System, parameter: str, values: np.ndarray) -> np.ndarray:
    """Eigenvalues of the system linearised at the origin, shape (len(values), n_x), each column one continuous path.

    parameter : `component.parameter`; values in its own (SI) unit.
    """
    from scipy.optimize import linear_sum_assignment

    monolith = Monolith(system, free=(parameter,))
    paths: list[np.ndarray] = []
    for value in values:
        new = np.linalg.eigvals(monolith.matrix(np.array([value])))
        if paths:
            _, order = linear_sum_assignment(np.abs(paths[-1][:, None] - new[None, :]))
            new = new[order]
        else:
            new = new[np.lexsort((new.imag, new.real))]
        paths.append(new)
    return np.array(paths)


def travel(paths: np.ndarray) -> np.ndarray:
    """How far each root moves from where it starts, relative to its size; shape (n_x,)."""
    return np.abs(paths - paths[0]).max(axis=0) / np.maximum(np.abs(paths).max(axis=0), 1e-12)


def decay_rates(system: System, across: tuple[str, np.ndarray], along: tuple[str, np.ndarray]) -> np.ndarray:
    """Decay rate (1/s) of the slowest root, shape (len(along), len(across)), over two parameters (name, values in SI)."""
    monolith = Monolith(system, free=(across[0], along[0]))
    return np.array([[_slowest(monolith, (a, b)) for a in across[1]] for b in along[1]])


def best(
    system: System, parameter: str, bounds: tuple[float, float], fixed: Mapping[str, float] | None = None
) -> tuple[float, float]:
    """The value of `parameter` within `bounds` for which the slowest root decays fastest, and that decay rate (1/s)."""
    from scipy.optimize import minimize_scalar

    fixed = fixed or {}
    monolith = Monolith(system, free=(parameter, *fixed))
    # The slowest root changes hands where two paths cross, so the rate may have several peaks: look, then refine.
    grid = np.linspace(*bounds, 201)
    rates = [_slowest(monolith, (value, *fixed.values())) for value in grid]
    k = int(np.argmax(rates))
    near = (grid[max(k - 1, 0)], grid[min(k + 1, grid.size - 1)])
    found = minimize_scalar(lambda value: -_slowest(monolith, (value, *fixed.values())), bounds=near, method="bounded")
    return float(found.x), -float(found.fun)


def _slowest(monolith: Monolith, q: tuple[float, ...]) -> float:
    return -float(np.linalg.eigvals(monolith.matrix(np.array(q))).real.max())
