"""The vehicle and its track: components with a mount for a gyro unit.

`VARIANTS` maps the name of a variant to the function that makes the component; nothing is loaded before it is asked for.
The first is the default.
"""

VARIANTS = {
    "wheel_pair": "vehicle.wheel_pair:wheel_pair",
    "lrt": "vehicle.lrt:lrt",
}
