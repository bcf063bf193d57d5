"""Two counter-rotating rotors in gimbals that a gear turns by opposite angles: no pitch load. SI units.

Rotor 1 has the momentum (H/2) e_x1(eta), rotor 2 has -(H/2) e_x1(-eta), e_x1(eta) = (cos(eta), 0, -sin(eta)); the gimbals'
absolute rates are theta' + eta' and theta' - eta'. Each gives its frame what nonlinear.py derives; together

    I_y eta'' = -k eta - c eta' - H psi' cos(eta)                               (1)  along the gear's one freedom
    M_z = H eta' cos(eta)                                                       (2)  yaw moment on the carrying frame
    M_x =  H theta' sin(eta)                                                    (3)
    M_y = -H phi'   sin(eta)                                                    (4)

The two first-order pitch moments, +- (H/2) psi', cancel in the frame, and so does the drive of the gimbals by pitch, so
that the spring sits in the gear and leaves the frame alone: in a steady curve M_y = 0, where the single gimbal loads its frame
with H psi'. What is left, (3) and (4), is of second order and does no work. With theta' = phi' = 0 it is nonlinear.py.

H, I_y, k, c : of both rotors and gimbals together. Their inertia about y under the frame's own pitch, I_y theta'', rides on the
frame like those about x and z, and the connector says so (`bonds`).
Energy: E = (I_y eta'^2 + k eta^2) / 2 gives E' = -(M_x phi' + M_y theta' + M_z psi') - c eta'^2, exactly.
Source: our derivation from the angular momentum balance; no such gyro unit is in the paper.
"""

from typing import Any

import casadi as ca

from gyro_cosim.component import Component, Variable, build, state

from .mount import CONNECTOR, ENERGY, bonds
from .parameters import FULL, SMALL
from .scene import gimbals

__all__ = ["twin_full", "twin_small"]

EQUATIONS = """\
I_yg eta'' = -k eta - c eta' - H psi' cos(eta)     (1)
M_z = H eta' cos(eta)                              (2)
M_x =  H theta' sin(eta)                           (3)
M_y = -H phi'   sin(eta)                           (4)
H = I_xg Omega,   k = k_g d_g^2,   c = c_g d_g^2, of both rotors and gimbals together"""

GEARED = (
    state("gimbal_angle", "rad", "angle of gimbal 1 against the frame; gimbal 2 has the opposite", symbol="eta", is_output=True,
          nominal=0.1, source="our derivation"),
    state("gimbal_rate", "rad/s", "rate of gimbal 1 against the frame", symbol="eta'", nominal=1.0, source="our derivation"),
)  # fmt: skip


def _motion(s: dict[str, ca.SX]) -> tuple[dict[str, Any], dict[str, Any]]:
    """State derivatives and outputs in the source's symbols."""
    H, I_y = s["rotor_inertia"] * s["rotor_speed"], s["gimbal_inertia"]
    k, c = s["gimbal_stiffness"] * s["spring_arm"] ** 2, s["gimbal_damping"] * s["spring_arm"] ** 2
    eta, eta_dot = s["gimbal_angle"], s["gimbal_rate"]

    eta_ddot = (-k * eta - c * eta_dot - H * s["yaw_rate"] * ca.cos(eta)) / I_y  # (1)
    return (
        {"gimbal_angle": eta_dot, "gimbal_rate": eta_ddot},
        {
            "yaw_moment": H * eta_dot * ca.cos(eta),  # (2)
            "roll_moment": H * s["pitch_rate"] * ca.sin(eta),  # (3)
            "pitch_moment": -H * s["roll_rate"] * ca.sin(eta),  # (4)
            "stored_energy": (I_y * eta_dot**2 + k * eta**2) / 2,
            "dissipated_power": c * eta_dot**2,
        },
    )


def twin_small() -> Component:
    """Make the pair of half rotors with Table 1's numbers together.

    Returns
    -------
    Component
        The component `gyro_unit:twin`.
    """
    return _variant("twin", "Two counter-rotating rotors in geared gimbals", SMALL)


def twin_full() -> Component:
    """Make the pair of half rotors with Table 2's numbers together.

    Returns
    -------
    Component
        The component `gyro_unit:twin_full`.
    """
    return _variant("twin_full", "Full-scale pair of counter-rotating rotors in geared gimbals", FULL)


def _variant(variant: str, description: str, parameters: tuple[Variable, ...]) -> Component:
    return build(
        scene=gimbals(), name="gyro_unit", variant=variant, description=description, equations=EQUATIONS,
        variables=(*CONNECTOR, *GEARED, *ENERGY, *parameters), model=_motion, internal_step=1e-3,
        bonds=bonds(roll="rotor_inertia", pitch="gimbal_inertia", yaw="gimbal_inertia"),
    )  # fmt: skip
