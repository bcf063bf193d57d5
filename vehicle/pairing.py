"""What a kind of wheel and rail tells the equations: how it stands at rest, where it touches, how far a flange has climbed.

`Conical` is the closed form of vehicle.wheel_rail, whose sizes are parameters; vehicle.tabulated has profiles given by points.
"""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any, Protocol

import casadi as ca

from .creep_laws import Patch
from .kalker import Coefficients
from .wheel_rail import Touch, Wheel, flange_profile, hertz_stiffness, tread_press, wheel_on_rail

__all__ = ["NTCIRW_WHEELS", "Conical", "Pairing", "Side", "Standing"]


@dataclass(frozen=True)
class Side:
    """One side of a wheel frame.

    Attributes
    ----------
    name : str
        "left" or "right".
    sign : int
        1 or -1.
    yaw : casadi.SX
        Of the frame against the track (rad).
    line : callable
        (y, z, metres ahead of the frame's centre) -> point (m) and unit tangent of the rail's line there; wheel_frame.rail_line.
    """

    name: str
    sign: int
    yaw: Any
    line: Callable[[Any, Any, Any], tuple[ca.SX, ca.SX]]


@dataclass(frozen=True)
class Standing:
    """How a wheel of a centred wheelset stands on straight track.

    Attributes
    ----------
    slope : casadi.SX or float
        Tangent of the contact angle, positive towards the flange.
    stiffness : casadi.SX
        K of N = K delta^1.5, where a search for the rest begins (N/m^1.5).
    press : callable
        Penetration (m) and its rate (m/s) -> normal load (N) and patch.
    heights : callable
        Penetration (m) and cosine of the contact angle -> height of the axle over the rails and over the contact (m).
    area : callable
        Normal load (N) -> product of the patch's semi-axes (m2).
    coefficients : Coefficients
        Kalker's.
    """

    slope: Any
    stiffness: Any
    press: Callable[[Any, Any], tuple[Any, Patch]]
    heights: Callable[[Any, Any], tuple[Any, Any]]
    area: Callable[[Any], Any]
    coefficients: Coefficients


class Pairing(Protocol):
    """A kind of wheel on a kind of rail."""

    @property
    def flange_side(self) -> int:
        """1: flanges outside the rails, -1: inside."""

    @property
    def unlike(self) -> bool:
        """Whether the right side differs from the left."""

    def standing(self, s: Mapping[str, ca.SX], grid: int, side: str = "left") -> Standing:
        """How a wheel stands; `s` are the symbols by name, `grid` FASTSIM's strips and cells."""

    def touches(self, wheel: Wheel, side: Side, s: Mapping[str, ca.SX], law: str, grid: int) -> tuple[Touch, Touch]:
        """Contact of tread and flange; `law` is the creep law of the tread."""

    def climb(self, flange: Touch, side: str, s: Mapping[str, ca.SX]) -> Any:
        """Way of the flange over the rail: 0 at first touch, 1 on the top of the tip."""


@dataclass(frozen=True)
class Conical:
    """A tread whose conicity is linear across, a flange that is a cone with a tip, a rail with a knife edge and a corner.

    Attributes
    ----------
    flange_side : int
        1: flanges outside the rails, -1: inside.
    """

    flange_side: int = 1

    @property
    def unlike(self) -> bool:
        """The sides are alike."""
        return False

    def standing(self, s: Mapping[str, ca.SX], grid: int, side: str = "left") -> Standing:
        """On the tread's middle."""
        K, radius = hertz_stiffness(s)

        def heights(depth: Any, cosine: Any) -> tuple[Any, Any]:
            height = s["rolling_radius"] - depth / cosine
            return height, height

        C = Coefficients(*(s[f"kalker_c{i}"] for i in (11, 22, 23, 33)))
        return Standing(s["conicity"], K, tread_press(s, grid), heights, lambda load: radius * (load / K) ** (2 / 3), C)

    def touches(self, wheel: Wheel, side: Side, s: Mapping[str, ca.SX], law: str, grid: int) -> tuple[Touch, Touch]:
        """The running line under the tread, and the line of the corner's centre, which the flange touches further on."""
        b, sign, towards_flange = s["contact_half_distance"], side.sign, self.flange_side * side.sign
        ahead = -sign * b * ca.sin(side.yaw)  # of the wheel's centre
        on_flange = ahead - towards_flange * s["rolling_radius"] * ca.tan(s["flange_angle"]) * ca.sin(side.yaw)
        running = side.line(sign * b, 0, ahead)
        corner = side.line(sign * b + towards_flange * s["corner_offset"], -s["corner_depth"], on_flange)
        return wheel_on_rail(wheel, running, corner, s, law, grid)

    def climb(self, flange: Touch, side: str, s: Mapping[str, ca.SX]) -> Any:
        """By where the corner's centre is on the flange."""
        _, summit = flange_profile(s)
        start = s["flange_clearance"] + s["corner_offset"]
        return (flange.depth - start) / (summit - start)


NTCIRW_WHEELS = Conical(1)
