"""A transport delay between a component and the rest, and what can be done about it where the answer comes in.

What a unit sends at the communication points n, v_n, arrives as w_n. A delay of d macro steps and a linear compensator
together are a filter with known coefficients, which the runs (DelayedSlave) and the eigenvalues (hil/sampled_model.py) share:

    w_n = sum_j b_j v_{n-j} + sum_{j >= 1} a_j w_{n-j}                                                        (1)

    delay d = m + r, 0 <= r < 1:     z_n = (1 - r) v_{n-m} + r v_{n-m-1}                                      (2)
    Polynomial of degree k:          w_n = p(n + d), p through z_n, z_{n-s}, ... , z_{n-ks}                   (3)
    Impulse (NEPCE at a delay):      w_n = z_n + g (z_n - w_{n-m}), m = ceil d                                (4)

(3) extrapolates over the delay from points s steps apart, half the delay unless told: nearer ones amplify noise. (4) adds
what the value used m steps ago lacked against the one that is now known to have been right, so that the impulse of the moment
arrives in the end; g = 1 would return all of it and ring for ever. Two more need more than a filter:

    model-based (Smith):             w_n = z_n + y_n - z(y)_n, y from a model of the unit with the same inputs         (5)
    PassivityController:             w_n - alpha u_n, alpha such that the unit has never given more than it got       (6)

Sources: Benedikt, Watzenig, Hofer (2013) for NEPCE; Smith (1957); Hannaford and Ryu, Time-domain passivity control (2002),
with the damping bounded by twice the size of the unit's own answer, so that it cannot shake the frame where its rate passes
zero.
"""

from abc import ABC, abstractmethod
from dataclasses import dataclass

import numpy as np

__all__ = [
    "COMPENSATORS",
    "Compensator",
    "Filter",
    "Impulse",
    "PassivityController",
    "Polynomial",
    "Taps",
    "Uncompensated",
    "delay_taps",
]


@dataclass(frozen=True, eq=False)
class Taps:
    """The coefficients of (1).

    Parameters
    ----------
    b
        From j = 0, shape (m,).
    a
        From j = 1, shape (n,).
    """

    b: np.ndarray
    a: np.ndarray


def delay_taps(d: float) -> np.ndarray:
    """b of (2).

    Parameters
    ----------
    d
        The delay in macro steps, whole or not.

    Returns
    -------
    b
        Shape (number of whole steps + 1,), one longer where `d` is not whole.

    Raises
    ------
    ValueError
        Where the delay is negative or not finite.
    """
    if not (np.isfinite(d) and d >= 0.0):
        raise ValueError(f"a delay must not be negative, got {d:g} macro steps")
    m = int(np.floor(d + 1e-9))
    r = max(0.0, d - m)
    b = np.zeros(m + (2 if r > 1e-9 else 1))
    b[m] = 1.0 - (r if r > 1e-9 else 0.0)
    if r > 1e-9:
        b[m + 1] = r
    return b


@dataclass(frozen=True)
class Compensator(ABC):
    """What stands at the receiving end of a delay."""

    @abstractmethod
    def taps(self, d: float) -> Taps:
        """The filter of delay and compensator for a delay of `d` macro steps."""

    @property
    @abstractmethod
    def name(self) -> str:
        """As the command line writes it."""


@dataclass(frozen=True)
class Uncompensated(Compensator):
    """The delay alone, (2)."""

    @property
    def name(self) -> str:
        return "none"

    def taps(self, d: float) -> Taps:
        return Taps(delay_taps(d), np.zeros(0))


@dataclass(frozen=True)
class Polynomial(Compensator):
    """Extrapolation over the delay, (3).

    Parameters
    ----------
    degree
        Of the polynomial, 1 or 2.
    spacing
        Distance of its points as a share of the delay.
    """

    degree: int = 1
    spacing: float = 0.5

    def __post_init__(self) -> None:
        if self.degree not in (1, 2):
            raise ValueError(f"degree of the predictor must be 1 or 2, got {self.degree!r}")
        if not self.spacing > 0.0:
            raise ValueError(f"spacing must be positive, got {self.spacing:g}")

    @property
    def name(self) -> str:
        return ("linear", "quadratic")[self.degree - 1]

    def taps(self, d: float) -> Taps:
        z = delay_taps(d)
        s = max(1, round(d * self.spacing))
        points = -s * np.arange(self.degree + 1)
        weights = [np.prod([(d - q) / (p - q) for q in points if q != p]) for p in points]  # Lagrange, at +d
        ahead = np.zeros(self.degree * s + 1)
        ahead[-points] = weights
        return Taps(np.convolve(z, ahead), np.zeros(0))


