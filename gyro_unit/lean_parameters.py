"""Parameters of the gyro units that are to keep the gimbal's lean small. The paper has none of them: every number is assumed.

How they were chosen: FULL's, so that a lean of about half a radian carries the moment H v / R of the paper's curve at 8 m/s
(739 N m at 2000 rpm), and that a change of spin takes some seconds; SMALL's, the same in proportion to Table 1's spring.
"""

from dataclasses import replace

from gyro_cosim.component import Variable, parameter

from .parameters import FULL, SMALL

__all__ = ["CENTRED_FULL", "CENTRED_SMALL", "PROGRESSIVE_FULL", "PROGRESSIVE_SMALL", "SCHEDULED_FULL", "SCHEDULED_SMALL"]

_ASSUMED = "assumed, see gyro_unit/lean_parameters.py"


def _progressive(table: tuple[Variable, ...], outer: float, damping: float, units: tuple[str, str]) -> tuple[Variable, ...]:
    """The table with a spring about the centre that may push outwards, and what outer spring and damper add."""
    centre = next(v for v in table if v.name == "gimbal_stiffness")
    rows = tuple(replace(v, min=-100 * centre.start, meaning=f"{v.meaning}, about the centre; below 0: it pushes outwards")
                 if v is centre else v for v in table)  # fmt: skip
    return (
        *rows,
        parameter("outer_stiffness", outer, units[0], "what the outer spring adds far from the centre, at the arm d_g",
                  symbol="k_o", source=_ASSUMED, assumed=(0.0, 100 * outer), min=0.0, nominal=outer),
        parameter("outer_damping", damping, units[1], "what the outer damper adds far from the centre, at the arm d_g",
                  symbol="c_o", source=_ASSUMED, assumed=(0.0, 100 * damping), min=0.0, nominal=damping),
        parameter("slot_angle", 0.3, "rad", "lean at which a quarter of outer stiffness and damping is there", symbol="eta_s",
                  source=_ASSUMED, assumed=(0.05, 1.0), min=1e-3, display_unit="deg"),
    )  # fmt: skip


def _centred(table: tuple[Variable, ...], gain: float, limit: float) -> tuple[Variable, ...]:
    """The table, the gain of the slow loop and its motor."""
    return (
        *table,
        parameter("centring_gain", gain, "N.m.s-1/rad", "torque of the motor over the integral of the lean", symbol="k_i",
                  source=_ASSUMED, assumed=(0.0, 100 * gain), min=0.0, nominal=gain),
        parameter("centring_torque_limit", limit, "N.m", "largest torque of the motor", symbol="T_max", source=_ASSUMED,
                  assumed=(limit / 10, limit * 10), min=1e-9, nominal=limit),
    )  # fmt: skip


def _scheduled(table: tuple[Variable, ...], rate: float, limit: float) -> tuple[Variable, ...]:
    """The table, the schedule and the motor."""
    return (
        *table,
        parameter("curve_spin", 0.5, "1", "spin in a tight curve over that on straight track", symbol="f", source=_ASSUMED,
                  assumed=(0.0, 2.0), min=0.0),
        parameter("schedule_rate", rate, "rad/s", "filtered yaw rate at which half of the change is wanted", symbol="r_s",
                  source=_ASSUMED, assumed=(rate / 10, rate * 10), min=1e-6),
        parameter("schedule_filter", 0.3, "s", "time constant of the yaw rate's filter", symbol="T_f", source=_ASSUMED,
                  assumed=(0.01, 10.0), min=1e-2),
        parameter("spin_time", 0.5, "s", "time in which the motor would undo an error of the spin, within its torque",
                  symbol="T_w", source=_ASSUMED, assumed=(0.1, 10.0), min=1e-2),
        parameter("motor_torque_limit", limit, "N.m", "largest torque of the motor", symbol="T_max", source=_ASSUMED,
                  assumed=(limit / 10, limit * 10), min=1e-9, nominal=limit),
    )  # fmt: skip


PROGRESSIVE_SMALL = _progressive(SMALL, 0.03, 0.02, ("N.m/rad", "N.m.s/rad"))
PROGRESSIVE_FULL = _progressive(FULL, 5e4, 5e4, ("N/m", "N.s/m"))
CENTRED_SMALL = _centred(SMALL, 4.5e-4, 0.02)
CENTRED_FULL = _centred(FULL, 1.5e3, 2e3)
SCHEDULED_SMALL = _scheduled(SMALL, 0.5, 0.01)
SCHEDULED_FULL = _scheduled(FULL, 0.08, 2e3)
