"""Random and tabulated irregularity as harmonics: seeded draws from the ERRI / German spectra, Fourier series of tables.

    S(W) = A Wc^2 / ((W^2 + Wr^2) (W^2 + Wc^2))                                        lateral (A_a), vertical (A_v), m^2 m/rad
    S(W) = (A_v / b^2) Wc^2 W^2 / ((W^2 + Wr^2) (W^2 + Wc^2) (W^2 + Ws^2))              cross level as an angle, rad^2 m/rad
    S(W) = A_g Wc^2 W^2 / ((W^2 + Wr^2) (W^2 + Wc^2) (W^2 + Ws^2))                     gauge, m^2 m/rad

one-sided, W in rad/m. The wave n K, K = 2 pi / L, stands for the band of width K around it: its amplitude is the root of
twice the integral of S over the band, its phase random.
Every channel has its own stream of random numbers. The cross level in metres is the angle times 2 b. A record by points has all
waves from its length down to two of its steps, and repeats nothing. Source: ERRI B176; figures as in the German low- and
high-disturbance spectra.
"""

from collections.abc import Mapping, Sequence
from math import pi

import numpy as np

from .irregularity import CHANNELS

__all__ = ["LEVELS", "ROUGH", "random_record", "random_track", "spectrum", "tabulated_track"]

ROUGH = ("lateral", "vertical", "cross_level")  # channels that are uneven unless told otherwise
W_C, W_R, W_S = 0.8246, 0.0206, 0.4380  # rad/m
LEVELS = {"low": (2.119e-7, 4.032e-7), "high": (6.125e-7, 1.08e-6)}  # (A_a, A_v), m rad
GAUGE = {"low": 5.32e-8, "high": 1.032e-7}  # A_g, m rad
B = 0.75  # m


def spectrum(channel: str, level: str, W: np.ndarray) -> np.ndarray:
    """Compute a one-sided spectrum of irregularity: S of the module's docstring.

    Parameters
    ----------
    channel : str
        "lateral", "vertical", "cross_level" or "gauge".
    level : str
        "low" or "high".
    W : array
        Wave numbers (rad/m).

    Returns
    -------
    array, shape of W
        S in m^2/(rad/m), the cross level in metres.

    Raises
    ------
    ValueError
        For an unknown level or channel.

    References
    ----------
    ERRI B176; figures as in the German low- and high-disturbance spectra.
    """
    if level not in LEVELS:
        raise ValueError(f"level must be one of {', '.join(LEVELS)}, got {level!r}")
    A_a, A_v = LEVELS[level]
    shape: np.ndarray = W_C**2 / ((W**2 + W_R**2) * (W**2 + W_C**2))
    if channel == "lateral":
        return A_a * shape
    if channel == "vertical":
        return A_v * shape
    if channel == "cross_level":
        cross: np.ndarray = (2 * B) ** 2 * A_v / B**2 * shape * W**2 / (W**2 + W_S**2)
        return cross
    if channel == "gauge":
        gauge: np.ndarray = GAUGE[level] * shape * W**2 / (W**2 + W_S**2)
        return gauge
    raise ValueError(f"channel must be one of {', '.join(CHANNELS)}, got {channel!r}")


