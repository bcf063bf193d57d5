"""Random numbers out of a counter, as CasADi expressions: the same bits in this process and in the C code of an FMU.

    h -> h^3 + k mod p,   p = 67108859 = 2^26 - 5, prime

Cubing permutes the residues (3 does not divide p - 1), and every product stays below 2^53, so that doubles hold it exactly:
only +, * and fmod are used, whose results IEEE 754 and C fix to the last bit. A few rounds scatter seed, channel and counter;
every further round draws one number. No state but the counter: a repeated step repeats its noise.

Normal numbers are sums of four uniform ones: mean 0, variance 1, never beyond 2 sqrt(3), a little lighter in the tails than
the normal distribution (kurtosis 2.7 instead of 3), as sensors that clip are. For simulation; of no use for secrets.
"""

from math import sqrt

import casadi as ca

__all__ = ["MAX_SEED", "Stream"]

P = 67108859.0
MAX_SEED = 67108858.0
_ROUND = 22695477.0  # an odd constant without meaning, so that 0 is no fixed point


def _cube(h: ca.SX, k: float) -> ca.SX:
    return ca.fmod(ca.fmod(h * h, P) * h + k, P)


class Stream:
    """Random numbers for one value of the counter; every draw is another.

    Parameters
    ----------
    seed, counter : casadi.SX
        Whole numbers from 0 to p - 1.
    channel : int
        0, 1, ...: channels of one seed are independent.
    """

    def __init__(self, seed: ca.SX, channel: int, counter: ca.SX) -> None:
        h = _cube(ca.fmod(seed + 1.0, P), _ROUND + channel)
        h = _cube(_cube(h, _ROUND - channel), _ROUND)
        h = _cube(ca.fmod(h + counter, P), _ROUND)
        self._h = _cube(_cube(h, _ROUND), _ROUND)
        self._draws = 0

    def uniform(self) -> ca.SX:
        """In [0, 1), in steps of 1/p."""
        self._draws += 1
        self._h = _cube(self._h, _ROUND + 2 * self._draws)
        return self._h / P

    def normal(self) -> ca.SX:
        """Mean 0, standard deviation 1."""
        return (self.uniform() + self.uniform() + self.uniform() + self.uniform() - 2.0) * sqrt(3.0)
