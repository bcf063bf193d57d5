"""What does a gyro unit do to a solid wheelset: inertia, damper or spring, and when does it help against hunting? SI units.

The unit of yaw_stability.py, equation (3) there, answers a yaw rate psi' of its frame with the moment -Z psi',

    Z(s) = H^2 s / (A s^2 + c s + k),        Z(j w) = R + j w J                                       (1)
    R = H^2 c w^2 / N,   J = H^2 (k - A w^2) / N,   N = (k - A w^2)^2 + (c w)^2                       (2)

R >= 0 is an added damping, J an added yaw inertia; a negative J is an added stiffness -w^2 J. Limits:

    slow, w << k / c and w << sqrt(k / A)      J = H^2 / k          an inertia
    k / c << w << c / A                        R = H^2 / c          a damper, the gimbal's angle in quadrature to its rate
    fast, w >> sqrt(k / A) and w >> c / A      -w^2 J = H^2 / A     a spring: the rotor keeps its direction in space

Any horizontal spin axis gives the same Z: the gimbal's axis is horizontal and square to it, and the momentum that yaw turns is
H either way. A vertical spin axis gives none, since yaw does not turn the momentum.

A wheelset on springs (Wickens 2003, without gravity and the coupling by spin creep), y lateral, psi yaw:

    m y'' + (E / v) y' + K_y y - E psi = 0,                        E = 2 f22                           (3)
    I psi'' + (F / v) psi' + K_psi psi + G y = -Z psi',            F = 2 f11 b^2 + 2 f33, G = 2 f11 b gamma / r0   (4)

Without a unit the characteristic polynomial is p(s) = P1 P2 + E G, P1 and P2 the operators on y in (3) and on psi in (4). On
the imaginary axis its odd and even parts vanish apart, which gives the hunting at the critical speed exactly:

    w^2 = (E K_psi + F K_y) / (E I + F m)                                                              (5)
    E F / v^2 = m I w^2 - m K_psi - I K_y + (K_y K_psi + E G) / w^2                                    (6)

With a unit p becomes p + s Z P1. A weak one moves a root s by

    ds = -s Z P1 / p'(s)                                                                               (7)

and at the critical speed it lowers the growth, so that this speed rises, if and only if (c > 0; from the real part of (7))

    (k - A w^2) / (c w) < q,    q = (B (K_y - m w^2) + a w E / v) / (B w E / v - a (K_y - m w^2))       (8)
    a = w^2 (m F + I E) / v,    B = (K_y K_psi + E G - m I w^4) / w

Where creep rules (m I w^2 and K_y K_psi small beside E G / w^2) q = v (I w / F + K_y / (w E)), so that the condition is

    k < A w^2 + c v (I w^2 / F + K_y / E)                                                              (9)

Hunting is a balance of creep forces: to first order its growth is decided by what acts in phase with the yaw angle. A spring
stops it, an inertia feeds it, and a damper alone (J = 0) only helps by the small q. So the unit helps where it acts as a spring,
that is where the gimbal's own frequency sqrt(k / A) is below that of hunting, or not far above it and well damped; it
harms where the gimbal is stiffer. (8) holds for a weak unit (H^2 to 0); of a strong one only the eigenvalues tell: `roots`.

References
----------
Wickens 2003, Fundamentals of Rail Vehicle Dynamics, for (3) and (4); (1), (2) and (5) to (9) are ours.
"""

from dataclasses import dataclass
from math import isfinite, sqrt

import numpy as np

from .yaw_stability import Gimbal

__all__ = ["Equivalent", "SprungWheelset", "critical_point", "equivalent", "impedance", "root_shift", "roots", "stiffest_spring"]


@dataclass(frozen=True)
class Equivalent:
    """What a gyro unit is to a yaw motion of one frequency; equation (2) of the module.

    Attributes
    ----------
    damping
        R, N m s.
    inertia
        J, kg m2; below 0 it acts as the stiffness -w^2 J.
    """

    damping: float
    inertia: float


@dataclass(frozen=True)
class SprungWheelset:
    """A solid wheelset on springs; equations (3) and (4) of the module.

    Parameters
    ----------
    mass, yaw_inertia
        m (kg) and I (kg m2).
    lateral_stiffness, yaw_stiffness
        K_y (N/m) and K_psi (N m) of all springs together.
    lateral_creep, yaw_creep, steering
        E = 2 f22 (N), F = 2 f11 b^2 + 2 f33 (N m2), G = 2 f11 b gamma / r0 (N).

    Raises
    ------
    ValueError
        Where a value is not finite, a stiffness is below 0, or another value not above 0.
    """

    mass: float
    yaw_inertia: float
    lateral_stiffness: float
    yaw_stiffness: float
    lateral_creep: float
    yaw_creep: float
    steering: float

    def __post_init__(self) -> None:
        for name, value in vars(self).items():
            if not isfinite(value):
                raise ValueError(f"{name} must be finite, got {value:g}")
            if name.endswith("stiffness"):
                if value < 0.0:
                    raise ValueError(f"{name} must be at least 0, got {value:g}")
            elif not value > 0.0:
                raise ValueError(f"{name} must be above 0, got {value:g}")

    def lateral(self, speed: float) -> np.ndarray:
        """Coefficients of P1(s), highest power first, shape (3,), at a speed in m/s."""
        return np.array([self.mass, self.lateral_creep / speed, self.lateral_stiffness])

    def yaw(self, speed: float) -> np.ndarray:
        """Coefficients of P2(s), highest power first, shape (3,), at a speed in m/s."""
        return np.array([self.yaw_inertia, self.yaw_creep / speed, self.yaw_stiffness])

    def polynomial(self, speed: float) -> np.ndarray:
        """Coefficients of p(s), highest power first, shape (5,), at a speed in m/s."""
        return np.polyadd(np.polymul(self.lateral(speed), self.yaw(speed)), [self.lateral_creep * self.steering])


