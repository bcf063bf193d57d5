"""Parameters of the full light-rail vehicle: Table 2 of the paper, and `assumed` ranges of what it does not give.

`lrt_parameters` is the table of `vehicle:lrt`. Where the paper gives no number the default is that of the named set A
(vehicle/sets); set B and your own are put on top by name.
"""

from math import cos, inf, radians

from gyro_cosim.component import Variable, parameter

from .contact import hertz_patch
from .friction import FRICTION
from .kalker import RATIO, coefficients

__all__ = [
    "DIMENSIONS", "MASSES", "PRIMARY_DAMPING", "PRIMARY_STIFFNESS", "RUN", "WHEEL", "drive_rows", "rail_and_contact",
    "vehicle_parameters",
]  # fmt: skip

TABLE = "Table 2"
OPEN = "not in the paper"
YOUNG, POISSON = 2.1e11, 0.28
PRIMARY_STIFFNESS, PRIMARY_DAMPING = 86700.0, 21000.0  # k in N/m along x, y and z, c in N s/m along x and z, Table 2


def drive_rows() -> tuple[Variable, ...]:
    """What holds the speed."""
    return (
        parameter("drive_gain", 20000.0, "N.s/m", "drive force per lack of speed, half at each axle; the drive also carries the "
                  "rolling drag of straight track", source="ours: holds the speed within 0.05 m/s against 1 kN", min=0.0),
        parameter("drive_on", 1.0, "1", "1: the drive holds the speed, 0: the vehicle rolls freely", source="ours", min=0.0,
                  max=1.0),
    )  # fmt: skip


RUN = (
    parameter("speed", 5.0, "m/s", "forward speed the drive holds", symbol="v", source="figs. 7 and 8", min=0.5, max=120.0,
              nominal=10.0, display_unit="kmh", tunable=False),
    parameter("gravity", 9.81, "m/s2", "acceleration of gravity", symbol="g", source="standard", min=0.1, tunable=False),
)  # fmt: skip

MASSES = (
    *RUN,
    parameter("body_mass", 2000.0, "kg", "mass of the car body", source=TABLE, min=1.0),
    parameter("body_ixx", 3000.0, "kg.m2", "roll inertia of the car body", source=TABLE, min=1e-3),
    parameter("body_iyy", 18166.7, "kg.m2", "pitch inertia of the car body", source=TABLE, min=1e-3),
    parameter("body_izz", 18166.7, "kg.m2", "yaw inertia of the car body", source=TABLE, min=1e-3),
    parameter("bogie_mass", 500.0, "kg", "mass of a bogie frame", source=TABLE, min=1.0),
    parameter("bogie_ixx", 276.3, "kg.m2", "roll inertia of a bogie frame", source=TABLE, min=1e-3),
    parameter("bogie_iyy", 163.14, "kg.m2", "pitch inertia of a bogie frame", source=TABLE, min=1e-3),
    parameter("bogie_izz", 404.7, "kg.m2", "yaw inertia of a bogie frame", source=TABLE, min=1e-3),
    parameter("frame_mass", 200.0, "kg", "mass of a wheel frame", source=TABLE, min=1.0),
    parameter("frame_ixx", 78.07, "kg.m2", "roll inertia of a wheel frame", source=TABLE, min=1e-3),
    parameter("frame_iyy", 52.23, "kg.m2", "pitch inertia of a wheel frame", source=TABLE, min=1e-3),
    parameter("frame_izz", 115.54, "kg.m2", "yaw inertia of a wheel frame", source=TABLE, min=1e-3),
    parameter("wheel_mass", 600.0, "kg", "mass of a wheel", source=TABLE, min=0.0),
    parameter("wheel_ixx", 25.13, "kg.m2", "inertia of a wheel about a diameter", source=TABLE, min=0.0),
    parameter("wheel_spin_inertia", 21.25, "kg.m2", "inertia of a wheel about its axle", symbol="I_yw", source=TABLE, min=1e-4,
              nominal=10.0),
    parameter("outer_gimbal_mass", 100.0, "kg", "mass of the outer gimbal, fixed to the wheel frame", source=TABLE, min=0.0),
    parameter("outer_gimbal_ixx", 12.78, "kg.m2", "roll inertia of the outer gimbal", source=TABLE, min=0.0),
    parameter("outer_gimbal_iyy", 11.32, "kg.m2", "pitch inertia of the outer gimbal", source=TABLE, min=0.0),
    parameter("outer_gimbal_izz", 24.03, "kg.m2", "yaw inertia of the outer gimbal", source=TABLE, min=0.0),
    parameter("inner_gimbal_mass", 500.0, "kg", "mass of inner gimbal and rotor", source=TABLE, min=0.0),
    parameter("inner_gimbal_ixx", 22.04, "kg.m2", "roll inertia of inner gimbal and rotor", source=TABLE, min=0.0),
    parameter("inner_gimbal_iyy", 0.0, "kg.m2", "pitch inertia of inner gimbal and rotor that turns with the frame; that of "
              "a single gimbal belongs to the gyro unit", source="a single gimbal", min=0.0),
    parameter("inner_gimbal_izz", 26.45, "kg.m2", "yaw inertia of inner gimbal and rotor",
              source=TABLE, min=0.0),
)  # fmt: skip

