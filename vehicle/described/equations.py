"""The equations of motion of a vehicle from a file, assembled part by part.

    free bodies, some with two frames on pivots     6 degrees of freedom (+ 2)     vehicle.car_body
    wheelsets and wheel frames                      6, or 5 where boxes do not pitch, and 1 or 2 spins     vehicle.wheel_frame
    springs and dampers between them                described.elements

Newton-Euler equations with the velocities in track axes and the angular velocities in body axes as states: no mass matrix has
to be solved. Every state is zero at rest at the set speed on straight level track.
"""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import casadi as ca

from .. import car_body, wheel_frame
from ..alignment import Alignment, TrackPoint
from ..irregularity import unevenness
from ..lrt_signals import PLACE
from ..rotation import column, cross
from ..trim import Trim, rest_state
from ..wheel_frame import SIDES, FrameState, Rolling
from ..wheel_rail import SLOWEST
from ..wheel_report import report
from .description import Body, Description, Wheelset
from .draws import Draws
from .elements import Action, Seat, meeting, springs_action
from .statics import Statics, statics

__all__ = ["Motion", "longest_step", "motion", "rest_states", "spins"]


@dataclass(frozen=True)
class Motion:
    """The equations of the vehicle, as expressions in SI.

    Attributes
    ----------
    derivatives, outputs : dict
        By name of state and of output.
    account : dict
        Energies (J) and powers (W) by kind, for checks.
    """

    derivatives: dict[str, Any]
    outputs: dict[str, Any]
    account: dict[str, Any]


@dataclass(frozen=True)
class _Moving:
    """A body in motion: place and velocities, its track frame, how that turns, rates of its place."""

    at: FrameState
    under: TrackPoint
    turn: ca.SX
    places: tuple[Any, ...]
    x: Any
    height: Any


def spins(wheelset: Wheelset) -> tuple[str, ...]:
    """What the spins of a wheelset's states are called."""
    return ("axle",) if wheelset.solid else ("left", "right")


def rest_states(s: Mapping[str, ca.SX], d: Description, loads: Mapping[str, Any], draws: Draws) -> dict[str, Trim]:
    """The rest state of the wheels, by wheelset; equal loads have theirs once."""
    found: dict[str, Trim] = {}
    for name, load in loads.items():
        twin = next((other for other in found if draws.same(loads[other], load)), None)
        found[name] = found[twin] if twin else rest_state(s, load, d.law, d.grid)
    return found


def _state(s: Mapping[str, ca.SX], prefix: str, x: Any, height: Any, W: tuple[Any, Any] = (0, 0), pitches: bool = True) -> FrameState:
    """Place and motion of a body at rest at x and `height`."""

    def get(name: str) -> Any:
        return s[f"{prefix}_{name}"]

    return FrameState(
        s=x + get("distance"), y=get("lateral_displacement"), z=height + get("vertical_displacement"),
        psi=get("yaw_angle"), phi=get("roll_angle"), theta=get("pitch_angle") if pitches else ca.SX(0),
        v=column(s["speed"] + get("speed_deviation"), get("lateral_velocity"), get("vertical_velocity")),
        omega=column(get("roll_rate"), get("pitch_rate") if pitches else 0, get("yaw_rate")), W=W,
    )  # fmt: skip


def motion(s: Mapping[str, ca.SX], d: Description) -> Motion:
    """Set up the equations of the whole vehicle.

    Parameters
    ----------
    s : mapping of str to casadi.SX
        Symbols of states, inputs and parameters by name.
    d : Description
        The vehicle.

    Returns
    -------
    Motion
        Derivatives, outputs and energies.
    """
    return _Assembly(s, d).motion()


