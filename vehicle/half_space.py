"""Creep forces of the exact theory by a table: what a half-space of one material gives, over shape and creepages.

With X, Y and S what Kalker's linear theory makes of the longitudinal and lateral creepage and of the spin, over mu N (of
`vehicle.creep_laws`), Z = S max(1, b / a), sigma = sqrt(X^2 + Y^2 + Z^2) and s = sigma / (1 + sigma), the forces are

    Fx = -mu N X A / (1 + sigma),   Fy = -mu N s B,   Mz = -mu N sqrt(a b) s M                                            (1)

with A, B, M tables, straight between their points, over

    t = a / (a + b),   s,   y = Y / sigma,   z = Z / sigma                                                                (2)

All three are even in X and so smooth functions of y and z up to the rim of the disc y^2 + z^2 <= 1, where X is 0: a free wheel
rolls there. At s = 0 they are the linear theory's, at s = 1 those of rigid sliding. `half_space.txt` holds them, made for
Poisson's ratio 0.28 by `tests/support/creep_table.py`, which solves the half-space and says how.
"""

from collections.abc import Callable
from functools import cache
from pathlib import Path
from typing import Any

import casadi as ca
import numpy as np

from gyro_cosim.component.tables import lattice

__all__ = ["SHAPES", "exact_forces"]

FILE = Path(__file__).with_name("half_space.txt")
SHAPES = (1 / 6, 5 / 6)  # a / (a + b) from and to: a / b from 1 / 5 to 5
EPS = 1e-6  # of sigma; keeps the direction of vanishing creepage finite
ROUND = 0.5  # a / (a + b) of a circle


def exact_forces(X: Any, Y: Any, S: Any, shape: tuple[Any, Any] | None = None) -> tuple[Any, Any, Any]:
    """Evaluate (1).

    Parameters
    ----------
    X, Y, S : casadi.SX
        Longitudinal creepage, lateral creepage and spin, each as the force of the linear theory over mu N.
    shape : pair of casadi.SX or None
        t, which the table continues as a constant beyond SHAPES, and b / a. None is a circle, and costs two thirds.

    Returns
    -------
    tuple of casadi.SX
        Fx / (mu N), Fy / (mu N) and Mz / (mu N sqrt(a b)).
    """
    Z = S if shape is None else S * ca.fmax(shape[1], 1)
    sigma = ca.sqrt(X * X + Y * Y + Z * Z + EPS * EPS)
    w = 1 / (1 + sigma)
    s, y, z = sigma * w, Y / sigma, Z / sigma
    e = _round()(s, y, z) if shape is None else _whole()(shape[0], s, y, z)
    return -X * w * e[0], -s * e[1], -s * e[2]


@cache
def _whole() -> Callable[..., ca.SX]:
    axes, values = _table()
    return lattice(axes, values, names=("t", "s", "y", "z"))


@cache
def _round() -> Callable[..., ca.SX]:
    axes, values = _table()
    (k,) = np.flatnonzero(np.isclose(axes[0], ROUND))
    return lattice(axes[1:], values[k], names=("s", "y", "z"))


@cache
def _table() -> tuple[list[np.ndarray], np.ndarray]:
    """The axes (2) and the values, shape (n_t, n_s, n, n, 3); the file holds the half with z > 0."""
    with FILE.open(encoding="utf-8") as file:
        sizes = [int(word) for word in (file.readline(), file.readline())[1].rpartition(":")[2].split()]
    shapes, steps, width, half = sizes
    upper = np.loadtxt(FILE).reshape(shapes, steps, width, half, 3)
    lower = upper[:, :, ::-1, ::-1] * [1.0, -1.0, -1.0]
    across = np.linspace(-1.0, 1.0, width)
    return [np.linspace(*SHAPES, shapes), np.linspace(0.0, 1.0, steps), across, across], np.concatenate([lower, upper], axis=3)
