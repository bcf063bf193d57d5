"""What springs and dampers between two bodies do, wherever they sit: one, a pair, or four at the corners. SI units.

n springs act along the axes of the upper body (a bogie that turns on its pivot has its own) on the displacement e of a point of
the lower body, and n dampers on its rate e' seen from there:

    F = -(K e + C e') + preload   on the lower body at that point; -F on the upper one at the same point.

Force and reaction share their point, so no angular momentum and no energy is made. e = 0 at rest. The corners at (+-l_x, +-l_y)
are summed in closed form, exactly: their displacements are linear in (+-l_x, +-l_y), so the sum of forces is that of the
middle n times, and the moment about the middle n (l_x^2 S_x x f_x + l_y^2 S_y x f_y), where S_j is the lower body's axis j in
the upper one's axes and f_j = -K (S_j - e_j) - C (w x S_j), w the relative angular velocity.

A damper held by a series stiffness K_s has a state, the stretch q of that, along each such axis (Maxwell; C' with c = 0 there):

    F = -K_s q,   q' = e' - K_s q / c           and with q_j for w x S_j l_j, as above

Curves and dry friction (`laws`) are no straight lines: each corner has its own e = e + i l_x (S_x - e_x) + j l_y (S_y - e_y).
"""

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

import casadi as ca

from ..rotation import about_z, column, cross
from ..wheel_frame import FrameState
from . import laws
from .between import AXES, Springs

__all__ = ["Action", "Meeting", "Seat", "acting", "meeting", "springs_action"]


@dataclass(frozen=True)
class Seat:
    """An upper body: the free body that moves it, and how it turns on that one's pivot.

    Attributes
    ----------
    at : FrameState
        The free body's place and motion.
    pivot : casadi.SX, shape (3, 1)
        Where the pivot is in the free body's axes (m); 0 where there is none.
    angle, rate : casadi.SX
        Angle against the free body (rad), absolute rate about its vertical axis (rad/s).
    x, y, height : casadi.SX
        Of the free body's centre at rest (m).
    """

    at: FrameState
    pivot: ca.SX
    angle: Any
    rate: Any
    x: Any
    y: Any
    height: Any


@dataclass(frozen=True)
class Meeting:
    """A point of the lower body seen from the upper one.

    Attributes
    ----------
    turn, to_body, axes : casadi.SX, shape (3, 3)
        From the upper body's axes to those of the free body that moves it; to the latter from the lower body's track axes,
        and from the lower body's axes.
    up, middle : casadi.SX, shape (3, 1)
        The point in the lower body's axes from its centre, and in the free body's axes from that one's centre (m).
    S, w : casadi.SX
        The lower body's axes and relative angular velocity (rad/s) in the upper one's axes.
    e, e_dot : casadi.SX, shape (3, 1)
        Displacement from rest (m) and its rate (m/s) in the upper body's axes.
    """

    turn: ca.SX
    to_body: ca.SX
    axes: ca.SX
    up: ca.SX
    middle: ca.SX
    S: ca.SX
    w: ca.SX
    e: ca.SX
    e_dot: ca.SX


@dataclass(frozen=True)
class Action:
    """What an element does.

    Attributes
    ----------
    upper, lower : str
        The bodies.
    frame_force, frame_moment : casadi.SX, shape (3, 1)
        On the lower body: N in its track axes, N m about its centre in its axes.
    body_force, body_moment : casadi.SX, shape (3, 1)
        On the free body that moves the upper one: N, and N m about its centre, in its axes.
    pivot_moment : casadi.SX
        On the upper body about its pivot (N m).
    energy, heat : casadi.SX
        Energy stored (J), heat of dampers (W).
    rates : dict of str to casadi.SX
        Derivatives of the element's states, by name.
    power : casadi.SX
        What comes in from outside (W).
    """

    upper: str
    lower: str
    frame_force: ca.SX
    frame_moment: ca.SX
    body_force: ca.SX
    body_moment: ca.SX
    pivot_moment: Any
    energy: Any
    heat: Any
    rates: dict[str, Any] = field(default_factory=dict)
    power: Any = 0


def meeting(seat: Seat, lower: FrameState, seen: tuple[ca.SX, ca.SX], up: ca.SX, rest: ca.SX) -> Meeting:
    """Where the point `up` of the lower body is.

    Parameters
    ----------
    seat, lower
        Upper and lower body.
    seen : tuple of casadi.SX, shapes (3, 1) and (3, 3)
        The lower body's track frame seen in that of the free body of `seat` (`Alignment.between`).
    up, rest : casadi.SX, shape (3, 1)
        The point in the lower body's axes from its centre; at rest from the pivot, in the upper body's axes (m).
    """
    body, (offset, turned) = seat.at, seen
    R_b, R_f = body.attitude(), lower.attitude()
    turn = about_z(seat.angle)
    to_body = R_b.T @ turned
    axes = to_body @ R_f
    middle = R_b.T @ (offset + turned @ column(0, lower.y, lower.z) - column(0, body.y, body.z)) + axes @ up
    S = turn.T @ axes
    e = turn.T @ (middle - seat.pivot) - rest
    omega = column(body.omega[0], body.omega[1], seat.rate)
    v_middle = to_body @ lower.v + axes @ cross(lower.omega, up)
    v_seat = R_b.T @ body.v + cross(body.omega, seat.pivot) + cross(omega, middle - seat.pivot)
    e_dot = turn.T @ (v_middle - v_seat)
    w = turn.T @ (axes @ lower.omega - omega)
    return Meeting(turn, to_body, axes, up, middle, S, w, e, e_dot)


