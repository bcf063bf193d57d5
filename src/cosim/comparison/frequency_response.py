"""The frequency response of a component between two of its signals, measured by driving it alone.

The input is a multisine, u(t) = sum a cos(2 pi f_k t + phi_k), whose frequencies are multiples of the lowest, with Schroeder's
phases, which keep its peaks low. After one period to settle the response at each f_k is the ratio of the Fourier coefficients
of output and input over the next. It holds for that amplitude: what noise, quantisation and limits do is in it.
Source: Schroeder, Synthesis of low-peak-factor signals (1970); Pintelon and Schoukens, System Identification, ch. 2.
"""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from ..slaves import Slave

LINES = 24


@dataclass(frozen=True, eq=False)
class Response:
    """A frequency response.

    Parameters
    ----------
    name : str
        Of the bond it was measured at.
    frequency : ndarray, shape (n,)
        Hz.
    value : ndarray of complex, shape (n,)
        Output over input. A phase below zero: the output is late.
    """

    name: str
    frequency: np.ndarray
    value: np.ndarray


def frequencies(step: float, lowest: float = 0.2) -> np.ndarray:
    """Multiples of `lowest` (Hz), evenly spaced in the logarithm, up to a tenth of the sampling rate 1 / `step` and 50 Hz."""
    highest = min(50.0, 0.1 / step)
    if highest < 2 * lowest:
        raise ValueError(
            f"`step` must be at most {0.05 / lowest:g} s for a frequency response from {lowest:g} Hz, got {step:g} s"
        )
    return lowest * np.unique(np.round(np.geomspace(1.0, highest / lowest, LINES)))


def measure(
    slave: Slave, values: Mapping[str, Any], place: int, row: int, *, rms: float, step: float, name: str = ""
) -> Response:
    """Measure one response of a slave that is driven alone.

    Parameters
    ----------
    slave : Slave
        Started anew for this.
    values : mapping
        Its parameters and start values.
    place, row : int
        Of the input that is driven and the output that is looked at.
    rms : float
        Of the drive, in the input's unit.
    step : float
        Time (s) between two points.
    name : str
        What the response is called.

    References
    ----------
    See the module's docstring.
    """
    f = frequencies(step)
    n = round(1 / f[0] / step)  # steps a period
    f = f * (1 / (n * step)) / f[0]  # the period is a whole number of steps
    phase = -np.pi * np.arange(f.size) * (np.arange(f.size) + 1) / f.size
    a, omega = rms * np.sqrt(2 / f.size), 2 * np.pi * f
    t = np.arange(n) * step
    waves = a * np.exp(1j * (omega * t[:, None] + phase))
    drive = np.stack([waves.sum(axis=1).real, (1j * omega * waves).sum(axis=1).real, (-(omega**2) * waves).sum(axis=1).real])
    slave.initialize(values, 0.0, 2 * n * step)
    still = np.array([float(values.get(s.name, s.start) or 0.0) for s in slave.inputs])
    U = np.zeros((3, still.size))
    U[0] = still
    y = np.zeros(n)
    for k in range(2 * n):
        U[:, place] = drive[:, k % n]
        U[0, place] += still[place]
        if k >= n:
            y[k - n] = slave.output(U[0], k * step)[row]
        else:
            slave.output(U[0], k * step)
        slave.step(U, k * step, step)
    basis = np.exp(-1j * omega * t[:, None])
    return Response(name, f, (basis * y[:, None]).sum(axis=0) / (basis * drive[0][:, None]).sum(axis=0))