class _Assembly:
    """What the equations of the parts share."""

    def __init__(self, s: Mapping[str, ca.SX], d: Description) -> None:
        self.s, self.d, self.draws = s, d, Draws(d.starts())
        self.track = Alignment.of(s, d.knots)
        self.rest: Statics = statics(s, d, self.draws)
        self.trims = rest_states(s, d, self.rest.wheel_loads, self.draws)
        self.bodies = {body.name: self._placed(body) for body in d.free}
        self.wheelsets = {one.name: self._stood(one) for one in d.wheelsets.values()}
        self.moving = self.bodies | self.wheelsets
        self.reference = next(iter(self.moving.values()))
        self._seen: dict[tuple[str, str], tuple[ca.SX, ca.SX]] = {}
        self.actions = {name: self._acting(name) for name in d.springs}

    def _moving(self, at: FrameState, x: Any, height: Any) -> _Moving:
        under = self.track.at(at.s)
        turn = under.turn_rate()
        return _Moving(at, under, turn, wheel_frame.place_rates(at, turn), x, height)

    def _placed(self, body: Body) -> _Moving:
        _, x, height = self.d.common_mass(self.s, body.name)
        return self._moving(_state(self.s, body.name, x, height), x, height)

    def _stood(self, one: Wheelset) -> _Moving:
        rest, s = self.trims[one.name], self.s
        W = tuple(s["speed"] * rest.spin_per_speed + s[f"{one.name}_{name}_spin_deviation"] for name in spins(one))
        x = one.x.of(s)
        return self._moving(_state(s, one.name, x, rest.axle_height, (W[0], W[-1]), one.pitches), x, rest.axle_height)

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

    def motion(self) -> Motion:
        """Everything put together."""
        s, d = self.s, self.d
        derivatives: dict[str, Any] = {}
        outputs: dict[str, Any] = {}
        account: dict[str, Any] = dict.fromkeys(
            ("kinetic_energy", "spring_energy", "damper_heat", "creep_heat", "press_power", "contact_power", "drive_power",
             "gravity_power", "mount_power"), 0
        ) | {"gaps": []}  # fmt: skip
        for part in (*(self._body(body) for body in d.free), *(self._wheelset(one) for one in d.wheelsets.values())):
            derivatives |= part.derivatives
            outputs |= part.outputs
            for kind, value in part.account.items():
                account[kind] = account[kind] + value
        for action in self.actions.values():
            account["spring_energy"] += action.energy
            account["damper_heat"] += action.heat
        for mount in d.mounts.values():
            felt = dict(zip(("roll", "pitch", "yaw"), self.rates(mount.body), strict=True))
            outputs |= {f"{mount.name}_{axis}_rate": rate for axis, rate in felt.items() if mount.name != mount.body}
        climbs = [value for name, value in outputs.items() if name.endswith("_climb")]
        outputs |= {
            "curvature": self.reference.under.curvature,
            "drive_power": account["drive_power"],
            "dissipated_power": account["damper_heat"] + account["creep_heat"],
            "derailed": ca.mmax(ca.vertcat(*climbs)) > 1,
        }
        return Motion(derivatives, outputs, account)

    def _body(self, body: Body) -> Motion:
        s, d, moving, frames = self.s, self.d, self.bodies[body.name], self.d.pivoted(body.name)
        at, (under, over) = moving.at, self.upon(body.name)
        m = d.common_mass(s, body.name)[0]
        weight = -m * s["gravity"] * moving.under.up()
        force = weight
        if under:
            force = force + at.attitude() @ _sum([a.body_force for a in under])
        if over:
            force = force + _sum([a.frame_force for a in over])
        moment = _sum([*(a.body_moment for a in under), *(a.frame_moment for a in over), *self.mounted(body.name)])
        v_dot = force / m - cross(moving.places[0] * moving.turn, at.v)
        account = {"kinetic_energy": m * ca.dot(at.v, at.v) / 2, "gravity_power": ca.dot(weight, at.v)}
        account["mount_power"] = sum((ca.dot(unit, at.omega) for unit in self.mounted(body.name)), ca.SX(0))
        if frames:
            omega_dot, rows = self._pivots(body, frames, moment, account)
        else:
            J, w = column(*body.inertia.of(s)), at.omega
            omega_dot, rows = (moment - cross(w, J * w)) / J, {}
            account["kinetic_energy"] += ca.dot(J * w, w) / 2
        derivatives = place_rows(body.name, moving.places) | rate_rows(body.name, v_dot, omega_dot) | rows
        return Motion(derivatives, {}, account)

    def _pivots(self, body: Body, frames: tuple[Body, ...], moment: ca.SX, account: dict[str, Any]) -> tuple[ca.SX, dict[str, Any]]:
        """omega' of a body with two frames on pivots, and the rows of the frames; their energies go to the account."""
        s, at = self.s, self.bodies[body.name].at
        one, other = frames
        assert one.pivot is not None
        values = dict(zip(("body_ixx", "body_iyy", "body_izz"), body.inertia.of(s), strict=True))
        values |= dict(zip(("bogie_ixx", "bogie_iyy", "bogie_izz"), one.inertia.of(s), strict=True))
        values |= {"body_mass": body.mass.of(s), "bogie_mass": one.mass.of(s), "body_height": body.centre.z.of(s)}
        values |= {"bogie_height": one.centre.z.of(s), "pivot_spacing": one.centre.x.of(s) - other.centre.x.of(s)}
        values |= {"pivot_damping": one.pivot.damping.of(s), "pivot_inertance": one.pivot.inertance.of(s)}
        angles = (s[f"{one.name}_angle"], s[f"{other.name}_angle"])
        rates = (s[f"{one.name}_rate"], s[f"{other.name}_rate"])
        moments = []
        for frame in frames:
            under = [a.pivot_moment for n, a in self.actions.items() if self.d.springs[n].upper == frame.name]
            turned = [unit for unit in self.mounted(frame.name)]
            moments.append(_sum([*under, *(unit[2] for unit in turned)]))
            for unit in turned:
                c, q, angle = unit[0], unit[1], s[f"{frame.name}_angle"]
                moment = moment + column(ca.cos(angle) * c - ca.sin(angle) * q, ca.sin(angle) * c + ca.cos(angle) * q, unit[2])
                rolling, pitching, yawing = self.rates(frame.name)
                account["mount_power"] += c * rolling + q * pitching + unit[2] * yawing
        omega_dot, w_dot = car_body.accelerations(values, at.omega, angles, rates, moment, (moments[0], moments[1]))
        account["kinetic_energy"] += car_body.rotational_energy(values, at.omega, angles, rates)
        account["damper_heat"] = car_body.pivot_heat(values, at.omega, rates)
        rows: dict[str, Any] = {}
        for frame, rate, acceleration in zip(frames, rates, w_dot, strict=True):
            rows |= {f"{frame.name}_angle": rate - at.omega[2], f"{frame.name}_rate": acceleration}
        return omega_dot, rows

    def rates(self, name: str) -> tuple[Any, Any, Any]:
        """Absolute roll, pitch and yaw rate of a body about its own axes."""
        omega = self.moving[self.d.host(name)].at.omega
        if self.d.host(name) == name:
            return omega[0], omega[1], omega[2]
        c, q = ca.cos(self.s[f"{name}_angle"]), ca.sin(self.s[f"{name}_angle"])
        return c * omega[0] + q * omega[1], c * omega[1] - q * omega[0], self.s[f"{name}_rate"]

    def _wheelset(self, one: Wheelset) -> Motion:
        s, d, moving, rest = self.s, self.d, self.wheelsets[one.name], self.trims[one.name]
        at, (under, over) = moving.at, self.upon(one.name)
        m, I_y = one.mass.of(s), one.spin_inertia.of(s)
        J = one.inertia.of(s)
        rough = unevenness(at.s, s, d.harmonics)
        wheels = wheel_frame.rolling(at, moving.turn, rough, s, d.law, one.flange_side, d.grid)
        lacking = s["speed"] - self.reference.at.v[0]
        pull = d.drive.gain.of(s) * lacking / len(d.drive.wheelsets) if one.name in d.drive.wheelsets else 0
        thrust = d.drive.on.of(s) * (2 * rest.drag + pull)
        weight = -m * s["gravity"] * moving.under.up()
        pressed = weight if one.load.is_zero else weight - one.load.of(s) * moving.under.up()
        units = self.mounted(one.name)
        force = _sum([wheels.force, *(a.frame_force for a in over), pressed, column(thrust, 0, 0)])
        if under:
            force = force + at.attitude() @ _sum([a.body_force for a in under])
        moment = _sum([wheels.moment, *(a.frame_moment for a in over), *(a.body_moment for a in under), *units])
        v_dot, omega_dot, W_dot = wheel_frame.accelerations(
            at, moving.turn, moving.places[0], m, J if one.pitches else (J[0], ca.SX(1), J[2]), I_y, force, moment,
            wheels.axle_moments, one.solid,
        )  # fmt: skip
        derivatives = place_rows(one.name, moving.places) | rate_rows(one.name, v_dot, omega_dot)
        if not one.pitches:
            del derivatives[f"{one.name}_pitch_angle"], derivatives[f"{one.name}_pitch_rate"]
        derivatives |= {f"{one.name}_{name}_spin_deviation": rate for name, rate in zip(spins(one), W_dot, strict=False)}
        outputs: dict[str, Any] = {f"{one.name}_guiding_force": wheels.force[1]}
        for (side, sign), W_side in zip(SIDES.items(), at.W, strict=True):
            rows = report(*wheels.touches[side], one.flange_side * sign, s)
            outputs |= {f"{one.name}_{side}_{name}": value for name, value in rows.items()} | {f"{one.name}_{side}_spin": W_side}
        account = _account(at, wheels, (m, column(*J), I_y))
        account |= {"drive_power": thrust * at.v[0], "gravity_power": ca.dot(pressed, at.v)}
        account["mount_power"] = sum((ca.dot(unit, at.omega) for unit in units), ca.SX(0))
        return Motion(derivatives, outputs, account)


