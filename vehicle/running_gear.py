"""One end of the vehicle: wheel frame, its two wheels on the rails, its suspension under the body, and its drive.

The drive pushes the frame at the axle, F = drag of straight track + gain (v - v_x of the body) / 2. The masses of outer and
inner gimbal ride on the frame, but for what has a state in the gyro unit: of a single gimbal its pitch inertia.
"""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import casadi as ca

from . import wheel_frame
from .alignment import CAPACITY, Alignment, TrackPoint
from .irregularity import unevenness
from .lrt_signals import PLACE
from .pairing import NTCIRW_WHEELS, Pairing
from .rotation import column
from .suspension import Support, support
from .trim import Trim
from .wheel_frame import SIDES, FrameState, Rolling
from .wheel_rail import SLOWEST
from .wheel_report import report

__all__ = ["Carried", "Design", "End", "body_state", "end_of", "frame_mass", "place_rows", "rate_rows"]


@dataclass(frozen=True)
class Design:
    """What is fixed when the vehicle is built.

    Attributes
    ----------
    law : str
        Creep law of the treads, a key of `vehicle.creep_laws.LAWS`.
    solid_axles : bool
        Whether both wheels of an axle turn together.
    pairing : Pairing
        Kind of wheels and rails.
    grid : int
        Number of FASTSIM's strips, and of cells in a strip.
    knots : int
        Free knots of the track's alignment.
    harmonics : int
        Harmonics of irregularity in each channel.
    """

    law: str = "polach"
    solid_axles: bool = False
    pairing: Pairing = NTCIRW_WHEELS
    grid: int = 7
    knots: int = CAPACITY
    harmonics: int = 0


@dataclass(frozen=True)
class Carried:
    """What an end needs of the rest: the body's state and track frame, its height, the rest state, the drive's force (N)."""

    body: FrameState
    under: TrackPoint
    height: Any
    rest: Trim
    thrust: Any


@dataclass(frozen=True)
class End:
    """State derivatives and outputs by name, the suspension's forces, and energies (J) and powers (W) by kind."""

    derivatives: dict[str, Any]
    outputs: dict[str, Any]
    springs: Support
    account: dict[str, Any]


def body_state(s: Mapping[str, ca.SX], prefix: str, offset: Any, height: Any, W: tuple[Any, Any] = (0, 0)) -> FrameState:
    """Place and motion of the body `prefix`, at rest `offset` before the vehicle's middle and `height` over the rails."""

    def get(name: str) -> Any:
        return s[f"{prefix}_{name}"]

    return FrameState(
        s=offset + get("distance"), y=get("lateral_displacement"), z=height + get("vertical_displacement"),
        psi=get("yaw_angle"), phi=get("roll_angle"), theta=get("pitch_angle"),
        v=column(s["speed"] + get("speed_deviation"), get("lateral_velocity"), get("vertical_velocity")),
        omega=column(get("roll_rate"), get("pitch_rate"), get("yaw_rate")), W=W,
    )  # fmt: skip


def place_rows(prefix: str, rates: tuple[Any, ...]) -> dict[str, Any]:
    """Derivatives of the six coordinates of a body, by name."""
    return {f"{prefix}_{name}": rate for (name, *_), rate in zip(PLACE, rates, strict=True)}


def rate_rows(prefix: str, v_dot: ca.SX, omega_dot: ca.SX) -> dict[str, Any]:
    """Derivatives of the six velocities of a body, by name."""
    names = ("speed_deviation", "lateral_velocity", "vertical_velocity", "roll_rate", "pitch_rate", "yaw_rate")
    values = (v_dot[0], v_dot[1], v_dot[2], omega_dot[0], omega_dot[1], omega_dot[2])
    return {f"{prefix}_{name}": value for name, value in zip(names, values, strict=True)}


def frame_mass(s: Mapping[str, ca.SX]) -> tuple[Any, tuple[Any, Any, Any]]:
    """(mass, (J_x, J_y, J_z)) of a wheel frame with wheels and gimbals; J_y without the wheels' own."""
    b2 = s["contact_half_distance"] ** 2
    m = s["frame_mass"] + 2 * s["wheel_mass"] + s["outer_gimbal_mass"] + s["inner_gimbal_mass"]
    wheels = 2 * (s["wheel_ixx"] + s["wheel_mass"] * b2)
    return m, (
        s["frame_ixx"] + wheels + s["outer_gimbal_ixx"] + s["inner_gimbal_ixx"],
        s["frame_iyy"] + s["outer_gimbal_iyy"] + s["inner_gimbal_iyy"],
        s["frame_izz"] + wheels + s["outer_gimbal_izz"] + s["inner_gimbal_izz"],
    )


