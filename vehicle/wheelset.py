"""One conventional wheelset on straight track, led by springs: the textbook's hunting. SI units.

    m (v' + s' Omega x v) = F,   J omega' + omega x (J omega + h e_y) = M,   2 I_y W' = tau       vehicle.wheel_frame
    F_y = -2 k_y y - 2 c_y y',   M_z = -2 l^2 (k_x psi + c_x psi')                                suspension

A rigid axle with two wheels in axle boxes that do not pitch: lateral, vertical, yaw and roll motion, running along the track
and spin, on the same wheel-rail contact as the full vehicle. The car's weight is a force at the axle; a drive holds the speed.
For small motions it is the textbook's pair of equations: Klingel's wave at low speed, and a linear critical speed.
"""

from collections.abc import Mapping, Sequence
from typing import Any

import casadi as ca

from gyro_cosim.component import Component, Variable, build, input_, output, parameter, state

from . import scene, wheel_frame
from .alignment import Alignment
from .irregularity import unevenness
from .lrt import INTERNAL_STEP, with_starts
from .lrt_parameters import MASSES, PRIMARY_STIFFNESS, WHEEL, rail_and_contact
from .pairing import Conical
from .rotation import column
from .track_parameters import parameters_of_track
from .trim import rest_state
from .variants import CONVENTIONAL
from .wheel_frame import SIDES, FrameState
from .wheel_report import REPORT, report

__all__ = ["sprung_wheelset"]

EQUATIONS = """\
m (v' + s' Omega x v) = F,   J omega' + omega x (J omega + h e_y) = M,   2 I_y W' = tau
F_y = -2 k_y y - 2 c_y y',   M_z = -2 l^2 (k_x psi + c_x psi')"""

LAW, GRID, KNOTS = "polach", 7, 4
WHEELS = Conical(-1)
NAMES = ("distance", "lateral_displacement", "vertical_displacement", "yaw_angle", "roll_angle")

ROWS = (
    parameter("wheelset_mass", 1400.0, "kg", "mass of the wheelset", symbol="m", source="Table 2: frame and two wheels", min=1.0),
    parameter("wheelset_ixx", 800.0, "kg.m2", "roll inertia of the wheelset", source="of that size",
              assumed=(400.0, 1200.0), min=1.0),
    parameter("wheelset_izz", 800.0, "kg.m2", "yaw inertia of the wheelset", source="of that size",
              assumed=(400.0, 1200.0), min=1.0),
    parameter("axle_load", 34335.0, "N", "weight on the rails, wheelset and car", source="Table 2: half the vehicle", min=1.0),
    parameter("guide_stiffness_x", PRIMARY_STIFFNESS, "N/m", "longitudinal stiffness at each end", symbol="k_x",
              source="Table 2", min=0.0),
    parameter("guide_stiffness_y", PRIMARY_STIFFNESS, "N/m", "lateral stiffness at each end", symbol="k_y",
              source="Table 2", min=0.0),
    parameter("guide_damping_x", 0.0, "N.s/m", "longitudinal damping at each end", symbol="c_x", source="textbook case", min=0.0),
    parameter("guide_damping_y", 0.0, "N.s/m", "lateral damping at each end", symbol="c_y", source="textbook case", min=0.0),
    parameter("guide_half_spacing", 0.7, "m", "half the distance of the springs", symbol="l", source="as the full vehicle's",
              assumed=(0.4, 1.0), min=0.0),
    parameter("drive_gain", 20000.0, "N.s/m", "drive force per lack of speed", source="ours", min=0.0),
)  # fmt: skip

SIGNALS = (
    input_("yaw_moment", "N.m", "moment on the wheelset about z", symbol="M", nominal=100.0),
    state("distance", "m", "run along the centre line", symbol="s", is_output=True, nominal=10.0, source="rest"),
    state("lateral_displacement", "m", "lateral displacement", symbol="y", is_output=True, nominal=0.01, source="rest"),
    state("vertical_displacement", "m", "vertical displacement from rest", symbol="z", nominal=1e-3, source="rest"),
    state("yaw_angle", "rad", "yaw against the track", symbol="psi", is_output=True, nominal=0.01, source="rest"),
    state("roll_angle", "rad", "roll against the plane of the rails", symbol="phi", nominal=1e-3, source="rest"),
    state("speed_deviation", "m/s", "velocity along the track less the set speed", nominal=0.1, source="rest"),
    state("lateral_velocity", "m/s", "velocity across the track", symbol="v_y", nominal=0.1, source="rest"),
    state("vertical_velocity", "m/s", "velocity square to the rails", symbol="v_z", nominal=0.1, source="rest"),
    state("roll_rate", "rad/s", "absolute roll rate", nominal=0.1, source="rest"),
    state("yaw_rate", "rad/s", "absolute yaw rate", symbol="psi'", is_output=True, nominal=0.1, source="rest"),
    state("spin_deviation", "rad/s", "absolute spin less that of pure rolling", symbol="W", nominal=1.0, source="rest"),
    *(output(f"{side}_{name}", unit, f"{side} wheel: {meaning}", symbol=symbol, nominal=nominal)
      for side in SIDES for name, unit, meaning, symbol, nominal in REPORT),
    output("derailed", "1", "1 when a flange has passed the top of the rail, else 0"),
)  # fmt: skip