DIMENSIONS = (
    parameter("pivot_spacing", 6.69, "m", "distance of the wheel pairs and of the pivots above them", symbol="L", source=OPEN,
              assumed=(4.0, 7.0), min=1.0, max=20.0),
    parameter("body_height", 1.5, "m", "centre of gravity of the car body over the rails", source=OPEN, assumed=(1.0, 2.0),
              min=0.0),
    parameter("bogie_height", 0.55, "m", "centre of gravity of a bogie frame over the rails", source=OPEN, assumed=(0.3, 0.8),
              min=0.0),
    parameter("spring_height", 0.45, "m", "height of the primary springs over the rails", source=OPEN, assumed=(0.25, 0.6),
              min=0.0),
    parameter("spring_half_spacing_x", 0.5, "m", "half the distance of the springs along the track", source=OPEN,
              assumed=(0.3, 0.8), min=0.0),
    parameter("spring_half_spacing_y", 0.7, "m", "half the distance of the springs across the track", source=OPEN,
              assumed=(0.4, 1.0), min=0.0),
    parameter("springs_per_corner", 1.0, "1", "number of springs and dampers at each of four corners", source=OPEN,
              assumed=(1.0, 2.0), min=0.0),
    *(parameter(f"primary_stiffness_{axis}", PRIMARY_STIFFNESS, "N/m", f"stiffness of one primary spring along {axis}",
                source=TABLE, min=0.0, nominal=1e5) for axis in "xyz"),
    parameter("primary_damping_x", PRIMARY_DAMPING, "N.s/m", "damping of one primary damper along x", source=TABLE, min=0.0,
              nominal=1e4),
    parameter("primary_damping_y", 0.0, "N.s/m", "damping of one primary damper along y", source=TABLE, min=0.0, nominal=1e4),
    parameter("primary_damping_z", PRIMARY_DAMPING, "N.s/m", "damping of one primary damper along z", source=TABLE, min=0.0,
              nominal=1e4),
    parameter("pivot_damping", 0.0, "N.m.s/rad", "yaw damper between a bogie frame and the car body", symbol="c_p",
              source="Table 2: nothing acts between them", min=0.0, nominal=1e4),
    parameter("pivot_inertance", 0.0, "kg.m2", "rotational inerter between a bogie frame and the car body", symbol="b_p",
              source="Table 2: nothing acts between them", min=0.0, nominal=1e3),
    *drive_rows(),
)  # fmt: skip

WHEEL = (
    parameter("contact_half_distance", 0.7475, "m", "half the distance of the contact points", symbol="b",
              source=f"{OPEN}: gauge 1.435 m and the rail heads", assumed=(0.73, 0.77), min=0.1),
    parameter("rolling_radius", 0.328, "m", "rolling radius of a centred wheel", symbol="r_0", source=OPEN,
              assumed=(0.27, 0.33), min=0.05),
    parameter("conicity", 0.049, "1", "tread conicity at the centre; the radius grows towards the flange", symbol="gamma_0",
              source=f"{OPEN} for the full vehicle (0.025 in Table 1)", assumed=(0.0, 0.5), max=1.0, min=-0.5),
    parameter("conicity_gradient", 10.65, "1/m", "growth of the conicity towards the flange", symbol="gamma_1",
              source=f"{OPEN} for the full vehicle (0.8 in Table 1)", assumed=(0.0, 20.0), min=0.0, max=40.0),
    parameter("flange_clearance", 0.0061, "m", "lateral displacement at which the flange meets the rail", source=OPEN,
              assumed=(0.004, 0.012), min=0.0005, max=0.05, display_unit="mm"),
    parameter("tread_margin", 0.004, "m", "the tread goes on straight beyond clearance plus this", source="ours", min=0.0,
              display_unit="mm"),
    parameter("flange_angle", radians(71.8), "rad", "angle of the flange's cone against the axle", symbol="delta",
              source=f"{OPEN}: usual", assumed=(radians(60.0), radians(72.0)), min=0.5, max=1.4, display_unit="deg"),
    parameter("flange_height", 0.028, "m", "height of the flange's top under the running line", source=f"{OPEN}: usual",
              assumed=(0.02, 0.036), min=0.015, display_unit="mm"),
    parameter("flange_tip_radius", 0.012, "m", "radius of the flange's tip", source=f"{OPEN}: usual", assumed=(0.008, 0.015),
              min=0.002, display_unit="mm"),
)  # fmt: skip


