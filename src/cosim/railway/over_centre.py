"""What no gyro unit can do for free wheels that spin creep turns aside, and what a spring over centre can. SI units.

The pair of wheels is that of yaw_stability.py; K, D, L, a, c_y v, I and q(s) are its. Behind the connector stands any unit whose
small motion is a yaw moment that follows the yaw rate, M = -(N(s) / Q(s)) psi', deg N <= deg Q: springs, dampers, rotors, slow
loops, sampled controllers. The characteristic polynomial is

    p(s) = Q(s) q(s) + N(s) s (s + L),     p(0) = Q(0) (K L - c_y v)                            (11)

since the unit measures a rate, which says nothing of a yaw angle that stays. If all roots of p have negative real parts then
p(0) has the sign of its leading coefficient, that of Q. So where K L < c_y v, Q(0) and the leading coefficient of Q have
different signs, and Q has an odd number of positive roots:

    a unit that itself comes to rest in a still frame cannot stabilise the pair where K L < c_y v.                         (12)

Whatever its springs, dampers, motors and spin: progressive or not (its slope at the centre counts), with a slow loop or without,
its spin scheduled on the yaw rate or not (at rest the spin is what it is). Only a unit that falls over by itself can: the plant's
pole lies between two of its zeros on the positive real axis, 0 and infinity (the parity of Youla, Bongiorno and Lu).
The gyroscopes of the monorails of Brennan and Schilowsky, 1907 to 1914, had such gimbals.

A spring over centre, k_g < 0: then (7), k_g (K L - c_y v) > 0, holds just there, and (6) becomes, with a > K + D L,

    c_g / |k_g| < (a - K - D L) / (c_y v - K L)                                                 (13)

the same ratio as in (8), but as an upper bound: the damper must be small. For a fast rotor (9) asks for 1 / L less,

    c_g / |k_g| < (a - K - D L) / (c_y v - K L) - 1 / L                                         (14)

The right side grows with v: a grows as v^2, c_y v - K L as v, and L as v. Where it is negative no fast rotor does it.
(13) is necessary, (14) the limit for H to infinity; like (8) they are the pair's, and for a vehicle an estimate.

A slow loop that turns the gimbal back by the integral of its lean, torque -k_i z with z' = eta, has Q = A s^3 + c_g s^2 + k_g s +
k_i and N = H^2 s^2. The last two coefficients of p ask, for k_i > 0, for K L > c_y v and

    k_g / k_i > (a - K - D L) / (K L - c_y v)                                                   (15)

so the loop's time k_g / k_i must exceed the ratio that (8) asks of c_g / k_g: it cannot be quicker than the spring it relieves.

References
----------
Youla, Bongiorno and Lu 1974, Single-loop feedback stabilization of linear multivariable dynamical plants, Automatica 10, p. 159.
"""

from collections.abc import Sequence
from math import inf

import numpy as np

from .yaw_stability import WheelPair

__all__ = ["centring_time", "closed_loop", "largest_ratio", "stable_units_fail"]


def closed_loop(pair: WheelPair, numerator: Sequence[float], denominator: Sequence[float]) -> np.ndarray:
    """The characteristic polynomial (11) of the pair with any unit.

    Parameters
    ----------
    pair
        The pair of wheels.
    numerator, denominator
        N and Q of the unit, highest power first; N in N m s times what Q is in.

    Returns
    -------
    p
        Coefficients, highest power first.

    Raises
    ------
    ValueError
        Where the degree of N exceeds that of Q: such a unit would need an acceleration of the frame.
    """
    N, Q = np.trim_zeros(np.atleast_1d(numerator), "f"), np.trim_zeros(np.atleast_1d(denominator), "f")
    if N.size > Q.size:
        raise ValueError(f"the numerator's degree must be at most that of the denominator, got {N.size - 1} and {Q.size - 1}")
    return np.polyadd(np.polymul(Q, pair.cubic), np.polymul(N, [1.0, pair.relaxation, 0.0]))


def stable_units_fail(pair: WheelPair) -> bool:
    """Whether, by (12), no unit that is stable by itself can stabilise the pair."""
    return bool(pair.cubic[3] < 0.0)


def largest_ratio(pair: WheelPair, *, fast: bool = False) -> float:
    """The ratio c_g / |k_g| in s that a gimbal with a spring over centre must stay below.

    Parameters
    ----------
    pair
        The pair of wheels.
    fast
        By (14), for a fast rotor, rather than by the necessary (13).

    Returns
    -------
    ratio
        0 where no damper is small enough, as where K L >= c_y v: there a spring over centre makes a root positive.
    """
    _, _, slope, constant = (float(c) for c in pair.cubic)
    if constant >= 0.0:
        return 0.0
    less = 0.0 if not fast else 1.0 / pair.relaxation if pair.relaxation > 0.0 else inf
    return max(slope / constant - less, 0.0)


def centring_time(pair: WheelPair) -> float:
    """The time k_g / k_i in s that a slow loop must exceed by (15): infinite where none is slow enough."""
    _, _, slope, constant = (float(c) for c in pair.cubic)
    return inf if not constant > 0.0 else max(-slope / constant, 0.0)
