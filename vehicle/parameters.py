"""Parameters of the vehicle's components: number, unit, source; what is not given in the source is marked `assumed`.

WHEEL_PAIR is Table 1 of the paper, the 1/10-scale wheel pair, less the rows that belong to the gyro unit.
"""

from gyro_cosim.component import parameter

__all__ = ["WHEEL_PAIR"]

WHEEL_PAIR = (
    parameter(
        "speed", 10.0, "m/s", "forward speed", symbol="v", source="sec. 2.4, figs. 3 and 4",
        min=0.1, max=200.0, nominal=10.0, display_unit="kmh",
    ),
    parameter("wheelset_mass", 2.53, "kg", "mass of the wheel pair", symbol="m_w", source="Table 1", min=1e-3),
    parameter(
        "gyro_mass", 0.41, "kg", "mass of the gyro unit that rides on the wheel pair", symbol="m_g", source="Table 1", min=0.0,
    ),
    parameter(
        "yaw_inertia", 0.006, "kg.m2", "yaw inertia of the wheel pair alone", symbol="I_zw",
        source="Table 1 names it without a value", assumed=(0.003, 0.007), min=1e-6, nominal=0.006,
    ),
    parameter(
        "payload_yaw_inertia", 1.3e-4, "kg.m2", "yaw inertia of the gyro unit that turns with the wheel pair",
        symbol="I_yg", source="eq. (2) writes I_yg; Table 1 gives I_zg the same value", min=0.0, nominal=1e-4,
    ),
    parameter(
        "wheel_load", 14.42, "N", "vertical load of one wheel", symbol="P",
        source="not in the paper: m_t g / 2 makes 2 P the weight; read as the load of the pair it would be twice that",
        assumed=(14.42, 28.84), min=0.0, nominal=10.0,
    ),
    parameter(
        "contact_half_distance", 0.049, "m", "half the distance of the contact points", symbol="b",
        source="Table 1 (2b = 0.098 m)", min=1e-3,
    ),
    parameter(
        "rolling_radius", 0.036, "m", "rolling radius of a centred wheel; enters the wheel speed only, not eqs. (1)-(2)",
        symbol="r_0", source="Table 1", min=1e-3,
    ),
    parameter("lateral_creep_coefficient", 171.0, "N", "lateral creep coefficient of one wheel", symbol="k_22",
              source="Table 1", min=0.0, nominal=100.0),
    parameter("conicity", 0.025, "1", "negative tread conicity at the centre", symbol="gamma_0", source="Table 1"),
    parameter("conicity_gradient", 0.8, "1/m", "growth of the conicity with lateral displacement", symbol="gamma_1",
              source="Table 1"),
)  # fmt: skip
