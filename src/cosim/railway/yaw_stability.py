"""When can a gyro stabilise the yaw motion of a pair of free wheels with negative conicity? A necessary condition. SI units.

A wheel pair, reduced to its slow motion (y lateral displacement, psi yaw, eta gimbal angle; rates small, no flange contact):

    y' = v psi - L y,                                L = k_y v / (2 f22)                       (1)
    I psi'' + D psi' + K psi = B g0 v y' + c_y y + H eta',   D = 2 f33 / v                     (2)
    A eta'' + c_g eta' + k_g eta = -H psi'                                                     (3)

(1) is the lateral force balance of creep and gravity without inertia. (2) is the yaw balance: K = 2 P g0 (b + g0 r0) is the
gravity stiffness; B g0 v y' is what free wheels need to spin up as they move to another radius, and the tilt of their spin
momentum, B = 2 I_y (b / r0^3 + 1 / (r0 b)); c_y y is the moment of spin creep. `wheel_pair` has K, k_y and c_y.
Units: L 1/s; I and A kg m2; D and c_g N m s; K and k_g N m; B g0 kg, so that a = B g0 v^2 is N m; c_y N; H N m s.
c_g and k_g are about the gimbal axis: number times constant times lever arm squared.

With y = v psi / (s + L) from (1) and H eta' = -G psi, G = H^2 s^2 / (A s^2 + c_g s + k_g), from (3), the characteristic
polynomial is

    p(s) = (A s^2 + c_g s + k_g) q(s) + H^2 s^2 (s + L)                                        (4)
    q(s) = I s^3 + (I L + D) s^2 + (K + D L - a) s + (K L - c_y v)                             (5)

Each term of (4) is in N^2 m^2 / s. If all its roots have negative real parts then all its coefficients are positive. The
gyro's own term begins with s^2, so the last two do not know the spin:

    s^1:   k_g (K + D L - a) + c_g (K L - c_y v) > 0                                           (6)
    s^0:   k_g (K L - c_y v) > 0                                                               (7)

and for k_g > 0 (6) is

    a < K + D L + (c_g / k_g) (K L - c_y v)                                                    (8)

Neither H and A, nor the number of springs and dampers n (k_g = n k_z d^2, c_g = n c_z d^2) nor their lever arm d stand in it:
only the ratio c_g / k_g does. The reason: to a slow yaw motion a gyro with a spring on its gimbal is an added inertia H^2 / k_g;
its damping only comes with s^3. What must resist in (6) is the vehicle's own K, which the spin inertia of its wheels
overcomes as v^2. Since D L does not depend on v, and K L - c_y v grows as v, the ratio that is needed grows as v at high speed.

Without a spring (k_g = 0) the gimbal's angle is neutral, p has a root at zero, and of (6) there remains K L > c_y v. The price:
in a curve of radius R the frame turns with v / R, and (3) at rest is k_g eta = -H v / R: without a spring nothing bounds the
lean.

What (8) does not say. It is necessary, not sufficient: the other coefficients must be positive and Routh's determinants
too, and these do contain H. For H to infinity at fixed A, c_g, k_g the two slow roots tend to

    s = -(p1 - p0 / L) / (2 H^2 L) +- i sqrt(p0 / (H^2 L)),     p1, p0 as in (6), (7)           (9)

(put s^2 = -p0 / (H^2 L) + small into H^2 s^3 + H^2 L s^2 + p1 s + p0), so a fast rotor requires a ratio larger by 1 / L. And
(1) to (3) leave out roll, pitch, flanges, large creepages and the coupling of the two pairs through the body: of a vehicle (8)
is an estimate, and a vehicle may be stable at a smaller ratio (one in studies/stability_law.py is, above 16 m/s).

Growth where (6) is broken. By Gauss and Lucas the roots of p' lie in the convex hull of the roots of p, so the largest real part
of a root of p is at least that of a root of p'. Where (6) is broken p'(0) = p1 < 0, while p'(s) > 0 for large s: p' has a
positive real root, and the vehicle grows at least as fast.                                    (10)

References
----------
Wickens 2003, Fundamentals of Rail Vehicle Dynamics, for creep and gravity of (1) and (2); Gantmacher 1959, The Theory of
Matrices 2, chapter 15, for the signs of the coefficients; Marden 1966, Geometry of Polynomials, section 6, for Gauss and Lucas.
"""

from collections.abc import Mapping
from dataclasses import dataclass
from math import inf, isfinite

import numpy as np

__all__ = ["Gimbal", "WheelPair", "characteristic_polynomial", "growth_bound", "margin", "needed_ratio", "wheel_pair"]


def _finite_with_inertia(values: Mapping[str, float]) -> None:
    for name, value in values.items():
        if not isfinite(value):
            raise ValueError(f"{name} must be finite, got {value:g}")
    if not values["inertia"] > 0.0:
        raise ValueError(f"inertia must be above 0, got {values['inertia']:g}")


@dataclass(frozen=True)
class WheelPair:
    """A pair of free wheels at a speed, reduced to slow yaw motion; equations (1) and (2) of the module.

    Parameters
    ----------
    inertia
        I, yaw inertia of all that yaws with the pair, kg m2.
    relaxation
        L, rate at which a lateral displacement dies out, 1/s.
    damping
        D, of yaw by spin creep, N m s.
    stiffness
        K, of yaw by gravity, N m.
    spin_up
        a = B g0 v^2, by the spin inertia of the wheels, N m.
    creep
        c_y v, yaw moment of spin creep per displacement, times speed, N m/s.
    """

    inertia: float
    relaxation: float
    damping: float
    stiffness: float
    spin_up: float
    creep: float

    def __post_init__(self) -> None:
        _finite_with_inertia(vars(self))

    @property
    def cubic(self) -> np.ndarray:
        """Coefficients of q(s), equation (5), highest power first, shape (4,)."""
        I, L, D, K = self.inertia, self.relaxation, self.damping, self.stiffness
        return np.array([I, I * L + D, K + D * L - self.spin_up, K * L - self.creep])


