"""The equations of motion of a vehicle from a file, put together part by part.

    free bodies, some with two frames on pivots     6 degrees of freedom (+ 2)     vehicle.car_body
    wheelsets and wheel frames                      6, or 5 where boxes do not pitch, and 1 or 2 spins     vehicle.wheel_frame
    springs, links, roll bars between them          described.elements, described.links
    forces and torques from outside                 described.applied

Newton-Euler equations with the velocities in track axes and the angular velocities in body axes as states: no mass matrix has
to be solved. Every state is zero at rest at the set speed on straight level track.
"""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import casadi as ca

from .. import car_body, wheel_frame
from ..irregularity import unevenness
from ..rotation import column, cross
from ..wheel_frame import SIDES, FrameState, Rolling
from ..wheel_rail import SLOWEST
from ..wheel_report import report
from .applied import torques_on
from .assembly import Assembly
from .description import Body, Description, Wheelset
from .draws import Draws
from .moving import place_rows, rate_rows, spins, summed
from .statics import at_rest
from .wheels import pairing_of

__all__ = ["Motion", "longest_step", "motion"]


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
    parts = Assembly(s, d)
    derivatives: dict[str, Any] = {}
    outputs: dict[str, Any] = {}
    account: dict[str, Any] = dict.fromkeys(
        ("kinetic_energy", "spring_energy", "damper_heat", "creep_heat", "press_power", "contact_power", "drive_power",
         "gravity_power", "mount_power", "applied_power"), 0
    ) | {"gaps": []}  # fmt: skip
    for part in (*(_body(parts, body) for body in d.free), *(_wheelset(parts, one) for one in d.wheelsets.values())):
        derivatives |= part.derivatives
        outputs |= part.outputs
        for kind, value in part.account.items():
            account[kind] = account[kind] + value
    for action in parts.actions:
        account["spring_energy"] += action.energy
        account["damper_heat"] += action.heat
        account["applied_power"] += action.power
        derivatives |= action.rates
    for mount in d.mounts.values():
        felt = dict(zip(("roll", "pitch", "yaw"), parts.rates(mount.body), strict=True))
        outputs |= {f"{mount.name}_{axis}_rate": rate for axis, rate in felt.items() if mount.name != mount.body}
    climbs = [value for name, value in outputs.items() if name.endswith("_climb")]
    outputs |= {
        "curvature": parts.reference.under.curvature,
        "cant_angle": parts.reference.under.cant,
        "drive_power": account["drive_power"],
        "dissipated_power": account["damper_heat"] + account["creep_heat"],
        "derailed": ca.mmax(ca.vertcat(*climbs)) > 1,
    }
    return Motion(derivatives, outputs, account)


def _body(parts: Assembly, body: Body) -> Motion:
    s, d, moving, frames = parts.s, parts.d, parts.bodies[body.name], parts.d.pivoted(body.name)
    at, (under, over) = moving.at, parts.upon(body.name)
    m = d.common_mass(s, body.name)[0]
    weight = -m * s["gravity"] * moving.under.up()
    force = weight
    if under:
        force = force + at.attitude() @ summed([a.body_force for a in under])
    if over:
        force = force + summed([a.frame_force for a in over])
    moment = summed([*(a.body_moment for a in under), *(a.frame_moment for a in over), *parts.mounted(body.name)])
    account = {"kinetic_energy": m * ca.dot(at.v, at.v) / 2, "gravity_power": ca.dot(weight, at.v)}
    account["mount_power"] = sum((ca.dot(unit, at.omega) for unit in parts.mounted(body.name)), ca.SX(0))
    for push, turning, power in parts.pushed(body.name):
        force, moment = force + push, moment + turning
        account["applied_power"] = account.get("applied_power", 0) + power
    v_dot = force / m - cross(moving.places[0] * moving.turn, at.v)
    if frames:
        omega_dot, rows = _pivots(parts, body, frames, moment, account)
    else:
        J, w = column(*body.inertia.of(s)), at.omega
        omega_dot, rows = (moment - cross(w, J * w)) / J, {}
        account["kinetic_energy"] += ca.dot(J * w, w) / 2
    derivatives = place_rows(body.name, moving.places) | rate_rows(body.name, v_dot, omega_dot) | rows
    return Motion(derivatives, {}, account)


def _pivots(
    parts: Assembly, body: Body, frames: tuple[Body, ...], moment: ca.SX, account: dict[str, Any]
) -> tuple[ca.SX, dict[str, Any]]:
    """omega' of a body with two frames on pivots, and the rows of the frames; their energies go to the account."""
    s, at = parts.s, parts.bodies[body.name].at
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
        under = [a.pivot_moment for a in parts.actions if a.upper == frame.name]
        turned = parts.mounted(frame.name)
        moments.append(summed([*under, *(unit[2] for unit in turned)]))
        for unit in turned:
            c, q, angle = unit[0], unit[1], s[f"{frame.name}_angle"]
            moment = moment + column(ca.cos(angle) * c - ca.sin(angle) * q, ca.sin(angle) * c + ca.cos(angle) * q, unit[2])
            rolling, pitching, yawing = parts.rates(frame.name)
            account["mount_power"] += c * rolling + q * pitching + unit[2] * yawing
    omega_dot, w_dot = car_body.accelerations(values, at.omega, angles, rates, moment, (moments[0], moments[1]))
    account["kinetic_energy"] += car_body.rotational_energy(values, at.omega, angles, rates)
    account["damper_heat"] = car_body.pivot_heat(values, at.omega, rates)
    rows: dict[str, Any] = {}
    for frame, rate, acceleration in zip(frames, rates, w_dot, strict=True):
        rows |= {f"{frame.name}_angle": rate - at.omega[2], f"{frame.name}_rate": acceleration}
    return omega_dot, rows


