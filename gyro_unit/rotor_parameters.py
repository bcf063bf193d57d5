"""Motor, bearing and end stops of the multibody gyro unit. The paper says nothing about them: every number is assumed.

How they were chosen: the speed controller closes at 5 rad/s (K_p = 5 C 1/s, K_i = K_p 1/s), well below the gimbal's motion and
fast against a run; bearing losses are of the size of ball bearings' (a time constant of minutes); the end stop's spring rings
at about 200 rad/s with the gimbal, which an internal step of 1 ms resolves.
"""

from gyro_cosim.component import Variable, parameter

__all__ = ["ROTOR_FULL", "ROTOR_SMALL"]

_ASSUMED = "assumed, see gyro_unit/rotor_parameters.py"


def _rotor(
    *, gain: float, limit: float, viscous: float, coulomb: float, stop_angle: float, stop: float, arm_unit: str
) -> tuple[Variable, ...]:
    """The table; every assumed range is a tenth to ten times the number."""

    def assumed(value: float) -> tuple[float, float]:
        return value / 10, value * 10

    return (
        parameter("speed_gain", gain, "N.m.s/rad", "motor torque over speed error", symbol="K_p", source=_ASSUMED,
                  assumed=assumed(gain), min=0.0, nominal=gain),
        parameter("speed_integral_gain", gain, "N.m/rad", "motor torque over integral of the speed error", symbol="K_i",
                  source=_ASSUMED, assumed=assumed(gain), min=0.0, nominal=gain),
        parameter("motor_torque_limit", limit, "N.m", "largest torque of the motor", symbol="T_max", source=_ASSUMED,
                  assumed=assumed(limit), min=0.0, nominal=limit),
        parameter("bearing_viscous_friction", viscous, "N.m.s/rad", "viscous friction of the rotor's bearing", symbol="b",
                  source=_ASSUMED, assumed=assumed(viscous), min=0.0, nominal=viscous),
        parameter("bearing_friction", coulomb, "N.m", "dry friction of the rotor's bearing", symbol="T_c", source=_ASSUMED,
                  assumed=assumed(coulomb), min=0.0, nominal=coulomb),
        parameter("bearing_friction_speed", 0.5, "rad/s", "spin within which dry friction changes sign", symbol="n_s",
                  source="numerical: smooths the sign function", assumed=(0.1, 1.0), min=1e-3),
        parameter("stop_angle", stop_angle, "rad", "gimbal angle at which the end stops begin", symbol="eta_s",
                  source=_ASSUMED, assumed=(0.2, 1.5), min=0.0, display_unit="deg"),
        parameter("stop_stiffness", stop, arm_unit, "stiffness of the end stops at the arm d_g", symbol="k_s",
                  source=_ASSUMED, assumed=assumed(stop), min=0.0, nominal=stop),
        parameter("stop_damping", 1.0, "s/rad", "damping of the end stops over their stiffness", symbol="d_s",
                  source=_ASSUMED, assumed=(0.0, 10.0), min=0.0),
    )  # fmt: skip


ROTOR_SMALL = _rotor(gain=1.85e-3, limit=0.02, viscous=1e-6, coulomb=1e-4, stop_angle=1.3, stop=5.0, arm_unit="N.m/rad")
ROTOR_FULL = _rotor(gain=110.0, limit=50.0, viscous=0.01, coulomb=2.0, stop_angle=0.5, stop=1.2e7, arm_unit="N/m")