def rail_and_contact() -> tuple[Variable, ...]:
    """Rail head, material and contact: what can be computed (Kalker's coefficients, the flange's patch) is."""
    C = coefficients(1.0, 1.0, POISSON)
    flange = hertz_patch(10e3, 0.337 / cos(radians(70.0)), inf, 0.013, YOUNG, POISSON)
    F = coefficients(1.0, RATIO[0], POISSON)
    from_table = "Kalker's table, a/b = 1, Poisson's ratio 0.28"
    beyond = "Kalker's table at its end a/b = 10; the flange's patch is longer still"
    return (
        parameter("rail_crown_radius", 0.3, "m", "transverse radius of the rail's crown, for the patch",
                  source="UIC 60 rail head", min=0.05),
        parameter("corner_radius", 0.013, "m", "radius of the rail head's corner", source="UIC 60 rail head", min=0.002,
                  display_unit="mm"),
        parameter("corner_offset", 0.020, "m", "distance of the corner circle's centre from the running line", source="rail head",
                  assumed=(0.015, 0.025), min=0.0, display_unit="mm"),
        parameter("corner_depth", 0.0135, "m", "depth of the corner circle's centre under the running line", source="rail head",
                  assumed=(0.012, 0.016), min=0.0, display_unit="mm"),
        parameter("rail_lateral_stiffness", 1.1e7, "N/m", "lateral stiffness of the rail against the flange", source=OPEN,
                  assumed=(5e6, 4e7),
                  min=1e5, nominal=1e7),
        parameter("friction", 0.369, "1", "coefficient of friction", symbol="mu", source=OPEN, assumed=(0.2, 0.4), min=0.0,
                  max=1.0),
        *FRICTION,
        parameter("youngs_modulus", YOUNG, "Pa", "Young's modulus of wheel and rail", symbol="E", source="steel", min=1e9,
                  nominal=1e11),
        parameter("poisson_ratio", POISSON, "1", "Poisson's ratio of wheel and rail", symbol="nu", source="steel", min=0.0,
                  max=0.5),
        parameter("contact_damping", 10.0, "s/m", "damping of the contact per approach rate, as a factor on the load",
                  source="gives 10 to 20 % of critical damping at the contact's frequency", assumed=(0.0, 30.0), min=0.0),
        *(parameter(f"kalker_c{i}", float(c), "1", f"Kalker's C{i} on the tread", symbol=f"C{i}", source=from_table, min=0.0)
          for i, c in zip((11, 22, 23, 33), C, strict=True)),
        *(parameter(f"flange_kalker_c{i}", float(c), "1", f"Kalker's C{i} on the flange", symbol=f"C{i}", source=beyond, min=0.0)
          for i, c in zip((11, 22, 23, 33), F, strict=True)),
        parameter("flange_patch_load", 10e3, "N", "load of the flange's reference patch", source="ours", min=1.0, nominal=1e4),
        parameter("flange_patch_a", flange.a, "m", "semi-axis of the reference patch along the rail",
                  source="Hertz: 10 kN, wheel 0.337 m / cos 70 deg, rail corner 13 mm", min=1e-5, display_unit="mm"),
        parameter("flange_patch_b", flange.b, "m", "semi-axis of the reference patch up the flange",
                  source="Hertz: 10 kN, wheel 0.337 m / cos 70 deg, rail corner 13 mm", min=1e-5, display_unit="mm"),
    )  # fmt: skip


def vehicle_parameters() -> tuple[Variable, ...]:
    """Every parameter of the vehicle but those of the track (vehicle.track_parameters)."""
    return (*MASSES, *DIMENSIONS, *WHEEL, *rail_and_contact())
