"""What the equations of a vehicle's parts share: places and velocities, the rest state, what springs do."""

from collections.abc import Mapping
from typing import Any

import casadi as ca

from .. import wheel_frame
from ..alignment import Alignment
from ..rotation import column
from ..trim import Trim, rest_state
from ..wheel_frame import FrameState
from .description import Body, Description, Wheelset
from .draws import Draws
from .elements import Action, Seat, meeting, springs_action
from .moving import Moving, spins, state_of
from .statics import Statics, at_rest

__all__ = ["Assembly", "rest_states"]


def rest_states(s: Mapping[str, ca.SX], d: Description, loads: Mapping[str, Any], draws: Draws) -> dict[str, Trim]:
    """The rest state of the wheels, by wheelset; equal loads have theirs once."""
    found: dict[str, Trim] = {}
    for name, load in loads.items():
        twin = next((other for other in found if draws.same(loads[other], load)), None)
        found[name] = found[twin] if twin else rest_state(s, load, d.law, d.grid)
    return found


class Assembly:
    """What the equations of the parts share."""

    def __init__(self, s: Mapping[str, ca.SX], d: Description) -> None:
        self.s, self.d, self.draws = s, d, Draws(d.starts())
        self.track = Alignment.of(s, d.knots)
        self.rest: Statics = at_rest(s, d, self.draws)
        self.trims = rest_states(s, d, self.rest.wheel_loads, self.draws)
        self.bodies = {body.name: self._placed(body) for body in d.free}
        self.wheelsets = {one.name: self._stood(one) for one in d.wheelsets.values()}
        self.moving = self.bodies | self.wheelsets
        self.reference = next(iter(self.moving.values()))
        self._seen: dict[tuple[str, str], tuple[ca.SX, ca.SX]] = {}
        self.actions = {name: self._acting(name) for name in d.springs}

    def _in_motion(self, at: FrameState, x: Any, height: Any) -> Moving:
        under = self.track.at(at.s)
        turn = under.turn_rate()
        return Moving(at, under, turn, wheel_frame.place_rates(at, turn), x, height)

    def _placed(self, body: Body) -> Moving:
        _, x, height = self.d.common_mass(self.s, body.name)
        return self._in_motion(state_of(self.s, body.name, x, height), x, height)

    def _stood(self, one: Wheelset) -> Moving:
        rest, s = self.trims[one.name], self.s
        W = tuple(s["speed"] * rest.spin_per_speed + s[f"{one.name}_{name}_spin_deviation"] for name in spins(one))
        x = one.x.of(s)
        return self._in_motion(state_of(s, one.name, x, rest.axle_height, (W[0], W[-1]), one.pitches), x, rest.axle_height)

    def seat(self, name: str) -> Seat:
        """A body as what carries springs."""
        host = self.moving[self.d.host(name)]
        if self.d.host(name) == name:
            return Seat(host.at, column(0, 0, 0), ca.SX(0), host.at.omega[2], host.x, host.height)
        x = self.draws.clean(self.d.bodies[name].centre.x.of(self.s) - host.x)
        return Seat(host.at, column(x, 0, 0), self.s[f"{name}_angle"], self.s[f"{name}_rate"], host.x, host.height)

    def seen(self, one: str, other: str) -> tuple[ca.SX, ca.SX]:
        """The track frame of `other` seen in that of `one`, both free."""
        if (one, other) not in self._seen:
            a, b = self.moving[one], self.moving[other]
            self._seen[one, other] = self.track.between(a.at.s, a.under, b.at.s, b.under)
        return self._seen[one, other]

    def _acting(self, name: str) -> Action:
        springs, s, clean = self.d.springs[name], self.s, self.draws.clean
        seat, lower = self.seat(springs.upper), self.moving[springs.lower]
        x, _, z = springs.at.of(s)
        up = column(clean(x - lower.x), 0, z - lower.height)
        rest = column(clean(x - seat.x - seat.pivot[0]), 0, z - seat.height)
        at = meeting(seat, lower.at, self.seen(self.d.host(springs.upper), springs.lower), up, rest)
        return springs_action(s, springs, self.rest.preloads.get(name, (0, 0)), seat, at)

    def upon(self, name: str) -> tuple[list[Action], list[Action]]:
        """The springs under a free body, those of its pivots' frames among them, and those over it."""
        under = [a for one, a in self.actions.items() if self.d.host(self.d.springs[one].upper) == name]
        over = [a for one, a in self.actions.items() if self.d.springs[one].lower == name]
        return under, over

    def mounted(self, name: str) -> list[ca.SX]:
        """Moments of the gyro units on a body, in its axes."""
        mounts = [mount.name for mount in self.d.mounts.values() if mount.body == name]
        return [column(*(self.s[f"{mount}_{axis}_moment"] for axis in ("roll", "pitch", "yaw"))) for mount in mounts]

    def rates(self, name: str) -> tuple[Any, Any, Any]:
        """Absolute roll, pitch and yaw rate of a body about its own axes."""
        omega = self.moving[self.d.host(name)].at.omega
        if self.d.host(name) == name:
            return omega[0], omega[1], omega[2]
        c, q = ca.cos(self.s[f"{name}_angle"]), ca.sin(self.s[f"{name}_angle"])
        return c * omega[0] + q * omega[1], c * omega[1] - q * omega[0], self.s[f"{name}_rate"]
