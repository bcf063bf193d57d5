"""What would a yaw damper or an inerter do for a pair of free wheels, in place of a gyro unit? SI units.

Both stand between the bogie, which yaws with the pair, and something heavy that hardly yaws, the car body; neither can be
mounted where a gyro is, which needs nothing to push against. Taken against a body at rest, a damper c_p adds to D and an
inerter b_p to I of yaw_stability.py, and the characteristic polynomial is its cubic (5):

    q(s) = I s^3 + (I L + D) s^2 + p1 s + p0,   p1 = K + D L - a,   p0 = K L - c_y v                    (1)

By Routh the pair is stable if and only if (I, L > 0)

    p0 > 0,   p1 > 0   and   (L + D / I) p1 > p0                                                        (2)

- A damper raises p1 by c_p L: where p0 > 0 a large enough one always stabilises the pair. A gyro with a spring does not raise it
  at all (it is an inertia to slow yaw motion): that is the stability law of yaw_stability.py.
- An inerter is in none of p0 and p1, and in the last of (2) it makes the left side smaller: it stabilises no pair that is
  unstable without it. It only makes the growth slower.

With D + c_p = x the last of (2) is an equation of second degree at its limit,

    L x^2 + (I L^2 + K - a) x + I (L (K - a) - p0) = 0                                                  (3)

whose larger root, where p0 > 0, is what the pair needs: for x above it (I L + x)(K + L x - a) > I p0 > 0, and both
factors are positive, since at the larger root they are.

References
----------
Gantmacher 1959, The Theory of Matrices 2, chapter 15, for Routh's conditions; (3) is ours. Smith 2002, IEEE Transactions on
Automatic Control 47(10), 1648-1662, for the inerter: its force is proportional to the acceleration between its ends.
"""

from dataclasses import replace
from math import inf, sqrt

from .yaw_stability import WheelPair

__all__ = ["is_stable", "needed_damping", "with_device"]


def with_device(pair: WheelPair, damping: float = 0.0, inertance: float = 0.0) -> WheelPair:
    """The pair with a yaw damper and an inerter against a body that does not yaw.

    Parameters
    ----------
    pair
        The pair of wheels.
    damping
        c_p, N m s, at least 0.
    inertance
        b_p, kg m2, at least 0.

    Returns
    -------
    WheelPair

    Raises
    ------
    ValueError
        Where damping or inertance is negative or no number.
    """
    for name, value in {"damping": damping, "inertance": inertance}.items():
        if not value >= 0.0:
            raise ValueError(f"{name} must be at least 0, got {value:g}")
    return replace(pair, damping=pair.damping + damping, inertia=pair.inertia + inertance)


def is_stable(pair: WheelPair) -> bool:
    """Whether all motions of the pair die out, by (2)."""
    _, square, slope, constant = (float(c) for c in pair.cubic)
    return constant > 0.0 and slope > 0.0 and square * slope > pair.inertia * constant


def needed_damping(pair: WheelPair) -> float:
    """The yaw damper (N m s) above which the pair is stable, by (3): 0 where it is without one, infinite where none is enough."""
    I, L, K, a = pair.inertia, pair.relaxation, pair.stiffness, pair.spin_up
    constant = float(pair.cubic[3])
    if not (constant > 0.0 and L > 0.0):
        return 0.0 if is_stable(pair) else inf
    half = (I * L**2 + K - a) / (2 * L)
    return max(-half + sqrt(half**2 - I * (L * (K - a) - constant) / L) - pair.damping, 0.0)
