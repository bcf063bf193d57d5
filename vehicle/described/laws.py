"""Forces along one direction that are no straight lines: curves with rounded corners, dry friction. SI units.

    ramp(e) = 0 for e < -w,   (e + w)^2 / (4 w) within +-w,   e beyond w          a corner at 0, rounded over +-w        (1)
    f(e) = k_0 e + sum k_j ramp(e - d_j) - sum k_j ramp(d_j - e)                  corners ahead and behind               (2)
    F(v) = F_0 tanh(v / v_0)                                                      dry friction                           (3)

(1) is exactly 0 before its corner and exactly straight behind it, so a bump stop is free within its gap less w. The stored
energy is the integral of (2), in closed form. (3) slides at any speed: it does not hold a load at rest, it creeps.
"""

from collections.abc import Mapping
from typing import Any

import casadi as ca

from .between import Curve

__all__ = ["dry_friction", "ramp", "ramp_energy", "stored", "travelled"]


def ramp(e: Any, w: Any) -> Any:
    """(1)."""
    q = ca.fmin(ca.fmax(e + w, 0), 2 * w)
    return q * q / (4 * w) + ca.fmax(e - w, 0)


def ramp_energy(e: Any, w: Any) -> Any:
    """Integral of (1) from far before the corner."""
    q, beyond = ca.fmin(ca.fmax(e + w, 0), 2 * w), ca.fmax(e - w, 0)
    return q * q * q / (12 * w) + beyond * (beyond + 2 * w) / 2


def travelled(curve: Curve, s: Mapping[str, Any], e: Any) -> Any:
    """(2), the force (N) against a travel e (m)."""
    k, corners = curve.bends(s)
    w = curve.rounding.of(s)
    return k * e + sum(side * by * ramp(side * (e - at), w) for at, by, side in corners)


def stored(curve: Curve, s: Mapping[str, Any], e: Any) -> Any:
    """The energy (J) that it then holds."""
    k, corners = curve.bends(s)
    w = curve.rounding.of(s)
    return k * e * e / 2 + sum(by * ramp_energy(side * (e - at), w) for at, by, side in corners)


def dry_friction(force: Any, v_0: Any, rate: Any) -> Any:
    """(3), N."""
    return force * ca.tanh(rate / v_0)
