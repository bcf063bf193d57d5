"""Energy that the coupling itself makes or loses, per power bond.

A bond carries a motion w one way and an effort M back; the slaves see them as the inputs w~ and M~. The vehicle takes
M~ w, the unit gives -M w~, so the coupling adds the residual power

    dP = M~ w - M w~,

zero for a perfect coupling. It is integrated over each macro step with Simpson's rule: the inputs are known polynomials,
and between communication points M and w are interpolated through the last points reached.
Source: Sadjina et al., Energy conservation and power bonds in co-simulations (2016), who take dP at the end of the step.
"""

from dataclasses import dataclass

import numpy as np

from component.units import unit
from cosim.network import Bond, Network

_CHUNK = 2048
# value half a step after the second newest point, from the newest, second newest, ... point
_MIDDLE = {2: (1 / 2, 1 / 2), 3: (3 / 8, 6 / 8, -1 / 8), 4: (5 / 16, 15 / 16, -5 / 16, 1 / 16)}


@dataclass(frozen=True)
class BondEnergy:
    """What a power bond carried and what the coupling added to it; SI.

    residual (J) : sum of the residual energy, positive where the coupling made energy.
    peak_power (W) : largest residual power in size.
    exchanged (J) : integral of the size of the power across the bond.
    """

    name: str
    residual: float
    peak_power: float
    exchanged: float

    @property
    def share(self) -> float:
        """Size of the residual as a share of the exchanged energy; 0 where nothing was exchanged."""
        return abs(self.residual) / self.exchanged if self.exchanged > 0.0 else 0.0


class EnergyMeter:
    """Sums the residual of every bond; record() is cheap, the arithmetic is done chunk by chunk."""

    def __init__(self, network: Network, Y: np.ndarray) -> None:
        self._network = network
        self._signals = np.array([k for b in network.bonds for k in (b.motion, b.effort)], dtype=int)
        n = len(network.bonds)
        self._residual, self._peak, self._exchanged = np.zeros(n), np.zeros(n), np.zeros(n)
        self._factor = np.array([_factor(network, b) for b in network.bonds])
        self._past: list[np.ndarray] = [Y[self._signals]]  # up to 3 points before the chunk, oldest first
        self._points: list[np.ndarray] = []
        self._used: list[list[np.ndarray]] = []
        self._lengths: list[float] = []

    def record(self, h: float, Y: np.ndarray, used: list[np.ndarray]) -> None:
        """One macro step of h (s) that reached Y under the inputs `used`, per slave of shape (3, n_u)."""
        if not self._signals.size:
            return
        self._points.append(Y[self._signals])
        self._used.append(used)
        self._lengths.append(h)
        if len(self._points) == _CHUNK:
            self._flush()

    def result(self) -> tuple[BondEnergy, ...]:
        """The sums so far."""
        if self._points:
            self._flush()
        rows = zip(self._network.bonds, self._residual, self._peak, self._exchanged, strict=True)
        return tuple(BondEnergy(b.name, float(r), float(p), float(e)) for b, r, p, e in rows)

    def _flush(self) -> None:
        known = len(self._past)
        Z = np.array([*self._past, *self._points])  # (known + n, 2 bonds)
        h = np.array(self._lengths)
        n = len(h)
        end, start = Z[known:], Z[known - 1 : -1]
        middle = np.empty_like(end)
        cold = min(n, max(0, 3 - known))  # the first steps of a run have fewer points behind them
        for k in range(cold):
            weights = _MIDDLE[known + k + 1]
            middle[k] = sum(weight * Z[known + k - j] for j, weight in enumerate(weights))
        middle[cold:] = sum(weight * Z[known + cold - j : known + n - j] for j, weight in enumerate(_MIDDLE[4]))
        if n > 1 and abs(h[-1] - h[-2]) > 1e-9 * h[-2]:  # the last, shorter step does not fit the even spacing
            middle[-1] = (end[-1] + start[-1]) / 2
        sums = np.zeros((len(self._network.bonds), n, 3))
        powers = np.zeros_like(sums)
        for i, bond in enumerate(self._network.bonds):
            w = np.stack([start[:, 2 * i], middle[:, 2 * i], end[:, 2 * i]], axis=1)
            M = np.stack([start[:, 2 * i + 1], middle[:, 2 * i + 1], end[:, 2 * i + 1]], axis=1)
            w_used = self._input(bond.motion_input, h)
            M_used = self._input(bond.effort_input, h)
            sums[i] = (M_used * w - M * w_used) * self._factor[i]
            powers[i] = M * w * self._factor[i]
        simpson = np.array([1.0, 4.0, 1.0]) / 6.0
        self._residual += (sums @ simpson) @ h
        self._exchanged += (np.abs(powers) @ simpson) @ h
        self._peak = np.maximum(self._peak, np.abs(sums).max(axis=(1, 2)))
        self._past = list(Z[-3:])
        self._points, self._used, self._lengths = [], [], []

    def _input(self, place: tuple[int, int], h: np.ndarray) -> np.ndarray:
        """The polynomial of one input at start, middle and end of every step, in the unit of its source; (n, 3)."""
        i, j = place
        U = np.array([used[i][:, j] for used in self._used])
        s = h[:, None] * np.array([0.0, 0.5, 1.0])
        values = U[:, :1] + U[:, 1:2] * s + U[:, 2:] * s**2 / 2
        ((scale, offset),) = [(a, b) for _, place_in_u, a, b in self._network.wires(i) if place_in_u == j]
        return (values - offset) / scale


def _factor(network: Network, bond: Bond) -> float:
    """From the product of the signals' units to W."""
    factor = 1.0
    for k in (bond.motion, bond.effort):
        if network.units[k]:
            factor *= unit(network.units[k]).factor
    return factor
