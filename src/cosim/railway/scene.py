"""What a moving picture of a railway vehicle shows: bodies, their shapes, and the signals that move them.

The scene is data, in metres and radians, in the track frame of the vehicle: x forward, y left, z up. A body stands at
s = offset + distance along the track, y and height + vertical above the rails, turned by Rz(yaw) Rx(roll) Ry(pitch). A part of a
body turns about one of its axes, by an angle signal or by a rate signal.
"""

from collections.abc import Mapping, Sequence
from typing import Any

__all__ = ["moving_bodies"]

AXES = ("lateral_displacement", "vertical_displacement", "yaw_angle", "roll_angle", "pitch_angle")
PARTS = ("lateral", "vertical", "yaw", "roll", "pitch")


def moving_bodies(names: Sequence[str], values: Mapping[str, Any]) -> dict[str, Any] | None:
    """The first vehicle among the signals of a run.

    Parameters
    ----------
    names : sequence of str
        The recorded signals, `component.variable`.
    values : mapping of str to float
        Parameters by the same names, SI.

    Returns
    -------
    dict, optional
        `signals` that tell most, `track` (signals of distance and curvature, half the gauge), `bodies`, `forces`; None where
        there is no vehicle whose motion was recorded. docs/report.md describes them field by field.
    """
    known = set(names)
    for name in names:
        vehicle, _, signal = name.partition(".")
        if signal == "body_distance" and f"{vehicle}.front_distance" in known and f"{vehicle}.pivot_spacing" in values:
            return _vehicle(vehicle, known, values)
    return None


def _vehicle(vehicle: str, known: set[str], values: Mapping[str, Any]) -> dict[str, Any]:
    get = {name.partition(".")[2]: float(v) for name, v in values.items() if name.startswith(f"{vehicle}.") and v is not None}
    length, height, radius, half = get["pivot_spacing"], get["body_height"], get["rolling_radius"], get["contact_half_distance"]
    bodies = [
        _body(vehicle, "body", 0.0, height, known)
        | {"shapes": [{"role": "car", "size": [1.75 * length, 2.3, 2.4], "at": [0.0, 0.0, 2.0 - height + 0.35]}]}
    ]
    forces = []
    for end, offset in (("front", length / 2), ("rear", -length / 2)):
        wheels = []
        for side, y in (("left", half), ("right", -half)):
            wheels.append(
                {
                    "name": f"{end} {side} wheel", "at": [0.0, y, 0.0], "axis": [0, 1, 0], "rate": f"{vehicle}.{end}_{side}_spin",
                    "shapes": [{"role": "wheel", "radius": radius, "width": 0.11, "flange": get.get("flange_height", 0.028)}],
                }
            )  # fmt: skip
            forces.append(
                {
                    "body": f"{end} frame", "at": [0.0, y, -radius],
                    "vertical": f"{vehicle}.{end}_{side}_vertical_force", "lateral": f"{vehicle}.{end}_{side}_lateral_force",
                    "flange": f"{vehicle}.{end}_{side}_flange_force",
                }
            )  # fmt: skip
        frame = _body(vehicle, end, offset, radius, known) | {
            "name": f"{end} frame",
            "shapes": [{"role": "frame", "size": [1.0, 1.15, 0.12], "at": [0.0, 0.0, 0.0]}],
            "parts": wheels + _gyro(end, known),
        }
        bodies.append(frame)
    return {
        "vehicle": vehicle,
        "signals": _telling(vehicle, known),
        "track": {"distance": f"{vehicle}.body_distance", "curvature": f"{vehicle}.curvature", "half_gauge": half},
        "bodies": bodies,
        "forces": [f for f in forces if f["vertical"] in known and f["lateral"] in known],
    }


def _telling(vehicle: str, known: set[str]) -> list[str]:
    """The signals that tell most of a run, which the page draws first."""
    first = [f"{vehicle}.front_{name}" for name in ("lateral_displacement", "yaw_angle", "guiding_force")]
    gimbals = [name for name in ("gyro_front.gimbal_angle", "gyro.gimbal_angle") if name in known]
    return [name for name in (*first, *gimbals) if name in known]


def _body(vehicle: str, prefix: str, offset: float, height: float, known: set[str]) -> dict[str, Any]:
    """Where a body stands: signals that were not recorded are left out, and count as zero."""
    moved = {part: f"{vehicle}.{prefix}_{axis}" for part, axis in zip(PARTS, AXES, strict=True)}
    return {"name": prefix, "along": f"{vehicle}.{prefix}_distance", "offset": offset, "height": height} | {
        part: signal for part, signal in moved.items() if signal in known
    }


def _gyro(end: str, known: set[str]) -> list[dict[str, Any]]:
    """The gyro unit on an end's frame: a gimbal that leans about the frame's lateral axis, and the rotor in it."""
    for component in (f"gyro_{end}", "gyro"):
        angle = f"{component}.gimbal_angle"
        if angle in known:
            shapes = [
                {"role": "gimbal", "size": [0.5, 0.62, 0.08], "at": [0.0, 0.0, 0.0]},
                {"role": "rotor", "radius": 0.2, "width": 0.3},
            ]
            return [{"name": f"{end} gimbal", "at": [0.0, 0.0, 0.05], "axis": [0, 1, 0], "angle": angle, "shapes": shapes}]
    return []
