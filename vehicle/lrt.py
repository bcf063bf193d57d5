"""The full light-rail vehicle of the paper: car body, two bogie frames, two wheel frames, four wheels, on any track.

    body with bogies   6 + 2 degrees of freedom     vehicle.car_body
    wheel frames       2 x 6                        vehicle.wheel_frame, vehicle.suspension
    wheel spins        2 x 2 (solid axles 2 x 1)    vehicle.wheel_rail

24 in all; each gyro unit adds gimbal pitch and rotor spin, which makes the paper's 28. Newton-Euler equations with the
velocities in track axes and the angular velocities in body axes as states: no mass matrix has to be solved. The masses of
outer and inner gimbal ride on the wheel frames, all but the inner gimbal's pitch inertia, which is the gyro unit's state.
The drive pushes each wheel frame at the axle: F = drag of straight track + gain (v - v_x of the body) / 2 each.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

import casadi as ca

from component import Bond, Component, Variable, build
from vehicle import car_body, wheel_frame
from vehicle.alignment import CAPACITY, Alignment
from vehicle.creep_laws import creep_law
from vehicle.irregularity import unevenness
from vehicle.lrt_parameters import lrt_parameters
from vehicle.lrt_signals import ENDS, PLACE, lrt_signals
from vehicle.rotation import column, cross
from vehicle.suspension import support
from vehicle.track_parameters import track_parameters
from vehicle.trim import trim
from vehicle.wheel_frame import SIDES, FrameState
from vehicle.wheel_rail import SLOWEST
from vehicle.wheel_report import report

INTERNAL_STEP = 5e-4  # s; benchmarks/vehicle_step.py shows why

EQUATIONS = """\
m (v' + s' Omega x v) = F,   J omega' + omega x (J omega + h e_y) = M        each body in its track frame
I_y W' = r Fx + Mz sin(delta)                                               each wheel
J_b w' = M_springs                                                          each bogie about its pivot
F of the tread by Hertz and the creep law, F of the flange by the rail's lateral stiffness and creep"""


@dataclass(frozen=True)
class Design:
    """What is fixed when the vehicle is built. `flange_side` 1: flanges outside the rails (NTCIRW), -1: inside."""

    law: str = "polach"
    solid_axles: bool = False
    flange_side: int = 1
    grid: int = 7  # FASTSIM's strips and cells
    knots: int = CAPACITY
    harmonics: int = 0


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


def frame_mass(s: Mapping[str, ca.SX]) -> tuple[Any, tuple[Any, Any, Any]]:
    """(mass, (J_x, J_y, J_z)) of a wheel frame with wheels and gimbals; J_y without the wheels' and the inner gimbal's own."""
    b2 = s["contact_half_distance"] ** 2
    m = s["frame_mass"] + 2 * s["wheel_mass"] + s["outer_gimbal_mass"] + s["inner_gimbal_mass"]
    wheels = 2 * (s["wheel_ixx"] + s["wheel_mass"] * b2)
    return m, (
        s["frame_ixx"] + wheels + s["outer_gimbal_ixx"] + s["inner_gimbal_ixx"],
        s["frame_iyy"] + s["outer_gimbal_iyy"],
        s["frame_izz"] + wheels + s["outer_gimbal_izz"] + s["inner_gimbal_izz"],
    )


