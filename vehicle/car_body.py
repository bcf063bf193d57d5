"""Equations of motion of the car body with its two bogie frames, each turning about a pivot of the body. SI units.

The three are one body of mass m with its centre on the body's axis of symmetry; bogie i sits at x_i = +-L/2, its centre on
the pivot's axis, turned by theta_i, with the absolute rate w_i = omega_z + theta_i' about that axis. In body axes

    H = (J_xx w_x + J_xy w_y,  J_xy w_x + J_yy w_y,  J_zz w_z + sum J_b w_i),   H' + omega x H = M      (1)
    J_b w_i' + (omega x H_i)_z = M_i                                                                    (2)

where J_b is the bogie's own inertia about its vertical axis (so J_zz leaves it out), H_i = J_i(theta_i) omega its momentum
about its own centre in x and y, and M_i the springs' moment about the pivot: a pivot passes no moment about its axis.
J_xx, J_yy and J_xy hold the bogies' inertias turned by theta_i. (2) taken from the z row of (1) leaves J_zz w_z'.

What may act about the pivot between body and bogie, a yaw damper c_p and a rotational inerter b_p, gives the bogie
T_i = -c_p theta_i' - b_p theta_i'' and the body -T_i; the paper has neither. M_i + T_i in (2) makes

    (J_b + b_p) w_i' = N_i + b_p w_z',   N_i = M_i - c_p theta_i' - (omega x H_i)_z                     (3)
    (J_zz + sum b_p J_b / (J_b + b_p)) w_z' = M_z - sum M_i + ... + sum (c_p theta_i' + b_p N_i / (J_b + b_p))   (4)

with the kinetic energy b_p theta_i'^2 / 2 in an inerter and the heat c_p theta_i'^2 in a damper.
"""

from collections.abc import Mapping
from typing import Any

import casadi as ca

from .rotation import column

__all__ = ["accelerations", "bogie_inertia", "common_inertia", "masses", "pivot_heat", "rotational_energy"]


def masses(s: Mapping[str, ca.SX]) -> tuple[Any, Any]:
    """(mass, height of the common centre over the rails) of body and bogies."""
    m = s["body_mass"] + 2 * s["bogie_mass"]
    return m, (s["body_mass"] * s["body_height"] + 2 * s["bogie_mass"] * s["bogie_height"]) / m


def bogie_inertia(s: Mapping[str, ca.SX], angle: Any) -> tuple[Any, Any, Any]:
    """(J_xx, J_yy, J_xy) of a bogie turned by `angle`, about its own centre in body axes."""
    mean, half = (s["bogie_ixx"] + s["bogie_iyy"]) / 2, (s["bogie_ixx"] - s["bogie_iyy"]) / 2
    return mean + half * ca.cos(2 * angle), mean - half * ca.cos(2 * angle), half * ca.sin(2 * angle)


def common_inertia(s: Mapping[str, ca.SX], angles: tuple[Any, Any]) -> tuple[Any, Any, Any, Any]:
    """(J_xx, J_yy, J_xy, J_zz) of (1)."""
    _, height = masses(s)
    up_body, up_bogie = s["body_height"] - height, s["bogie_height"] - height
    m_b, m_g, half = s["body_mass"], s["bogie_mass"], s["pivot_spacing"] / 2
    turned = [bogie_inertia(s, angle) for angle in angles]
    lift = m_b * up_body**2 + 2 * m_g * up_bogie**2
    return (
        s["body_ixx"] + lift + turned[0][0] + turned[1][0],
        s["body_iyy"] + lift + turned[0][1] + turned[1][1] + 2 * m_g * half**2,
        turned[0][2] + turned[1][2],
        s["body_izz"] + 2 * m_g * half**2,
    )


def accelerations(
    s: Mapping[str, ca.SX], omega: ca.SX, angles: tuple[Any, Any], rates: tuple[Any, Any], moment: ca.SX,
    pivot_moments: tuple[Any, Any],
) -> tuple[ca.SX, tuple[Any, Any]]:  # fmt: skip
    """(omega', (w_1', w_2')) from (1) and (2); `moment` about the common centre and `rates` w_i, all in body axes."""
    Jxx, Jyy, Jxy, Jzz = common_inertia(s, angles)
    Jb, c_p, b_p = s["bogie_izz"], s["pivot_damping"], s["pivot_inertance"]
    wx, wy, wz = omega[0], omega[1], omega[2]
    Hx, Hy, Hz = Jxx * wx + Jxy * wy, Jxy * wx + Jyy * wy, Jzz * wz + Jb * (rates[0] + rates[1])
    half = (s["bogie_ixx"] - s["bogie_iyy"]) / 2
    dx: Any = 0  # J' omega, from the turning bogies
    dy: Any = 0
    driven, gyroscopic, damped = [], 0, 0
    for angle, rate, M_i in zip(angles, rates, pivot_moments, strict=True):
        twist = 2 * (rate - wz) * half
        c, q = ca.cos(2 * angle), ca.sin(2 * angle)
        dx, dy = dx + twist * (-q * wx + c * wy), dy + twist * (c * wx + q * wy)
        Ixx, Iyy, Ixy = bogie_inertia(s, angle)
        turning = wx * (Ixy * wx + Iyy * wy) - wy * (Ixx * wx + Ixy * wy)
        driven.append(M_i - c_p * (rate - wz) - turning)  # N_i
        gyroscopic = gyroscopic + turning
        damped = damped + c_p * (rate - wz)
    Mx, My = moment[0] - dx - (wy * Hz - wz * Hy), moment[1] - dy - (wz * Hx - wx * Hz)
    Mz = moment[2] - pivot_moments[0] - pivot_moments[1] - (wx * Hy - wy * Hx) + gyroscopic
    Mz = Mz + damped + b_p / (Jb + b_p) * (driven[0] + driven[1])
    wz_dot = Mz / (Jzz + 2 * b_p * Jb / (Jb + b_p))  # (4)
    determinant = Jxx * Jyy - Jxy * Jxy
    omega_dot = column((Jyy * Mx - Jxy * My) / determinant, (Jxx * My - Jxy * Mx) / determinant, wz_dot)
    return omega_dot, ((driven[0] + b_p * wz_dot) / (Jb + b_p), (driven[1] + b_p * wz_dot) / (Jb + b_p))  # (3)


def pivot_heat(s: Mapping[str, ca.SX], omega: ca.SX, rates: tuple[Any, Any]) -> Any:
    """Heat of the yaw dampers between body and bogies (W)."""
    return s["pivot_damping"] * ((rates[0] - omega[2]) ** 2 + (rates[1] - omega[2]) ** 2)


def rotational_energy(s: Mapping[str, ca.SX], omega: ca.SX, angles: tuple[Any, Any], rates: tuple[Any, Any]) -> Any:
    """Kinetic energy of the rotation about the common centre, and of the inerters at the pivots (J)."""
    Jxx, Jyy, Jxy, Jzz = common_inertia(s, angles)
    wx, wy, wz = omega[0], omega[1], omega[2]
    of_bogies = s["bogie_izz"] * (rates[0] ** 2 + rates[1] ** 2)
    of_bogies = of_bogies + s["pivot_inertance"] * ((rates[0] - wz) ** 2 + (rates[1] - wz) ** 2)
    return (Jxx * wx**2 + Jyy * wy**2 + 2 * Jxy * wx * wy + Jzz * wz**2 + of_bogies) / 2