@dataclass(frozen=True)
class Gimbal:
    """A gyro unit; equation (3) of the module.

    Parameters
    ----------
    momentum
        H, of the rotor, N m s.
    inertia
        A, about the gimbal axis, kg m2.
    damping, stiffness
        c_g and k_g about the gimbal axis, lever arm included, N m s and N m; not both 0.
    """

    momentum: float
    inertia: float
    damping: float
    stiffness: float

    def __post_init__(self) -> None:
        _finite_with_inertia(vars(self))
        for name in ("damping", "stiffness"):
            if getattr(self, name) < 0.0:
                raise ValueError(f"{name} must be at least 0, got {getattr(self, name):g}")
        if self.damping == self.stiffness == 0.0:
            raise ValueError("damping and stiffness must not both be 0: the ratio of nothing to nothing says nothing")


def wheel_pair(
    *,
    speed: float,
    load: float,
    yaw_inertia: float,
    spin_inertia: float,
    rolling_radius: float,
    contact_half_distance: float,
    conicity: float,
    conicity_gradient: float,
    f22: float,
    f23: float,
    f33: float,
) -> WheelPair:
    """Reduce a pair of free wheels to slow yaw motion.

    With g = g0 / (b + g0 r0): K = 2 P g0 (b + g0 r0), k_y = 2 (P - f23 / r0) g1 (1 - g r0)^2 - 4 P g,
    c_y = 2 f33 g1 / r0 (1 - 2 b g0 / r0) - f23 k_y / f22, I = yaw_inertia + 2 I_y b^2 / r0^2.

    Parameters
    ----------
    speed
        v, m/s, above 0.
    load
        P, of a wheel, N.
    yaw_inertia
        Of frame, wheels and all else that yaws with them, kg m2, without the last term of I.
    spin_inertia
        I_y, of a wheel about its axle, kg m2.
    rolling_radius, contact_half_distance
        r0 and b, m.
    conicity, conicity_gradient
        g0 (1) and g1 (1/m).
    f22, f23, f33
        Of one wheel, N, N m, N m2: how fast the lateral force falls with lateral and with spin creepage, and the spin moment with
        spin creepage, at the spin creepage of rest. Kalker's coefficients on a flat tread; on a steep one friction lowers them.

    Returns
    -------
    WheelPair

    Raises
    ------
    ValueError
        Where a speed, radius, distance or f22 is not above 0, or a value is not finite.
    """
    v, P, r0, b, g0, g1 = speed, load, rolling_radius, contact_half_distance, conicity, conicity_gradient
    lengths = {"speed": v, "rolling_radius": r0, "contact_half_distance": b, "f22": f22}
    for name, value in lengths.items():
        if not value > 0.0:
            raise ValueError(f"{name} must be above 0, got {value:g}")
    g = g0 / (b + g0 * r0)
    k_y = 2 * (P - f23 / r0) * g1 * (1 - g * r0) ** 2 - 4 * P * g
    B = 2 * spin_inertia * (b / r0**3 + 1 / (r0 * b))
    c_y = 2 * f33 * g1 / r0 * (1 - 2 * b * g0 / r0) - f23 * k_y / f22
    return WheelPair(
        inertia=yaw_inertia + 2 * spin_inertia * b**2 / r0**2,
        relaxation=k_y * v / (2 * f22),
        damping=2 * f33 / v,
        stiffness=2 * P * g0 * (b + g0 * r0),
        spin_up=B * g0 * v**2,
        creep=c_y * v,
    )


def characteristic_polynomial(pair: WheelPair, gimbal: Gimbal) -> np.ndarray:
    """Coefficients of p(s), equation (4), highest power first, shape (6,); the last is 0 where the gimbal has no spring."""
    spin = gimbal.momentum**2 * np.array([1.0, pair.relaxation, 0.0, 0.0])
    return np.polyadd(np.polymul([gimbal.inertia, gimbal.damping, gimbal.stiffness], pair.cubic), spin)


def margin(pair: WheelPair, ratio: float) -> float:
    """How far the necessary condition (8) is from being broken, K + D L + (c_g / k_g) (K L - c_y v) - a.

    Parameters
    ----------
    pair
        The pair of wheels.
    ratio
        c_g / k_g of the gimbal, s; infinite where it has no spring.

    Returns
    -------
    margin
        In N m. Below 0 no spin, no number of springs and no lever arm makes the pair stable. Without a spring it is infinite,
        with the sign of K L - c_y v.

    Raises
    ------
    ValueError
        Where the ratio is negative or NaN.
    """
    if not ratio >= 0.0:
        raise ValueError(f"ratio must be at least 0, got {ratio:g}")
    _, _, slope, constant = (float(c) for c in pair.cubic)
    return slope + (ratio * constant if constant else 0.0)


def needed_ratio(pair: WheelPair) -> float:
    """The ratio c_g / k_g in s that the gimbal must exceed by (7) and (8): 0 where any will do, infinite where none will."""
    _, _, slope, constant = (float(c) for c in pair.cubic)
    if not constant > 0.0:
        return inf
    return max(-slope / constant, 0.0)


def growth_bound(pair: WheelPair, gimbal: Gimbal) -> float:
    """A lower bound on the largest real part of a root of p, by (10), 1/s: always true, and positive where (6) is broken.

    Where the gimbal has no spring the root at zero counts as a root of p.
    """
    return float(np.roots(np.polyder(characteristic_polynomial(pair, gimbal))).real.max())
