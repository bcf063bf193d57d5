"""Tangential forces of rolling contact: five laws over Kalker's linear theory, one formula for numbers and symbols.

A law takes the creepages and a `Patch` and returns (Fx, Fy, Mz) on the wheel:

    linear                  Fx = -G ab C11 xi, Fy = -G ab C22 eta - G (ab)^1.5 C23 phi               no limit
    shen-hedrick-elkins     the linear force times (1 - u/3 + u^2/27) below u = 3, then mu N / F      u = F / (mu N)
    polach                  the linear force times (2 / (pi u)) (e / (1 + e^2) + atan e)              e = pi u / 4
    fastsim                 Kalker 1982: tractions of a wire brush, cut at mu p, from the leading edge backwards
    half-space              the exact theory, by the table of vehicle/half_space.py

F is the resultant of the linear Fx and Fy, spin included. Approximations, by name: Shen-Hedrick-Elkins and Polach carry the
spin in the resultant (Polach's own spin terms are not used) and reduce the spin moment Mz by the factor of the force;
FASTSIM takes one flexibility for each creepage and a parabolic pressure. xi and eta are the wheel's slip velocity along
and across the rolling direction over the rolling speed, phi (1/m) its spin about the normal (up) over that speed.

Every law has the same arguments and result, numbers or CasADi symbols:

    xi, eta, phi   longitudinal and lateral creepage (1), spin creepage (1/m)
    q              the patch
    -> Fx, Fy, Mz  forces (N) and spin moment (N m) on the wheel

Sources: Shen, Hedrick, Elkins 1983; Polach 1999; Kalker 1982.
"""

from collections.abc import Callable
from dataclasses import dataclass
from functools import cache
from typing import Any

import casadi as ca
import numpy as np

from .half_space import exact_forces
from .kalker import Coefficients

__all__ = ["LAWS", "NO_FORCE", "Forces", "Patch", "creep_law", "fastsim", "half_space", "linear", "polach", "shen_hedrick_elkins"]

Forces = tuple[Any, Any, Any]
NO_FORCE = 1e-3  # N; keeps the quotient of two vanishing forces finite


@dataclass(frozen=True)
class Patch:
    """A loaded contact patch.

    Attributes
    ----------
    a, b : float or casadi.SX
        Semi-axes along and across the rolling direction (m).
    N : float or casadi.SX
        Normal load (N).
    mu : float or casadi.SX
        Coefficient of friction (1).
    G : float or casadi.SX
        Shear modulus (Pa).
    C : Coefficients
        Kalker's coefficients (1).
    grid : int
        Number of strips, and of cells in a strip, that FASTSIM uses.
    """

    a: Any
    b: Any
    N: Any
    mu: Any
    G: Any
    C: Coefficients
    grid: int = 50


def linear(xi: Any, eta: Any, phi: Any, q: Patch) -> Forces:
    """Kalker's linear theory, without a limit: for small creepages.

    References
    ----------
    Kalker 1967, On the rolling contact of two elastic bodies in the presence of dry friction.
    """
    ab = q.a * q.b
    ab15 = ab * ca.sqrt(ab)
    Fx = -q.G * ab * q.C.C11 * xi
    Fy = -q.G * (ab * q.C.C22 * eta + ab15 * q.C.C23 * phi)
    Mz = q.G * (ab15 * q.C.C23 * eta - ab * ab * q.C.C33 * phi)
    return Fx, Fy, Mz


def _scaled(factor: Callable[[Any], Any], xi: Any, eta: Any, phi: Any, q: Patch) -> Forces:
    """The linear forces times `factor(u)`, u their resultant over the friction limit."""
    Fx, Fy, Mz = linear(xi, eta, phi, q)
    limit = q.mu * q.N + NO_FORCE
    u = ca.sqrt(Fx * Fx + Fy * Fy + NO_FORCE**2) / limit
    e = factor(u)
    return e * Fx, e * Fy, e * Mz


def _shen_hedrick_elkins_factor(u: Any) -> Any:
    below = ca.fmin(u, 3.0)  # the cubic meets 1/u at u = 3 with its slope; beyond, 1/u
    return (1.0 - below / 3.0 + below * below / 27.0) * below / u


def _polach_factor(u: Any) -> Any:
    e = np.pi / 4 * u
    return 2.0 / (np.pi * u) * (e / (1.0 + e * e) + ca.atan(e))


def shen_hedrick_elkins(xi: Any, eta: Any, phi: Any, q: Patch) -> Forces:
    """Shen, Hedrick and Elkins: the cubic of Johnson and Vermeulen on the resultant with spin.

    References
    ----------
    Shen, Hedrick, Elkins 1983, A comparison of alternative creep force models for rail vehicle dynamic analysis.
    """
    return _scaled(_shen_hedrick_elkins_factor, xi, eta, phi, q)


def polach(xi: Any, eta: Any, phi: Any, q: Patch) -> Forces:
    """Polach: smooth in every creepage, reaches the friction limit asymptotically.

    References
    ----------
    Polach 1999, A fast wheel-rail forces calculation computer code.
    """
    return _scaled(_polach_factor, xi, eta, phi, q)


