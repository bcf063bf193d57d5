"""What a gyro unit looks like: gimbals that lean in the frame, a rotor in each. See `component.scene`.

Lengths are shares of the breadth that the vehicle has at its mount: the same unit rides on the model and on the vehicle.
"""

from typing import Any

from gyro_cosim.component.scene import FORMAT

__all__ = ["gimbal", "gimbals"]

PITCH, ROLL = [0, 1, 0], [-1, 0, 0]


def gimbal(axis: list[int] = PITCH) -> dict[str, Any]:
    """One gimbal that leans by `gimbal_angle` about an axis of the frame, with its rotor in it."""
    return {"format": FORMAT, "parts": [_leaning("gimbal", 0.0, axis, 1.0)]}


def gimbals() -> dict[str, Any]:
    """Two gimbals beside each other that lean against each other."""
    return {"format": FORMAT, "parts": [_leaning("gimbal 1", 0.27, PITCH, 0.5), _leaning("gimbal 2", -0.27, [0, -1, 0], 0.5)]}


def _leaning(name: str, y: float, axis: list[int], share: float) -> dict[str, Any]:
    return {
        "name": name, "at": [0.0, y, 0.0], "axis": axis, "angle": "gimbal_angle",
        "shapes": [
            {"role": "gimbal", "size": [0.44, 0.54 * share, 0.07], "at": [0.0, 0.0, 0.0]},
            {"role": "rotor", "radius": 0.18, "width": 0.26 * share},
        ],
    }  # fmt: skip