def _wheelset(parts: Assembly, one: Wheelset) -> Motion:
    s, d, moving, rest = parts.s, parts.d, parts.wheelsets[one.name], parts.standing[one.name]
    at, (under, over) = moving.at, parts.upon(one.name)
    m, I_y = one.mass.of(s), one.spin_inertia.of(s)
    J = one.inertia.of(s)
    rough = unevenness(at.s, s, d.harmonics, d.course.record)
    wheels = wheel_frame.rolling(at, moving.turn, rough, s, d.law, parts.pairing, d.grid)
    thrust = d.drive.on.of(s) * _pull(parts, one, rest.drag)
    weight = -m * s["gravity"] * moving.under.up()
    pressed = weight if one.load.is_zero else weight - one.load.of(s) * moving.under.up()
    units = parts.mounted(one.name)
    force = summed([wheels.force, *(a.frame_force for a in over), pressed, column(thrust, 0, 0)])
    if under:
        force = force + at.attitude() @ summed([a.body_force for a in under])
    moment = summed([wheels.moment, *(a.frame_moment for a in over), *(a.body_moment for a in under), *units])
    account = _account(at, wheels, (m, column(*J), I_y))
    account["applied_power"] = 0
    for push, turning, power in parts.pushed(one.name):
        force, moment = force + push, moment + turning
        account["applied_power"] += power
    torques = [torque for torque in d.torques.values() if torque.wheelset == one.name]
    axle_moments = wheels.axle_moments
    if torques:
        T = torques_on(s, torques)
        axle_moments = (axle_moments[0] + T[0], axle_moments[1] + T[1])
        account["applied_power"] += sum(turned * (W - at.omega[1]) for turned, W in zip(T, at.W, strict=True))
    v_dot, omega_dot, W_dot = wheel_frame.accelerations(
        at, moving.turn, moving.places[0], m, J if one.pitches else (J[0], ca.SX(1), J[2]), I_y, force, moment,
        axle_moments, one.solid,
    )  # fmt: skip
    derivatives = place_rows(one.name, moving.places) | rate_rows(one.name, v_dot, omega_dot)
    if not one.pitches:
        del derivatives[f"{one.name}_pitch_angle"], derivatives[f"{one.name}_pitch_rate"]
    derivatives |= {f"{one.name}_{name}_spin_deviation": rate for name, rate in zip(spins(one), W_dot, strict=False)}
    outputs: dict[str, Any] = {f"{one.name}_guiding_force": wheels.force[1]}
    for (side, sign), W_side in zip(SIDES.items(), at.W, strict=True):
        climb = parts.pairing.climb(wheels.touches[side][1], side, s)
        rows = report(*wheels.touches[side], parts.pairing.flange_side * sign, climb)
        outputs |= {f"{one.name}_{side}_{name}": value for name, value in rows.items()} | {f"{one.name}_{side}_spin": W_side}
    account |= {"drive_power": thrust * at.v[0], "gravity_power": ca.dot(pressed, at.v)}
    account["mount_power"] = sum((ca.dot(unit, at.omega) for unit in units), ca.SX(0))
    return Motion(derivatives, outputs, account)


def _pull(parts: Assembly, one: Wheelset, drag: Any) -> Any:
    """What the drive pulls with at a wheelset: its drag on straight track, and its share of the gain times the lack of speed."""
    s, drive, reference = parts.s, parts.d.drive, parts.reference.at
    if parts.d.course.speeds is None:
        wanted, share = s["speed"], None
    else:
        wanted, share = parts.d.course.speeds.at(reference.s)
    if one.name not in drive.wheelsets:
        return drag if share is None else share * drag
    pull = drive.gain.of(s) * (wanted - reference.v[0])
    if drive.traction_limit is not None:
        pull = ca.fmin(pull, drive.traction_limit.of(s))
    if drive.braking_limit is not None:
        pull = ca.fmax(pull, -drive.braking_limit.of(s))
    whole = drag + pull / len(drive.wheelsets)
    return whole if share is None else share * whole


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
    loads = at_rest(s, d, draws).wheel_loads
    seen: list[ca.SX] = []
    steps = []
    tread = pairing_of(d).standing(s, d.grid)
    reference = next(iter((*(body.name for body in d.free), *d.wheelsets)))
    for name, one in d.wheelsets.items():
        m, J = one.mass.of(s), one.inertia.of(s)
        load = (loads[name][0] + loads[name][1]) / 2
        numbers = ca.vertcat(load, m, J[0], J[2])
        if any(draws.same(numbers, other) for other in seen):
            continue
        seen.append(numbers)
        view = {**s, "wheel_spin_inertia": one.spin_inertia.of(s)}
        speed = s["speed"] + s[f"{reference}_speed_deviation"]
        steps.append(wheel_frame.longest_step(view, tread, load, m, J, speed))
    return steps[0] if len(steps) == 1 else ca.mmin(ca.vertcat(*steps))
