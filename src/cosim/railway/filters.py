"""The filters of EN 14363: 20 Hz low pass over time, sliding mean over 2 m of track. SI units."""

import math

import numpy as np

CUT_OFF = 20.0  # Hz
WINDOW = 2.0  # m


def low_pass(signal: np.ndarray, t: np.ndarray, cut_off: float = CUT_OFF) -> np.ndarray:
    """A signal without what is faster than a frequency: 24 dB per octave, no phase shift.

    A Butterworth filter of order 2 forwards and backwards, its corner moved so that both together lose 3 dB at `cut_off`.

    Parameters
    ----------
    signal
        Shape (n,).
    t
        Evenly spaced times, s, shape (n,).
    cut_off
        In Hz.

    Returns
    -------
    filtered
        Shape (n,).

    Raises
    ------
    ValueError
        Where the times are not evenly spaced, or too coarse for the filter.
    """
    from scipy.signal import butter, sosfiltfilt

    t, signal = np.asarray(t, dtype=float), np.asarray(signal, dtype=float)
    step = even_step(signal, t)
    corner = cut_off * (math.sqrt(2.0) - 1.0) ** -0.25
    if not 2.0 * corner * step < 1.0:
        raise ValueError(f"the sampling rate must exceed {2.0 * corner:.3g} Hz to cut off at {cut_off:g} Hz, got {1.0 / step:g}")
    sos = butter(2, corner, fs=1.0 / step, output="sos")
    return np.asarray(sosfiltfilt(sos, signal, padlen=min(t.size - 1, 200)))


def sliding_mean(signal: np.ndarray, distance: np.ndarray, window: float = WINDOW) -> np.ndarray:
    """The mean over a window of track around each point; the window is shorter at both ends.

    Parameters
    ----------
    signal
        Shape (n,).
    distance
        Along the track, m, growing, shape (n,).
    window
        In m.

    Returns
    -------
    mean
        Shape (n,).

    Raises
    ------
    ValueError
        Where the distance does not grow.
    """
    s, y = np.asarray(distance, dtype=float), np.asarray(signal, dtype=float)
    if s.shape != y.shape or s.ndim != 1 or s.size < 2 or not np.all(np.diff(s) > 0.0):
        raise ValueError("distance must grow and be as long as signal")
    integral = np.concatenate([[0.0], np.cumsum((y[1:] + y[:-1]) / 2 * np.diff(s))])
    low, high = np.maximum(s - window / 2, s[0]), np.minimum(s + window / 2, s[-1])
    return np.asarray((np.interp(high, s, integral) - np.interp(low, s, integral)) / (high - low))


def en14363(signal: np.ndarray, t: np.ndarray, distance: np.ndarray) -> np.ndarray:
    """A signal as EN 14363 assesses it: 20 Hz low pass over time, then the mean over 2 m of track.

    Parameters
    ----------
    signal
        Shape (n,).
    t
        Evenly spaced times, s, shape (n,).
    distance
        Along the track, m, growing, shape (n,).

    Returns
    -------
    filtered
        Shape (n,).

    References
    ----------
    EN 14363, quasi-static and dynamic safety.
    """
    return sliding_mean(low_pass(signal, t), distance)


def even_step(signal: np.ndarray, t: np.ndarray) -> float:
    """The step of evenly spaced times, s.

    Parameters
    ----------
    signal
        What belongs to the times, shape (n,).
    t
        Times, s, shape (n,).

    Raises
    ------
    ValueError
        Where the times are not evenly spaced, or the shapes differ.
    """
    if signal.shape != t.shape or t.ndim != 1 or t.size < 2:
        raise ValueError(f"signal and t must be columns of equal length, got {signal.shape} and {t.shape}")
    step = float(t[-1] - t[0]) / (t.size - 1)
    if not np.allclose(np.diff(t), step, rtol=1e-6, atol=1e-9):
        raise ValueError("t must be evenly spaced")
    return step


def band_pass(signal: np.ndarray, t: np.ndarray, low: float, high: float) -> np.ndarray:
    """A signal without what is slower or faster than a band: 24 dB per octave at both edges, no phase shift.

    Parameters
    ----------
    signal
        Shape (n,).
    t
        Evenly spaced times, s, shape (n,).
    low, high
        Edges of the band, Hz, where it loses 3 dB.

    Returns
    -------
    filtered
        Shape (n,). Within some 1 / low of either end it is not settled.

    Raises
    ------
    ValueError
        Where the times are not evenly spaced, or too coarse for the filter.
    """
    from scipy.signal import butter, sosfiltfilt

    slower = low_pass(signal, t, high)
    sos = butter(
        2, low * (math.sqrt(2.0) - 1.0) ** 0.25, "highpass", fs=1.0 / even_step(slower, np.asarray(t, dtype=float)), output="sos"
    )
    return np.asarray(sosfiltfilt(sos, slower, padlen=min(slower.size - 1, 200)))
