"""How much two signals on one time grid differ: in size, at the peaks, and in time."""

from dataclasses import dataclass

import numpy as np


@dataclass(frozen=True)
class Difference:
    """A signal y against its reference r.

    Parameters
    ----------
    rms, peak : float
        rms(y - r) / rms(r) and max|y - r| / max|r|. Where r is zero throughout, y takes its place in the denominator.
    shift : float
        Time (s) by which y comes later than r, at the greatest cross-correlation.
    correlation : float
        The coefficient there, 1 where y is r moved and scaled. Where it is below 0.9 or so the shift means little; signals
        that do not move give 0 and 1.
    reference_peak, own_peak : float
        max|r| and max|y|, in the signal's unit.
    """

    rms: float
    peak: float
    shift: float
    correlation: float
    reference_peak: float
    own_peak: float


def signal_difference(t: np.ndarray, reference: np.ndarray, own: np.ndarray, rest: float = 0.0) -> Difference:
    """How much a signal differs from its reference.

    Parameters
    ----------
    t : ndarray, shape (n,)
        Evenly spaced times (s).
    reference, own : ndarray, shape (n,)
        The two signals.
    rest : float
        What never exceeds this counts as zero throughout, so that rounding is not compared with rounding.
    """
    reference, own = (np.zeros_like(v) if np.abs(v).max() <= rest else v for v in (reference, own))
    largest, own_largest = float(np.abs(reference).max()), float(np.abs(own).max())
    size = _rms(reference) or _rms(own)
    shift, correlation = time_shift(t, reference, own)
    return Difference(
        rms=_rms(own - reference) / size if size else 0.0,
        peak=float(np.abs(own - reference).max()) / (largest or own_largest) if size else 0.0,
        shift=shift, correlation=correlation, reference_peak=largest, own_peak=own_largest,
    )  # fmt: skip


def _rms(values: np.ndarray) -> float:
    return float(np.sqrt(np.mean(values**2)))


def time_shift(t: np.ndarray, reference: np.ndarray, own: np.ndarray) -> tuple[float, float]:
    """(shift in s, correlation coefficient) at the lag of greatest cross-correlation, a quarter of the record at most.

    The plain cross-correlation, which favours small lags, finds the peak; the one over the common part alone, which a start
    off zero does not pull to no lag, then places it, between samples by the parabola through the three values about it.
    """
    n = t.size
    a, b = reference - reference.mean(), own - own.mean()
    norm = float(np.sqrt((a**2).sum() * (b**2).sum()))
    if n < 8 or norm <= 1e-24 * n * max(float((reference**2).max()), float((own**2).max()), 1e-300):
        return 0.0, 1.0 if np.array_equal(reference, own) else 0.0
    size = 1 << (2 * n - 1).bit_length()
    product = np.fft.irfft(np.fft.rfft(b, size) * np.conj(np.fft.rfft(a, size)), size)
    reach = n // 4
    plain = np.concatenate([product[-reach:], product[: reach + 1]])  # lags -reach ... reach
    near = plain / _common_norm(a, b, reach, norm)
    k = int(np.argmax(plain))
    while 0 < k < near.size - 1 and max(near[k - 1], near[k + 1]) > near[k]:
        k += 1 if near[k + 1] > near[k - 1] else -1
    offset = 0.0
    if 0 < k < near.size - 1:
        before, at, after = near[k - 1 : k + 2]
        curvature = before - 2 * at + after
        offset = 0.5 * (before - after) / curvature if curvature < 0.0 else 0.0
    return float((k - reach + offset) * (t[1] - t[0])), float(near[k])


def _common_norm(a: np.ndarray, b: np.ndarray, reach: int, floor: float) -> np.ndarray:
    """sqrt(sum a^2 sum b^2) over what a and b, moved by each lag -reach ... reach, have in common."""
    n, lags = a.size, np.arange(-reach, reach + 1)
    A, B = (np.concatenate([[0.0], np.cumsum(v**2)]) for v in (a, b))
    first, last = np.maximum(0, -lags), np.minimum(n, n - lags)  # of a; b lies `lag` further on
    product: np.ndarray = np.maximum((A[last] - A[first]) * (B[last + lags] - B[first + lags]), (1e-6 * floor) ** 2)
    return np.asarray(np.sqrt(product))
