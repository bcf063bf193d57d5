"""What the equations of a vehicle's parts share: places and velocities, the rest state, what springs do."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import casadi as ca

from .. import wheel_frame
from ..alignment import Alignment
from ..pairing import Pairing
from ..rotation import column
from ..trim import rest_state
from ..wheel_frame import FrameState
from .applied import force_on, torque_action, torques_on
from .between import Link, Springs
from .description import Body, Description, Joint, Wheelset
from .draws import Draws
from .elements import Action, Meeting, Seat, meeting, springs_action
from .links import link_action, roll_bar_action
from .moving import Moving, spins, state_of
from .sections import Vector
from .statics import Statics, at_rest
from .wheels import pairing_of

__all__ = ["Assembly", "Standing", "standing"]


@dataclass(frozen=True)
class Standing:
    """How a wheelset stands at rest.

    Attributes
    ----------
    axle_height, lateral, roll
        m, m, rad.
    spins_per_speed
        Spin over speed of each wheel (rad/m).
    drag
        N.
    """

    axle_height: Any
    lateral: Any
    roll: Any
    spins_per_speed: tuple[Any, Any]
    drag: Any


def standing(
    s: Mapping[str, ca.SX], d: Description, pairing: Pairing, loads: Mapping[str, tuple[Any, Any]], draws: Draws
) -> dict[str, Standing]:
    """The rest state of the wheels, by wheelset; equal loads have theirs once.

    Each wheel is trimmed for its own load, which is the rest of an axle where both are alike. Where they are not, side forces of
    cones and a solid axle's common spin are left over, and the wheelset settles from there.
    """
    known: list[tuple[Any, str, Any]] = []

    def trimmed(load: Any, side: str) -> Any:
        side = side if pairing.unlike else "left"
        twin = next((trim for other, where, trim in known if where == side and draws.same(other, load)), None)
        if twin is None:
            twin = rest_state(s, load, d.law, pairing.standing(s, d.grid, side))
            known.append((load, side, twin))
        return twin

    found = {}
    for name, (left, right) in loads.items():
        one = trimmed(left, "left")
        if not (d.lopsided or pairing.unlike):
            found[name] = Standing(one.axle_height, 0, 0, (one.spin_per_speed, one.spin_per_speed), 2 * one.drag)
            continue
        other, b = trimmed(right, "right"), s["contact_half_distance"]
        spins_ = (one.spin_per_speed, other.spin_per_speed)
        if d.wheelsets[name].solid:
            spins_ = ((spins_[0] + spins_[1]) / 2,) * 2
        height, roll = (one.axle_height + other.axle_height) / 2, (one.axle_height - other.axle_height) / (2 * b)
        lateral = -roll * s["rolling_radius"]  # where the treads stay at their places on the rails
        found[name] = Standing(height, lateral, roll, spins_, one.drag + other.drag)
    return found


class Assembly:
    """What the equations of the parts share."""

    def __init__(self, s: Mapping[str, ca.SX], d: Description) -> None:
        self.s, self.d, self.draws = s, d, Draws(d.starts())
        self.track = Alignment.of(s, d.knots, d.course.line)
        self.pairing = pairing_of(d)
        self.rest: Statics = at_rest(s, d, self.draws)
        self.standing = standing(s, d, self.pairing, self.rest.wheel_loads, self.draws)
        self.bodies = {body.name: self._placed(body) for body in d.free}
        self.wheelsets = {one.name: self._stood(one) for one in d.wheelsets.values()}
        self.moving = self.bodies | self.wheelsets
        self.reference = next(iter(self.moving.values()))
        self._seen: dict[tuple[str, str], tuple[ca.SX, ca.SX]] = {}
        self.actions = [action for joint in d.joints for action in self._acting(joint)]
        self.actions += [self._bracing(name) for name, torque in d.torques.items() if torque.against]

    def _in_motion(self, at: FrameState, place: tuple[Any, Any, Any]) -> Moving:
        under = self.track.at(at.s)
        turn = under.turn_rate()
        return Moving(at, under, turn, wheel_frame.place_rates(at, turn), *place)

    def _placed(self, body: Body) -> Moving:
        place = self.d.common_mass(self.s, body.name)[1:]
        return self._in_motion(state_of(self.s, body.name, place), place)

    def _stood(self, one: Wheelset) -> Moving:
        rest, s = self.standing[one.name], self.s
        turning = zip(spins(one), rest.spins_per_speed, strict=False)
        W = tuple(s["speed"] * per_speed + s[f"{one.name}_{name}_spin_deviation"] for name, per_speed in turning)
        place = (one.x.of(s), rest.lateral, rest.axle_height)
        return self._in_motion(state_of(s, one.name, place, (W[0], W[-1]), roll=rest.roll, pitches=one.pitches), place)

    def seat(self, name: str) -> Seat:
        """A body as what carries springs."""
        host = self.moving[self.d.host(name)]
        if self.d.host(name) == name:
            return Seat(host.at, column(0, 0, 0), ca.SX(0), host.at.omega[2], host.x, host.y, host.height)
        x = self.draws.clean(self.d.bodies[name].centre.x.of(self.s) - host.x)
        return Seat(host.at, column(x, 0, 0), self.s[f"{name}_angle"], self.s[f"{name}_rate"], host.x, host.y, host.height)

    def seen(self, one: str, other: str) -> tuple[ca.SX, ca.SX]:
        """The track frame of `other` seen in that of `one`, both free."""
        if (one, other) not in self._seen:
            a, b = self.moving[one], self.moving[other]
            self._seen[one, other] = self.track.between(a.at.s, a.under, b.at.s, b.under)
        return self._seen[one, other]

    def _meeting(self, joint: Joint, seat: Seat, upper_end: ca.SX, point: tuple[Any, Any, Any]) -> Meeting:
        """Where a point of the lower body, given at rest, is; at rest it is `upper_end` from the upper body's pivot."""
        lower = self.moving[joint.lower]
        up = column(self.draws.clean(point[0] - lower.x), point[1] - lower.y, point[2] - lower.height)
        return meeting(seat, lower.at, self.seen(self.d.host(joint.upper), joint.lower), up, upper_end)

    def _from_pivot(self, seat: Seat, point: tuple[Any, Any, Any]) -> ca.SX:
        """A point at rest, from the upper body's pivot, or from its centre where it has none."""
        x, y, z = point
        return column(self.draws.clean(x - seat.x - seat.pivot[0]), y - seat.y, z - seat.height)

    def _acting(self, joint: Joint) -> list[Action]:
        s, seat = self.s, self.seat(joint.upper)
        if isinstance(joint, Springs):
            point = joint.at.of(s)
            at = self._meeting(joint, seat, self._from_pivot(seat, point), point)
            return [springs_action(s, joint, self.rest.preloads.get(joint.name, (0, 0, 0)), seat, at)]
        if isinstance(joint, Link):
            found = []
            for side, sign in joint.sides:
                above, below = (_mirrored(end, sign).of(s) for end in (joint.upper_end, joint.lower_end))
                start, end = self._from_pivot(seat, above), self._from_pivot(seat, below)
                found.append(link_action(s, joint, side, seat, self._meeting(joint, seat, start, below), end - start))
            return found
        lower = self.moving[joint.lower]
        centre = (lower.x, lower.y, lower.height)
        return [roll_bar_action(s, joint, seat, self._meeting(joint, seat, self._from_pivot(seat, centre), centre))]

    def _bracing(self, name: str) -> Action:
        torque = self.d.torques[name]
        host = self.d.host(torque.against)
        body, frame = self.moving[host].at, self.moving[torque.wheelset].at
        axle = body.attitude().T @ self.seen(host, torque.wheelset)[1] @ frame.attitude()[:, 1]
        omega = column(body.omega[0], body.omega[1], self.seat(torque.against).rate)
        total = sum(torques_on(self.s, [torque]), ca.SX(0))
        return torque_action(torque, total, axle, (omega, frame.omega[1]))

    def upon(self, name: str) -> tuple[list[Action], list[Action]]:
        """What acts under a free body, under its pivots' frames too, and what acts over it."""
        under = [a for a in self.actions if self.d.host(a.upper) == name]
        return under, [a for a in self.actions if a.lower == name]

    def mounted(self, name: str) -> list[ca.SX]:
        """Moments of the gyro units on a body, in its axes."""
        mounts = [mount.name for mount in self.d.mounts.values() if mount.body == name]
        return [column(*(self.s[f"{mount}_{axis}_moment"] for axis in ("roll", "pitch", "yaw"))) for mount in mounts]

    def pushed(self, name: str) -> list[tuple[ca.SX, ca.SX, Any]]:
        """Forces from outside on a free body: (N in track axes, N m in its axes, W)."""
        return [force_on(self.s, one, self.moving[name]) for one in self.d.forces.values() if one.body == name]

    def rates(self, name: str) -> tuple[Any, Any, Any]:
        """Absolute roll, pitch and yaw rate of a body about its own axes."""
        omega = self.moving[self.d.host(name)].at.omega
        if self.d.host(name) == name:
            return omega[0], omega[1], omega[2]
        c, q = ca.cos(self.s[f"{name}_angle"]), ca.sin(self.s[f"{name}_angle"])
        return c * omega[0] + q * omega[1], c * omega[1] - q * omega[0], self.s[f"{name}_rate"]


def _mirrored(place: Vector, sign: int) -> Vector:
    """A place, or the one across the middle of the track."""
    return place if sign > 0 else Vector(place.x, place.y.negative(), place.z)
