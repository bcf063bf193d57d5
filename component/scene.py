"""What a component looks like as it moves: a document of bodies, shapes and the signals that move them, carried in its FMU.

Lengths in m, angles in rad, x forward, y left, z up. A number may be {"parameter": NAME}, {"parameter": NAME, "factor": K}: the
value that a run gives it. docs/report.md describes the fields.
"""

from collections.abc import Collection, Iterator, Mapping
from typing import Any

__all__ = ["FORMAT", "PLACE", "check_scene", "signals_of_scene"]

FORMAT = 1
PLACE = "extra/io.github.gyro-cosim.scene/scene.json"  # in an FMU
_SIGNALS = ("along", "lateral", "vertical", "yaw", "roll", "pitch", "angle", "rate", "flange", "distance", "curvature", "force")
_LISTS = ("prefer", "signals")


def signals_of_scene(scene: Any) -> Iterator[str]:
    """Every signal that a scene names, and every parameter."""
    if isinstance(scene, Mapping):
        for key, value in scene.items():
            if key in (*_SIGNALS, "parameter") and isinstance(value, str):
                yield value
            elif key in _LISTS:
                yield from value
            else:
                yield from signals_of_scene(value)
    elif isinstance(scene, list | tuple):
        for item in scene:
            yield from signals_of_scene(item)


def check_scene(where: str, scene: Mapping[str, Any], names: Collection[str]) -> None:
    """ValueError where a scene is of another format, or names a signal or parameter that the component has not."""
    if scene.get("format") != FORMAT:
        raise ValueError(f"{where}: scene must be of format {FORMAT}, got {scene.get('format')!r}")
    for name in signals_of_scene(scene):
        if name not in names:
            raise ValueError(f"{where}: scene must name variables of the component, got {name!r}")
