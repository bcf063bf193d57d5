"""Parameters of the gyro units: number, unit, source; what the source leaves open is marked `assumed`.

SMALL is Table 1 of the paper, the unit on the 1/10-scale wheel pair. As printed it is no rigid body: a body's inertia
about one axis cannot exceed the sum of the other two, but I_xg = 3.7e-4 > I_yg + I_zg = 2.6e-4 kg m2. We keep the numbers
to reproduce the paper; the variant `consistent` replaces I_yg.
"""

from math import pi

from component import parameter

SMALL = (
    parameter(
        "rotor_speed", 100 * 2 * pi / 60, "rad/s", "spin of the rotor", symbol="Omega", source="fig. 4, top (100 rpm)",
        min=-2000.0, max=2000.0, nominal=10.0, display_unit="rpm",
    ),
    parameter("rotor_inertia", 3.7e-4, "kg.m2", "inertia of the rotor about its spin axis", symbol="I_xg", source="Table 1",
              min=0.0, nominal=1e-4),
    parameter("gimbal_inertia", 1.3e-4, "kg.m2", "inertia of inner gimbal and rotor about the gimbal axis", symbol="I_yg",
              source="Table 1", min=1e-7, nominal=1e-4),
    parameter("gimbal_stiffness", 0.0045, "N.m/rad", "stiffness of the gimbal's spring", symbol="k_g",
              source="Table 1 (printed in N m)", min=0.0, nominal=1e-3),
    parameter("gimbal_damping", 6.3e-4, "N.m.s/rad", "damping of the gimbal", symbol="c_g", source="Table 1 (printed in N m s)",
              min=0.0, nominal=1e-3),
    parameter(
        "spring_arm", 1.0, "1", "lever arm d_g as a factor on k_g and c_g", symbol="d_g",
        source="not in the paper; k_g and c_g carry torsional units already, and an arm of a few cm would leave no damping",
        assumed=(0.03, 1.0), min=0.0,
    ),
)  # fmt: skip
