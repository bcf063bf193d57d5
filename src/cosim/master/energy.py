"""Energy that the coupling itself makes or loses, per power bond.

A bond carries a motion w one way and an effort M back; the slaves see them as the inputs w~ and M~. The vehicle takes
M~ w, the unit gives -M w~, so the coupling adds the residual power

    dP = M~ w - M w~,

zero for a perfect coupling. It is integrated over each macro step with Simpson's rule: the inputs are known polynomials,
and between communication points M and w are interpolated through the last points reached.
Source: Sadjina et al., Energy conservation and power bonds in co-simulations (2016), who take dP at the end of the step.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from ..kernel.energy import Bonds, Sums
from ..network import Network
from ..network.bonds import watts

UNTRUSTED = 0.01  # share of a bond's energy
NEGLIGIBLE = 1e-6, 1e-12  # share of the energy of the largest bond, and J: at rest only rounding is exchanged
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


def untrustworthy(energies: Sequence[BondEnergy]) -> BondEnergy | None:
    """The bond whose energy the coupling itself has made or lost to the largest share, where that is more than a hundredth.

    Bonds that carry next to nothing, in themselves or beside another, are left out.
    """
    share, least = NEGLIGIBLE
    least = max(least, share * max((bond.exchanged for bond in energies), default=0.0))
    suspects = [bond for bond in energies if bond.share > UNTRUSTED and bond.exchanged > least]
    return max(suspects, key=lambda bond: bond.share, default=None)


@dataclass(frozen=True, eq=False)
class EnergySums:
    """What an EnergyMeter has summed so far; a value, a part of the state of a run.

    Parameters
    ----------
    residual, peak, exchanged : ndarray, shape (n_bonds,)
        See BondEnergy.
    past : ndarray, shape (1 to 3, 2 n_bonds)
        Motion and effort of each bond in turn at the last points, oldest first.
    step : float
        Length of the last step, s; 0 before the first.
    """

    residual: np.ndarray
    peak: np.ndarray
    exchanged: np.ndarray
    past: np.ndarray
    step: float = 0.0

    def copies(self) -> Sums:
        """The sums, to be added to in place."""
        return Sums(self.residual.copy(), self.exchanged.copy(), self.peak.copy())


class EnergyMeter:
    """Sums the residual of every power bond of a network over macro steps.

    bonds : what the sums are of.
    """

    def __init__(self, network: Network) -> None:
        self._network = network
        ends = [place for b in network.bonds for place in (b.motion_input, b.effort_input)]
        conversions = [next((a, c) for _, place, a, c in network.wires(i) if place == j) for i, j in ends]
        self.bonds = Bonds(
            signals=np.array([k for b in network.bonds for k in (b.motion, b.effort)], dtype=np.int64),
            inverse=np.array([1.0 / scale for scale, _ in conversions]),
            offset=np.array([offset for _, offset in conversions]),
            factor=np.array([watts(b, network.units) for b in network.bonds]),
        )

    def begin(self, Y: np.ndarray) -> EnergySums:
        """The sums at the start of a run, whose outputs are Y, shape (n_Y,)."""
        none = np.zeros(self.bonds.factor.size)
        return EnergySums(none, none, none, Y[None, self.bonds.signals])

    def anew(self, sums: EnergySums, Y: np.ndarray) -> EnergySums:
        """The same sums, to go on from the outputs Y, shape (n_Y,), to which they have jumped."""
        return EnergySums(sums.residual, sums.peak, sums.exchanged, Y[None, self.bonds.signals])

    def add(self, sums: EnergySums, h: np.ndarray, Y: np.ndarray, used: np.ndarray) -> EnergySums:
        """The sums after n macro steps more.

        Parameters
        ----------
        sums : EnergySums
            Before them.
        h : ndarray, shape (n,)
            Their lengths, s.
        Y : ndarray, shape (n, n_Y)
            The outputs that they reached.
        used : ndarray, shape (n, 2 n_bonds, 3)
            The inputs of the bonds, motion and effort of each in turn, that they followed.
        """
        if not self.bonds.signals.size or not len(h):
            return sums
        new, before = sums.copies(), sums.step or float(h[0])
        self._add_arrays(new, sums.past, Y, h, before, used)
        return self.after(sums, new, Y, h)

    def after(self, sums: EnergySums, new: Sums, Y: np.ndarray, h: np.ndarray) -> EnergySums:
        """The sums after the macro steps of add(), which have been added to `new`, copies of `sums`."""
        if not self.bonds.signals.size or not len(h):
            return sums
        past = np.concatenate([sums.past, Y[-3:, self.bonds.signals]])[-3:]
        return EnergySums(new.residual, new.peak, new.exchanged, past, float(h[-1]))

    def _add_arrays(self, sums: Sums, past: np.ndarray, Y: np.ndarray, h: np.ndarray, before: float, used: np.ndarray) -> None:
        """kernel.energy.accumulate on whole arrays: the same operations in the same order, so the same bits."""
        signals, inverse, offset, factor = self.bonds
        known = len(past)
        Z = np.concatenate([past, Y[:, signals]])
        residuals, powers = [], []
        value, slope, curvature = used[:, :, 0] - offset, used[:, :, 1], used[:, :, 2] / 2
        for point, s in ((Z[known - 1 : -1], 0.0), (_middle(Z, known, h, before), 0.5), (Z[known:], 1.0)):
            at = (s * h)[:, None]
            taken = (value + at * (slope + at * curvature) if s else value) * inverse
            w, M = point[:, ::2], point[:, 1::2]
            residuals.append((taken[:, 1::2] * w - M * taken[:, ::2]) * factor)
            powers.append(np.abs(M * w * factor))
        sixth = (h / 6)[:, None]
        for total, (start, middle, end) in ((sums.residual, residuals), (sums.exchanged, powers)):  # Simpson's rule
            steps = sixth * (start + 4 * middle + end)
            total[:] = np.cumsum(np.vstack([total, steps]), axis=0)[-1]  # one by one: the same bits in any chunks
        np.maximum(sums.peak, np.abs(residuals).max(axis=(0, 1)), out=sums.peak)

    def result(self, sums: EnergySums) -> tuple[BondEnergy, ...]:
        """The sums in words."""
        rows = zip(self._network.bonds, sums.residual, sums.peak, sums.exchanged, strict=True)
        return tuple(BondEnergy(b.name, float(r), float(p), float(e)) for b, r, p, e in rows)


def _middle(Z: np.ndarray, known: int, h: np.ndarray, before: float) -> np.ndarray:
    """The signals half-way through each step, by interpolation through the last points reached where steps are even."""
    n = len(h)
    middle = np.empty_like(Z[known:])
    cold = min(n, max(0, 3 - known))  # the first steps of a run have fewer points behind them
    for k in range(cold):
        middle[k] = sum(weight * Z[known + k - j] for j, weight in enumerate(_MIDDLE[known + k + 1]))
    middle[cold:] = sum(weight * Z[known + cold - j : known + n - j] for j, weight in enumerate(_MIDDLE[4]))
    uneven = np.flatnonzero(np.abs(np.diff(h, prepend=before)) > 1e-9 * h)
    middle[uneven] = (Z[known + uneven] + Z[known + uneven - 1]) / 2
    return middle


def residual_power(network: Network, Y: np.ndarray, used: list[np.ndarray], h: float) -> tuple[np.ndarray, np.ndarray]:
    """Size of the residual power and of the power of every bond (W) at the end of a step of h (s) that reached Y."""
    residual, power = np.zeros(len(network.bonds)), np.zeros(len(network.bonds))
    for row, bond in enumerate(network.bonds):
        taken = []
        for i, j in (bond.motion_input, bond.effort_input):
            scale, offset = next((a, c) for _, place, a, c in network.wires(i) if place == j)
            U = used[i][:, j]
            taken.append((U[0] + h * (U[1] + h * U[2] / 2) - offset) / scale)
        w, M, factor = Y[bond.motion], Y[bond.effort], watts(bond, network.units)
        residual[row], power[row] = abs((taken[1] * w - M * taken[0]) * factor), abs(M * w * factor)
    return residual, power