def _sum(parts: list[Any]) -> Any:
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


def _account(frame: FrameState, wheels: Rolling, inertias: tuple[Any, ca.SX, Any]) -> dict[str, Any]:
    """Energies of frame and wheels, heat of creep, and what the contacts take up by being pressed."""
    m, J, I_y = inertias
    touches = [touch for pair in wheels.touches.values() for touch in pair]
    spinning = sum(tau * (W - frame.omega[1]) for tau, W in zip(wheels.axle_moments, frame.W, strict=True))
    return {
        "kinetic_energy": (m * ca.dot(frame.v, frame.v) + ca.dot(J * frame.omega, frame.omega)
                           + I_y * (frame.W[0] ** 2 + frame.W[1] ** 2)) / 2,
        "creep_heat": sum(touch.heat for touch in touches) * ca.fmax(frame.v[0], SLOWEST),
        "press_power": sum(touch.normal_load * touch.approach_rate for touch in touches),
        "contact_power": ca.dot(wheels.force, frame.v) + ca.dot(wheels.moment, frame.omega) + spinning,
        "gaps": [(touch.gap, touch.approach_rate) for touch in touches],
    }  # fmt: skip


def longest_step(s: Mapping[str, ca.SX], d: Description) -> Any:
    """Longest stable explicit step (s) of the wheels' creep: the least over wheelsets that differ."""
    draws = Draws(d.starts())
    loads = statics(s, d, draws).wheel_loads
    seen: list[ca.SX] = []
    steps = []
    reference = next(iter((*(body.name for body in d.free), *d.wheelsets)))
    for name, one in d.wheelsets.items():
        m, J = one.mass.of(s), one.inertia.of(s)
        numbers = ca.vertcat(loads[name], m, J[0], J[2])
        if any(draws.same(numbers, other) for other in seen):
            continue
        seen.append(numbers)
        view = {**s, "wheel_spin_inertia": one.spin_inertia.of(s)}
        speed = s["speed"] + s[f"{reference}_speed_deviation"]
        steps.append(wheel_frame.longest_step(view, loads[name], m, J, speed))
    return steps[0] if len(steps) == 1 else ca.mmin(ca.vertcat(*steps))
