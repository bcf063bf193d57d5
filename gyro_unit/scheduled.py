"""Gyro unit whose rotor turns slower (or faster) in curves: the spin follows the curvature. SI units.

The unit knows of the curvature what its connector tells: the frame's yaw rate, v / R in a curve, filtered.

    r' = (psi' - r) / T_f                                                       (1)  filter
    W_s = Omega [f + (1 - f) / (1 + (r / r_s)^4)]                               (2)  spin wanted, in a tight curve f Omega
    T = T_max tanh(C (W_s - W) / (T_w T_max)),   C W' = T                       (3)  motor, and the rotor's absolute spin W
    I_y omega_y' = -k eta - c eta' - C W omega_z1                               (4)  inner gimbal
    M = -T e_x1 + C W omega_y e_z1 + (k eta + c eta') e_y                       (5)  moment on the carrying frame

e_x1 = (cos(eta), 0, -sin(eta)) spin axis, e_z1 = (sin(eta), 0, cos(eta)), omega_z1 = psi' cos(eta) + phi' sin(eta). The motor
pushes against the gimbal, so the frame feels -T about the spin axis: (5) is the change of the rotor's momentum C W e_x1, as in
multibody.py, less its terms of second order. The controller holds the absolute spin: the rotor does not follow the frame's roll,
and its inertia about x has a state here, so the vehicle must not carry it (`bonds`). For f = 1 the unit is nonlinear.py, but
for that inertia.

A rate cannot tell a tight curve run slowly from a wide one run fast, v / R is all it says; and what the filter does not hold
back of the vehicle's own yaw motion changes the spin too.

Power: P_m = T (W - omega_x1), omega_x1 = phi' cos(eta) - psi' sin(eta), is the motor's; a brake that returns energy has P_m < 0.
Energy: E = (C W^2 + I_y omega_y^2 + k eta^2) / 2 gives E' = -M.w + P_m - c eta'^2, w = (phi', theta', psi'), exactly.
Source: our own.
"""

from typing import Any

import casadi as ca

from gyro_cosim.component import Component, Variable, build, output, state

from .lean_parameters import SCHEDULED_FULL, SCHEDULED_SMALL
from .mount import CONNECTOR, ENERGY, GIMBAL, bonds
from .scene import gimbal

__all__ = ["scheduled_full", "scheduled_small"]

EQUATIONS = """\
r' = (psi' - r) / T_f                                                     (1)
W_s = Omega (f + (1 - f) / (1 + (r / r_s)^4))                             (2)
T = T_max tanh(C (W_s - W) / (T_w T_max)),   C W' = T                     (3)
I_yg omega_y' = -k eta - c eta' - C W omega_z1,   eta' = omega_y - theta' (4)
M_z =  T sin(eta) + C W omega_y cos(eta)                                  (5)
M_x = -T cos(eta) + C W omega_y sin(eta)
M_y = k eta + c eta'
C = I_xg,   k = k_g d_g^2,   c = c_g d_g^2,   omega_z1 = psi' cos(eta) + phi' sin(eta)"""

SCHEDULE = (
    state("rotor_speed_deviation", "rad/s", "absolute spin rate of the rotor less that on straight track", symbol="W - Omega",
          nominal=1.0, source="ours"),
    state("filtered_yaw_rate", "rad/s", "yaw rate behind its filter", symbol="r", nominal=0.1, source="ours"),
    output("spin", "rad/s", "absolute spin of the rotor", symbol="W", nominal=10.0),
    output("motor_power", "W", "mechanical power of the motor into the gyro unit", symbol="P_m", nominal=0.01),
)  # fmt: skip


def _motion(s: dict[str, ca.SX]) -> tuple[dict[str, Any], dict[str, Any]]:
    """State derivatives and outputs in the source's symbols."""
    C, I_y, Omega = s["rotor_inertia"], s["gimbal_inertia"], s["rotor_speed"]
    k, c = s["gimbal_stiffness"] * s["spring_arm"] ** 2, s["gimbal_damping"] * s["spring_arm"] ** 2
    phi_dot, psi_dot, r = s["roll_rate"], s["yaw_rate"], s["filtered_yaw_rate"]
    eta, omega_y, W = s["gimbal_angle"], s["gimbal_pitch_rate"], Omega + s["rotor_speed_deviation"]
    sin, cos = ca.sin(eta), ca.cos(eta)

    f, T_max = s["curve_spin"], s["motor_torque_limit"]
    wanted = Omega * (f + (1 - f) / (1 + (r / s["schedule_rate"]) ** 4))  # (2)
    T = T_max * ca.tanh(C * (wanted - W) / (s["spin_time"] * T_max))  # (3)
    eta_dot = omega_y - s["pitch_rate"]
    tau = k * eta + c * eta_dot
    omega_x1, omega_z1 = phi_dot * cos - psi_dot * sin, psi_dot * cos + phi_dot * sin
    return (
        {
            "gimbal_angle": eta_dot,
            "gimbal_pitch_rate": (-tau - C * W * omega_z1) / I_y,  # (4)
            "rotor_speed_deviation": T / C,
            "filtered_yaw_rate": (psi_dot - r) / s["schedule_filter"],  # (1)
        },
        {
            "yaw_moment": T * sin + C * W * omega_y * cos,  # (5)
            "roll_moment": -T * cos + C * W * omega_y * sin,
            "pitch_moment": tau,
            "spin": W,
            "motor_power": T * (W - omega_x1),
            "stored_energy": (C * W**2 + I_y * omega_y**2 + k * eta**2) / 2,
            "dissipated_power": c * eta_dot**2,
        },
    )


def scheduled_small() -> Component:
    """Make the gyro unit with its spin scheduled on the curvature, Table 1's numbers.

    Returns
    -------
    Component
        The component `gyro_unit:scheduled`.
    """
    return _variant("scheduled", "Gyroscopic damper with its spin scheduled on the curvature", SCHEDULED_SMALL)


def scheduled_full() -> Component:
    """Make the same with Table 2's numbers.

    Returns
    -------
    Component
        The component `gyro_unit:scheduled_full`.
    """
    return _variant("scheduled_full", "Full-scale gyroscopic damper with its spin scheduled on the curvature", SCHEDULED_FULL)


def _variant(variant: str, description: str, parameters: tuple[Variable, ...]) -> Component:
    return build(
        scene=gimbal(), name="gyro_unit", variant=variant, description=description, equations=EQUATIONS,
        variables=(*CONNECTOR, *GIMBAL, *SCHEDULE, *ENERGY, *parameters), model=_motion, internal_step=1e-3,
        bonds=bonds(roll="0", pitch="0", yaw="gimbal_inertia"),
    )  # fmt: skip