@dataclass(frozen=True)
class Impulse(Compensator):
    """What was missed is returned once it is known, (4).

    Parameters
    ----------
    gain
        g, at least 0 and below 1.
    """

    gain: float = 0.7

    def __post_init__(self) -> None:
        if not 0.0 <= self.gain < 1.0:
            raise ValueError(f"gain must be at least 0 and below 1, got {self.gain:g}")

    @property
    def name(self) -> str:
        return "nepce"

    def taps(self, d: float) -> Taps:
        m = int(np.ceil(d - 1e-9))
        if m == 0:
            return Taps(delay_taps(d), np.zeros(0))
        a = np.zeros(m)
        a[m - 1] = -self.gain
        return Taps((1.0 + self.gain) * delay_taps(d), a)


COMPENSATORS: dict[str, Compensator] = {
    "none": Uncompensated(), "linear": Polynomial(1), "quadratic": Polynomial(2), "nepce": Impulse(),
}  # fmt: skip


class Filter:
    """(1) for several signals at once, started as if their first values had always been."""

    def __init__(self, taps: Taps, first: np.ndarray) -> None:
        self._taps = taps
        self._v = np.tile(first, (max(1, taps.b.size - 1), 1))
        gain = taps.b.sum() / (1.0 - taps.a.sum())
        self._w = np.tile(gain * first, (max(1, taps.a.size), 1))

    def value(self, v: np.ndarray) -> np.ndarray:
        """w_n for v_n = `v`; may be asked again with another."""
        b, a = self._taps.b, self._taps.a
        w = b[0] * v
        if b.size > 1:
            w = w + b[1:] @ self._v
        return np.asarray(w + a @ self._w) if a.size else w

    def push(self, v: np.ndarray) -> None:
        """Go on to the next n."""
        w = self.value(v)
        self._v = np.vstack([v, self._v[:-1]])
        self._w = np.vstack([w, self._w[:-1]])

    def copy(self) -> "Filter":
        """A filter that goes on from here by itself."""
        twin = Filter.__new__(Filter)
        twin._taps, twin._v, twin._w = self._taps, self._v, self._w  # never written in place
        return twin


@dataclass(frozen=True)
class PassivityController:
    """A damper at the interface that lets a gyro unit give no more energy than it got, (6), summed over its bonds.

    Parameters
    ----------
    absorbed
        Energy that the unit has taken and the controller has let pass, J; see gyro_cosim.comparison.unit_energy.
    motion, effort
        Sums of squares so far, for the bound.

    Notes
    -----
    What must have been absorbed is what the unit stores and has turned into heat, where it reports that: then the interface
    creates nothing. Else it is 0: then the unit never gives more than it got, but may give back what its damper took,
    which holds a growing oscillation only once that credit is spent.
    """

    absorbed: float = 0.0
    motion: float = 0.0
    effort: float = 0.0

    def corrected(
        self, u: np.ndarray, w: np.ndarray, h: float, required: float = 0.0
    ) -> tuple[np.ndarray, "PassivityController"]:
        """What arrives at a communication point.

        Parameters
        ----------
        u, w
            Motions and efforts, shape (bonds,).
        h
            The macro step, s.
        required
            Energy that must have been absorbed by now, J.

        Returns
        -------
        efforts, controller
            Shape (bonds,); the controller after the point.
        """
        uu, ww = float(u @ u), float(w @ w)
        motion, effort = self.motion + uu, self.effort + ww
        absorbed = self.absorbed - h * float(w @ u)
        if absorbed < required and uu > 0.0:
            alpha = min((required - absorbed) / (h * uu), 2.0 * np.sqrt(effort / motion))
            return w - alpha * u, PassivityController(absorbed + h * alpha * uu, motion, effort)
        return w, PassivityController(absorbed, motion, effort)
