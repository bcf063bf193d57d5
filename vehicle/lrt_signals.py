"""Rows of the table of the full vehicle that are signals: inputs, states and outputs, for both ends and all four wheels.

Every state is zero at rest at the set speed on straight level track, so that the vehicle starts without a transient.
"""

from gyro_cosim.component import Variable, input_, output, state

from .wheel_report import REPORT

__all__ = ["ENDS", "MOTION", "PLACE", "WHEELS", "body_rows", "vehicle_signals"]

ENDS = ("front", "rear")
WHEELS = tuple(f"{end}_{side}" for end in ENDS for side in ("left", "right"))

PLACE = (
    ("distance", "m", "run along the centre line since the start", "s", 10.0),
    ("lateral_displacement", "m", "lateral displacement from the centre line", "y", 0.01),
    ("vertical_displacement", "m", "vertical displacement from rest", "z", 0.01),
    ("yaw_angle", "rad", "yaw against the track", "psi", 0.01),
    ("roll_angle", "rad", "roll against the plane of the rails", "phi", 0.01),
    ("pitch_angle", "rad", "pitch against the track", "theta", 0.01),
)
MOTION = (
    ("speed_deviation", "m/s", "velocity along the track less the set speed", "v_x - v", 0.1),
    ("lateral_velocity", "m/s", "velocity across the track", "v_y", 0.1),
    ("vertical_velocity", "m/s", "velocity square to the rails", "v_z", 0.1),
    ("roll_rate", "rad/s", "absolute roll rate about its own axis", "phi'", 0.1),
    ("pitch_rate", "rad/s", "absolute pitch rate about its own axis", "theta'", 0.1),
    ("yaw_rate", "rad/s", "absolute yaw rate about its own axis", "psi'", 0.1),
)


def body_rows(prefix: str, what: str, is_output: bool) -> tuple[Variable, ...]:
    """Place and motion of one body that follows the track."""
    return tuple(
        state(f"{prefix}_{name}", unit, f"{what}: {meaning}", symbol=symbol, nominal=nominal, is_output=is_output,
              source="rest")
        for name, unit, meaning, symbol, nominal in (*PLACE, *MOTION)
    )  # fmt: skip


def vehicle_signals(solid: bool) -> tuple[Variable, ...]:
    """All signals; `solid` axles have one spin per pair."""
    rows: list[Variable] = []
    for end in ENDS:
        rows += [input_(f"{end}_{axis}_moment", "N.m", f"{axis} moment of the gyro unit on the {end} wheel frame", nominal=100.0)
                 for axis in ("yaw", "roll", "pitch")]  # fmt: skip
    rows += body_rows("body", "car body with bogies", is_output=True)
    for end in ENDS:
        rows += body_rows(end, f"{end} wheel frame", is_output=True)
        rows += [
            state(f"{end}_bogie_angle", "rad", f"{end} bogie frame: yaw against the car body", symbol="theta_b", nominal=0.01,
                  is_output=True, source="rest"),
            state(f"{end}_bogie_rate", "rad/s", f"{end} bogie frame: absolute rate about the pivot", nominal=0.1, source="rest"),
        ]  # fmt: skip
        for side in ("axle",) if solid else ("left", "right"):
            rows.append(state(f"{end}_{side}_spin_deviation", "rad/s", f"{end} {side}: absolute spin less that of pure rolling",
                              symbol="W", nominal=1.0, source="rest"))  # fmt: skip
        rows += [
            output(f"{end}_{side}_spin", "rad/s", f"{end} {side} wheel: absolute spin about the axle", symbol="W", nominal=10.0)
            for side in ("left", "right")
        ]
        rows.append(output(f"{end}_guiding_force", "N", f"{end} pair: lateral force of the rails on it, to the left",
                           symbol="sum Y", nominal=1e4))  # fmt: skip
    for wheel in WHEELS:
        rows += [output(f"{wheel}_{name}", unit, f"{wheel.replace('_', ' ')} wheel: {meaning}", symbol=symbol, nominal=nominal)
                 for name, unit, meaning, symbol, nominal in REPORT]  # fmt: skip
    rows += [
        output("curvature", "1/m", "curvature of the track under the car body", symbol="kappa", nominal=0.01),
        output(
            "cant_angle",
            "rad",
            "cant of the track under the car body, positive with the left rail high",
            symbol="alpha",
            nominal=0.1,
        ),
        output("drive_power", "W", "power of the drive", nominal=1e3),
        output("dissipated_power", "W", "heat of dampers and creep", nominal=1e3),
        output("derailed", "1", "1 when a flange has passed the top of the rail, else 0"),
    ]
    return tuple(rows)
