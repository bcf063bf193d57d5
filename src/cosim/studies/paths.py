"""Studies of small systems in one line: roots over a parameter, decay of the slowest root over two, best value of one."""

from collections.abc import Mapping

import numpy as np

from gyro_cosim.studies.rest import AtRest
from gyro_cosim.system import System


def roots(system: System, parameter: str, values: np.ndarray) -> np.ndarray:
    """Eigenvalues of the system linearised at rest, shape (len(values), n_x), each column one continuous path.

    parameter : `component.parameter`; values in its own (SI) unit.
    """
    return AtRest(system, (parameter,)).paths(np.asarray(values)[:, None])


def travel(paths: np.ndarray) -> np.ndarray:
    """How far each root moves from where it starts, relative to its size; shape (n_x,)."""
    return np.abs(paths - paths[0]).max(axis=0) / np.maximum(np.abs(paths).max(axis=0), 1e-12)


def decay_rates(system: System, across: tuple[str, np.ndarray], along: tuple[str, np.ndarray]) -> np.ndarray:
    """Decay rate (1/s) of the slowest root, shape (len(along), len(across)), over two parameters (name, values in SI)."""
    rest = AtRest(system, (across[0], along[0]))
    return np.array([[-rest.growth((a, b)) for a in across[1]] for b in along[1]])


def best(
    system: System, parameter: str, bounds: tuple[float, float], fixed: Mapping[str, float] | None = None
) -> tuple[float, float]:
    """The value of `parameter` within `bounds` for which the slowest root decays fastest, and that decay rate (1/s)."""
    from scipy.optimize import minimize_scalar

    fixed = fixed or {}
    rest = AtRest(system, (parameter, *fixed))
    # The slowest root changes hands where two paths cross, so the rate may have several peaks: look, then refine.
    grid = np.linspace(*bounds, 201)
    growth = [rest.growth((value, *fixed.values())) for value in grid]
    k = int(np.argmin(growth))
    near = (grid[max(k - 1, 0)], grid[min(k + 1, grid.size - 1)])
    found = minimize_scalar(lambda value: rest.growth((value, *fixed.values())), bounds=near, method="bounded")
    return float(found.x), -float(found.fun)
