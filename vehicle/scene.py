"""What vehicles look like as they move; see `component.scene`. Sizes that nobody gives are usual ones, for the eye alone."""

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from gyro_cosim.component.scene import FORMAT

from .profiles import conventional_wheel, ntcirw_wheel, rail_head

__all__ = ["frame", "laid", "moved", "of_vehicle", "sections", "wheel_forces"]

MOTIONS = {"lateral": "lateral_displacement", "vertical": "vertical_displacement",
           "yaw": "yaw_angle", "roll": "roll_angle", "pitch": "pitch_angle"}  # fmt: skip
REACH, POINTS = 0.05, 121  # m to either side of the running line, and points, of a section


def moved(prefix: str, names: Sequence[str]) -> dict[str, str]:
    """The signals that move a body, of those that there are: `prefix` with "_", or empty."""
    return {part: f"{prefix}{name}" for part, name in MOTIONS.items() if f"{prefix}{name}" in names}


def frame(
    name: str,
    prefix: str,
    offset: float,
    names: Sequence[str],
    values: Mapping[str, float],
    *,
    along: Any,
    solid: bool,
    outside: bool = True,
) -> dict[str, Any]:
    """A pair of wheels with what is between them: a frame, or an axle where it is `solid`.

    outside : whether the flanges run outside the rails.
    """
    radius, half = values["rolling_radius"], values["contact_half_distance"]
    flange = values.get("flange_height", 0.04 * half)
    wheels = [
        {
            "name": f"{name} {side} wheel", "at": [0.0, y, 0.0], "axis": [0, 1, 0],
            "rate": f"{prefix}{side}_spin" if f"{prefix}{side}_spin" in names else {"parameter": "speed", "factor": 1 / radius},
            "shapes": [{"role": "wheel", "radius": radius, "width": 0.15 * half, "flange": flange, "outside": outside}],
        }
        for side, y in (("left", half), ("right", -half))
    ]  # fmt: skip
    size = [0.3 * radius, 1.9 * half, 0.3 * radius] if solid else [1.3 * half, 1.55 * half, 0.16 * half]
    return {
        "name": name, "along": along, "offset": offset, "height": radius, **moved(prefix, names),
        "shapes": [{"role": "frame", "size": size, "at": [0.0, 0.0, 0.0]}], "parts": wheels,
    }  # fmt: skip


def wheel_forces(body: str, prefix: str, names: Sequence[str], values: Mapping[str, float]) -> list[dict[str, Any]]:
    """Where the rails press on a pair of wheels."""
    half, radius = values["contact_half_distance"], values["rolling_radius"]
    return [
        {
            "name": f"{body} {side}", "body": body, "at": [0.0, y, -radius], "vertical": f"{prefix}{side}_vertical_force",
            "lateral": f"{prefix}{side}_lateral_force", "flange": f"{prefix}{side}_flange_force",
        }
        for side, y in (("left", half), ("right", -half))
        if f"{prefix}{side}_vertical_force" in names
    ]  # fmt: skip


def sections(values: Mapping[str, float], flange_side: int) -> dict[str, Any]:
    """Sections of the left wheel and rail across the track: y to the left and z up from the running line at rest (m).

    Empty where tread, fillet and flange of these values do not make a section.
    """
    g0, clearance, angle = values["conicity"], values["flange_clearance"], values["flange_angle"]
    shape: dict[str, Any] = {
        "height": values["flange_height"], "tip": values["flange_tip_radius"], "margin": values["tread_margin"],
        "corner": values["corner_radius"], "corner_offset": values["corner_offset"], "depth": values["corner_depth"],
    }  # fmt: skip
    try:
        if flange_side > 0:
            wheel = ntcirw_wheel(g0, values["conicity_gradient"], clearance, angle, **shape)
        else:
            wheel = conventional_wheel(g0, clearance, angle)
    except ValueError:  # the equations of the contact know no such limit
        return {}
    head = rail_head()
    return laid((wheel.y, wheel.z), (head.y, head.z))


def laid(
    wheel: tuple[np.ndarray, np.ndarray], rail: tuple[np.ndarray, np.ndarray],
    contacts: Sequence[tuple[str, float, float, float, float, float]] = (),
) -> dict[str, Any]:  # fmt: skip
    """Sections by their points: across, outwards, and up from the running line at rest (m).

    contacts : part, shift towards the flange (m), place outwards and up (m), contact angle (rad), radius
        less that of the tape line (m)
    """
    found: dict[str, Any] = {"wheel": _points(*wheel), "rail": _points(*rail)}
    if contacts:
        found["contacts"] = [[part, *(round(float(value), 6) for value in rest)] for part, *rest in contacts]
    return found


def _points(y: np.ndarray, z: np.ndarray) -> list[list[float]]:
    inside = np.flatnonzero(np.abs(y) <= REACH)
    chosen = inside[:: max(1, inside.size // POINTS)]
    return [[round(float(y[k]), 6), round(float(z[k]), 6)] for k in chosen]


def of_vehicle(
    bodies: Sequence[Mapping[str, Any]], forces: Sequence[Mapping[str, Any]], mounts: Sequence[Mapping[str, Any]],
    track: Mapping[str, Any], *, prefer: Sequence[str] = (), profiles: Mapping[str, Any] | None = None,
    joints: Sequence[Mapping[str, Any]] = (),
) -> dict[str, Any]:  # fmt: skip
    """The document."""
    return {
        "format": FORMAT, "prefer": list(prefer), "track": dict(track), "bodies": [dict(body) for body in bodies],
        "forces": [dict(force) for force in forces], "mounts": [dict(mount) for mount in mounts],
        "profiles": dict(profiles or {}), **({"joints": list(joints)} if joints else {}),
    }  # fmt: skip
