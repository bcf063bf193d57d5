"""Energy that the coupling itself makes or loses, per power bond.

A bond carries a motion w one way and an effort M back; the slaves see them as the inputs w~ and M~. The vehicle takes
M~ w, the unit gives -M w~, so the coupling adds the residual power

    dP = M~ w - M w~,

zero for a perfect coupling. It is integrated over each macro step with Simpson's rule: the inputs are known polynomials,
and between communication points M and w are interpolated through the last points reached.
Source: Sadjina et al., Energy conservation and power bonds in co-simulations (2016), who take dP at the end of the step.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np

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
    found = [bond for bond in energies if bond.share > UNTRUSTED and bond.exchanged > least]
    return max(found, key=lambda bond: bond.share, default=None)


class EnergyMeter:
    """Sums the residual of every bond over the macro steps handed to add().

    signals : places in Y of motion and effort of each bond in turn, shape (2 bonds,).
    kernel : `accumulate` compiled, for runs whose loop is compiled too; None for the arithmetic on whole arrays.
    """

    kernel: Callable[..., None] | None = None

    def __init__(self, network: Network, Y: np.ndarray) -> None:
        self._bonds = network.bonds
        self.signals = np.array([k for b in network.bonds for k in (b.motion, b.effort)], dtype=int)
        n = len(network.bonds)
        self._residual, self._peak, self._exchanged = np.zeros(n), np.zeros(n), np.zeros(n)
        self._factor = np.array([watts(b, network.units) for b in network.bonds])
        ends = [place for b in network.bonds for place in (b.motion_input, b.effort_input)]
        conversions = [next((a, c) for _, place, a, c in network.wires(i) if place == j) for i, j in ends]
        self._scale, self._offset = (np.array([c[k] for c in conversions]) for k in (0, 1))
        self._step = 0.0  # the last step's length, s
        self._past = Y[None, self.signals]  # up to 3 points before the next step, oldest first

    def add(self, h: np.ndarray, Y: np.ndarray, used: np.ndarray) -> None:
        """n macro steps of h (s), shape (n,), that reached Y, shape (n, n_Y), under inputs `used`, shape (n, 2 bonds, 3)."""
        if not self.signals.size or not len(h):
            return
        known = len(self._past)
        if self.kernel is not None:
            before = self._step or float(h[0])
            self.kernel(
                self._past, Y, self.signals, h, before, used, self._scale, self._offset, self._factor,
                self._residual, self._exchanged, self._peak,
            )  # fmt: skip
            self._step, self._past = float(h[-1]), np.concatenate([self._past, Y[-3:, self.signals]])[-3:]
            return
        Z = np.concatenate([self._past, Y[:, self.signals]])
        start, end = Z[known - 1 : -1], Z[known:]
        middle = self._middle(Z, known, h, self._step or float(h[0]))
        self._step = float(h[-1])
        added, carried = np.zeros((2, *start.shape[:1], len(self._factor)))
        for point, weight, s in ((start, 1.0, 0.0), (middle, 4.0, 0.5), (end, 1.0, 1.0)):  # Simpson's rule
            at = (s * h)[:, None]
            taken = used[:, :, 0] + at * (used[:, :, 1] + at * used[:, :, 2] / 2)
            taken = (taken - self._offset) / self._scale
            w, M = point[:, ::2], point[:, 1::2]
            residual = (taken[:, 1::2] * w - M * taken[:, ::2]) * self._factor
            added += weight * residual
            carried += weight * np.abs(M * w * self._factor)
            self._peak = np.maximum(self._peak, np.abs(residual).max(axis=0))
        for sums, of_steps in ((self._residual, added), (self._exchanged, carried)):  # one by one: the same bits in any chunks
            sums[:] = np.cumsum(np.vstack([sums, h[:, None] * of_steps / 6]), axis=0)[-1]
        self._past = Z[-3:].copy()

    @staticmethod
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

    def result(self) -> tuple[BondEnergy, ...]:
        """The sums so far."""
        rows = zip(self._bonds, self._residual, self._peak, self._exchanged, strict=True)
        return tuple(BondEnergy(b.name, float(r), float(p), float(e)) for b, r, p, e in rows)

    def state(self) -> dict[str, np.ndarray]:
        """What a checkpoint keeps."""
        sums = {"residual": self._residual, "peak": self._peak, "exchanged": self._exchanged}
        return {**sums, "past": self._past, "step": np.array(self._step)}

    def resume(self, state: dict[str, np.ndarray]) -> None:
        """Go on from what state() gave."""
        self._residual, self._peak, self._exchanged = (state[k].copy() for k in ("residual", "peak", "exchanged"))
        self._past, self._step = state["past"], float(state["step"])


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
