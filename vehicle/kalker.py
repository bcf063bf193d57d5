"""Kalker's coefficients of the linear theory of rolling contact: a table over the patch's axes and Poisson's ratio.

    Fx = -G a b C11 xi
    Fy = -G a b C22 eta - G (a b)^1.5 C23 phi
    Mz =  G (a b)^1.5 C23 eta - G (a b)^2 C33 phi

a lies along the rolling direction. Between two rows of the table the coefficients are linear in the smaller of a/b and b/a;
between Poisson's ratios 0, 0.25 and 0.5 their inverses (compliances) are a parabola. C33 hardly depends on Poisson's
ratio: its column of 0.25 serves all. Source: Kalker 1967. Valid from a/b = 0.1 to b/a = 0.1.
"""

from typing import Any, NamedTuple

import casadi as ca

__all__ = ["LONG", "POISSON", "RATIO", "WIDE", "Coefficients", "coefficients"]

RATIO = (0.1, 0.2, 0.3, 0.4, 0.5, 0.6, 0.7, 0.8, 0.9, 1.0)  # a/b in WIDE, b/a in LONG
POISSON = (0.0, 0.25, 0.5)  # of the rows of C11, C22 and C23

Row = tuple[float, ...]

# patches wide across the rail (a <= b): C11, C22, C23 at the three Poisson's ratios, C33 at 0.25 ...
WIDE: tuple[tuple[Row, ...], ...] = (
    (
        (2.51, 2.59, 2.68, 2.78, 2.88, 2.98, 3.09, 3.19, 3.29, 3.40),
        (3.31, 3.37, 3.44, 3.53, 3.62, 3.72, 3.81, 3.91, 4.01, 4.12),
        (4.85, 4.81, 4.80, 4.82, 4.83, 4.91, 4.97, 5.05, 5.12, 5.20),
    ),
    (
        (2.51, 2.59, 2.68, 2.78, 2.88, 2.98, 3.09, 3.19, 3.29, 3.40),
        (2.52, 2.63, 2.75, 2.88, 3.01, 3.14, 3.28, 3.41, 3.54, 3.67),
        (2.53, 2.66, 2.81, 2.98, 3.14, 3.31, 3.48, 3.65, 3.82, 3.98),
    ),
    (
        (0.334, 0.483, 0.607, 0.720, 0.827, 0.930, 1.03, 1.13, 1.23, 1.33),
        (0.473, 0.603, 0.715, 0.823, 0.929, 1.03, 1.14, 1.25, 1.36, 1.47),
        (0.731, 0.809, 0.889, 0.977, 1.07, 1.18, 1.29, 1.40, 1.51, 1.63),
    ),
    ((8.28, 4.27, 2.96, 2.32, 1.93, 1.68, 1.50, 1.37, 1.27, 1.19),),
)
# ... and long in the rolling direction (a >= b)
LONG: tuple[tuple[Row, ...], ...] = (
    (
        (10.7, 6.96, 5.57, 4.84, 4.37, 4.06, 3.82, 3.65, 3.51, 3.40),
        (11.7, 7.78, 6.34, 5.57, 5.10, 4.78, 4.54, 4.36, 4.22, 4.12),
        (12.9, 8.82, 7.34, 6.57, 6.11, 5.80, 5.58, 5.42, 5.30, 5.20),
    ),
    (
        (10.7, 6.96, 5.57, 4.84, 4.37, 4.06, 3.82, 3.65, 3.51, 3.40),
        (12.8, 8.14, 6.40, 5.48, 4.90, 4.50, 4.21, 3.99, 3.81, 3.67),
        (16.0, 9.79, 7.51, 6.31, 5.56, 5.04, 4.67, 4.39, 4.16, 3.98),
    ),
    (
        (12.2, 5.72, 3.79, 2.88, 2.35, 2.01, 1.76, 1.58, 1.44, 1.33),
        (14.6, 6.63, 4.32, 3.24, 2.62, 2.23, 1.95, 1.75, 1.59, 1.47),
        (18.0, 7.89, 5.01, 3.70, 2.96, 2.50, 2.18, 1.94, 1.77, 1.63),
    ),
    ((0.526, 0.601, 0.674, 0.747, 0.819, 0.892, 0.965, 1.04, 1.11, 1.19),),
)


class Coefficients(NamedTuple):
    """Kalker's coefficients of a patch.

    Attributes
    ----------
    C11, C22, C23, C33 : float or casadi.SX
        Longitudinal, lateral, lateral by spin, and spin (1).
    """

    C11: Any
    C22: Any
    C23: Any
    C33: Any


def _along(x: Any, values: Row) -> Any:
    """Piecewise linear interpolation over RATIO, clamped at both ends, as a sum of ramps: numbers and symbols alike."""
    x = ca.fmin(ca.fmax(x, RATIO[0]), RATIO[-1])
    slopes = [(v - u) / (k - j) for j, k, u, v in zip(RATIO, RATIO[1:], values, values[1:], strict=False)]
    y: Any = values[0] + slopes[0] * (x - RATIO[0])
    for knot, before, after in zip(RATIO[1:-1], slopes, slopes[1:], strict=False):
        y = y + (after - before) * ca.fmax(x - knot, 0.0)
    return y


def _at(x: Any, nu: Any, rows: tuple[Row, ...]) -> Any:
    """A coefficient at ratio `x` and Poisson's ratio `nu`: the parabola through the inverses of the rows."""
    if len(rows) == 1:
        return _along(x, rows[0])
    compliance: Any = 0.0
    for i, row in enumerate(rows):
        j, k = (POISSON[n] for n in range(3) if n != i)
        weight = (nu - j) * (nu - k) / ((POISSON[i] - j) * (POISSON[i] - k))
        compliance = compliance + weight / _along(x, row)
    return 1.0 / compliance


def coefficients(a: Any, b: Any, poisson_ratio: Any = 0.25) -> Coefficients:
    """Interpolate the coefficients of a patch.

    Parameters
    ----------
    a, b : float or casadi.SX
        Semi-axes along and across the rolling direction (m).
    poisson_ratio : float or casadi.SX
        Of both bodies (1).

    Returns
    -------
    Coefficients
        Numbers, or symbols where an argument is one. A symbolic ratio a / b is clamped to the table.

    Raises
    ------
    ValueError
        If a / b is a number outside the table.

    References
    ----------
    Kalker 1967, On the rolling contact of two elastic bodies in the presence of dry friction.
    """
    if not isinstance(a, ca.SX) and not isinstance(b, ca.SX) and not RATIO[0] <= min(a / b, b / a):
        raise ValueError(f"a / b must lie between 0.1 and 10, the range of Kalker's table, got {a / b:g}")
    wide = [_at(a / b, poisson_ratio, rows) for rows in WIDE]
    long = [_at(b / a, poisson_ratio, rows) for rows in LONG]
    return Coefficients(*(ca.if_else(a <= b, w, v) for w, v in zip(wide, long, strict=True)))
