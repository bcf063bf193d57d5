"""Gyro units: passive dampers behind one connector, swapped by name.

`VARIANTS` maps the name of a variant to the function that makes the component; nothing is loaded before it is asked for.
The first is the default. A name alone is the 1/10-scale gyro unit of Table 1, with `_full` that of Table 2 (`consistent` mends
what is wrong in Table 1 only).

Public besides VARIANTS: `mount` (the connector, for gyro units of your own), `parameters.SMALL` and `parameters.FULL` (the
paper's tables), `hil.behind_rig` (a test rig around any gyro unit) and the functions that make the variants.
"""

__all__ = ["VARIANTS"]

VARIANTS = {
    "linear": "gyro_cosim.gyro_unit.linear:linear_small",
    "nonlinear": "gyro_cosim.gyro_unit.nonlinear:nonlinear_small",
    "consistent": "gyro_cosim.gyro_unit.nonlinear:consistent",
    "multibody": "gyro_cosim.gyro_unit.multibody:multibody_small",
    "twin": "gyro_cosim.gyro_unit.twin:twin_small",
    "lateral": "gyro_cosim.gyro_unit.lateral:lateral_small",
    "progressive": "gyro_cosim.gyro_unit.progressive:progressive_small",
    "centred": "gyro_cosim.gyro_unit.centred:centred_small",
    "scheduled": "gyro_cosim.gyro_unit.scheduled:scheduled_small",
    "off": "gyro_cosim.gyro_unit.held:off",
    "locked": "gyro_cosim.gyro_unit.held:locked",
    "hil": "gyro_cosim.gyro_unit.hil:small",
    "linear_full": "gyro_cosim.gyro_unit.linear:linear_full",
    "nonlinear_full": "gyro_cosim.gyro_unit.nonlinear:nonlinear_full",
    "multibody_full": "gyro_cosim.gyro_unit.multibody:multibody_full",
    "twin_full": "gyro_cosim.gyro_unit.twin:twin_full",
    "lateral_full": "gyro_cosim.gyro_unit.lateral:lateral_full",
    "progressive_full": "gyro_cosim.gyro_unit.progressive:progressive_full",
    "centred_full": "gyro_cosim.gyro_unit.centred:centred_full",
    "scheduled_full": "gyro_cosim.gyro_unit.scheduled:scheduled_full",
    "off_full": "gyro_cosim.gyro_unit.held:off_full",
    "locked_full": "gyro_cosim.gyro_unit.held:locked_full",
    "hil_full": "gyro_cosim.gyro_unit.hil:full",
}
