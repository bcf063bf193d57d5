"""Gyroscopic damper whose rotor spins about the lateral axis, as a traction motor does, in a gimbal that rolls. SI units.

    I_x omega_x' = -k eta - c eta' - H omega_z1,   eta' = omega_x + phi'        (1)  gimbal, about -x
    omega_z1 = psi' cos(eta) + theta' sin(eta)                                  (2)  frame's rate about the gimbal's z axis
    (M_y, M_z) = H omega_x (sin(eta), cos(eta))                                 (3)  moment on the carrying frame
    M_x = -(k eta + c eta')                                                     (4)  roll moment on it

This is nonlinear.py turned by a right angle about z: its roll is our pitch, its pitch our roll reversed. The spin axis in
the frame is (0, cos(eta), -sin(eta)); omega_x is the gimbal's absolute rate about -x, eta' - phi'. To yaw the unit is the
same impedance as one that spins about x (src/cosim/railway/yaw_impedance.py), so where the spin points makes no difference
there; but in a curve this gimbal leans sideways and loads its frame with a roll moment, H v / R, in place of a pitch moment.

The gimbal's roll inertia is a state of the unit; the rotor's, about y, rides on the frame, and so does the gimbal's about z: the
connector says so.

Energy: E = I_x omega_x^2 / 2 + k eta^2 / 2 gives E' = -(M_x phi' + M_y theta' + M_z psi') - c eta'^2, exactly.
Source: our derivation, from nonlinear.py by rotation. The idea of a traction motor as a gyroscopic damper is that of Yoshino,
Hosoya, Yabuno, Lin and Suda, Proc. IMechE F 229(4), 395-401, 2015; their unit is not modelled here, only its spin axis.
"""

from typing import Any

import casadi as ca

from gyro_cosim.component import Component, Variable, build, state

from .mount import CONNECTOR, ENERGY, bonds
from .parameters import FULL, SMALL
from .scene import ROLL, gimbal

__all__ = ["lateral_full", "lateral_small"]

EQUATIONS = """\
I_x omega_x' = -k eta - c eta' - H (psi' cos(eta) + theta' sin(eta)),   eta' = omega_x + phi'     (1)
M_z = H omega_x cos(eta)                                                                          (2)
M_y = H omega_x sin(eta)                                                                          (3)
M_x = -(k eta + c eta')                                                                           (4)
H = I_xg Omega,   k = k_g d_g^2,   c = c_g d_g^2"""

ROLLING = (
    state("gimbal_angle", "rad", "angle of the gimbal against the frame, about -x", symbol="eta", is_output=True, nominal=0.1,
          source="our derivation"),
    state("gimbal_roll_rate", "rad/s", "absolute rate of the gimbal about -x: eta' - phi'", symbol="omega_x", nominal=1.0,
          source="our derivation"),
)  # fmt: skip


def _motion(s: dict[str, ca.SX]) -> tuple[dict[str, Any], dict[str, Any]]:
    """State derivatives and outputs in the source's symbols."""
    H, I_x = s["rotor_inertia"] * s["rotor_speed"], s["gimbal_inertia"]
    k, c = s["gimbal_stiffness"] * s["spring_arm"] ** 2, s["gimbal_damping"] * s["spring_arm"] ** 2
    eta, omega_x = s["gimbal_angle"], s["gimbal_roll_rate"]

    eta_dot = omega_x + s["roll_rate"]
    omega_z1 = s["yaw_rate"] * ca.cos(eta) + s["pitch_rate"] * ca.sin(eta)  # (2)
    omega_x_dot = (-k * eta - c * eta_dot - H * omega_z1) / I_x  # (1)
    return (
        {"gimbal_angle": eta_dot, "gimbal_roll_rate": omega_x_dot},
        {
            "yaw_moment": H * omega_x * ca.cos(eta),  # (3)
            "pitch_moment": H * omega_x * ca.sin(eta),
            "roll_moment": -(k * eta + c * eta_dot),  # (4)
            "stored_energy": (I_x * omega_x**2 + k * eta**2) / 2,
            "dissipated_power": c * eta_dot**2,
        },
    )


def lateral_small() -> Component:
    """Make the unit that spins about the lateral axis, Table 1's numbers.

    Returns
    -------
    Component
        The component `gyro_unit:lateral`.
    """
    return _variant("lateral", "Gyroscopic damper that spins about the lateral axis, as a traction motor", SMALL)


def lateral_full() -> Component:
    """Make the same with Table 2's numbers.

    Returns
    -------
    Component
        The component `gyro_unit:lateral_full`.
    """
    return _variant("lateral_full", "Full-scale gyroscopic damper that spins about the lateral axis, as a traction motor", FULL)


def _variant(variant: str, description: str, parameters: tuple[Variable, ...]) -> Component:
    return build(
        scene=gimbal(ROLL), name="gyro_unit", variant=variant, description=description, equations=EQUATIONS,
        variables=(*CONNECTOR, *ROLLING, *ENERGY, *parameters), model=_motion, internal_step=1e-3,
        bonds=bonds(roll="0", pitch="rotor_inertia", yaw="gimbal_inertia"),
    )  # fmt: skip
