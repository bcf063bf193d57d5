"""Safety against derailment from recorded forces: limits, the filters of EN 14363, and the verdict. SI units.

    Nadal       Y/Q = (tan d - mu) / (1 + mu tan d)                     one flange about to climb
    Weinstock   |Y/Q| of both wheels of a pair = Nadal + mu             the other wheel slides sideways on its tread
    EN 14363    Y/Q after a 20 Hz low pass and a sliding mean over 2 m, limit 0.8;
                sum of guiding forces of a pair, filtered alike, limit 10 kN + P0 / 3 (Prud'homme)

Nothing here knows a component: signals come as arrays over time, wheels as the names the caller gives.
"""

import math
from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from .filters import en14363

LIMIT = 0.8  # EN 14363, filtered Y/Q


def nadal_limit(contact_angle: float, friction: float) -> float:
    """Y/Q at which a flange may climb.

    Parameters
    ----------
    contact_angle
        Of the flange, rad, between 0 and pi/2.
    friction
        Coefficient of friction between wheel and rail, 0 to 1.

    Returns
    -------
    limit

    References
    ----------
    Nadal, Theorie de la stabilite des locomotives (1896).
    """
    if not 0.0 < contact_angle < math.pi / 2:
        raise ValueError(f"contact_angle must lie between 0 and pi/2, got {contact_angle:g}")
    if not 0.0 <= friction <= 1.0:
        raise ValueError(f"friction must lie in 0..1, got {friction:g}")
    tangent = math.tan(contact_angle)
    return (tangent - friction) / (1.0 + friction * tangent)


def weinstock_limit(contact_angle: float, friction: float) -> float:
    """Sum of |Y/Q| of both wheels of a pair at which the flanging one may climb.

    Parameters
    ----------
    contact_angle, friction
        As for `nadal_limit`.

    Returns
    -------
    limit

    References
    ----------
    Weinstock, Wheel climb derailment criteria for evaluation of rail vehicle safety, ASME 84-WA/RT-1 (1984).
    """
    return nadal_limit(contact_angle, friction) + friction


def guiding_force_limit(axle_load: float, alpha: float = 1.0) -> float:
    """The largest sum of guiding forces of a pair.

    Parameters
    ----------
    axle_load
        Static, N.
    alpha
        1, or 0.85 for freight wagons.

    Returns
    -------
    limit
        In N.
    """
    if not axle_load > 0.0:
        raise ValueError(f"axle_load must be positive, got {axle_load:g}")
    return alpha * (10e3 + axle_load / 3.0)


@dataclass(frozen=True)
class Extreme:
    """The largest size of a filtered signal.

    Parameters
    ----------
    wheel
        Wheel or pair that it belongs to.
    value, limit
        In the signal's unit.
    distance, t
        Where, m along the track, and when, s.
    """

    wheel: str
    value: float
    distance: float
    t: float
    limit: float

    @property
    def exceeded(self) -> bool:
        """Whether the limit is exceeded."""
        return self.value > self.limit


def worst(signals: Mapping[str, np.ndarray], t: np.ndarray, distance: np.ndarray, limit: float = LIMIT) -> Extreme:
    """The wheel or pair whose filtered signal is largest in size.

    Parameters
    ----------
    signals
        Wheel -> signal, such as Y/Q, shape (n,).
    t
        Evenly spaced times, s, shape (n,).
    distance
        Along the track, m, growing, shape (n,).
    limit
        What the largest size is compared with.

    Returns
    -------
    Extreme

    Raises
    ------
    ValueError
        Without a signal, or where the filter cannot take it.
    """
    if not signals:
        raise ValueError("signals must hold at least one wheel, got none")
    extremes = []
    for wheel, signal in signals.items():
        filtered = np.abs(en14363(signal, t, distance))
        i = int(np.argmax(filtered))
        extremes.append(Extreme(wheel, float(filtered[i]), float(distance[i]), float(t[i]), limit))
    return max(extremes, key=lambda extreme: extreme.value)


@dataclass(frozen=True)
class Verdict:
    """Whether a wheel left the rails.

    Parameters
    ----------
    derailed
        Whether one did.
    wheel, t, distance
        The first one, when, s, and where, m; empty and NaN where none did.
    cause
        Why, in words; empty where it is not known.
    through
        What track was passed, in words: "through the curve of R = 50 m".
    unfinished
        The curve or transition that the run ends in, so that nobody knows whether the vehicle passes it; else empty.
    """

    derailed: bool
    wheel: str = ""
    t: float = math.nan
    distance: float = math.nan
    cause: str = ""
    through: str = ""
    unfinished: str = ""

    @property
    def text(self) -> str:
        """One line for people."""
        if self.derailed:
            why = f", {self.cause}" if self.cause else ""
            return f"derailed: {self.wheel} at s = {self.distance:.2f} m, t = {self.t:.3f} s{why}"
        if self.unfinished:
            return f"not decidable: every wheel stayed on its rail, but the run ends in the {self.unfinished}"
        return "passed: every wheel stayed on its rail" + (f", {self.through}" if self.through else "")


def verdict(climbs: Mapping[str, np.ndarray], t: np.ndarray, distance: np.ndarray) -> Verdict:
    """Whether a wheel left its rail.

    Parameters
    ----------
    climbs
        Wheel -> way of its flange over the rail, shape (n,): 0 where it first touches, 1 on top. NaN counts as derailed.
    t, distance
        Times, s, and distances along the track, m, shape (n,).

    Returns
    -------
    Verdict
    """
    first: tuple[int, str] | None = None
    for wheel, climb in climbs.items():
        past = np.flatnonzero(~(np.asarray(climb) <= 1.0))  # NaN counts as derailed
        if past.size and (first is None or past[0] < first[0]):
            first = (int(past[0]), wheel)
    if first is None:
        return Verdict(False)
    i, wheel = first
    return Verdict(True, wheel, float(t[i]), float(distance[i]))
