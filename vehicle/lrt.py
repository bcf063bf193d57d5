"""The full light-rail vehicle of the paper: car body, two bogie frames, two wheel frames, four wheels, on any track.

    body with bogies   6 + 2 degrees of freedom     vehicle.car_body
    wheel frames       2 x 6                        vehicle.running_gear, vehicle.wheel_frame, vehicle.suspension
    wheel spins        2 x 2 (solid axles 2 x 1)    vehicle.wheel_rail

24 in all; each gyro unit adds gimbal pitch and rotor spin, which makes the paper's 28. Newton-Euler equations with the
velocities in track axes and the angular velocities in body axes as states: no mass matrix has to be solved.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

import casadi as ca

from gyro_cosim.component import Bond, Component, Variable, build

from . import car_body, scene, wheel_frame
from .alignment import Alignment
from .creep_laws import creep_law
from .lrt_parameters import vehicle_parameters
from .lrt_signals import ENDS, WHEELS, vehicle_signals
from .rotation import cross
from .running_gear import Carried, Design, body_state, end_of, frame_mass, place_rows, rate_rows
from .track_parameters import parameters_of_track
from .trim import rest_state

__all__ = ["INTERNAL_STEP", "Motion", "lrt_set_a", "motion", "vehicle", "wheel_load", "with_starts"]

INTERNAL_STEP = 5e-4  # s; benchmarks/vehicle_step.py shows why

EQUATIONS = """\
m (v' + s' Omega x v) = F,   J omega' + omega x (J omega + h e_y) = M        each body in its track frame
I_y W' = r Fx + Mz sin(delta)                                               each wheel
J_b w' = M_springs + M_pivot                                                each bogie about its pivot
F of the tread by Hertz and the creep law, F of the flange by the rail's lateral stiffness and creep"""


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


def motion(s: Mapping[str, ca.SX], design: Design) -> Motion:
    """Set up the equations of the whole vehicle.

    Parameters
    ----------
    s : mapping of str to casadi.SX
        Symbols of states, inputs and parameters by name.
    design : Design
        What is fixed when the vehicle is built.

    Returns
    -------
    Motion
        Derivatives, outputs and energies.
    """
    track = Alignment.of(s, design.knots)
    m, height = car_body.masses(s)
    rest = rest_state(s, wheel_load(s), design.law, design.pairing.standing(s, design.grid))
    body = body_state(s, "body", 0, height)
    under = track.at(body.s)
    turn = under.turn_rate()
    places = wheel_frame.place_rates(body, turn)
    thrust = s["drive_on"] * (2 * rest.drag + s["drive_gain"] * (s["speed"] - body.v[0]) / 2)
    ends = [end_of(s, design, track, Carried(body, under, height, rest, thrust), end) for end in ENDS]

    weight = -m * s["gravity"] * under.up()
    force = weight + body.attitude() @ (ends[0].springs.body_force + ends[1].springs.body_force)
    moment = ends[0].springs.body_moment + ends[1].springs.body_moment
    angles, rates = ((s[f"front_{name}"], s[f"rear_{name}"]) for name in ("bogie_angle", "bogie_rate"))
    pivot_moments = (ends[0].springs.pivot_moment, ends[1].springs.pivot_moment)
    v_dot = force / m - cross(places[0] * turn, body.v)
    omega_dot, w_dot = car_body.accelerations(s, body.omega, angles, rates, moment, pivot_moments)
    derivatives = place_rows("body", places) | rate_rows("body", v_dot, omega_dot) | ends[0].derivatives | ends[1].derivatives
    derivatives |= {f"{end}_bogie_rate": rate for end, rate in zip(ENDS, w_dot, strict=True)}

    account = {kind: ends[0].account[kind] + ends[1].account[kind] for kind in ends[0].account}
    account["kinetic_energy"] += m * ca.dot(body.v, body.v) / 2 + car_body.rotational_energy(s, body.omega, angles, rates)
    account["damper_heat"] += car_body.pivot_heat(s, body.omega, rates)
    account["gravity_power"] += ca.dot(weight, body.v)
    outputs = ends[0].outputs | ends[1].outputs
    outputs |= {
        "curvature": under.curvature,
        "cant_angle": under.cant,
        "drive_power": account["drive_power"],
        "dissipated_power": account["damper_heat"] + account["creep_heat"],
        "derailed": ca.mmax(ca.vertcat(*(outputs[f"{wheel}_climb"] for wheel in WHEELS))) > 1,
    }
    return Motion(derivatives, outputs, account)


def wheel_load(s: Mapping[str, ca.SX]) -> Any:
    """Static load of one wheel (N) from the symbols of the table."""
    return s["gravity"] * (car_body.masses(s)[0] / 2 + frame_mass(s)[0]) / 2


