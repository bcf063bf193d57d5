"""The vehicle and its track: components with a mount for a gyro unit.

`VARIANTS` maps the name of a variant to the function that makes the component; nothing is loaded before it is asked for.
The first is the default.

Public besides VARIANTS: `lrt.lrt_set_a`, `wheel_pair.small_wheel_pair`, `wheelset.sprung_wheelset` and the functions of
`variants`, which make the components; `track` and `spectra` (the track as data), `profiles`, `contact`, `creep_laws` and `kalker`
(wheel and rail as plain functions), `parameter_sets`, `reduction`. The other modules hold the equations of the vehicle.
`contact_points`, loaded on first use: where a wheelset with profiles by points touches its rails.
"""

from typing import Any

__all__ = ["VARIANTS"]

VARIANTS = {
    "wheel_pair": "gyro_cosim.vehicle.wheel_pair:small_wheel_pair",
    "lrt": "gyro_cosim.vehicle.lrt:lrt_set_a",
    "lrt_set_b": "gyro_cosim.vehicle.variants:lrt_set_b",
    "lrt_shen_hedrick_elkins": "gyro_cosim.vehicle.variants:lrt_shen_hedrick_elkins",
    "lrt_fastsim": "gyro_cosim.vehicle.variants:lrt_fastsim",
    "lrt_half_space": "gyro_cosim.vehicle.variants:lrt_half_space",
    "lrt_rough": "gyro_cosim.vehicle.variants:lrt_rough",
    "lrt_solid_axle": "gyro_cosim.vehicle.variants:lrt_solid_axle",
    "wheelset": "gyro_cosim.vehicle.wheelset:sprung_wheelset",
}


def __getattr__(name: str) -> Any:
    """`contact_points`, loaded when it is first asked for."""
    if name == "contact_points":
        from .wheelset_contact import contact_points

        return contact_points
    raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