def _motion(s: dict[str, ca.SX]) -> tuple[dict[str, Any], dict[str, Any]]:
    rest = rest_state(s, s["axle_load"] / 2, LAW, WHEELS.standing(s, GRID))
    W = s["speed"] * rest.spin_per_speed + s["spin_deviation"]
    at = FrameState(
        s["distance"], s["lateral_displacement"], rest.axle_height + s["vertical_displacement"], s["yaw_angle"], s["roll_angle"],
        ca.SX(0), column(s["speed"] + s["speed_deviation"], s["lateral_velocity"], s["vertical_velocity"]),
        column(s["roll_rate"], 0, s["yaw_rate"]), (W, W),
    )  # fmt: skip
    under = Alignment.of(s, KNOTS).at(at.s)
    turn = under.turn_rate()
    wheels = wheel_frame.rolling(at, turn, unevenness(at.s, s, 0), s, LAW, WHEELS, GRID)
    s_dot, y_dot, z_dot, psi_dot, phi_dot, _ = wheel_frame.place_rates(at, turn)
    l2 = s["guide_half_spacing"] ** 2
    drive = 2 * rest.drag - s["drive_gain"] * s["speed_deviation"]
    guide = column(drive, -2 * (s["guide_stiffness_y"] * at.y + s["guide_damping_y"] * y_dot), 0)
    guide_yaw = -2 * l2 * (s["guide_stiffness_x"] * at.psi + s["guide_damping_x"] * psi_dot)
    force = wheels.force + guide - s["axle_load"] * under.up()
    moment = wheels.moment + column(0, 0, guide_yaw + s["yaw_moment"])
    J = (s["wheelset_ixx"], ca.SX(1), s["wheelset_izz"])  # the boxes do not pitch: the second is not used
    v_dot, omega_dot, W_dot = wheel_frame.accelerations(
        at, turn, s_dot, s["wheelset_mass"], J, s["wheel_spin_inertia"], force, moment, wheels.axle_moments, solid=True
    )
    out: dict[str, Any] = {}
    climbs = []
    for side, sign in SIDES.items():
        rows = report(*wheels.touches[side], -sign, WHEELS.climb(wheels.touches[side][1], side, s))
        climbs.append(rows["climb"])
        out |= {f"{side}_{name}": value for name, value in rows.items()}
    out["derailed"] = ca.fmax(*climbs) > 1
    rates = dict(zip(NAMES, (s_dot, y_dot, z_dot, psi_dot, phi_dot), strict=True))
    rates |= {"speed_deviation": v_dot[0], "lateral_velocity": v_dot[1], "vertical_velocity": v_dot[2]}
    rates |= {"roll_rate": omega_dot[0], "yaw_rate": omega_dot[2], "spin_deviation": W_dot[0]}
    return rates, out


def _longest_step(s: dict[str, ca.SX]) -> Any:
    J = (s["wheelset_ixx"], ca.SX(1), s["wheelset_izz"])
    tread = WHEELS.standing(s, GRID)
    return wheel_frame.longest_step(s, tread, s["axle_load"] / 2, s["wheelset_mass"], J, s["speed"] + s["speed_deviation"])


def sprung_wheelset(parameters: Mapping[str, float] | None = None) -> Component:
    """Make the single wheelset.

    Parameters
    ----------
    parameters : mapping of str to float, optional
        Start values that replace those of the table, SI.

    Returns
    -------
    Component
        The component `vehicle:wheelset`.

    Raises
    ------
    ValueError
        For a name or value that the table does not allow.
    """
    chosen = [v for v in MASSES if v.name in ("speed", "gravity", "wheel_spin_inertia")]
    table: tuple[Variable, ...] = (*SIGNALS, *chosen, *ROWS, *WHEEL, *rail_and_contact(), *parameters_of_track(KNOTS, 0))
    rows = with_starts("vehicle:wheelset", table, CONVENTIONAL | dict(parameters or {}))
    return build(
        name="vehicle", variant="wheelset", description="One conventional wheelset on springs", equations=EQUATIONS,
        variables=rows, model=_motion, internal_step=INTERNAL_STEP, longest_step=_longest_step,
        scene=_scene(rows),
    )  # fmt: skip


def _scene(rows: Sequence[Variable]) -> dict[str, Any]:
    """What it looks like as it moves."""
    names, values = [v.name for v in rows], {v.name: v.start for v in rows if v.causality == "parameter"}
    pair = scene.frame("wheelset", "", 0.0, names, values, along="distance", solid=True, outside=False)
    for wheel in pair["parts"]:
        wheel["rate"] = {"parameter": "speed", "factor": 1 / values["rolling_radius"]}
    mount = {"name": "mount", "body": "wheelset", "at": [0.0, 0.0, 0.3], "size": 1.15, "signals": ["yaw_rate"]}
    track = {"distance": "distance", "half_gauge": values["contact_half_distance"]}
    return scene.of_vehicle(
        [pair], scene.wheel_forces("wheelset", "", names, values), [mount], track,
        prefer=["lateral_displacement", "yaw_angle"], profiles=scene.sections(values, WHEELS.flange_side),
    )  # fmt: skip
