"""Ride comfort of passengers by EN 12299, from accelerations on the floor: weighting filters and the mean comfort N_MV. SI units.

    H(s) = s^2 / (s^2 + s w1/Q1 + w1^2)  w2^2 / (s^2 + s w2/Q1 + w2^2)           band limits, Q1 = 1/sqrt(2)
           (1 + s/w3) / (1 + s/(Q2 w4) + (s/w4)^2)                               from acceleration to velocity
           K (1 + s/(Q3 w5) + (s/w5)^2) / (1 + s/(Q4 w6) + (s/w6)^2)             step upwards (vertical only)

    N_MV = 6 sqrt(a_x^2 + a_y^2 + a_z^2)                                         mean comfort, standard method

w = 2 pi f. W_d weights the horizontal, W_b the vertical directions; a is the 95th percentile of the r.m.s. values of the
weighted acceleration over windows of 5 s, of which a test has 60 (5 minutes), in m/s^2.

Source: EN 12299:2009, whose numbers were taken from a public program that names it (pyridy), the standard itself not being at
hand. W_d is that of ISO 2631-1, Table 3. EN 12299's W_b has other resonance qualities than W_b of BS 6841 and
ISO 8041, which stands here too, since a value of it is published: at 100 rad/s it is 0.8126.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from math import inf, pi, sqrt

import numpy as np

from .filters import even_step

WINDOW = 5.0  # s
PERCENTILE = 95.0
Q1 = 1 / sqrt(2)
SCALE = ((1.5, "very comfortable"), (2.5, "comfortable"), (3.5, "medium"), (4.5, "uncomfortable"), (inf, "very uncomfortable"))


@dataclass(frozen=True)
class Weighting:
    """A weighting filter; see the module's docstring.

    Parameters
    ----------
    name
        Of the filter.
    f1, f2, f3, f4, f5, f6
        Corner frequencies, Hz; without a step f5 and f6 are infinite.
    Q2, Q3, Q4
        Resonance qualities.
    K
        Gain.
    """

    name: str
    f3: float
    f4: float
    Q2: float
    f5: float = inf
    Q3: float = 1.0
    f6: float = inf
    Q4: float = 1.0
    K: float = 1.0
    f1: float = 0.4
    f2: float = 100.0

    def response(self, f: np.ndarray) -> np.ndarray:
        """H(2 pi i f) at frequencies `f` (Hz), complex, shape of f."""
        s = 2j * pi * np.asarray(f, dtype=float)
        w1, w2, w3, w4, w5, w6 = (2 * pi * corner for corner in (self.f1, self.f2, self.f3, self.f4, self.f5, self.f6))
        band = s**2 / (s**2 + s * w1 / Q1 + w1**2) / (1 + s / (Q1 * w2) + (s / w2) ** 2)
        transition = (1 + s / w3) / (1 + s / (self.Q2 * w4) + (s / w4) ** 2)
        step = (1 + s / (self.Q3 * w5) + (s / w5) ** 2) / (1 + s / (self.Q4 * w6) + (s / w6) ** 2)
        return band * transition * self.K * step


W_D = Weighting("W_d", f3=2.0, f4=2.0, Q2=0.63)
W_B = Weighting("W_b", f3=16.0, f4=16.0, Q2=0.63, f5=2.5, Q3=0.8, f6=4.0, Q4=0.8, K=0.4)
W_B_ISO_8041 = Weighting("W_b of ISO 8041", f3=16.0, f4=16.0, Q2=0.55, f5=2.5, Q3=0.9, f6=4.0, Q4=0.95, K=0.4)


def weighted(acceleration: np.ndarray, t: np.ndarray, weighting: Weighting) -> np.ndarray:
    """An acceleration through a weighting filter, from rest.

    The filter acts in the frequency domain, where its gain is the standard's to rounding; zeros behind the signal keep its end
    from running into its beginning. The first seconds hold the filter's own start.

    Parameters
    ----------
    acceleration
        In m/s^2, shape (n,).
    t
        Evenly spaced times, s, shape (n,).
    weighting
        The filter.

    Returns
    -------
    weighted
        In m/s^2, shape (n,).

    Raises
    ------
    ValueError
        Where the times are not evenly spaced, or too coarse for the filter.
    """
    t, a = np.asarray(t, dtype=float), np.asarray(acceleration, dtype=float)
    step = even_step(a, t)
    if not 2.0 * weighting.f2 * step < 1.0:
        raise ValueError(f"the sampling rate must exceed {2 * weighting.f2:g} Hz for {weighting.name}, got {1.0 / step:g}")
    n = 2 * t.size + round(20.0 / weighting.f1 / step)  # the filter rings for some periods of its lowest corner
    spectrum = np.fft.rfft(a, n) * weighting.response(np.fft.rfftfreq(n, step))
    return np.asarray(np.fft.irfft(spectrum, n)[: t.size])


def window_rms(signal: np.ndarray, t: np.ndarray, window: float = WINDOW) -> np.ndarray:
    """Root mean square over windows, one after another; what remains at the end is not used.

    Parameters
    ----------
    signal, t
        Shape (n,); times evenly spaced, s.
    window
        Length of a window, s.

    Returns
    -------
    rms
        Shape (number of whole windows,), in the signal's unit.

    Raises
    ------
    ValueError
        Where the signal is shorter than a window.
    """
    points = round(window * (len(t) - 1) / float(t[-1] - t[0]))
    if not 1 <= points <= len(t):
        raise ValueError(f"the signal must be as long as a window of {window:g} s, is {t[-1] - t[0]:g} s")
    parts = np.asarray(signal, dtype=float)[: len(t) // points * points].reshape(-1, points)
    return np.asarray(np.sqrt((parts**2).mean(axis=1)))


def percentile(windows: Sequence[float] | np.ndarray) -> float:
    """The 95th percentile of r.m.s. values, m/s^2."""
    return float(np.percentile(windows, PERCENTILE))


def mean_comfort(x: np.ndarray, y: np.ndarray, z: np.ndarray) -> float:
    """N_MV from the weighted accelerations.

    Parameters
    ----------
    x, y, z
        Root mean square values of the windows along each axis, m/s^2, shape (windows,); x and y by W_d, z by W_b.

    Returns
    -------
    mean_comfort

    References
    ----------
    EN 12299:2009, standard method.
    """
    return 6.0 * sqrt(percentile(x) ** 2 + percentile(y) ** 2 + percentile(z) ** 2)


def verdict(mean: float) -> str:
    """What EN 12299 calls an N_MV of this size."""
    return next(word for limit, word in SCALE if mean < limit or limit == inf)
