"""What is left of the gyro unit where its rotor is at rest, or where its gimbal is locked. SI units.

`off`, rotor at rest (H = 0): the gimbal is a pendulum without gravity on its spring and damper, which only pitch moves,

    I_y omega_y' = -k eta - c eta',   eta' = omega_y - theta'                   (1)
    M_y = k eta + c eta',   M_x = M_z = 0                                       (2)

`locked`, gimbal fixed at eta = 0, rotor turning: the rotor's momentum H e_x turns with the frame,

    (M_x, M_y, M_z) = -omega x H e_x = (0, -H psi', H theta')                   (3)

which does no work: M_y theta' + M_z psi' = 0. The locked gimbal's own inertia about y rides on the frame as those about x and
z do, which the connector says; with a free gimbal it does not.

Energy: E' = -(sum of moment times rate) - c eta'^2, exactly, with E = (I_y omega_y^2 + k eta^2) / 2 in `off`, E = 0 in `locked`
(the rotor keeps its speed in the gimbal, so its energy is a constant, left out).
Source: nonlinear.py with H = 0, and with eta = 0; the two ends between which every gyro unit lies.
"""

from typing import Any

import casadi as ca

from gyro_cosim.component import Component, Variable, build, output

from .mount import CONNECTOR, ENERGY, GIMBAL, bonds
from .parameters import FULL, SMALL
from .scene import gimbal

__all__ = ["locked", "locked_full", "off", "off_full"]

OFF = """\
I_yg omega_y' = -k eta - c eta',   eta' = omega_y - theta'     (1)
M_y = k eta + c eta',   M_x = M_z = 0                          (2)
k = k_g d_g^2,   c = c_g d_g^2"""

LOCKED = """\
M_x = 0,   M_y = -H psi',   M_z = H theta',   eta = 0     (3)
H = I_xg Omega"""

ROTOR = ("rotor_speed", "rotor_inertia")
FIXED = (output("gimbal_angle", "rad", "angle of the inner gimbal against the frame: locked", symbol="eta", nominal=0.1),)


def _off(s: dict[str, ca.SX]) -> tuple[dict[str, Any], dict[str, Any]]:
    """State derivatives and outputs in the source's symbols."""
    I_y = s["gimbal_inertia"]
    k, c = s["gimbal_stiffness"] * s["spring_arm"] ** 2, s["gimbal_damping"] * s["spring_arm"] ** 2
    eta, omega_y = s["gimbal_angle"], s["gimbal_pitch_rate"]

    eta_dot = omega_y - s["pitch_rate"]
    M_y = k * eta + c * eta_dot  # (2)
    return (
        {"gimbal_angle": eta_dot, "gimbal_pitch_rate": -M_y / I_y},  # (1)
        {
            "yaw_moment": 0,
            "roll_moment": 0,
            "pitch_moment": M_y,
            "stored_energy": (I_y * omega_y**2 + k * eta**2) / 2,
            "dissipated_power": c * eta_dot**2,
        },
    )


def _locked(s: dict[str, ca.SX]) -> tuple[dict[str, Any], dict[str, Any]]:
    """No states; outputs in the source's symbols."""
    H = s["rotor_inertia"] * s["rotor_speed"]
    moments = {"roll_moment": 0, "pitch_moment": -H * s["yaw_rate"], "yaw_moment": H * s["pitch_rate"]}  # (3)
    return {}, {**moments, "gimbal_angle": 0, "stored_energy": 0, "dissipated_power": 0}


def off() -> Component:
    """Make the gyro unit with its rotor at rest, Table 1's numbers.

    Returns
    -------
    Component
        The component `gyro_unit:off`.
    """
    return _resting("off", "Gyro unit with its rotor at rest", SMALL)


def off_full() -> Component:
    """Make the gyro unit with its rotor at rest, Table 2's numbers.

    Returns
    -------
    Component
        The component `gyro_unit:off_full`.
    """
    return _resting("off_full", "Full-scale gyro unit with its rotor at rest", FULL)


def locked() -> Component:
    """Make the gyro unit with its gimbal locked, Table 1's numbers.

    Returns
    -------
    Component
        The component `gyro_unit:locked`.
    """
    return _fixed("locked", "Gyro unit with its gimbal locked", SMALL)


def locked_full() -> Component:
    """Make the gyro unit with its gimbal locked, Table 2's numbers.

    Returns
    -------
    Component
        The component `gyro_unit:locked_full`.
    """
    return _fixed("locked_full", "Full-scale gyro unit with its gimbal locked", FULL)


def _start(parameters: tuple[Variable, ...], name: str) -> str:
    """What a parameter that the variant has not is in its table, as text."""
    return repr(next(v.start for v in parameters if v.name == name))


def _resting(variant: str, description: str, parameters: tuple[Variable, ...]) -> Component:
    table, spin = tuple(v for v in parameters if v.name not in ROTOR), _start(parameters, "rotor_inertia")
    return build(
        scene=gimbal(), name="gyro_unit", variant=variant, description=description, equations=OFF,
        variables=(*CONNECTOR, *GIMBAL, *ENERGY, *table), model=_off, internal_step=1e-3,
        bonds=bonds(roll=spin, pitch="0", yaw="gimbal_inertia"),
    )  # fmt: skip


def _fixed(variant: str, description: str, parameters: tuple[Variable, ...]) -> Component:
    table, across = tuple(v for v in parameters if v.name in ROTOR), _start(parameters, "gimbal_inertia")
    return build(
        scene=gimbal(), name="gyro_unit", variant=variant, description=description, equations=LOCKED,
        variables=(*CONNECTOR, *FIXED, *ENERGY, *table), model=_locked, internal_step=1e-3,
        bonds=bonds(roll="rotor_inertia", pitch=across, yaw=across),
    )  # fmt: skip
