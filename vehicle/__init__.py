"""The vehicle and its track: components with a mount for a gyro unit.

`VARIANTS` maps the name of a variant to the function that makes the component; nothing is loaded before it is asked for.
The first is the default.
"""

VARIANTS = {
    "wheel_pair": "vehicle.wheel_pair:wheel_pair",
    "lrt": "vehicle.lrt:lrt",
    "lrt_set_b": "vehicle.variants:lrt_set_b",
    "lrt_shen_hedrick_elkins": "vehicle.variants:lrt_shen_hedrick_elkins",
    "lrt_fastsim": "vehicle.variants:lrt_fastsim",
    "lrt_rough": "vehicle.variants:lrt_rough",
    "lrt_solid_axle": "vehicle.variants:lrt_solid_axle",
    "wheelset": "vehicle.wheelset:wheelset",
}
