"""Why a wheel left its rail: its flange climbed under load, it had lost its load, or the vehicle rolled over. SI units.

    body roll-over      for most of the last half second all wheels of the other side carried less than a twentieth of what
                        they did at the beginning: the vehicle leans on one rail, and what its flanges do there follows
    wheel unloading     the wheel itself carried less than a tenth over the last tenth of a second
    flange climb        otherwise: the flange went up its rail under load, at the Y/Q, unfiltered, that is told

A wheel is also off its rail where it hangs HIGH above it, whatever its flange does: so it is when a vehicle rolls over.
"""

import numpy as np

from ..trajectory import Trajectory
from .safety import Verdict

__all__ = ["cause", "lifted"]

LOAD, LIFT, RATIO, CLIMB = "_vertical_force", "_wheel_lift", "_derailment_coefficient", "_climb"
HIGH = 0.05  # m, more than a flange is high
SIDES = {"left": "right", "right": "left"}


def _side(wheel: str) -> str:
    return wheel.rpartition("_")[2]


def lifted(trajectory: Trajectory, vehicle: str, wheels: tuple[str, ...]) -> Verdict:
    """Whether all wheels of a side came to hang above their rail.

    Parameters
    ----------
    trajectory
        Of a run.
    vehicle, wheels
        Its name and those of its wheels.

    Returns
    -------
    Verdict
    """
    first = len(trajectory)
    off = ""
    for side in SIDES:
        gaps = [f"{vehicle}.{wheel}{LIFT}" for wheel in wheels if _side(wheel) == side]
        if not gaps or not all(name in trajectory.names for name in gaps):
            continue
        high = np.flatnonzero(np.min([trajectory[name] for name in gaps], axis=0) > HIGH)
        if high.size and high[0] < first:
            first, off = int(high[0]), next(wheel for wheel in wheels if _side(wheel) == side)
    if not off:
        return Verdict(False)
    return Verdict(True, off, float(trajectory.t[first]), float(trajectory[f"{vehicle}.body_distance"][first]), "body roll-over")


def cause(trajectory: Trajectory, vehicle: str, wheels: tuple[str, ...], verdict: Verdict) -> str:
    """Why a wheel left its rail; empty where none did, or the wheels' loads were not recorded.

    Parameters
    ----------
    trajectory
        Of a run.
    vehicle, wheels
        Its name and those of its wheels.
    verdict
        Which wheel left its rail, and when.

    Returns
    -------
    str
        "body roll-over", "wheel unloading" or "flange climb at Y/Q up to 1.2".
    """
    if not verdict.derailed or not all(f"{vehicle}.{wheel}{LOAD}" in trajectory.names for wheel in wheels):
        return ""
    t = trajectory.t
    loads = {wheel: trajectory[f"{vehicle}.{wheel}{LOAD}"] for wheel in wheels}
    recent, last = (t > verdict.t - 0.5) & (t <= verdict.t), (t > verdict.t - 0.1) & (t <= verdict.t)
    other = [wheel for wheel in wheels if _side(wheel) == SIDES.get(_side(verdict.wheel))]
    light = [np.mean(loads[wheel][recent] < 0.05 * loads[wheel][0]) > 0.5 for wheel in other if recent.any()]
    if light and all(light):
        return "body roll-over"
    if last.any() and np.median(loads[verdict.wheel][last]) < 0.1 * loads[verdict.wheel][0]:
        return "wheel unloading"
    apart = np.flatnonzero((t < verdict.t) & (trajectory[f"{vehicle}.{verdict.wheel}{CLIMB}"] <= 0.0))
    touching = (t <= verdict.t) & (np.arange(t.size) > (apart[-1] if apart.size else -1))
    ratio = trajectory[f"{vehicle}.{verdict.wheel}{RATIO}"][touching]
    finite = ratio[np.isfinite(ratio)]
    return f"flange climb at Y/Q up to {finite.max():.2g}" if finite.size else "flange climb"
