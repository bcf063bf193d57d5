"""Named parameter sets of the full vehicle, kept as data in vehicle/sets: values, factors, and where they come from."""

import tomllib
from dataclasses import dataclass
from importlib.resources import files

from .lrt_parameters import lrt_parameters

TABLE_2_STIFFNESS, TABLE_2_DAMPING = 86700.0, 21000.0  # N/m, N s/m of one gimbal spring and damper


@dataclass(frozen=True)
class ParameterSet:
    """Start values by name for the vehicle and for its full-scale gyro units, and what is known of their origin."""

    name: str
    provenance: str
    vehicle: dict[str, float]
    gyro: dict[str, float]


def parameter_set_names() -> tuple[str, ...]:
    """The sets there are."""
    return tuple(
        sorted(f.name.removesuffix(".toml") for f in files(__package__).joinpath("sets").iterdir() if f.name.endswith(".toml"))
    )


def parameter_set(name: str) -> ParameterSet:
    """The set called `name`; ValueError lists those there are."""
    if name not in parameter_set_names():
        raise ValueError(f"parameter set must be one of {', '.join(parameter_set_names())}, got {name!r}")
    data = tomllib.loads(files(__package__).joinpath("sets", f"{name}.toml").read_text(encoding="utf-8"))
    values = dict(data["vehicle"])
    factors = values.pop("scaled", {})
    table = {v.name: v.start for v in lrt_parameters()}
    values |= {key: table[key] * factor for key, factor in factors.items()}
    n = data["gyro"]["springs"]
    gyro = {"gimbal_stiffness": n * TABLE_2_STIFFNESS, "gimbal_damping": n * TABLE_2_DAMPING}
    return ParameterSet(name, data["provenance"].strip(), values, gyro)
