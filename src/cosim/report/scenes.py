"""The moving picture of a system, from the scenes that its components' FMUs carry; see `component.scene`."""

import json
from collections.abc import Collection, Iterator, Mapping
from typing import Any

from gyro_cosim.component.scene import FORMAT, PLACE

from ..systems import System, archive, catalogue

__all__ = ["scene_of"]

LARGEST = 1 << 20  # bytes of a scene


def scene_of(system: System, names: Collection[str], values: Mapping[str, float]) -> dict[str, Any] | None:
    """One scene: the first component that has bodies, with what is mounted on it.

    Parameters
    ----------
    system : System
        What ran.
    names : collection of str
        The recorded signals, `component.variable`; what names another one stays at rest.
    values : mapping of str to float
        Parameters by the same names, SI.

    Returns
    -------
    dict, optional
        With signals by their full names and numbers for parameters; None where no component shows itself.
    """
    found = {c.name: scene for c in system.components if (scene := _carried(c.source)) is not None}
    for host, scene in found.items():
        if scene.get("bodies"):
            whole = _resolved(scene, host, names, values)
            mounts = {mount["name"]: mount for mount in scene.get("mounts", ())}
            for place, guest in _mounted(system, host, mounts):
                if guest in found:
                    parts = _resolved(found[guest], guest, names, values).get("parts", [])
                    _put(whole, mounts[place], [_sized(part, mounts[place]) for part in parts])
                    whole["prefer"] += [part["angle"] for part in parts if part.get("angle")]
            return whole if whole["track"].get("distance") is not None else None
    return None


def _carried(source: str) -> dict[str, Any] | None:
    """The scene in a component's FMU; None where there is none that can be read."""
    if source.startswith(("process:", "tcp://")):
        return None
    try:
        location = source if ".fmu" in source else str(catalogue.fmu(source))
        if not archive.exists(f"{location}#{PLACE}"):
            return None
        content = archive.read(f"{location}#{PLACE}")
        scene = json.loads(content) if len(content) <= LARGEST else None
        return scene if isinstance(scene, dict) and scene.get("format") == FORMAT else None
    except (ValueError, RuntimeError, OSError, RecursionError):
        return None


def _mounted(system: System, host: str, mounts: Mapping[str, Any]) -> Iterator[tuple[str, str]]:
    """Which component is fed with the motion of which mount."""
    for place, mount in mounts.items():
        for guest in dict.fromkeys(c.end[0] for c in system.connections if c.start[0] == host and c.start[1] in mount["signals"]):
            yield place, guest


def _put(scene: dict[str, Any], mount: Mapping[str, Any], parts: list[dict[str, Any]]) -> None:
    for body in scene["bodies"]:
        if body["name"] == mount["body"]:
            body.setdefault("parts", []).extend(parts)


def _sized(part: Mapping[str, Any], mount: Mapping[str, Any]) -> dict[str, Any]:
    """A part in metres at its mount, from one in shares of the mount's breadth."""
    size = mount["size"]
    shapes = [
        {key: [size * x for x in value] if isinstance(value, list) else size * value if key != "role" else value
         for key, value in shape.items()}
        for shape in part["shapes"]
    ]  # fmt: skip
    at = [a + size * b for a, b in zip(mount["at"], part["at"], strict=True)]
    return {**part, "at": at, "shapes": shapes, "name": f"{mount['name']} {part['name']}"}


_SIGNALS = ("along", "lateral", "vertical", "yaw", "roll", "pitch", "angle", "rate", "flange", "distance", "curvature")


def _resolved(value: Any, component: str, names: Collection[str], values: Mapping[str, float], key: str = "") -> Any:
    """With full names for signals, None for those that were not recorded, and numbers for parameters."""
    if isinstance(value, dict):
        if "parameter" in value:
            return values.get(f"{component}.{value['parameter']}", 0.0) * value.get("factor", 1.0)
        return {k: _resolved(v, component, names, values, k) for k, v in value.items()}
    if isinstance(value, list):
        if key == "prefer":
            return [f"{component}.{name}" for name in value if f"{component}.{name}" in names]
        return [_resolved(v, component, names, values) for v in value]
    if key in _SIGNALS and isinstance(value, str):
        return f"{component}.{value}" if f"{component}.{value}" in names else None
    return value
