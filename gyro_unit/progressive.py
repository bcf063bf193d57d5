"""Gyro unit with a progressive gimbal spring: soft about the centre, or pushing outwards, stiff at the lean of a curve. SI units.

nonlinear.py with another spring and damper: k eta and c become

    tau_s(eta) = k_0 eta + k_1 [eta - (3/2) s atan(eta / s) + s^2 eta / (2 (eta^2 + s^2))]     (1)
    tau_s'(eta) = k_0 + k_1 w,   w = (eta^2 / (eta^2 + s^2))^2                                  (2)
    c(eta) = c_0 + c_1 w                                                                        (3)

k_0 is the stiffness about the centre, k_0 + k_1 that far outside, s the angle at which a quarter of k_1 and c_1 is there: smooth,
and flat in the slot (what is added begins with eta^4), as a buffer with its own damper would be. k_0 < 0 is an over-centre
spring: it pushes the gimbal outwards until k_1 holds it. Held in a still frame such a gimbal does not stay at eta = 0; on a
vehicle a spinning rotor can keep it there (src/cosim/railway/yaw_stability.py says when). For k_1 = c_1 = 0 the unit is
nonlinear.py.

Energy: E = I_y omega_y^2 / 2 + V(eta), V' = tau_s,
V = k_0 eta^2 / 2 + k_1 [eta^2 / 2 - (3/2) s eta atan(eta / s) + s^2 ln(1 + eta^2 / s^2)], gives
E' = -(M_x phi' + M_y theta' + M_z psi') - c(eta) eta'^2, exactly. With k_0 < 0 < k_0 + k_1 the energy V is negative
beside the centre and bounded below: the unit is passive, but can return what its spring was loaded with.
Source: our own; the paper's spring is linear.
"""

from typing import Any

import casadi as ca

from gyro_cosim.component import Component, Variable, build

from .lean_parameters import PROGRESSIVE_FULL, PROGRESSIVE_SMALL
from .mount import CONNECTOR, ENERGY, GIMBAL, SINGLE_GIMBAL
from .scene import gimbal

__all__ = ["progressive_full", "progressive_small"]

EQUATIONS = """\
I_yg omega_y' = -tau_s - c eta' - H (psi' cos(eta) + phi' sin(eta)),   eta' = omega_y - theta'
tau_s = k_0 eta + k_1 (eta - 3/2 s atan(eta/s) + s^2 eta / (2 (eta^2 + s^2)))                      (1)
M_z = H omega_y cos(eta)
M_x = H omega_y sin(eta)
M_y = tau_s + c eta'
c = c_0 + c_1 (eta^2 / (eta^2 + s^2))^2                                                            (3)
H = I_xg Omega,   k_0 = k_g d_g^2,   k_1 = k_o d_g^2,   c_0 = c_g d_g^2,   c_1 = c_o d_g^2,   s = eta_s"""


def _motion(x: dict[str, ca.SX]) -> tuple[dict[str, Any], dict[str, Any]]:
    """State derivatives and outputs in the source's symbols."""
    H, I_y, square = x["rotor_inertia"] * x["rotor_speed"], x["gimbal_inertia"], x["spring_arm"] ** 2
    k_0, k_1 = x["gimbal_stiffness"] * square, x["outer_stiffness"] * square
    c_0, c_1, s = x["gimbal_damping"] * square, x["outer_damping"] * square, x["slot_angle"]
    eta, omega_y = x["gimbal_angle"], x["gimbal_pitch_rate"]

    turn, share = ca.atan(eta / s), eta**2 / s**2
    tau_s = k_0 * eta + k_1 * (eta - 1.5 * s * turn + eta / (2 * (1 + share)))  # (1)
    V = k_0 * eta**2 / 2 + k_1 * (eta**2 / 2 - 1.5 * s * eta * turn + s**2 * ca.log(1 + share))
    eta_dot = omega_y - x["pitch_rate"]
    c = c_0 + c_1 * (share / (1 + share)) ** 2  # (3)
    omega_z1 = x["yaw_rate"] * ca.cos(eta) + x["roll_rate"] * ca.sin(eta)
    return (
        {"gimbal_angle": eta_dot, "gimbal_pitch_rate": (-tau_s - c * eta_dot - H * omega_z1) / I_y},
        {
            "yaw_moment": H * omega_y * ca.cos(eta),
            "roll_moment": H * omega_y * ca.sin(eta),
            "pitch_moment": tau_s + c * eta_dot,
            "stored_energy": I_y * omega_y**2 / 2 + V,
            "dissipated_power": c * eta_dot**2,
        },
    )


def progressive_small() -> Component:
    """Make the gyro unit with a progressive spring, Table 1's numbers about the centre.

    Returns
    -------
    Component
        The component `gyro_unit:progressive`.
    """
    return _variant("progressive", "Gyroscopic damper with a progressive gimbal spring", PROGRESSIVE_SMALL)


def progressive_full() -> Component:
    """Make the same with Table 2's numbers about the centre.

    Returns
    -------
    Component
        The component `gyro_unit:progressive_full`.
    """
    return _variant("progressive_full", "Full-scale gyroscopic damper with a progressive gimbal spring", PROGRESSIVE_FULL)


def _variant(variant: str, description: str, parameters: tuple[Variable, ...]) -> Component:
    return build(
        scene=gimbal(), name="gyro_unit", variant=variant, description=description, equations=EQUATIONS,
        variables=(*CONNECTOR, *GIMBAL, *ENERGY, *parameters), model=_motion, internal_step=1e-3, bonds=SINGLE_GIMBAL,
    )  # fmt: skip
