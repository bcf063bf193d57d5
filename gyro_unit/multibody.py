"""Gyro unit by Euler's equations: rotor and inner gimbal under all three frame rates, the rotor driven by a motor. SI units.

Derivation. w = (phi', theta', psi') is the frame's absolute rate in frame axes, eta the gimbal's angle about y, and

    e_x1 = (cos(eta), 0, -sin(eta)),  e_z1 = (sin(eta), 0, cos(eta))            gimbal axes in the frame; e_x1 is the spin axis
    omega_x1 = phi' cos(eta) - psi' sin(eta),  omega_z1 = phi' sin(eta) + psi' cos(eta),  omega_y = theta' + eta'

Gimbal and rotor together have the momentum L = (A omega_x1 + C W) e_x1 + B omega_y e_y + A omega_z1 e_z1: C rotor about
its spin axis, W its absolute spin rate, B both about y, A both about z1 and the gimbal about x1, taken as equal. Then
A (omega_x1 e_x1 + omega_z1 e_z1) = A (phi' e_x + psi' e_z) is fixed in the frame whatever eta: it RIDES ON THE FRAME, as the
inertia A about x and z that the vehicle carries. So no acceleration crosses the interface, and nothing is lost. (For unequal
inertias a term is missing, their difference times a frame acceleration times sin(eta). Table 2 has one roll inertia for gimbal
and rotor, 22.04 kg m2, which is C here and has its state W: about x nothing is left to ride on the frame, and the connector
says so.)
The frame exerts on the rest, C W e_x1 + B omega_y e_y, the moment at which that changes, and feels its reaction; the first
part turns with the gimbal's absolute rate, the second with the frame's (Euler's equations):

    C W' = T                                                                    (1)  rotor, T motor less friction
    B omega_y' = -C W omega_z1 - tau                                            (2)  gimbal, eta' = omega_y - theta'
    tau = k eta + c eta' + F_s(eta, eta')                                       (3)  spring, damper, end stops
    M = -T e_x1 + C W omega_y e_z1 + tau e_y + B omega_y (psi' e_x - phi' e_z)  (4)  moment on the carrying frame

Motor and bearing act between gimbal and rotor, on the relative spin Omega_r = W - omega_x1:

    T = clip(T_b(Omega) + K_p e + K_i z, +- T_max) - T_b(Omega_r),  e = Omega - Omega_r,  z' = e while not clipped     (5)
    T_b(n) = b n + T_c tanh(n / n_s)                                            (6)  bearing friction, fed forward in (5)
    F_s = k_s p (1 + d_s p')_+ sign(eta),  p = (|eta| - eta_s)_+                (7)  end stops (Hunt and Crossley 1975)

The states are eta, omega_y, W - Omega and z, so that whatever speed is set the rotor starts at it.

Energy: E = (C W^2 + B omega_y^2 + k eta^2 + k_s p^2) / 2 gives, exactly,
E' = -M.w + P_m - (c eta'^2 + T_b Omega_r + (F_s - k_s p) p'),  P_m = motor torque times Omega_r: but for the motor passive.

Limits: for motion of size s the moments differ from nonlinear.py's by s^2, under yaw and pitch with a stiff speed controller,
and under roll too with motor and bearing free (a rotor held in its gimbal adds its spin inertia C to the frame's roll).
Source: our derivation; Table 1 or 2 for C, B, k, c; motor, bearing and end stops are assumed (rotor_parameters.py).
"""

from typing import Any

import casadi as ca

from gyro_cosim.component import Component, Variable, build, output, state

from .mount import CONNECTOR, ENERGY, GIMBAL, bonds
from .parameters import FULL, SMALL
from .rotor_parameters import ROTOR_FULL, ROTOR_SMALL
from .scene import gimbal

__all__ = ["multibody_full", "multibody_small"]

EQUATIONS = """\
C W' = T                                                                                  (1)
B omega_y' = -C W omega_z1 - tau,   eta' = omega_y - theta'                               (2)
tau = k eta + c eta' + F_s                                                                (3)
M = -T e_x1 + C W omega_y e_z1 + tau e_y + B omega_y (psi' e_x - phi' e_z)                (4)
T = clip(T_b(Omega) + K_p e + K_i z, +-T_max) - T_b(Omega_r),   e = Omega - Omega_r       (5)
T_b(n) = b n + T_c tanh(n / n_s)                                                          (6)
F_s = k_s p (1 + d_s p')_+ sign(eta),   p = (|eta| - eta_s)_+                             (7)
C = I_xg,  B = I_yg,  k = k_g d_g^2,  c = c_g d_g^2,  Omega_r = W - omega_x1
omega_x1 = phi' cos(eta) - psi' sin(eta),   omega_z1 = phi' sin(eta) + psi' cos(eta)"""

