"""Single-gimbal gyroscopic damper with the geometry of a large gimbal angle. SI units.

    I_y omega_y' = -k eta - c eta' - H omega_z1,   eta' = omega_y - theta'      (1)  inner gimbal
    omega_z1 = psi' cos(eta) + phi' sin(eta)                                    (2)  frame's rate about the gimbal's z axis
    (M_x, M_z) = H omega_y (sin(eta), cos(eta))                                 (3)  moment on the carrying frame
    M_y = k eta + c eta'                                                        (4)  pitch moment on it

The rotor's momentum is H e_x1, e_x1 = (cos(eta), 0, -sin(eta)) the spin axis in the frame. Turning with the gimbal's
absolute rate omega it needs the torque omega x H e_x1 = H (omega_z1 e_y - omega_y e_z1), e_z1 = (sin(eta), 0, cos(eta)).
Its y part stands in (1), the reaction of its z1 part on the frame is (3).

The gimbal's own inertias about x1 and z1 ride on the frame (they belong to the vehicle). Left out are the terms of second
order in the rates that couple them with the gimbal's motion and do no work, I_y omega_y (psi' e_x - phi' e_z) on the frame:
multibody.py has them, and the rotor's speed as a freedom.

Energy: E = I_y omega_y^2 / 2 + k eta^2 / 2 gives E' = -(M_x phi' + M_y theta' + M_z psi') - c eta'^2, exactly.
Source: paper, eqs. (2)-(3); the sines and cosines are ours: the paper linearises.
"""

from dataclasses import replace
from typing import Any

import casadi as ca

from gyro_cosim.component import Component, Variable, build

from .mount import CONNECTOR, ENERGY, GIMBAL, SINGLE_GIMBAL
from .parameters import FULL, SMALL
from .scene import gimbal

__all__ = ["consistent", "nonlinear_full", "nonlinear_small"]

EQUATIONS = """\
I_yg omega_y' = -k eta - c eta' - H (psi' cos(eta) + phi' sin(eta)),   eta' = omega_y - theta'     (1)
M_z = H omega_y cos(eta)                                                                           (2)
M_x = H omega_y sin(eta)                                                                           (3)
M_y = k eta + c eta'                                                                               (4)
H = I_xg Omega,   k = k_g d_g^2,   c = c_g d_g^2"""


def _motion(s: dict[str, ca.SX]) -> tuple[dict[str, Any], dict[str, Any]]:
    """State derivatives and outputs in the source's symbols."""
    H, I_y = s["rotor_inertia"] * s["rotor_speed"], s["gimbal_inertia"]
    k, c = s["gimbal_stiffness"] * s["spring_arm"] ** 2, s["gimbal_damping"] * s["spring_arm"] ** 2
    eta, omega_y = s["gimbal_angle"], s["gimbal_pitch_rate"]

    eta_dot = omega_y - s["pitch_rate"]
    omega_z1 = s["yaw_rate"] * ca.cos(eta) + s["roll_rate"] * ca.sin(eta)  # (2)
    omega_y_dot = (-k * eta - c * eta_dot - H * omega_z1) / I_y  # (1)
    return (
        {"gimbal_angle": eta_dot, "gimbal_pitch_rate": omega_y_dot},
        {
            "yaw_moment": H * omega_y * ca.cos(eta),  # (3)
            "roll_moment": H * omega_y * ca.sin(eta),
            "pitch_moment": k * eta + c * eta_dot,  # (4)
            "stored_energy": (I_y * omega_y**2 + k * eta**2) / 2,
            "dissipated_power": c * eta_dot**2,
        },
    )


def nonlinear_small() -> Component:
    """Make the gyro unit with Table 1's numbers and the full gimbal geometry.

    Returns
    -------
    Component
        The component `gyro_unit:nonlinear`.
    """
    return _variant("nonlinear", "Single-gimbal gyroscopic damper with large gimbal angles", SMALL)


def nonlinear_full() -> Component:
    """Make the same with Table 2's numbers: the gyro unit of the full vehicle.

    Returns
    -------
    Component
        The component `gyro_unit:nonlinear_full`.
    """
    return _variant("nonlinear_full", "Full-scale single-gimbal gyroscopic damper with large gimbal angles", FULL)


def consistent() -> Component:
    """Make `nonlinear` with the smallest gimbal inertia a rigid rotor of Table 1's I_xg can have: a thin disc, I_xg / 2.

    Returns
    -------
    Component
        The component `gyro_unit:consistent`.
    """
    disc = next(v.start for v in SMALL if v.name == "rotor_inertia") / 2
    table = tuple(
        replace(v, start=disc, source="thin disc: I_xg / 2; Table 1's 1.3e-4 is impossible for a rigid body",
                assumed=(disc, 2 * disc)) if v.name == "gimbal_inertia" else v
        for v in SMALL
    )  # fmt: skip
    return _variant("consistent", "As nonlinear, with a physically possible gimbal inertia", table)


def _variant(variant: str, description: str, parameters: tuple[Variable, ...]) -> Component:
    return build(
        scene=gimbal(), name="gyro_unit", variant=variant, description=description, equations=EQUATIONS,
        variables=(*CONNECTOR, *GIMBAL, *ENERGY, *parameters), model=_motion, internal_step=1e-3, bonds=SINGLE_GIMBAL,
    )  # fmt: skip
