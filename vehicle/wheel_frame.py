"""Equations of motion of a wheel frame (or a solid wheelset) with its two wheels, on the track. SI units.

The frame, its wheels and the gimbals that ride on it are one rigid body of mass m and inertia J about its centre on the axle
line, but for the wheels' inertia about the axle, which turns with each wheel. Velocity v in track axes, angular velocity
omega in the frame's axes, W the absolute spin of a wheel about the axle, Omega the turn of the track frame per metre:

    s' = v_x / (1 + Omega_y z - Omega_z y),   y' = v_y + s' Omega_x z,   z' = v_z - s' Omega_x y        (1)
    m (v' + s' Omega x v) = F                                                                           (2)
    J omega' + omega x (J omega + h e_y) = M - tau e_y,   h = I_y (W_L + W_R)                            (3)
    I_y W' = tau of the wheel: the moment of its contact forces about the axle                          (4)

z in (1) and the moment arms counts from the rails. tau is the sum of the wheels' axle moments: the bearings pass
everything on but that. A solid axle has one W, with 2 I_y and both moments. F and M hold contact forces, weight, the given
drive force at the axle, and what the caller adds: suspension and gyro.
"""

from collections.abc import Mapping
from dataclasses import dataclass
from functools import partial
from typing import Any

import casadi as ca

from . import friction
from .irregularity import Unevenness
from .pairing import Pairing, Side, Standing
from .rotation import angle_rates, attitude, column, cross, dot
from .wheel_rail import SLOWEST, Touch, Wheel, shear_modulus

__all__ = ["SIDES", "FrameState", "Rolling", "accelerations", "longest_step", "place_rates", "rail_line", "rolling"]

SIDES = {"left": 1, "right": -1}


@dataclass(frozen=True)
class FrameState:
    """Place and motion of a body that follows the track.

    Attributes
    ----------
    s, y, z : casadi.SX
        Along the centre line, to the left of it, above the rails (m).
    psi, phi, theta : casadi.SX
        Yaw, roll, pitch against the track (rad).
    v : casadi.SX, shape (3, 1)
        Velocity in track axes (m/s).
    omega : casadi.SX, shape (3, 1)
        Absolute angular velocity in the body's axes (rad/s).
    W : tuple of two casadi.SX
        Absolute spins of left and right wheel (rad/s).
    """

    s: Any
    y: Any
    z: Any
    psi: Any
    phi: Any
    theta: Any
    v: ca.SX
    omega: ca.SX
    W: tuple[Any, Any]

    def attitude(self) -> ca.SX:
        """From the frame's axes to track axes, (3, 3)."""
        return attitude(self.psi, self.phi, self.theta)


def place_rates(at: FrameState, turn: ca.SX) -> tuple[Any, ...]:
    """(s', y', z', psi', phi', theta') of any body that follows the track: (1) and vehicle.rotation; `turn` is Omega."""
    s_dot = at.v[0] / (1 + turn[1] * at.z - turn[2] * at.y)
    relative = at.omega - at.attitude().T @ (s_dot * turn)
    y_dot = at.v[1] + s_dot * turn[0] * at.z
    z_dot = at.v[2] - s_dot * turn[0] * at.y
    return s_dot, y_dot, z_dot, *angle_rates(at.phi, at.theta, relative)


def rail_line(turn: ca.SX, rough: Unevenness, side: int, y: Any, z: Any, x: Any) -> tuple[ca.SX, ca.SX]:
    """A point of the line (y, z) of the rail `side` near `x` metres ahead, and its unit tangent, in the track frame's axes.

    The line at s + u stands at X + u e_x + R (0, y, z); to second order in u: (0, y, z) + T u + (0, Omega_z, -Omega_y) u^2 / 2
    with T = e_x + Omega x (0, y, z) and the unevenness on top.
    """
    lateral, vertical, lateral_slope, vertical_slope = rough.rail(side)
    T = column(1 + turn[1] * z - turn[2] * y, lateral_slope - turn[0] * z, vertical_slope + turn[0] * y)
    bend = column(0, turn[2], -turn[1])
    u = x / T[0]
    t = T + u * bend
    return column(0, y + lateral, z + vertical) + u * (T + u / 2 * bend), t / ca.sqrt(dot(t, t))


@dataclass(frozen=True)
class Rolling:
    """What the rails do to a wheel frame.

    Attributes
    ----------
    force : casadi.SX, shape (3, 1)
        Sum of the contact forces in track axes (N).
    moment : casadi.SX, shape (3, 1)
        Their moment about the frame's centre in its axes (N m).
    axle_moments : tuple of two casadi.SX
        Moment about the axle of left and right wheel (N m).
    touches : dict of str to (Touch, Touch)
        Tread and flange contact of "left" and "right" wheel.
    """

    force: ca.SX
    moment: ca.SX
    axle_moments: tuple[Any, Any]
    touches: dict[str, tuple[Touch, Touch]]