def motion(s: Mapping[str, ca.SX], design: Design) -> tuple[dict[str, Any], dict[str, Any]]:
    """State derivatives and outputs; the outputs hold more than the table reports: energies for the tests."""
    track = Alignment.of(s, design.knots)
    g, half = s["gravity"], s["pivot_spacing"] / 2
    m_body, h_body = car_body.masses(s)
    m_frame, J = frame_mass(s)
    rest = trim(s, g * (m_body / 2 + m_frame) / 2, design.law, design.grid)

    body = body_state(s, "body", 0, h_body)
    under_body = track.at(body.s)
    turn = under_body.turn_rate()
    rates = wheel_frame.place_rates(body, turn)
    derivatives: dict[str, Any] = {f"body_{name}": rate for (name, *_), rate in zip(PLACE, rates, strict=True)}
    force, moment = -m_body * g * under_body.up(), ca.SX.zeros(3)
    angles = tuple(s[f"{end}_bogie_angle"] for end in ENDS)
    bogie_rates = tuple(s[f"{end}_bogie_rate"] for end in ENDS)
    lack = s["drive_gain"] * (s["speed"] - body.v[0]) / 2
    thrust = s["drive_on"] * (2 * rest.drag + lack)

    out: dict[str, Any] = {"curvature": under_body.curvature, "drive_power": 0, "dissipated_power": 0}
    out |= dict.fromkeys(("kinetic_energy", "spring_energy", "damper_heat", "creep_heat", "contact_power", "press_power"), 0)
    out |= {"gravity_power": ca.dot(force, body.v), "mount_power": 0}
    pivot_moments, climbs = [], []
    for i, end in enumerate(ENDS):
        W_rest = s["speed"] * rest.spin_per_speed
        spins = ("axle", "axle") if design.solid_axles else ("left", "right")
        W = tuple(W_rest + s[f"{end}_{side}_spin_deviation"] for side in spins)
        frame = body_state(s, end, half if end == "front" else -half, rest.axle_height, W)
        under = track.at(frame.s)
        springs = support(body, frame, *track.between(body.s, under_body, frame.s, under), half if end == "front" else -half,
                          angles[i], bogie_rates[i], (h_body, rest.axle_height), s)  # fmt: skip
        frame_turn = under.turn_rate()
        rough = unevenness(frame.s, s, design.harmonics)
        wheels = wheel_frame.rolling(frame, frame_turn, rough, s, design.law, design.flange_side, design.grid)
        gyro = column(*(s[f"{end}_{axis}_moment"] for axis in ("roll", "pitch", "yaw")))
        weight = -m_frame * g * under.up()
        F = wheels.force + springs.frame_force + weight + column(thrust, 0, 0)
        places = wheel_frame.place_rates(frame, frame_turn)
        v_dot, omega_dot, W_dot = wheel_frame.accelerations(
            frame, frame_turn, places[0], m_frame, J, s["wheel_spin_inertia"], F, wheels.moment + springs.frame_moment + gyro,
            wheels.axle_moments, design.solid_axles,
        )  # fmt: skip
        derivatives |= {f"{end}_{name}": rate for (name, *_), rate in zip(PLACE, places, strict=True)}
        derivatives |= _rate_rows(end, v_dot, omega_dot)
        derivatives |= {f"{end}_{side}_spin_deviation": rate for side, rate in zip(spins, W_dot, strict=True)}
        derivatives[f"{end}_bogie_angle"] = bogie_rates[i] - body.omega[2]
        force, moment = force + body.attitude() @ springs.body_force, moment + springs.body_moment
        pivot_moments.append(springs.pivot_moment)

        speed = ca.fmax(frame.v[0], SLOWEST)
        for (side, sign), W_side in zip(SIDES.items(), W, strict=True):
            tread, flange = wheels.touches[side]
            towards = design.flange_side * sign
            rows = report(tread, flange, towards, s)
            out |= {f"{end}_{side}_{name}": value for name, value in rows.items()} | {f"{end}_{side}_spin": W_side}
            climbs.append(rows["climb"])
            out |= {f"{end}_{side}_{kind}": (c.gap, c.approach_rate) for kind, c in (("tread", tread), ("flange", flange))}
            out["creep_heat"] += (tread.heat + flange.heat) * speed
            out["press_power"] += sum(c.normal_load * c.approach_rate for c in (tread, flange))
        out[f"{end}_guiding_force"] = wheels.force[1]
        out["drive_power"] += thrust * frame.v[0]
        out["damper_heat"] += springs.heat
        out["spring_energy"] += springs.energy
        out["gravity_power"] += ca.dot(weight, frame.v)
        out["mount_power"] += ca.dot(gyro, frame.omega)
        free = frame.omega[1]
        out["contact_power"] += (
            ca.dot(wheels.force, frame.v)
            + ca.dot(wheels.moment, frame.omega)
            + sum(tau * (w - free) for tau, w in zip(wheels.axle_moments, W, strict=True))
        )
        out["kinetic_energy"] += (
            m_frame * ca.dot(frame.v, frame.v) + ca.dot(column(*J) * frame.omega, frame.omega)
            + s["wheel_spin_inertia"] * (W[0] ** 2 + W[1] ** 2)
        ) / 2  # fmt: skip

    v_dot = force / m_body - cross(rates[0] * turn, body.v)
    omega_dot, w_dot = car_body.accelerations(s, body.omega, angles, bogie_rates, moment, tuple(pivot_moments))
    derivatives |= _rate_rows("body", v_dot, omega_dot)
    derivatives |= {f"{end}_bogie_rate": rate for end, rate in zip(ENDS, w_dot, strict=True)}
    out["kinetic_energy"] += m_body * ca.dot(body.v, body.v) / 2 + car_body.rotational_energy(s, body.omega, angles, bogie_rates)
    out["dissipated_power"] = out["damper_heat"] + out["creep_heat"]
    out["derailed"] = ca.mmax(ca.vertcat(*climbs)) > 1
    return derivatives, out


