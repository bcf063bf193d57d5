"""Gyro unit with active centring: a motor on the gimbal axis turns the gimbal slowly back from its lean. SI units.

nonlinear.py with a motor between frame and gimbal, beside spring and damper:

    T = -T_max tanh(k_i z / T_max),   z' = eta                                  (1)  slow loop: integral of the lean
    I_y omega_y' = -k eta - c eta' + T - H omega_z1                             (2)  inner gimbal
    M_y = k eta + c eta' - T                                                    (3)  pitch moment on the carrying frame

The rest is nonlinear.py. In a long curve the motor takes over the moment H v / R from the spring, and the lean goes to zero.
The torque is limited smoothly; the integral goes on behind the limit, so T_max must exceed H v / R. For k_i = 0 the unit is
nonlinear.py.

Power: P_m = T eta' is what the motor gives to the gimbal (negative: takes from it); the power of holding a torque at rest, heat
in a real motor's windings, is not in it.
Energy: E = I_y omega_y^2 / 2 + k eta^2 / 2 gives E' = -(M_x phi' + M_y theta' + M_z psi') + P_m - c eta'^2, exactly: not passive.
Source: our own.
"""

from typing import Any

import casadi as ca

from gyro_cosim.component import Component, Variable, build, output, state

from .lean_parameters import CENTRED_FULL, CENTRED_SMALL
from .mount import CONNECTOR, ENERGY, GIMBAL, SINGLE_GIMBAL
from .scene import gimbal

__all__ = ["centred_full", "centred_small"]

EQUATIONS = """\
T = -T_max tanh(k_i z / T_max),   z' = eta                                                               (1)
I_yg omega_y' = -k eta - c eta' + T - H (psi' cos(eta) + phi' sin(eta)),   eta' = omega_y - theta'       (2)
M_y = k eta + c eta' - T                                                                                 (3)
M_z = H omega_y cos(eta)
M_x = H omega_y sin(eta)
H = I_xg Omega,   k = k_g d_g^2,   c = c_g d_g^2"""

CENTRING = (
    state("lean_integral", "rad.s", "integral of the gimbal angle", symbol="z", nominal=0.1, source="ours"),
    output("centring_torque", "N.m", "torque of the motor on the gimbal", symbol="T", nominal=0.01),
    output("motor_power", "W", "mechanical power of the motor into the gyro unit", symbol="P_m", nominal=0.01),
)


def _motion(s: dict[str, ca.SX]) -> tuple[dict[str, Any], dict[str, Any]]:
    """State derivatives and outputs in the source's symbols."""
    H, I_y = s["rotor_inertia"] * s["rotor_speed"], s["gimbal_inertia"]
    k, c = s["gimbal_stiffness"] * s["spring_arm"] ** 2, s["gimbal_damping"] * s["spring_arm"] ** 2
    eta, omega_y, T_max = s["gimbal_angle"], s["gimbal_pitch_rate"], s["centring_torque_limit"]

    eta_dot = omega_y - s["pitch_rate"]
    omega_z1 = s["yaw_rate"] * ca.cos(eta) + s["roll_rate"] * ca.sin(eta)
    T = -T_max * ca.tanh(s["centring_gain"] * s["lean_integral"] / T_max)  # (1)
    tau = k * eta + c * eta_dot - T
    return (
        {"gimbal_angle": eta_dot, "gimbal_pitch_rate": (-tau - H * omega_z1) / I_y, "lean_integral": eta},  # (2)
        {
            "yaw_moment": H * omega_y * ca.cos(eta),
            "roll_moment": H * omega_y * ca.sin(eta),
            "pitch_moment": tau,  # (3)
            "centring_torque": T,
            "motor_power": T * eta_dot,
            "stored_energy": (I_y * omega_y**2 + k * eta**2) / 2,
            "dissipated_power": c * eta_dot**2,
        },
    )


def centred_small() -> Component:
    """Make the gyro unit with active centring, Table 1's numbers.

    Returns
    -------
    Component
        The component `gyro_unit:centred`.
    """
    return _variant("centred", "Gyroscopic damper with active centring of its gimbal", CENTRED_SMALL)


def centred_full() -> Component:
    """Make the same with Table 2's numbers.

    Returns
    -------
    Component
        The component `gyro_unit:centred_full`.
    """
    return _variant("centred_full", "Full-scale gyroscopic damper with active centring of its gimbal", CENTRED_FULL)


def _variant(variant: str, description: str, parameters: tuple[Variable, ...]) -> Component:
    return build(
        scene=gimbal(), name="gyro_unit", variant=variant, description=description, equations=EQUATIONS,
        variables=(*CONNECTOR, *GIMBAL, *CENTRING, *ENERGY, *parameters), model=_motion, internal_step=1e-3, bonds=SINGLE_GIMBAL,
    )  # fmt: skip