def rolling(
    at: FrameState, turn: ca.SX, rough: Unevenness, s: Mapping[str, ca.SX], law: str, pairing: Pairing, grid: int
) -> Rolling:
    """Set up the contact forces on both wheels.

    Parameters
    ----------
    at : FrameState
        Place and motion of the frame.
    turn : casadi.SX, shape (3, 1)
        Omega, turn of the track frame (rad/m).
    rough : Unevenness
        Irregularity under the axle.
    s : mapping of str to casadi.SX
        A component's symbols by name.
    law : str
        Creep law of the treads.
    pairing : Pairing
        Kind of wheels and rails.
    grid : int
        FASTSIM's strips and cells.

    Returns
    -------
    Rolling
        Forces and moments.
    """
    R, b = at.attitude(), s["contact_half_distance"]
    e_y = column(-ca.sin(at.psi) * ca.cos(at.phi), ca.cos(at.psi) * ca.cos(at.phi), ca.sin(at.phi))
    origin = column(0, at.y, at.z)
    spin_free = R @ at.omega - at.omega[1] * e_y
    speed = ca.fmax(at.v[0], SLOWEST)
    force, moment, axle_moments, touches = ca.SX.zeros(3), ca.SX.zeros(3), [], {}
    for (name, side), W in zip(SIDES.items(), at.W, strict=True):
        towards_flange = pairing.flange_side * side
        centre = origin + side * b * e_y
        wheel = Wheel(centre, towards_flange * e_y, origin, at.v, spin_free + W * e_y, speed, friction.under(s, name, at.s))
        pair = pairing.touches(wheel, Side(name, side, at.psi, partial(rail_line, turn, rough, side)), s, law, grid)
        touches[name] = pair
        here = pair[0].moment + pair[1].moment
        axle_moments.append(here[0] * e_y[0] + here[1] * e_y[1] + here[2] * e_y[2])
        force += pair[0].force + pair[1].force
        moment += here
    return Rolling(force, R.T @ moment, (axle_moments[0], axle_moments[1]), touches)


def accelerations(
    at: FrameState, turn: ca.SX, s_dot: Any, m: Any, J: tuple[Any, Any, Any], I_y: Any, force: ca.SX, moment: ca.SX,
    axle_moments: tuple[Any, Any], solid: bool,
) -> tuple[ca.SX, ca.SX, tuple[Any, Any]]:  # fmt: skip
    """Solve (2) to (4) for (v', omega', (W_L', W_R')).

    Parameters
    ----------
    at, turn
        As in `rolling`; s_dot is the rate of s (m/s).
    m, J, I_y
        Mass (kg), inertias about x, y, z without the wheels' spin, spin inertia of a wheel (kg m^2).
    force, moment : casadi.SX, shape (3, 1)
        N in track axes; N m about the centre in the frame's axes.
    axle_moments : tuple of two casadi.SX
        Of left and right wheel (N m).
    solid : bool
        Whether both wheels turn together.
    """
    v_dot = force / m - cross(s_dot * turn, at.v)
    tau = axle_moments[0] + axle_moments[1]
    h = I_y * (at.W[0] + at.W[1])
    wx, wy, wz = at.omega[0], at.omega[1], at.omega[2]
    Jx, Jy, Jz = J
    omega_dot = column(
        (moment[0] - (Jz - Jy) * wy * wz + h * wz) / Jx,
        (moment[1] - tau - (Jx - Jz) * wx * wz) / Jy,
        (moment[2] - (Jy - Jx) * wx * wy - h * wx) / Jz,
    )
    if solid:
        together = tau / (2 * I_y)
        return v_dot, omega_dot, (together, together)
    return v_dot, omega_dot, (axle_moments[0] / I_y, axle_moments[1] / I_y)


def longest_step(s: Mapping[str, ca.SX], tread: Standing, wheel_load: Any, m: Any, J: tuple[Any, Any, Any], speed: Any) -> Any:
    """Longest explicit Runge-Kutta step (s): creep damps the slip of a light wheel ever faster at low speed.

    Slip along the rail decays with f11 / v (r0^2 / I_y + the frame's share, at most 2 b^2 / J_z or 2 / m), slip across it with
    2 f22 / v (1 / m + r0^2 / J_x), by the linear theory at the static load. The classical method is stable up to 2.78 over that
    rate; a seventh is kept for wheels that carry more than their share and for flanges. benchmarks/vehicle_step.py shows that
    0.5 ms are then good to some nanometres at 5 m/s, flange contact with 16 kN included, where they are 85 % of the limit.

    Parameters
    ----------
    s : mapping of str to casadi.SX
        A component's symbols by name.
    tread : Standing
        How a wheel stands.
    wheel_load, m, J, speed : casadi.SX
        Static load (N), mass (kg), inertias (kg m^2) and forward speed (m/s) of the frame.
    """
    area = tread.area(wheel_load)
    f11, f22 = (shear_modulus(s) * area * C for C in tread.coefficients[:2])
    r2, b2 = s["rolling_radius"] ** 2, s["contact_half_distance"] ** 2
    along = f11 * (r2 / s["wheel_spin_inertia"] + 2 * ca.fmax(b2 / J[2], 1 / m))
    across = 2 * f22 * (1 / m + r2 / J[0])
    return 0.86 * 2.78 * ca.fmax(speed, SLOWEST) / ca.fmax(along, across)