def random_record(
    level: str, seed: int, length: float, step: float = 0.25, channels: Sequence[str] = CHANNELS
) -> tuple[np.ndarray, dict[str, np.ndarray]]:
    """Draw a random track as points.

    Parameters
    ----------
    level : str
        "low" or "high".
    seed : int
        Decides the phases; every channel has its own stream of random numbers.
    length, step : float
        Of the record, and between its points (m).
    channels : sequence of str
        Those that are uneven.

    Returns
    -------
    position : array, shape (n,)
        m, from 0 on.
    displacements : dict of str to array, shape (n,)
        m, by channel.

    Raises
    ------
    ValueError
        For an unknown level or channel, or a record of fewer than 8 steps.
    """
    if not step > 0.0 or not length >= 8 * step:
        raise ValueError(f"a record must have 8 steps or more, got a length of {length:g} m and steps of {step:g} m")
    n = round(length / step)
    K = 2 * pi / (n * step)
    waves = K * np.arange(1, n // 2)
    streams = dict(zip(CHANNELS, np.random.SeedSequence(seed).spawn(len(CHANNELS)), strict=True))
    found = {}
    for channel in channels:
        amplitude = np.sqrt(2 * K * spectrum(channel, level, waves))
        phase = np.random.default_rng(streams[channel]).uniform(0.0, 2 * pi, waves.size)
        half = np.zeros(n // 2 + 1, complex)
        half[1 : waves.size + 1] = n / 2 * amplitude * np.exp(1j * phase)
        found[channel] = np.fft.irfft(half, n)
    return step * np.arange(n), found


def random_track(
    level: str,
    seed: int,
    harmonics: int,
    longest: float = 100.0,
    channels: Sequence[str] = ROUGH,
) -> dict[str, float]:
    """Draw a random track.

    Parameters
    ----------
    level : str
        "low" or "high".
    seed : int
        Decides the phases; every channel has its own stream of random numbers.
    harmonics : int
        Waves in each channel: from `longest` down to `longest` / `harmonics`.
    longest : float
        Longest wave, and period of the track (m).
    channels : sequence of str
        Of "lateral", "vertical" and "cross_level", those that are uneven.

    Returns
    -------
    dict of str to float
        Parameters of a vehicle with that many harmonics, by name.

    Raises
    ------
    ValueError
        For an unknown level or channel, or where harmonics or longest wave are not positive.
    """
    if harmonics < 1 or not longest > 0.0:
        raise ValueError(f"harmonics and longest must be positive, got {harmonics} and {longest:g}")
    K = 2 * pi / longest
    W = K * np.arange(1, harmonics + 1)
    nodes, weights = np.polynomial.legendre.leggauss(8)
    nodes, weights = nodes / 2, weights / 2  # on a band of width 1
    streams = dict(zip(CHANNELS, np.random.SeedSequence(seed).spawn(len(CHANNELS)), strict=True))
    values: dict[str, float] = {"harmonics_length": longest}
    for channel in channels:
        bands = K * weights * spectrum(channel, level, W[:, None] + K * nodes)
        amplitude = np.sqrt(2 * bands.sum(axis=1))
        phase = np.random.default_rng(streams[channel]).uniform(0.0, 2 * pi, harmonics)
        values |= _named(channel, amplitude * np.cos(phase), amplitude * np.sin(phase))
    return values


def tabulated_track(
    position: Sequence[float], tables: Mapping[str, Sequence[float]], harmonics: int, tolerance: float = 0.05
) -> dict[str, float]:
    """Turn tables of irregularity into harmonics. The track repeats them for ever: their length is the period.

    Parameters
    ----------
    position : sequence of float, shape (n,)
        Places along the track (m), increasing, n at least 3.
    tables : mapping of str to sequence of float, shape (n,)
        Displacement (m) by channel: "lateral", "vertical", "cross_level" or "gauge". The last value should be the first, or
        the series hardly converges.
    harmonics : int
        Waves in each channel.
    tolerance : float
        What the harmonics may miss of a table's rms (1).

    Returns
    -------
    dict of str to float
        Parameters of a vehicle with that many harmonics, by name.

    Raises
    ------
    ValueError
        For an unknown channel, positions that do not increase, a table that does not fit them or is not finite, or where the
        harmonics miss more than `tolerance`.
    """
    s = np.asarray(position, dtype=float)
    if s.ndim != 1 or s.size < 3 or not np.all(np.diff(s) > 0.0):
        raise ValueError("positions of an irregularity table must be at least three and increase")
    length = s[-1] - s[0]
    even = s[0] + length * np.arange(8 * harmonics) / (8 * harmonics)
    values: dict[str, float] = {"harmonics_length": float(length)}
    for channel, table in tables.items():
        if channel not in CHANNELS:
            raise ValueError(f"channel must be one of {', '.join(CHANNELS)}, got {channel!r}")
        w = np.asarray(table, dtype=float)
        if w.shape != s.shape or not np.all(np.isfinite(w)):
            raise ValueError(f"table {channel!r} must hold a finite number for each of {s.size} positions, got shape {w.shape}")
        w = w - w.mean()
        c = np.fft.rfft(np.interp(even, s, w))[1 : harmonics + 1] * 2 / even.size
        c *= np.exp(-2j * pi * np.arange(1, harmonics + 1) * s[0] / length)  # phases count from s = 0
        waves = np.exp(2j * pi * np.outer(even, np.arange(1, harmonics + 1)) / length)
        missed = np.std(np.interp(even, s, w) - (waves @ c).real)
        if missed > tolerance * np.std(w):
            raise ValueError(
                f"{harmonics} harmonics miss {missed / np.std(w):.2g} of table {channel!r}, allowed is {tolerance:g}"
            )
        values |= _named(channel, c.real, -c.imag)
    return values


def _named(channel: str, cosine: np.ndarray, sine: np.ndarray) -> dict[str, float]:
    return {f"{channel}_{part}[{n}]": float(v) for part, a in (("cosine", cosine), ("sine", sine)) for n, v in enumerate(a)}
