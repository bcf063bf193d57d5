"""The rest state on straight level track: how deep a tread is pressed in, how fast a wheel turns, what drag is left.

By symmetry one wheel decides: its load P must be carried and its axle free of torque. With s, c the sine and cosine of the
tread's contact angle, H the height of the axle over the contact (r0 - delta / c of a cone), and forces by the creep law at
the creepages xi (unknown), 0 and (v - xi v) s / (H v) = (1 - xi) s / H, which the conical tread cannot avoid (spin creep),

    N(delta) c - F2 s = P,       -H F1 + Mz s = 0

are solved for delta and xi by Newton steps, unrolled: a formula in the parameters, exact to rounding, so that a
vehicle whose states all start at zero starts at rest whatever the parameters are. F1 is the drag of one wheel.
FASTSIM's steps take their matrix from Polach's law, which is near it and far cheaper to differentiate, and are one more.
"""

from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Any

import casadi as ca

from .creep_laws import LAWS
from .friction import falling, slip_speed
from .pairing import Standing

__all__ = ["Trim", "rest_state"]

STEPS = 4
MATRIX_FROM = {"fastsim": "polach"}


@dataclass(frozen=True)
class Trim:
    """The rest state of one wheel.

    Attributes
    ----------
    axle_height : casadi.SX
        Over the rail (m).
    creepage : casadi.SX
        Longitudinal (1).
    drag : casadi.SX
        N.
    spin_per_speed : casadi.SX
        Spin over forward speed (rad/m).
    """

    axle_height: Any
    creepage: Any
    drag: Any
    spin_per_speed: Any


def rest_state(s: Mapping[str, ca.SX], wheel_load: Any, law: str, tread: Standing) -> Trim:
    """Set up the rest state.

    Parameters
    ----------
    s : mapping of str to casadi.SX
        A component's symbols by name.
    wheel_load : casadi.SX
        P, static load of the wheel (N).
    law : str
        Creep law, a key of `vehicle.creep_laws.LAWS`.
    tread : Standing
        How the wheel stands.

    Returns
    -------
    Trim
        The state as a formula in the parameters.
    """
    slope = tread.slope
    cosine = 1 / ca.sqrt(1 + slope * slope)
    sine = slope * cosine

    z = ca.SX.sym("z", 2)
    guess = (wheel_load / cosine / tread.stiffness) ** (2 / 3)

    def forces(at: ca.SX, by: str) -> tuple[Any, ...]:
        delta, xi = guess * at[0], 1e-3 * at[1]  # both unknowns of order one
        N, patch = tread.press(delta, 0)
        height, H = tread.heights(delta, cosine)
        patch = replace(patch, mu=falling(s, patch.mu)(slip_speed(s["speed"], xi, ca.SX(0))))
        return N, *LAWS[by](xi, ca.SX(0), (1 - xi) * sine / H, patch), height, H, xi

    def residual(at: ca.SX, by: str) -> ca.SX:
        N, F1, F2, Mz, _, H, _ = forces(at, by)
        return ca.vertcat((N * cosine - F2 * sine) / wheel_load - 1, (Mz * sine - H * F1) / (wheel_load * H))

    jacobian = ca.jacobian(residual(z, MATRIX_FROM.get(law, law)), z)
    at = ca.SX([1.0, 0.0])
    for _ in range(STEPS + (law in MATRIX_FROM)):
        J, r = ca.substitute(jacobian, z, at), residual(at, law)
        determinant = J[0, 0] * J[1, 1] - J[0, 1] * J[1, 0]
        at -= ca.vertcat(J[1, 1] * r[0] - J[0, 1] * r[1], J[0, 0] * r[1] - J[1, 0] * r[0]) / determinant
    _, F1, _, _, height, H, xi = forces(at, law)
    return Trim(height, xi, -F1, (1 - xi) / H)
