"""Roots of small systems in one line: over one parameter, the slowest over two, the best value of one; a root measured."""

from collections.abc import Mapping

import numpy as np

from ..systems import System
from .at_rest import AtRest


def roots(system: System, parameter: str, values: np.ndarray) -> np.ndarray:
    """Eigenvalues of a system linearised at rest, over one parameter.

    Parameters
    ----------
    system
        Of catalogue components.
    parameter
        As `component.parameter`.
    values
        Of the parameter, in its SI unit, shape (m,).

    Returns
    -------
    paths
        1/s, complex, shape (m, n_x); each column is one continuous path.
    """
    return AtRest(system, (parameter,)).paths(np.asarray(values)[:, None])


def travel(paths: np.ndarray) -> np.ndarray:
    """How far each root moves from where it starts, relative to its size.

    Parameters
    ----------
    paths
        Of `roots`, shape (m, n_x).

    Returns
    -------
    travel
        Shape (n_x,).
    """
    return np.asarray(np.abs(paths - paths[0]).max(axis=0) / np.maximum(np.abs(paths).max(axis=0), 1e-12))


def decay_rates(system: System, across: tuple[str, np.ndarray], along: tuple[str, np.ndarray]) -> np.ndarray:
    """Decay rate of the slowest root over two parameters.

    Parameters
    ----------
    system
        Of catalogue components.
    across, along
        Each the name `component.parameter` and its values in SI units.

    Returns
    -------
    decay
        1/s, shape (values along, values across); negative where a root grows.
    """
    rest = AtRest(system, (across[0], along[0]))
    return np.array([[-rest.growth((a, b)) for a in across[1]] for b in along[1]])


def best(
    system: System, parameter: str, bounds: tuple[float, float], fixed: Mapping[str, float] | None = None
) -> tuple[float, float]:
    """The value of a parameter for which the slowest root decays fastest.

    Parameters
    ----------
    system
        Of catalogue components.
    parameter
        As `component.parameter`.
    bounds
        Its lowest and highest value, in its SI unit.
    fixed
        Values of other parameters, in SI units.

    Returns
    -------
    value, decay
        In the parameter's SI unit, and in 1/s.
    """
    from scipy.optimize import minimize_scalar

    fixed = fixed or {}
    rest = AtRest(system, (parameter, *fixed))
    # The slowest root changes hands where two paths cross, so the rate may have several peaks: look, then refine.
    grid = np.linspace(*bounds, 201)
    growth = [rest.growth((value, *fixed.values())) for value in grid]
    k = int(np.argmin(growth))
    near = (grid[max(k - 1, 0)], grid[min(k + 1, grid.size - 1)])
    refined = minimize_scalar(lambda value: rest.growth((value, *fixed.values())), bounds=near, method="bounded")
    return float(refined.x), -float(refined.fun)


def measured_root(t: np.ndarray, y: np.ndarray) -> complex:
    """The root s (1/s) of y = Re(a e^{s t}), of either sign of growth, by Prony's method; imaginary part not negative.

    With z = e^{s m h} y(k + 2m) = 2 Re(z) y(k + m) - |z|^2 y(k), solved for both numbers over all k by
    least squares; m is half the time between two changes of sign, so that the three values differ as much as they can.

    Parameters
    ----------
    t
        Evenly spaced times over some periods, s, shape (n,).
    y
        One oscillation alone, without offset, shape (n,).

    Returns
    -------
    s
        In 1/s.

    Raises
    ------
    ValueError
        Where `t` is not evenly spaced, or `y` changes its sign less than three times.
    """
    if not (t.ndim == 1 and t.shape == y.shape and np.allclose(np.diff(t), t[1] - t[0], rtol=1e-6, atol=0.0)):
        raise ValueError(f"`t` must be evenly spaced and as long as `y`, got shapes {t.shape} and {y.shape}")
    changes = np.flatnonzero(np.diff(np.signbit(y)))
    if changes.size < 3:
        raise ValueError(f"`y` must change its sign at least three times, it does {changes.size} times")
    m = max(1, round(float(np.diff(changes).mean()) / 2))
    rows = np.column_stack([y[m:-m], y[: -2 * m]])
    (sum_, product), *_ = np.linalg.lstsq(rows, y[2 * m :], rcond=None)
    z = np.roots([1.0, -sum_, -product])[0]
    s = np.log(z.astype(complex)) / (m * (t[1] - t[0]))
    return complex(s.real, abs(s.imag))
