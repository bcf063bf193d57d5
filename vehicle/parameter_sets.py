"""Named parameter sets of the full vehicle, kept as data in vehicle/sets: values, factors, and where they come from."""

import tomllib
from dataclasses import dataclass
from importlib.resources import files

from .lrt_parameters import vehicle_parameters

__all__ = ["ParameterSet", "parameter_set", "parameter_set_names"]


@dataclass(frozen=True)
class ParameterSet:
    """Start values by name for the vehicle and for its full-scale gyro units, and what is known of their origin.

    Attributes
    ----------
    name : str
        What the set is called: the name of its file in vehicle/sets.
    provenance : str
        Where the values come from, in sentences.
    vehicle : dict of str to float
        Start values of `vehicle:lrt`, in the units of its table.
    gyro : dict of str to float
        Start values of the full-scale gyro units: `gimbal_stiffness` (N/m) and `gimbal_damping` (N s/m).
    """

    name: str
    provenance: str
    vehicle: dict[str, float]
    gyro: dict[str, float]


def parameter_set_names() -> tuple[str, ...]:
    """Name the sets there are.

    Returns
    -------
    tuple of str
        The names, sorted.
    """
    return tuple(
        sorted(f.name.removesuffix(".toml") for f in files(__package__).joinpath("sets").iterdir() if f.name.endswith(".toml"))
    )


def parameter_set(name: str) -> ParameterSet:
    """Read a parameter set.

    Factors of the set are multiplied with the start values of the vehicle's table. The gimbals have n springs and dampers like
    the vertical ones of the primary suspension (Table 2: k_z and c_z serve both).

    Parameters
    ----------
    name : str
        One of `parameter_set_names()`.

    Returns
    -------
    ParameterSet
        The set's values.

    Raises
    ------
    ValueError
        If there is no such set; the message lists those there are.
    """
    if name not in parameter_set_names():
        raise ValueError(f"parameter set must be one of {', '.join(parameter_set_names())}, got {name!r}")
    data = tomllib.loads(files(__package__).joinpath("sets", f"{name}.toml").read_text(encoding="utf-8"))
    values = dict(data["vehicle"])
    factors = values.pop("scaled", {})
    table = {v.name: v.start for v in vehicle_parameters()}
    values |= {key: table[key] * factor for key, factor in factors.items()}
    n = data["gyro"]["springs"]
    gyro = {f"gimbal_{kind}": n * table[f"primary_{kind}_z"] for kind in ("stiffness", "damping")}
    return ParameterSet(name, data["provenance"].strip(), values, gyro)
