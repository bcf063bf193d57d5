"""The limits that a run is judged by: EN 14363's for passenger vehicles, or those of a file."""

import difflib
from dataclasses import dataclass, fields, replace
from pathlib import Path

from ..systems.scenario import read_toml

__all__ = ["Limits", "read"]

MOST = 1e300  # of whole numbers in TOML, which know no bounds


@dataclass(frozen=True)
class Limits:
    """Limits, SI units.

    Parameters
    ----------
    ratio
        Of Y/Q, pure number.
    guiding_factor
        k of the limit k (10 kN + 2 Q0 / 3) of the sum of guiding forces: 1, or 0.85 for freight wagons.
    wheel_load_over, wheel_load
        Of Q, N: at most Q0 and the first, and never more than the second (200 kN up to 160 km/h).
    wheel_load_quasi_static, lateral_quasi_static
        Of Q and Y in curves, N.
    unloading
        Of 1 - Q / Q0, pure number; that of twisted track.
    lateral_acceleration, lateral_rms, vertical_acceleration, vertical_rms, lateral_quasi_static_acceleration
        Of the car body, m/s2.
    """

    ratio: float = 0.8
    guiding_factor: float = 1.0
    wheel_load_over: float = 90e3
    wheel_load: float = 200e3
    wheel_load_quasi_static: float = 145e3
    lateral_quasi_static: float = 60e3
    unloading: float = 0.6
    lateral_acceleration: float = 2.5
    lateral_rms: float = 0.5
    vertical_acceleration: float = 2.5
    vertical_rms: float = 0.75
    lateral_quasi_static_acceleration: float = 1.5


def read(file: Path) -> Limits:
    """Limits from a TOML file: fields of Limits, positive numbers in SI; what it does not name is as the standard has it.

    Raises
    ------
    ValueError
        For a file that is no TOML, another key, or what is no positive number.
    OSError
        If it cannot be read.
    """
    given = read_toml(file, f"{file}: a file of limits")
    known = [f.name for f in fields(Limits)]
    for key, value in given.items():
        if key not in known:
            near = difflib.get_close_matches(key, known, 1)
            hint = f"; {near[0]} is near" if near else ""
            raise ValueError(f"{file}: {key}: a limit must be one of {', '.join(known)}{hint}")
        if isinstance(value, bool) or not isinstance(value, (int, float)) or not 0.0 < value <= MOST:
            raise ValueError(f"{file}: {key}: a limit must be a positive number in SI units, got {value!r}")
    return replace(Limits(), **{key: float(value) for key, value in given.items()})