def fastsim(xi: Any, eta: Any, phi: Any, q: Patch) -> Forces:
    """FASTSIM on q.grid strips of q.grid cells, explicit from the leading edge, tractions taken at the cells' centres.

    Numbers use one array operation per column of cells; symbols are unrolled.

    References
    ----------
    Kalker 1982, A fast algorithm for the simplified theory of rolling contact.
    """
    n = q.grid
    L1 = 8.0 * q.a / (3.0 * q.G * q.C.C11)
    L2 = 8.0 * q.a / (3.0 * q.G * q.C.C22)
    L3 = np.pi * q.a * ca.sqrt(q.a / q.b) / (4.0 * q.G * q.C.C23)
    p0 = 2.0 * q.N / (np.pi * q.a * q.b)
    symbolic = any(isinstance(v, ca.SX) for v in (xi, eta, phi, q.a, q.b, q.N, q.mu, q.G))
    strips = (2.0 * np.arange(n) + 1.0) / n - 1.0  # y / b of the strips' centre lines
    if symbolic:
        forces = [_strip(y, xi, eta, phi, q, (L1, L2, L3, p0), ca) for y in strips]
        return tuple(sum(column) for column in zip(*forces, strict=True))
    Fx, Fy, Mz = _strip(strips, float(xi), float(eta), float(phi), q, (float(L1), float(L2), float(L3), float(p0)), np)
    return Fx.sum(), Fy.sum(), Mz.sum()


def _strip(Y: Any, xi: Any, eta: Any, phi: Any, q: Patch, flexibilities: tuple[Any, Any, Any, Any], math: Any) -> Forces:
    """Force and moment of the strip(s) at y = Y b, from the leading edge to the trailing one."""
    L1, L2, L3, p0 = flexibilities
    n = q.grid
    half = np.sqrt(1.0 - Y**2)  # half length of the strip over a
    dx = 2.0 * q.a * half / n
    area = dx * 2.0 * q.b / n
    tx: Any = 0.0
    ty: Any = 0.0
    Fx: Any = 0.0
    Fy: Any = 0.0
    Mz: Any = 0.0
    y = q.b * Y
    for i in range(n):
        X = half * (1.0 - (2.0 * i + 1.0) / n)  # centre of the cell over a
        run = dx / 2.0 if i == 0 else dx  # from the edge or from the last centre
        x_mean = q.a * X + run / 2.0
        tx = tx - run * (xi / L1 - phi * y / L3)
        ty = ty - run * (eta / L2 + phi * x_mean / L3)
        bound = q.mu * p0 * (half**2 - X**2)
        cut = math.fmin(1.0, bound / math.sqrt(tx * tx + ty * ty + 1.0))  # 1 Pa^2 under the root keeps it smooth
        tx, ty = tx * cut, ty * cut
        Fx, Fy, Mz = Fx + area * tx, Fy + area * ty, Mz + area * (q.a * X * ty - y * tx)
    return Fx, Fy, Mz


def half_space(xi: Any, eta: Any, phi: Any, q: Patch) -> Forces:
    """The exact theory of rolling contact for Hertz' ellipse, by a table: errors in docs/vehicle.md.

    Creepages enter scaled by Kalker's coefficients, so those of the patch count. A patch whose `a` is `b`, the same object, is
    a circle, for which the table has one variable less.

    References
    ----------
    Kalker 1990, Three-dimensional elastic bodies in rolling contact.
    """
    values = (xi, eta, phi, q.a, q.b, q.N, q.mu, q.G, *q.C)
    if not any(isinstance(value, ca.SX) for value in values):
        return tuple(float(force) for force in _half_space_of_numbers()(*values))  # type: ignore[return-value]
    limit = q.mu * q.N + NO_FORCE
    circle = q.a is q.b
    middle = q.a if circle else ca.sqrt(q.a * q.b)
    strength = q.G * middle * middle / limit
    shape = None if circle else (q.a / (q.a + q.b), q.b / q.a)
    Fx, Fy, Mz = exact_forces(strength * q.C.C11 * xi, strength * q.C.C22 * eta, strength * middle * q.C.C23 * phi, shape)
    return limit * Fx, limit * Fy, limit * middle * Mz


@cache
def _half_space_of_numbers() -> ca.Function:
    values = [ca.SX.sym("value") for _ in range(12)]
    xi, eta, phi, a, b, N, mu, G, *C = values
    return ca.Function("half_space", values, list(half_space(xi, eta, phi, Patch(a, b, N, mu, G, Coefficients(*C)))))


LAWS: dict[str, Callable[[Any, Any, Any, Patch], Forces]] = {
    "kalker": linear,
    "linear": linear,
    "shen-hedrick-elkins": shen_hedrick_elkins,
    "polach": polach,
    "fastsim": fastsim,
    "half-space": half_space,
}


def creep_law(name: str) -> Callable[[Any, Any, Any, Patch], Forces]:
    """Look a law up.

    Parameters
    ----------
    name : str
        A key of LAWS.

    Returns
    -------
    callable
        law(xi, eta, phi, q) -> (Fx, Fy, Mz); see the module's docstring.

    Raises
    ------
    ValueError
        If there is no such law; the message lists those there are.
    """
    if name not in LAWS:
        raise ValueError(f"law must be one of {', '.join(LAWS)}, got {name!r}")
    return LAWS[name]
