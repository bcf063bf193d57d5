"""Frequency response of a system at rest to a wave that its parameters describe, as the irregularity of a track is.

With a wave a sin(k (s - s_0)) in the equations, s = v t, the linearised system is  z' = A z + b(t) a,  b(t) = Im(F exp(i w t)),
w = k v. Every axle meets the wave in its own time: that is in F. At t = 0, b is Im F where the wave begins with its phase 0,
and Re F where it is a quarter of a wave further. So both follow from derivatives of the equations by a, and

    Z = (i w - A)^-1 F,       a state is  |Z_k| a sin(w t + arg Z_k).
"""

from collections.abc import Sequence
from dataclasses import dataclass

import casadi as ca
import numpy as np

from ..systems import System
from .at_rest import AtRest

__all__ = ["Response", "Wave", "wave_response"]

FAR = 1000.0  # m, how far before the system a wave begins at least


@dataclass(frozen=True)
class Wave:
    """The parameters that describe a wave, as `component.parameter`, and how fast it is met.

    Attributes
    ----------
    amplitude, wavelength, start, cycles, speed : str
        a, 2 pi / k (m), s_0 (m), the number of waves, and v (m/s).
    """

    amplitude: str
    wavelength: str
    start: str
    cycles: str
    speed: str


@dataclass(frozen=True)
class Response:
    """What `wave_response` finds.

    Attributes
    ----------
    speed : float
        m/s.
    states : dict of str to array, complex, shape (m,)
        By state: its unit for each unit of the amplitude.
    """

    speed: float
    states: dict[str, np.ndarray]


def wave_response(system: System, wave: Wave, frequencies: Sequence[float], ignorable: Sequence[str] = ()) -> Response:
    """Compute the response of every state.

    Parameters
    ----------
    system
        Of catalogue components, at rest where all its states are zero.
    wave
        What excites it.
    frequencies
        Hz, positive, shape (m,).
    ignorable
        As of AtRest.

    Returns
    -------
    Response
        Of the system as it stands.

    Raises
    ------
    ValueError
        Where the system is not at rest, a parameter is not there, or a frequency is not positive.
    """
    f = np.asarray(frequencies, float)
    if not (f.size and np.all(f > 0.0) and np.all(np.isfinite(f))):
        raise ValueError(f"frequencies must be positive, got {list(frequencies)}")
    rest = AtRest(system, (wave.amplitude, wave.wavelength, wave.start, wave.cycles, wave.speed), ignorable)
    speed = float(rest.q0[4])
    if not speed > 0.0:
        raise ValueError(f"{wave.speed} must be positive, got {speed:g}")
    x, q = ca.SX.zeros(rest.monolith.x0.size), ca.SX.sym("q", rest.monolith.q0.size)
    slope = ca.Function("slope", [q], [ca.jacobian(rest.monolith.f(x, q), q)])
    A = rest.matrix([0.0, *rest.q0[1:]])
    found = np.empty((f.size, len(rest.states)), complex)
    for row, frequency in zip(found, f, strict=True):
        length = speed / frequency
        begin = -np.ceil(FAR / length) * length
        cycles = 4 * np.ceil(FAR / length)
        b = [rest.driven(slope, [0.0, length, begin - part * length, cycles, speed]) for part in (0.25, 0.0)]
        row[:] = np.linalg.solve(2j * np.pi * frequency * np.eye(A.shape[0]) - A, b[0] + 1j * b[1])
    states = (state.partition(" - ")[0] for state in rest.states)
    return Response(speed, dict(zip(states, found.T, strict=True)))