def end_of(s: Mapping[str, ca.SX], design: Design, track: Alignment, carried: Carried, end: str) -> End:
    """The equations of the end `end`, "front" or "rear"."""
    body, rest = carried.body, carried.rest
    offset = s["pivot_spacing"] / 2 if end == "front" else -s["pivot_spacing"] / 2
    m, J = frame_mass(s)
    spins = ("axle", "axle") if design.solid_axles else ("left", "right")
    W = tuple(s["speed"] * rest.spin_per_speed + s[f"{end}_{name}_spin_deviation"] for name in spins)
    frame = body_state(s, end, offset, rest.axle_height, (W[0], W[1]))
    under = track.at(frame.s)
    turn = under.turn_rate()
    bogie_angle, bogie_rate = s[f"{end}_bogie_angle"], s[f"{end}_bogie_rate"]
    seen = track.between(body.s, carried.under, frame.s, under)
    springs = support(body, frame, *seen, offset, bogie_angle, bogie_rate, (carried.height, rest.axle_height), s)
    wheels = wheel_frame.rolling(
        frame, turn, unevenness(frame.s, s, design.harmonics), s, design.law, design.pairing, design.grid
    )
    gyro = column(*(s[f"{end}_{axis}_moment"] for axis in ("roll", "pitch", "yaw")))
    weight = -m * s["gravity"] * under.up()
    force = wheels.force + springs.frame_force + weight + column(carried.thrust, 0, 0)
    moment = wheels.moment + springs.frame_moment + gyro
    places = wheel_frame.place_rates(frame, turn)
    v_dot, omega_dot, W_dot = wheel_frame.accelerations(
        frame, turn, places[0], m, J, s["wheel_spin_inertia"], force, moment, wheels.axle_moments, design.solid_axles
    )
    derivatives = place_rows(end, places) | rate_rows(end, v_dot, omega_dot)
    derivatives |= {f"{end}_{name}_spin_deviation": rate for name, rate in zip(spins, W_dot, strict=True)}
    derivatives[f"{end}_bogie_angle"] = bogie_rate - body.omega[2]

    outputs: dict[str, Any] = {f"{end}_guiding_force": wheels.force[1]}
    for (side, sign), W_side in zip(SIDES.items(), W, strict=True):
        climb = design.pairing.climb(wheels.touches[side][1], side, s)
        rows = report(*wheels.touches[side], design.pairing.flange_side * sign, climb)
        outputs |= {f"{end}_{side}_{name}": value for name, value in rows.items()} | {f"{end}_{side}_spin": W_side}
    inertias = (m, column(*J), s["wheel_spin_inertia"])
    account = _account(frame, wheels, springs, inertias)
    account |= {"drive_power": carried.thrust * frame.v[0], "gravity_power": ca.dot(weight, frame.v)}
    account["mount_power"] = ca.dot(gyro, frame.omega)
    return End(derivatives, outputs, springs, account)


def _account(frame: FrameState, wheels: Rolling, springs: Support, inertias: tuple[Any, ca.SX, Any]) -> dict[str, Any]:
    """Energies of frame, wheels and springs, heat of dampers and creep, and what the contacts take up by being pressed."""
    m, J, I_y = inertias
    touches = [touch for pair in wheels.touches.values() for touch in pair]
    spinning = sum(tau * (W - frame.omega[1]) for tau, W in zip(wheels.axle_moments, frame.W, strict=True))
    return {
        "kinetic_energy": (m * ca.dot(frame.v, frame.v) + ca.dot(J * frame.omega, frame.omega)
                           + I_y * (frame.W[0] ** 2 + frame.W[1] ** 2)) / 2,
        "spring_energy": springs.energy,
        "damper_heat": springs.heat,
        "creep_heat": sum(touch.heat for touch in touches) * ca.fmax(frame.v[0], SLOWEST),
        "press_power": sum(touch.normal_load * touch.approach_rate for touch in touches),
        "contact_power": ca.dot(wheels.force, frame.v) + ca.dot(wheels.moment, frame.omega) + spinning,
        "gaps": [(touch.gap, touch.approach_rate) for touch in touches],
    }  # fmt: skip
