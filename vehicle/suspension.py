"""Primary suspension between a bogie frame and its wheel frame: springs and dampers along the bogie's axes. SI units.

At each of four corners, at (+-l_x, +-l_y) and height h_s, n springs act on the displacement e of a point of the wheel
frame, seen from the turning bogie, and n dampers on its rate e' seen from there:

    F = -n (K e + C e') - (0, 0, m_body g / 8)   on the wheel frame at that point; -F on the bogie at the same point.

Force and reaction share their point, so no angular momentum and no energy is made. The last term is the preload: e = 0 at
rest. The four corners are summed in closed form, exactly: their displacements are linear in (+-l_x, +-l_y), so the sum of
forces is that of the middle four times, and the moment about the middle 4 n (l_x^2 S_x x f_x + l_y^2 S_y x f_y), where
S_j is the frame's axis j in bogie axes and f_j = -K (S_j - e_j) - C (w x S_j), w the relative angular velocity.
"""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import casadi as ca

from .rotation import about_z, column, cross
from .wheel_frame import FrameState

__all__ = ["Support", "support"]


@dataclass(frozen=True)
class Support:
    """What the suspension of one end does.

    Attributes
    ----------
    frame_force, frame_moment : casadi.SX, shape (3, 1)
        On the wheel frame: N in its track axes, N m about its centre in its axes.
    body_force, body_moment : casadi.SX, shape (3, 1)
        On the body: N, and N m about its centre, in body axes.
    pivot_moment : casadi.SX
        On the bogie about its pivot (N m).
    energy, heat : casadi.SX
        Energy stored in the springs (J), heat of the dampers (W).
    """

    frame_force: ca.SX
    frame_moment: ca.SX
    body_force: ca.SX
    body_moment: ca.SX
    pivot_moment: Any
    energy: Any
    heat: Any


def support(
    body: FrameState, frame: FrameState, offset: ca.SX, turned: ca.SX, pivot_x: Any, pivot_angle: Any, bogie_rate: Any,
    heights: tuple[Any, Any], s: Mapping[str, ca.SX],
) -> Support:  # fmt: skip
    """Set up the suspension of one end.

    Parameters
    ----------
    body, frame : FrameState
        Car body and wheel frame, each in its own track frame.
    offset, turned : casadi.SX, shapes (3, 1) and (3, 3)
        The frame's track frame seen in the body's (`Alignment.between`).
    pivot_x, pivot_angle, bogie_rate : casadi.SX
        Where the pivot is (m), the bogie's angle (rad) and its absolute rate about the pivot's axis (rad/s).
    heights : tuple of two casadi.SX
        Of the body's centre and of the axle over the rails at rest (m).
    s : mapping of str to casadi.SX
        A component's symbols by name.

    Returns
    -------
    Support
        Forces, moments, energy and heat.
    """
    h_body, h_axle = heights
    h_s = s["spring_height"]
    n = s["springs_per_corner"]
    K = n * column(*(s[f"primary_stiffness_{axis}"] for axis in "xyz"))
    C = n * column(*(s[f"primary_damping_{axis}"] for axis in "xyz"))
    l_x, l_y = s["spring_half_spacing_x"], s["spring_half_spacing_y"]
    R_b, R_f = body.attitude(), frame.attitude()
    turn = about_z(pivot_angle)  # from bogie axes to body axes
    pivot = column(pivot_x, 0, 0)
    up = column(0, 0, h_s - h_axle)  # the springs' middle in the frame's axes

    to_body = R_b.T @ turned  # from the frame's track axes to body axes
    axes = to_body @ R_f  # from the frame's axes to body axes
    middle = R_b.T @ (offset + turned @ column(0, frame.y, frame.z) - column(0, body.y, body.z)) + axes @ up
    S = turn.T @ axes
    e = turn.T @ (middle - pivot) - column(0, 0, h_s - h_body)
    bogie_omega = column(body.omega[0], body.omega[1], bogie_rate)
    v_middle = to_body @ frame.v + axes @ cross(frame.omega, up)
    v_bogie = R_b.T @ body.v + cross(body.omega, pivot) + cross(bogie_omega, middle - pivot)
    e_dot = turn.T @ (v_middle - v_bogie)
    w = turn.T @ (axes @ frame.omega - bogie_omega)

    F = -4 * (K * e + C * e_dot)
    M = ca.SX.zeros(3)
    energy, heat = 2 * ca.dot(K * e, e), 4 * ca.dot(C * e_dot, e_dot)
    for j, arm in ((0, l_x), (1, l_y)):
        S_j = S[:, j]
        stretch, rate = S_j - column(j == 0, j == 1, 0), cross(w, S_j)
        M += 4 * arm**2 * cross(S_j, -(K * stretch + C * rate))
        energy += 2 * arm**2 * ca.dot(K * stretch, stretch)
        heat += 4 * arm**2 * ca.dot(C * rate, rate)
    preload = column(0, 0, -(s["body_mass"] + 2 * s["bogie_mass"]) * s["gravity"] / 2)
    F_body, M_body = -(turn @ (F + preload)), -(turn @ M)
    return Support(
        frame_force=-(to_body.T @ F_body),
        frame_moment=cross(up, -(axes.T @ F_body)) + S.T @ M,
        body_force=F_body,
        body_moment=cross(middle, F_body) + M_body,
        pivot_moment=cross(middle - pivot, F_body)[2] + M_body[2],
        energy=energy + ca.dot(preload, -e),
        heat=heat,
    )
