"""Parameters of the gyro units: number, unit, source; what is not given in the paper is marked `assumed`.

SMALL is Table 1 of the paper, the gyro unit on the 1/10-scale wheel pair. As printed it is no rigid body: a body's inertia
about one axis cannot exceed the sum of the other two, but I_xg = 3.7e-4 > I_yg + I_zg = 2.6e-4 kg m2. We keep the numbers
to reproduce the paper; the variant `consistent` replaces I_yg.

FULL is Table 2 of the paper, the gyro unit on a wheel frame of the full vehicle. Table 2 gives springs and dampers in N/m and
N s/m, so d_g is a real lever arm here; how many of them act is not given in the paper: k_g = n k_z, c_g = n c_z. This file is
the source of k_z, c_z and n for the gyro units; a test ties them to the vehicle's parameter sets and to the systems' values.
"""

from math import pi

from gyro_cosim.component import parameter

__all__ = ["FULL", "SMALL"]

SPRING_STIFFNESS, SPRING_DAMPING = 86700.0, 21000.0  # k_z in N/m, c_z in N s/m, Table 2
SPRINGS = 2.04  # n of the vehicle's parameter set A

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

FULL = (
    parameter(
        "rotor_speed", 2000 * 2 * pi / 60, "rad/s", "spin of the rotor", symbol="Omega", source="sec. 3.2 (2000 rpm)",
        min=-2000.0, max=2000.0, nominal=100.0, display_unit="rpm",
    ),
    parameter("rotor_inertia", 22.04, "kg.m2", "inertia of the rotor about its spin axis", symbol="I_xg",
              source="Table 2, inner gimbal", min=0.0, nominal=10.0),
    parameter("gimbal_inertia", 26.45, "kg.m2", "inertia of inner gimbal and rotor about the gimbal axis", symbol="I_yg",
              source="Table 2, inner gimbal", min=1e-3, nominal=10.0),
    parameter("gimbal_stiffness", SPRINGS * SPRING_STIFFNESS, "N/m", "stiffness of the gimbal's springs together, n k_z",
              symbol="k_g",
              source="Table 2 (k_z = 86700 N/m); their number n is not in the paper: 2.04 as in the vehicle's set A",
              assumed=(SPRING_STIFFNESS, 4 * SPRING_STIFFNESS), min=0.0, nominal=1e5),
    parameter("gimbal_damping", SPRINGS * SPRING_DAMPING, "N.s/m", "damping of the gimbal's dampers together, n c_z",
              symbol="c_g",
              source="Table 2 (c_z = 21000 N s/m); their number n is not in the paper: 2.04 as in the vehicle's set A",
              assumed=(SPRING_DAMPING, 4 * SPRING_DAMPING), min=0.0, nominal=1e4),
    parameter(
        "spring_arm", 0.3, "m", "lever arm of springs and dampers about the gimbal axis", symbol="d_g",
        source="not in the paper; the outer gimbal's inertias are those of a flat frame of this size",
        assumed=(0.3, 0.5), min=0.0,
    ),
)  # fmt: skip