def with_starts(spec: str, table: Sequence[Variable], starts: Mapping[str, float]) -> tuple[Variable, ...]:
    """Give a table other start values; a value set outside its assumed range on purpose loses that range.

    Parameters
    ----------
    spec : str
        What the component is called, for messages.
    table : sequence of Variable
        The rows.
    starts : mapping of str to float
        New start values by name, in the units of the table.

    Returns
    -------
    tuple of Variable
        The rows in the same order.

    Raises
    ------
    ValueError
        If a name is not in the table, or a value not within min and max.
    """
    unknown = sorted(set(starts) - {v.name for v in table})
    if unknown:
        raise ValueError(f"{spec!r} has no variable {unknown[0]!r}")

    def changed(v: Variable) -> Variable:
        start = v.check(starts[v.name])
        inside = v.assumed is not None and v.assumed[0] <= start <= v.assumed[1]
        return replace(v, start=start, assumed=v.assumed if inside else None)

    return tuple(changed(v) if v.name in starts else v for v in table)


def vehicle(variant: str, description: str, design: Design, starts: Mapping[str, float], internal_step: float) -> Component:
    """Make a variant of this vehicle.

    Parameters
    ----------
    variant, description : str
        What the component is called, and one line on it.
    design : Design
        Creep law, axles, flanges, room for track data.
    starts : mapping of str to float
        Start values of parameters or states that replace those of the table.
    internal_step : float
        Longest internal step (s).

    Returns
    -------
    Component
        The vehicle; its connectors are "front" and "rear".

    Raises
    ------
    ValueError
        For an unknown creep law, or a name or value that the table does not allow.
    """
    creep_law(design.law)
    table = (*vehicle_signals(design.solid_axles), *vehicle_parameters(), *parameters_of_track(design.knots, design.harmonics))
    rows = with_starts(f"vehicle:{variant}", table, starts)

    def model(s: dict[str, ca.SX]) -> tuple[dict[str, Any], dict[str, Any]]:
        equations = motion(s, design)
        rates, outputs = equations.derivatives, equations.outputs
        values = ca.cse([ca.SX(value) for value in (*rates.values(), *outputs.values())])
        n = len(rates)
        return dict(zip(rates, values[:n], strict=True)), dict(zip(outputs, values[n:], strict=True))

    def longest_step(s: dict[str, ca.SX]) -> Any:
        tread = design.pairing.standing(s, design.grid)
        return wheel_frame.longest_step(s, tread, wheel_load(s), *frame_mass(s), s["speed"] + s["body_speed_deviation"])

    bonds = tuple(Bond(end, axis, f"{end}_{axis}_rate", f"{end}_{axis}_moment", f"inner_gimbal_i{about}{about}")
                  for end in ENDS for axis, about in (("yaw", "z"), ("roll", "x"), ("pitch", "y")))  # fmt: skip
    return build(name="vehicle", variant=variant, description=description, equations=EQUATIONS, variables=rows, model=model,
                 internal_step=internal_step, bonds=bonds, longest_step=longest_step,
                 scene=_scene(rows, design))  # fmt: skip


def _scene(rows: Sequence[Variable], design: Design) -> dict[str, Any]:
    """What it looks like as it moves."""
    names, values = [v.name for v in rows], {v.name: v.start for v in rows if v.causality == "parameter"}
    length, height = values["pivot_spacing"], values["body_height"]
    shape = {"role": "car", "size": [1.75 * length, 2.3, 2.4], "at": [0.0, 0.0, 2.35 - height]}
    moved = scene.moved("body_", names)
    bodies = [{"name": "body", "along": "body_distance", "offset": 0.0, "height": height, **moved, "shapes": [shape]}]
    forces, mounts = [], []
    for end, offset in (("front", length / 2), ("rear", -length / 2)):
        along = f"{end}_distance"
        bodies.append(
            scene.frame(
                end,
                f"{end}_",
                offset,
                names,
                values,
                along=along,
                solid=design.solid_axles,
                outside=design.pairing.flange_side > 0,
            )
        )
        forces += scene.wheel_forces(end, f"{end}_", names, values)
        signals = [f"{end}_{axis}_rate" for axis in ("yaw", "roll", "pitch")]
        mounts.append({"name": end, "body": end, "at": [0.0, 0.0, 0.05], "size": 1.15, "signals": signals})
    track = {"distance": "body_distance", "curvature": "curvature", "half_gauge": values["contact_half_distance"]}
    prefer = [f"front_{name}" for name in ("lateral_displacement", "yaw_angle", "guiding_force")]
    profiles = scene.sections(values, design.pairing.flange_side)
    return scene.of_vehicle(bodies, forces, mounts, track, prefer=prefer, profiles=profiles)


def lrt_set_a(parameters: Mapping[str, float] | None = None, **design: Any) -> Component:
    """Make the vehicle with independently rotating wheels of negative tread conicity.

    Parameters
    ----------
    parameters : mapping of str to float, optional
        Start values that replace those of the table, such as `Track(...).parameters()`, SI.
    **design
        Fields of `vehicle.running_gear.Design`: `law`, `knots`, `harmonics` and others.

    Returns
    -------
    Component
        The component `vehicle:lrt`.

    Raises
    ------
    ValueError
        For an unknown creep law, or a name or value that the table does not allow.

    Examples
    --------
    >>> lrt({"speed": 8.0, "curve_turn": 1.0}).spec
    'vehicle:lrt'
    """
    what = "Light-rail vehicle with independently rotating wheels of negative tread conicity"
    return vehicle("lrt", what, Design(**design), parameters or {}, INTERNAL_STEP)