def impedance(gimbal: Gimbal, s: complex) -> complex:
    """Z(s), equation (1): minus the yaw moment on the frame over its yaw rate (N m s), at s in 1/s."""
    return complex(gimbal.momentum**2 * s / (gimbal.inertia * s**2 + gimbal.damping * s + gimbal.stiffness))


def equivalent(gimbal: Gimbal, frequency: float) -> Equivalent:
    """Split the impedance into damping and inertia, equation (2).

    Parameters
    ----------
    gimbal
        The gyro unit.
    frequency
        w, rad/s, above 0.

    Returns
    -------
    Equivalent

    Raises
    ------
    ValueError
        Where the frequency is not above 0.
    """
    if not frequency > 0.0:
        raise ValueError(f"frequency must be above 0, got {frequency:g}")
    Z = impedance(gimbal, 1j * frequency)
    return Equivalent(Z.real, Z.imag / frequency)


def roots(wheelset: SprungWheelset, speed: float, gimbal: Gimbal | None = None) -> np.ndarray:
    """The roots of wheelset and gyro unit.

    Parameters
    ----------
    wheelset
        The wheelset.
    speed
        v, m/s, above 0.
    gimbal
        The gyro unit; None: the wheelset alone.

    Returns
    -------
    roots
        1/s, complex, in order of falling real part, shape (4,), or (6,) with a unit.

    Raises
    ------
    ValueError
        Where the speed is not above 0.
    """
    if not speed > 0.0:
        raise ValueError(f"speed must be above 0, got {speed:g}")
    p = wheelset.polynomial(speed)
    if gimbal is not None:
        unit = np.array([gimbal.inertia, gimbal.damping, gimbal.stiffness])
        p = np.polyadd(np.polymul(unit, p), gimbal.momentum**2 * np.polymul([1.0, 0.0, 0.0], wheelset.lateral(speed)))
    found = np.roots(p)
    return found[np.argsort(-found.real)]


def critical_point(wheelset: SprungWheelset) -> tuple[float, float]:
    """Compute the critical speed of the wheelset alone and its hunting there, equations (5) and (6).

    Returns
    -------
    speed, frequency
        v in m/s and w in rad/s.

    Raises
    ------
    ValueError
        Where there is none: without springs the wheelset hunts at any speed; stiff ones can rule hunting out.
    """
    m, I, E, F = wheelset.mass, wheelset.yaw_inertia, wheelset.lateral_creep, wheelset.yaw_creep
    K_y, K_psi, G = wheelset.lateral_stiffness, wheelset.yaw_stiffness, wheelset.steering
    w2 = (E * K_psi + F * K_y) / (E * I + F * m)
    if not w2 > 0.0:
        raise ValueError("lateral_stiffness and yaw_stiffness must not both be 0: without springs a wheelset hunts at any speed")
    damping = m * I * w2 - m * K_psi - I * K_y + (K_y * K_psi + E * G) / w2
    if not damping > 0.0:
        raise ValueError(f"steering must be large enough for the wheelset to hunt at some speed, got {G:g}")
    return sqrt(E * F / damping), sqrt(w2)


def root_shift(wheelset: SprungWheelset, speed: float, root: complex, gimbal: Gimbal) -> complex:
    """How far a weak unit moves a root of the wheelset alone (1/s), equation (7), at a speed in m/s."""
    P1, slope = np.polyval(wheelset.lateral(speed), root), np.polyval(np.polyder(wheelset.polynomial(speed)), root)
    return complex(-root * impedance(gimbal, root) * P1 / slope)


def stiffest_spring(wheelset: SprungWheelset, gimbal: Gimbal) -> float:
    """The gimbal stiffness (N m) below which a weak unit raises the critical speed, equation (8); `gimbal`'s own is not used.

    Raises
    ------
    ValueError
        As `critical_point`.
    """
    v, w = critical_point(wheelset)
    m, I, E, F = wheelset.mass, wheelset.yaw_inertia, wheelset.lateral_creep, wheelset.yaw_creep
    K_y, K_psi, G = wheelset.lateral_stiffness, wheelset.yaw_stiffness, wheelset.steering
    a = w**2 * (m * F + I * E) / v
    B = (K_y * K_psi + E * G - m * I * w**4) / w
    free = K_y - m * w**2
    q = (B * free + a * w * E / v) / (B * w * E / v - a * free)
    return gimbal.inertia * w**2 + q * gimbal.damping * w