def _rate_rows(prefix: str, v_dot: ca.SX, omega_dot: ca.SX) -> dict[str, Any]:
    """Derivatives of the six velocities of a body, by name."""
    names = ("speed_deviation", "lateral_velocity", "vertical_velocity", "roll_rate", "pitch_rate", "yaw_rate")
    values = (v_dot[0], v_dot[1], v_dot[2], omega_dot[0], omega_dot[1], omega_dot[2])
    return {f"{prefix}_{name}": value for name, value in zip(names, values, strict=True)}


def with_starts(spec: str, table: Sequence[Variable], starts: Mapping[str, float]) -> tuple[Variable, ...]:
    """The table with other start values; a value set outside its assumed range on purpose loses that range."""
    unknown = sorted(set(starts) - {v.name for v in table})
    if unknown:
        raise ValueError(f"{spec!r} has no variable {unknown[0]!r}")

    def changed(v: Variable) -> Variable:
        start = v.check(starts[v.name])
        inside = v.assumed is not None and v.assumed[0] <= start <= v.assumed[1]
        return replace(v, start=start, assumed=v.assumed if inside else None)

    return tuple(changed(v) if v.name in starts else v for v in table)


def vehicle(variant: str, description: str, design: Design, starts: Mapping[str, float], internal_step: float) -> Component:
    """A component of this vehicle; `starts` replaces start values of parameters or states."""
    creep_law(design.law)
    table = (*lrt_signals(design.solid_axles), *lrt_parameters(), *track_parameters(design.knots, design.harmonics))
    rows = with_starts(f"vehicle:{variant}", table, starts)
    reported = {v.name for v in rows if v.causality == "output" and not v.is_state}

    def model(s: dict[str, ca.SX]) -> tuple[dict[str, Any], dict[str, Any]]:
        derivatives, out = motion(s, design)
        names = [*derivatives, *(name for name in out if name in reported)]
        shared = ca.cse([ca.SX(value) for value in (*derivatives.values(), *(out[n] for n in names[len(derivatives) :]))])
        values = dict(zip(names, shared, strict=True))
        return {n: values[n] for n in derivatives}, {n: values[n] for n in names[len(derivatives) :]}

    def longest_step(s: dict[str, ca.SX]) -> Any:
        m, J = frame_mass(s)
        load = s["gravity"] * (car_body.masses(s)[0] / 2 + m) / 2
        return wheel_frame.longest_step(s, load, m, J, s["speed"] + s["body_speed_deviation"])

    bonds = tuple(Bond(end, axis, motion=f"{end}_{axis}_rate", effort=f"{end}_{axis}_moment")
                  for end in ENDS for axis in ("yaw", "roll", "pitch"))  # fmt: skip
    return build(name="vehicle", variant=variant, description=description, equations=EQUATIONS, variables=rows, model=model,
                 internal_step=internal_step, bonds=bonds, longest_step=longest_step)  # fmt: skip


def lrt(parameters: Mapping[str, float] | None = None, **design: Any) -> Component:
    """The vehicle with independently rotating wheels of negative tread conicity; `design` holds fields of `Design`."""
    what = "Light-rail vehicle with independently rotating wheels of negative tread conicity"
    return vehicle("lrt", what, Design(**design), parameters or {}, INTERNAL_STEP)
