"""A body in motion, and how its states are called."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import casadi as ca

from ..alignment import TrackPoint
from ..lrt_signals import PLACE
from ..rotation import column
from ..wheel_frame import FrameState
from .description import Wheelset

__all__ = ["Moving", "place_rows", "rate_rows", "spins", "state_of", "summed"]


@dataclass(frozen=True)
class Moving:
    """A body in motion: place and velocities, its track frame, how that turns, rates of its place, its centre at rest."""

    at: FrameState
    under: TrackPoint
    turn: ca.SX
    places: tuple[Any, ...]
    x: Any
    y: Any
    height: Any


def spins(wheelset: Wheelset) -> tuple[str, ...]:
    """What the spins of a wheelset's states are called."""
    return ("axle",) if wheelset.solid else ("left", "right")


def state_of(
    s: Mapping[str, ca.SX],
    prefix: str,
    at: tuple[Any, Any, Any],
    W: tuple[Any, Any] = (0, 0),
    *,
    roll: Any = 0,
    pitches: bool = True,
) -> FrameState:
    """Place and motion of a body whose centre is `at` (x, y, z) at rest, and that is rolled by `roll` there."""
    x, y, height = at

    def get(name: str) -> Any:
        return s[f"{prefix}_{name}"]

    return FrameState(
        s=x + get("distance"), y=y + get("lateral_displacement"), z=height + get("vertical_displacement"),
        psi=get("yaw_angle"), phi=roll + get("roll_angle"), theta=get("pitch_angle") if pitches else ca.SX(0),
        v=column(s["speed"] + get("speed_deviation"), get("lateral_velocity"), get("vertical_velocity")),
        omega=column(get("roll_rate"), get("pitch_rate") if pitches else 0, get("yaw_rate")), W=W,
    )  # fmt: skip


def summed(parts: list[Any]) -> Any:
    """Their sum, in this order."""
    if not parts:
        return ca.SX.zeros(3)
    total = parts[0]
    for part in parts[1:]:
        total = total + part
    return total


def place_rows(prefix: str, rates: tuple[Any, ...]) -> dict[str, Any]:
    """Derivatives of the six coordinates of a body, by name."""
    return {f"{prefix}_{name}": rate for (name, *_), rate in zip(PLACE, rates, strict=True)}


def rate_rows(prefix: str, v_dot: ca.SX, omega_dot: ca.SX) -> dict[str, Any]:
    """Derivatives of the six velocities of a body, by name."""
    names = ("speed_deviation", "lateral_velocity", "vertical_velocity", "roll_rate", "pitch_rate", "yaw_rate")
    values = (v_dot[0], v_dot[1], v_dot[2], omega_dot[0], omega_dot[1], omega_dot[2])
    return {f"{prefix}_{name}": value for name, value in zip(names, values, strict=True)}