ROTOR = (
    state("rotor_speed_deviation", "rad/s", "absolute spin rate of the rotor less the set speed", symbol="W - Omega", nominal=1.0,
          source="our derivation"),
    state("speed_integral", "rad", "integral of the speed error in the controller", symbol="z", nominal=1.0, source="assumed"),
    output("spin", "rad/s", "spin of the rotor in its gimbal", symbol="Omega_r", nominal=10.0),
    output("motor_power", "W", "mechanical power of the motor into the gyro unit", symbol="P_m", nominal=0.01),
)  # fmt: skip


def _motion(s: dict[str, ca.SX]) -> tuple[dict[str, Any], dict[str, Any]]:
    """State derivatives and outputs in the symbols of the docstring."""
    C, B, Omega = s["rotor_inertia"], s["gimbal_inertia"], s["rotor_speed"]
    k, c = s["gimbal_stiffness"] * s["spring_arm"] ** 2, s["gimbal_damping"] * s["spring_arm"] ** 2
    phi_dot, theta_dot, psi_dot = s["roll_rate"], s["pitch_rate"], s["yaw_rate"]
    eta, omega_y, z = s["gimbal_angle"], s["gimbal_pitch_rate"], s["speed_integral"]
    W = Omega + s["rotor_speed_deviation"]
    sin, cos = ca.sin(eta), ca.cos(eta)

    eta_dot = omega_y - theta_dot
    omega_x1, omega_z1 = phi_dot * cos - psi_dot * sin, phi_dot * sin + psi_dot * cos
    Omega_r = W - omega_x1

    def T_b(n: ca.SX) -> ca.SX:  # (6)
        return s["bearing_viscous_friction"] * n + s["bearing_friction"] * ca.tanh(n / s["bearing_friction_speed"])

    e = Omega - Omega_r
    wanted, T_max = T_b(Omega) + s["speed_gain"] * e + s["speed_integral_gain"] * z, s["motor_torque_limit"]
    T_m = ca.fmax(-T_max, ca.fmin(T_max, wanted))
    T = T_m - T_b(Omega_r)  # (5)

    k_s, d_s = s["stop_stiffness"] * s["spring_arm"] ** 2, s["stop_damping"]
    p = ca.fmax(0, ca.fabs(eta) - s["stop_angle"])
    p_dot = ca.sign(eta) * eta_dot
    F_s = k_s * p * ca.fmax(0, 1 + d_s * p_dot)  # (7), along p
    tau = k * eta + c * eta_dot + F_s * ca.sign(eta)  # (3)

    omega_y_dot = (-C * W * omega_z1 - tau) / B  # (2)
    return (
        {
            "gimbal_angle": eta_dot,
            "gimbal_pitch_rate": omega_y_dot,
            "rotor_speed_deviation": T / C,  # (1)
            "speed_integral": ca.if_else(ca.fabs(wanted) <= T_max, e, 0),
        },
        {
            "roll_moment": -T * cos + C * W * omega_y * sin + B * omega_y * psi_dot,  # (4)
            "pitch_moment": tau,
            "yaw_moment": T * sin + C * W * omega_y * cos - B * omega_y * phi_dot,
            "spin": Omega_r,
            "motor_power": T_m * Omega_r,
            "stored_energy": (C * W**2 + B * omega_y**2 + k * eta**2 + k_s * p**2) / 2,
            "dissipated_power": c * eta_dot**2 + T_b(Omega_r) * Omega_r + (F_s - k_s * p) * p_dot,
        },
    )


def multibody_small() -> Component:
    """Make the gyro unit with Table 1's numbers.

    Returns
    -------
    Component
        The component `gyro_unit:multibody`.
    """
    return _variant("multibody", "Gyro unit with rotor, motor and inner gimbal as rigid bodies", (*SMALL, *ROTOR_SMALL))


def multibody_full() -> Component:
    """Make the gyro unit with Table 2's numbers.

    Returns
    -------
    Component
        The component `gyro_unit:multibody_full`.
    """
    description = "Full-scale gyro unit with rotor, motor and inner gimbal as rigid bodies"
    return _variant("multibody_full", description, (*FULL, *ROTOR_FULL))


def _variant(variant: str, description: str, parameters: tuple[Variable, ...]) -> Component:
    return build(
        scene=gimbal(), name="gyro_unit", variant=variant, description=description, equations=EQUATIONS,
        variables=(*CONNECTOR, *GIMBAL, *ROTOR, *ENERGY, *parameters), model=_motion, internal_step=1e-3,
        bonds=bonds(roll="0", pitch="0", yaw="gimbal_inertia"),
    )  # fmt: skip
