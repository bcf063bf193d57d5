"""Wheel-rail contact as functions: the patch by Hertz, the tangential forces by a law chosen by name.

The same formulas serve numbers here and symbols in the vehicle's equations. Rolling direction x, across y, normal z up;
forces and moment act on the wheel.
"""

import math
from typing import Any, NamedTuple

import casadi as ca
from scipy.optimize import brentq
from scipy.special import ellipe, ellipk

from .creep_laws import Patch, creep_law
from .kalker import coefficients

__all__ = ["CreepForces", "HertzPatch", "creep_forces", "hertz_patch"]


class HertzPatch(NamedTuple):
    """An elliptic contact.

    Attributes
    ----------
    a, b : float
        Semi-axes along and across the rolling direction (m).
    approach : float
        Approach of the bodies (m).
    peak_pressure : float
        Largest pressure (Pa).
    """

    a: float
    b: float
    approach: float
    peak_pressure: float


class CreepForces(NamedTuple):
    """What a contact patch does to the wheel.

    Attributes
    ----------
    Fx, Fy : float or casadi.SX
        Forces along and across the rolling direction (N).
    Mz : float or casadi.SX
        Spin moment about the normal (N m).
    """

    Fx: Any
    Fy: Any
    Mz: Any


def hertz_patch(
    normal_load: float,
    wheel_rolling_radius: float,
    wheel_transverse_radius: float,
    rail_transverse_radius: float,
    youngs_modulus: float,
    poisson_ratio: float,
) -> HertzPatch:
    """Compute the elliptic contact of wheel and rail, both of one material, by Hertz' theory with exact elliptic integrals.

    Parameters
    ----------
    normal_load : float
        N.
    wheel_rolling_radius, wheel_transverse_radius, rail_transverse_radius : float
        m; positive where convex, `math.inf` where straight, the wheel's transverse one negative where hollow.
    youngs_modulus : float
        Pa.
    poisson_ratio : float
        1.

    Returns
    -------
    HertzPatch
        Semi-axes, approach and largest pressure.

    Raises
    ------
    ValueError
        If the load, a radius or the modulus is not positive, or the surfaces conform (no point contact).

    References
    ----------
    Johnson, Contact Mechanics, equations (4.26) to (4.30).
    """
    _positive("normal_load", normal_load)
    _positive("wheel_rolling_radius", wheel_rolling_radius, infinite=True)
    _positive("rail_transverse_radius", rail_transverse_radius, infinite=True)
    _positive("youngs_modulus", youngs_modulus)
    if not -1.0 < poisson_ratio <= 0.5:
        raise ValueError(f"poisson_ratio must lie in -1..0.5, got {poisson_ratio:g}")
    if math.isnan(wheel_transverse_radius) or wheel_transverse_radius == 0.0:
        raise ValueError(f"wheel_transverse_radius must be a number other than 0, got {wheel_transverse_radius:g}")
    A = 0.5 / wheel_rolling_radius  # gap = A x^2 + B y^2, the rail being straight along x
    B = 0.5 / wheel_transverse_radius + 0.5 / rail_transverse_radius
    if not (A > 0.0 and B > 0.0):
        raise ValueError(f"relative curvatures must be positive for a point contact, got {2 * A:g} and {2 * B:g} 1/m")
    ratio = min(A, B) / max(A, B)  # curvature along the long axis over that along the short one

    def curvature_ratio(m: float) -> float:
        """Of an ellipse with m = 1 - (short / long)^2: A_long / A_short = (K - E) / (E / (1 - m) - K)."""
        return float((ellipk(m) - ellipe(m)) / (ellipe(m) / (1.0 - m) - ellipk(m)))

    m = 0.0 if ratio > 1.0 - 1e-6 else brentq(lambda m: curvature_ratio(m) - ratio, 1e-9, 1.0 - 1e-12, xtol=1e-15)
    K, E = float(ellipk(m)), float(ellipe(m))
    modulus = youngs_modulus / (2.0 * (1.0 - poisson_ratio**2))  # 1 / E* = 2 (1 - nu^2) / E
    # A + B = (3 N / (2 pi E*)) E / (long short^2), Johnson, Contact Mechanics, eqs. (4.26)-(4.30)
    long = (1.5 * normal_load * E / (math.pi * modulus * (A + B) * (1.0 - m))) ** (1.0 / 3.0)
    short = long * math.sqrt(1.0 - m)
    approach = 1.5 * normal_load * K / (math.pi * modulus * long)
    a, b = (long, short) if A <= B else (short, long)
    return HertzPatch(a, b, approach, 1.5 * normal_load / (math.pi * a * b))


def creep_forces(
    longitudinal_creepage: Any,
    lateral_creepage: Any,
    spin: Any,
    a: Any,
    b: Any,
    normal_load: Any,
    friction: Any,
    shear_modulus: Any,
    poisson_ratio: Any,
    law: str = "fastsim",
) -> CreepForces:
    """Compute the tangential forces of a patch on the wheel. Numbers give numbers, symbols symbols.

    Parameters
    ----------
    longitudinal_creepage, lateral_creepage : float or casadi.SX
        Slip velocity of the wheel over the rolling speed (1).
    spin : float or casadi.SX
        The wheel's angular velocity about the upward normal over the rolling speed (1/m).
    a, b : float or casadi.SX
        Semi-axes along and across the rolling direction (m).
    normal_load : float or casadi.SX
        N.
    friction : float or casadi.SX
        Coefficient of friction (1).
    shear_modulus : float or casadi.SX
        Pa.
    poisson_ratio : float or casadi.SX
        Of both bodies (1); Kalker's coefficients depend on it.
    law : str
        "kalker" (or "linear"), "shen-hedrick-elkins", "polach", "fastsim" or "half-space"; `vehicle.creep_laws` states each.

    Returns
    -------
    CreepForces
        N, N and N m.

    Raises
    ------
    ValueError
        For an unknown law, friction outside 0..1, a load below 0, axes or modulus that are not positive, or a creepage that is
        not finite.
    """
    force = creep_law(law)
    for name, value, low, high in (
        ("friction", friction, 0.0, 1.0),
        ("poisson_ratio", poisson_ratio, 0.0, 0.5),
        ("normal_load", normal_load, 0.0, math.inf),
    ):
        if not isinstance(value, ca.SX) and not low <= value <= high:
            raise ValueError(f"{name} must lie in {low:g}..{high:g}, got {value:g}")
    for name, value in (("a", a), ("b", b), ("shear_modulus", shear_modulus)):
        if not isinstance(value, ca.SX):
            _positive(name, value)
    creepages = {"longitudinal_creepage": longitudinal_creepage, "lateral_creepage": lateral_creepage, "spin": spin}
    for name, value in creepages.items():
        if not isinstance(value, ca.SX) and not math.isfinite(value):
            raise ValueError(f"{name} must be finite, got {value:g}")
    symbolic = any(isinstance(v, ca.SX) for v in (*creepages.values(), a, b, normal_load, friction, shear_modulus))
    patch = Patch(a, b, normal_load, friction, shear_modulus, coefficients(a, b, poisson_ratio), grid=7 if symbolic else 50)
    forces = force(longitudinal_creepage, lateral_creepage, spin, patch)
    return CreepForces(*(forces if symbolic else map(float, forces)))


def _positive(name: str, value: float, infinite: bool = False) -> None:
    if not (value > 0.0 and (infinite or math.isfinite(value))):
        raise ValueError(f"{name} must be positive{'' if infinite else ' and finite'}, got {value:g}")