def springs_action(s: Mapping[str, ca.SX], springs: Springs, preload: tuple[Any, ...], seat: Seat, at: Meeting) -> Action:
    """Springs and dampers of the module's docstring; `preload` is (N upwards on the lower body, N m about x and y)."""
    n = springs.count
    K, C = column(*springs.stiffness.of(s)), column(*springs.damping.of(s))
    for i, axis in enumerate(AXES):
        if not getattr(springs.series, axis).is_zero:
            C[i] = 0
    F = -n * (K * at.e + C * at.e_dot)
    M = ca.SX.zeros(3)
    energy, heat = n / 2 * ca.dot(K * at.e, at.e), n * ca.dot(C * at.e_dot, at.e_dot)
    for j, _, half in springs.halves:
        arm = half.of(s)
        S_j = at.S[:, j]
        stretch, rate = S_j - column(j == 0, j == 1, 0), cross(at.w, S_j)
        M += n * arm**2 * cross(S_j, -(K * stretch + C * rate))
        energy += n / 2 * arm**2 * ca.dot(K * stretch, stretch)
        heat += n * arm**2 * ca.dot(C * rate, rate)
    rates: dict[str, Any] = {}
    for more in (*_held_dampers(s, springs, at, rates), *_corners(s, springs, at)):
        F, M, energy, heat = F + more[0], M + more[1], energy + more[2], heat + more[3]
    load, up = column(0, 0, preload[0]), column(0, 0, 1)
    F, energy = F + load, energy - ca.dot(load, at.e)
    heel, tilt = (ca.SX(part) for part in preload[1:])  # of corners that carry unlike forces along z
    if not (heel.is_zero() and tilt.is_zero()):
        M = M + heel * cross(at.S[:, 1], up) + tilt * cross(up, at.S[:, 0])
        energy = energy - heel * at.S[2, 1] + tilt * at.S[2, 0]
    return acting(springs, seat, at, F, M, energy, heat, rates)


def _held_dampers(
    s: Mapping[str, ca.SX], springs: Springs, at: Meeting, rates: dict[str, Any]
) -> list[tuple[ca.SX, ca.SX, Any, Any]]:
    """(force, moment, energy, heat) of dampers with a series stiffness; their states' rates go to `rates`."""
    n, found = springs.count, []
    for i, axis in enumerate(AXES):
        held = getattr(springs.series, axis)
        if held.is_zero:
            continue
        k, c, name = held.of(s), getattr(springs.damping, axis).of(s), f"{springs.name}_{axis}_series"
        along = column(i == 0, i == 1, i == 2)
        for state, rate, arm in (
            (name, at.e_dot[i], None),
            *((f"{name}_{word}", half.of(s) * cross(at.w, at.S[:, j])[i], half.of(s) * at.S[:, j])
              for j, word, half in springs.halves),
        ):  # fmt: skip
            q = s[state]
            force = -n * k * q * along
            rates[state] = rate - k * q / c
            still = ca.SX.zeros(3)
            found.append((force if arm is None else still, still if arm is None else cross(arm, force),
                          n / 2 * k * q * q, n * (k * q) ** 2 / c))  # fmt: skip
    return found


def _corners(s: Mapping[str, ca.SX], springs: Springs, at: Meeting) -> list[tuple[ca.SX, ca.SX, Any, Any]]:
    """(force, moment, energy, heat) of curves and dry friction, corner by corner."""
    rubbing = [axis for axis in AXES if not getattr(springs.friction, axis).is_zero]
    if not rubbing and not springs.curves:
        return []
    l_x, l_y = springs.half_x.of(s), springs.half_y.of(s)
    found = []
    for i, j in springs.corners:
        arm = i * l_x * at.S[:, 0] + j * l_y * at.S[:, 1]
        e = at.e + arm - column(i * l_x, j * l_y, 0)
        e_dot = at.e_dot + cross(at.w, arm)
        force, energy, heat = ca.SX.zeros(3), ca.SX(0), ca.SX(0)
        for axis, curve in springs.curves.items():
            of = AXES.index(axis)
            force[of] -= laws.travelled(curve, s, e[of])
            energy += laws.stored(curve, s, e[of])
        for axis in rubbing:
            of = AXES.index(axis)
            rub = laws.dry_friction(getattr(springs.friction, axis).of(s), springs.friction_speed.of(s), e_dot[of])
            force[of] -= rub
            heat += rub * e_dot[of]
        found.append((force, cross(arm, force), energy, heat))
    return found


def acting(
    joint: Any, seat: Seat, at: Meeting, force: ca.SX, moment: ca.SX, energy: Any, heat: Any, rates: dict[str, Any]
) -> Action:
    """A force at the point and a moment on the lower body, in the upper one's axes, with their reactions."""
    F_body, M_body = -(at.turn @ force), -(at.turn @ moment)
    return Action(
        upper=joint.upper,
        lower=joint.lower,
        frame_force=-(at.to_body.T @ F_body),
        frame_moment=cross(at.up, -(at.axes.T @ F_body)) + at.S.T @ moment,
        body_force=F_body,
        body_moment=cross(at.middle, F_body) + M_body,
        pivot_moment=cross(at.middle - seat.pivot, F_body)[2] + M_body[2],
        energy=energy,
        heat=heat,
        rates=rates,
    )
