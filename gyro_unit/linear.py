"""Single-gimbal gyroscopic damper, linear in the gimbal angle. SI units.

    I_y omega_y' = -k eta - c eta' - H psi',   eta' = omega_y - theta'          (1)  inner gimbal
    M_z = H omega_y                                                             (2)  yaw moment on the carrying frame
    M_y = k eta + c eta'                                                        (3)  pitch moment on it
    M_x = 0                                                                     (4)  second order in eta and the rates

H = I_xg Omega spin momentum, k = k_g d_g^2, c = c_g d_g^2. psi' and theta' are the frame's absolute yaw and pitch rates;
omega_y, the gimbal's absolute rate, is the state, so that no acceleration of the frame is needed.
With theta' = 0 equation (1) is the paper's equation (3) and M_z its term I_xg Omega eta' in equation (2).

Energy: E = I_y omega_y^2 / 2 + k eta^2 / 2 gives E' = -(M_z psi' + M_y theta') - c eta'^2: what the gyro unit takes
from the frame it stores or turns into heat, at every spin.
Source: paper, eqs. (2)-(3), Table 1; the pitch axis follows from the angular momentum balance of nonlinear.py for small eta.
"""

from typing import Any

import casadi as ca

from gyro_cosim.component import Component, Variable, build

from .mount import CONNECTOR, ENERGY, GIMBAL, SINGLE_GIMBAL
from .parameters import FULL, SMALL
from .scene import gimbal

__all__ = ["linear_full", "linear_small"]

EQUATIONS = """\
I_yg omega_y' = -k eta - c eta' - H psi',   eta' = omega_y - theta'     (1)
M_z = H omega_y                                                         (2)
M_y = k eta + c eta',   M_x = 0                                         (3)
H = I_xg Omega,   k = k_g d_g^2,   c = c_g d_g^2"""


def _motion(s: dict[str, ca.SX]) -> tuple[dict[str, Any], dict[str, Any]]:
    """State derivatives and outputs in the source's symbols."""
    H, I_y = s["rotor_inertia"] * s["rotor_speed"], s["gimbal_inertia"]
    k, c = s["gimbal_stiffness"] * s["spring_arm"] ** 2, s["gimbal_damping"] * s["spring_arm"] ** 2
    eta, omega_y, psi_dot = s["gimbal_angle"], s["gimbal_pitch_rate"], s["yaw_rate"]

    eta_dot = omega_y - s["pitch_rate"]
    omega_y_dot = (-k * eta - c * eta_dot - H * psi_dot) / I_y  # (1)
    M_z = H * omega_y  # (2)
    M_y = k * eta + c * eta_dot  # (3)
    return (
        {"gimbal_angle": eta_dot, "gimbal_pitch_rate": omega_y_dot},
        {
            "yaw_moment": M_z,
            "pitch_moment": M_y,
            "roll_moment": 0,
            "stored_energy": (I_y * omega_y**2 + k * eta**2) / 2,
            "dissipated_power": c * eta_dot**2,
        },
    )


def linear_small() -> Component:
    """Make the paper's gyro unit with Table 1's numbers.

    Returns
    -------
    Component
        The component `gyro_unit:linear`.
    """
    return _variant("linear", "Single-gimbal gyroscopic damper, linear in the gimbal angle", SMALL)


def linear_full() -> Component:
    """Make the same with Table 2's numbers: the gyro unit of the full vehicle.

    Returns
    -------
    Component
        The component `gyro_unit:linear_full`.
    """
    return _variant("linear_full", "Full-scale single-gimbal gyroscopic damper, linear in the gimbal angle", FULL)


def _variant(variant: str, description: str, parameters: tuple[Variable, ...]) -> Component:
    return build(
        scene=gimbal(), name="gyro_unit", variant=variant, description=description, equations=EQUATIONS,
        variables=(*CONNECTOR, *GIMBAL, *ENERGY, *parameters), model=_motion, internal_step=1e-3, bonds=SINGLE_GIMBAL,
    )  # fmt: skip
