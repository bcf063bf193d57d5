"""Gyro units: passive dampers behind one connector, swapped by name.

`VARIANTS` maps the name of a variant to the function that makes the component; nothing is loaded before it is asked for.
The first is the default.
"""

VARIANTS = {
    "linear": "gyro_unit.linear:linear",
    "nonlinear": "gyro_unit.nonlinear:nonlinear",
    "consistent": "gyro_unit.nonlinear:consistent",
    "linear_full": "gyro_unit.linear:linear_full",
    "nonlinear_full": "gyro_unit.nonlinear:nonlinear_full",
}
