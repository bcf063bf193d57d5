"""The connector of the gyro mount, the same for every variant and every vehicle, and the signals every variant reports.

Into the gyro unit: the absolute rates of the frame that carries it, about its axes x (forward), y (lateral) and z (up).
Out of it: the moments on that frame about the same axes, so that rate times moment is the power INTO the vehicle.
A variant without a pitch or roll moment returns 0 for it. Gimbal and rotor masses that ride on the frame belong to the
vehicle, so that no acceleration crosses the interface. Which inertias these are is the unit's to say, axis by axis (`bonds`):
what has a state of its own in the unit does not ride on the frame, what turns with the frame does; none lost, none twice.

Rows for the table of a gyro unit of your own:

    CONNECTOR   rates of the frame (inputs, rad/s) and moments on it (outputs, N m); every gyro unit has these
    BONDS       their pairs, by axis: what `build` gets as `bonds`
    bonds       the same, with what of the unit's inertia rides on the frame
    ENERGY      stored energy E (J) and dissipated power P (W), with E' = -(sum of moment times rate) - P
    GIMBAL      angle (rad) and absolute rate (rad/s) of a gimbal, for those that have one
"""

from gyro_cosim.component import Bond, Variable, input_, output, state

__all__ = ["BONDS", "CONNECTOR", "ENERGY", "GIMBAL", "SINGLE_GIMBAL", "bonds"]


def bonds(*, roll: str, pitch: str, yaw: str) -> tuple[Bond, ...]:
    """The pairs, with what of the unit's inertia rides on the frame: a parameter of the unit, or a number in kg m2."""
    rides = {"yaw": yaw, "roll": roll, "pitch": pitch}
    return tuple(Bond("mount", axis, f"{axis}_rate", f"{axis}_moment", inertia) for axis, inertia in rides.items())


BONDS = bonds(roll="", pitch="", yaw="")
# A rotor held at its speed in a gimbal with a state about y: the inner gimbal is alike about y and z, as a body of revolution is.
SINGLE_GIMBAL = bonds(roll="rotor_inertia", pitch="0", yaw="gimbal_inertia")

CONNECTOR: tuple[Variable, ...] = (
    input_("yaw_rate", "rad/s", "absolute yaw rate of the carrying frame", symbol="psi'", nominal=1.0),
    input_("roll_rate", "rad/s", "absolute roll rate of the carrying frame", symbol="phi'", nominal=1.0),
    input_("pitch_rate", "rad/s", "absolute pitch rate of the carrying frame", symbol="theta'", nominal=1.0),
    output("yaw_moment", "N.m", "yaw moment on the carrying frame", symbol="M_z", nominal=0.01),
    output("roll_moment", "N.m", "roll moment on the carrying frame", symbol="M_x", nominal=0.01),
    output("pitch_moment", "N.m", "pitch moment on the carrying frame", symbol="M_y", nominal=0.01),
)

ENERGY: tuple[Variable, ...] = (
    output("stored_energy", "J", "kinetic energy of the gimbal and energy of its spring", symbol="E", nominal=0.01),
    output("dissipated_power", "W", "power turned into heat, never negative", symbol="P_c", nominal=0.01),
)

GIMBAL: tuple[Variable, ...] = (
    state("gimbal_angle", "rad", "angle of the inner gimbal against the frame", symbol="eta", is_output=True, nominal=0.1,
          source="sec. 2.4"),
    state("gimbal_pitch_rate", "rad/s", "absolute rate of the inner gimbal about the gimbal axis: theta' + eta'",
          symbol="omega_y", nominal=1.0, source="sec. 2.4"),
)  # fmt: skip
