"""Cycles of z' = f(z, v) by collocation: their equations, Newton's method for them, their multipliers.

A period 2 pi / w is cut into N intervals of length h, and in each the collocation polynomial of Radau IIA with three stages
(Hairer, Wanner 1996, section IV.5; order 5, and what is too fast for an interval is damped, not reflected) meets

    Z_is = Z_(i-1)3 + h sum_r a_sr f(Z_ir, v),   i = 1 .. N, s = 1 .. 3,   Z_0 = Z_N                          (1)
    sum_is  f(Z*_is) . (Z_is - Z*_is) = 0                                                                     (2)

(2) holds the phase to that of the cycle before, Z*. Newton's method solves each interval for what its begin does to it, so that
n + 2 unknowns are left for the whole period.

Lengths are measured with each state over its size in the mode with which a branch begins, so that metres and radians count
alike; states that this mode does not move do not count.

A small disturbance of a cycle is multiplied by Floquet's multipliers in each period, the eigenvalues of the product of what (1)
makes of a disturbance in each interval. One of them is 1, along the cycle; it is stable if the others lie inside the unit circle.
"""

from dataclasses import dataclass
from typing import Protocol

import numpy as np

__all__ = ["Arc", "Cycle", "Flow"]

NEUTRAL = 1e-4  # how near to 1 a multiplier says nothing
NEWTON, ENOUGH = 12, 1e-5  # steps; the one that is smaller than this, in scaled unknowns, is the last: the error is its square
_ROOT = 6**0.5
PLACES = np.array([(4 - _ROOT) / 10, (4 + _ROOT) / 10, 1.0])  # of the stages in an interval
A = np.array(
    [
        [(88 - 7 * _ROOT) / 360, (296 - 169 * _ROOT) / 1800, (-2 + 3 * _ROOT) / 225],
        [(296 + 169 * _ROOT) / 1800, (88 + 7 * _ROOT) / 360, (-2 - 3 * _ROOT) / 225],
        [(16 - _ROOT) / 36, (16 + _ROOT) / 36, 1 / 9],
    ]
)


class Flow(Protocol):
    """What a system must give."""

    def rates(self, z: np.ndarray, v: float) -> np.ndarray:
        """f at each of m states, shape (m, n) -> (m, n)."""

    def slopes(self, z: np.ndarray, v: float) -> np.ndarray:
        """df/dz, shape (m, n) -> (m, n, n)."""

    def by_parameter(self, z: np.ndarray, v: float) -> np.ndarray:
        """df/dv, shape (m, n) -> (m, n)."""


@dataclass(frozen=True, eq=False)
class Cycle:
    """A periodic motion.

    Attributes
    ----------
    v : float
        The parameter.
    frequency : float
        Hz.
    z : array, shape (N, 3, n)
        States at PLACES of N even intervals of the period.
    multiplier : float
        The largest size of Floquet's multipliers, that of the cycle itself left out.
    error : float
        How far that of the cycle itself is from 1.
    """

    v: float
    frequency: float
    z: np.ndarray
    multiplier: float
    error: float

    @property
    def is_stable(self) -> bool:
        """Whether small disturbances die out."""
        return self.multiplier < 1.0 - max(NEUTRAL, self.error)

    @property
    def is_unstable(self) -> bool:
        """Whether a small disturbance grows; a cycle may be neither stable nor unstable to the accuracy of the multipliers."""
        return self.multiplier > 1.0 + max(NEUTRAL, self.error)

    def amplitudes(self) -> np.ndarray:
        """Half of what each state spans over the period, between the places too, shape (n,)."""
        begin = np.roll(self.z[:, 2], 1, axis=0)
        fine = np.einsum("ks,isn->ikn", _between(), np.concatenate([begin[:, None], self.z], axis=1)).reshape(-1, self.z.shape[2])
        return np.asarray((fine.max(axis=0) - fine.min(axis=0)) / 2)


def _between() -> np.ndarray:
    """Lagrange's polynomials of an interval's begin and stages at eight places, shape (8, 4)."""
    nodes, at = np.append(0.0, PLACES), np.linspace(0.125, 1.0, 8)
    others = [np.delete(nodes, k) for k in range(4)]
    return np.array([[np.prod((t - o) / (nodes[k] - o)) for k, o in enumerate(others)] for t in at])


class Arc:
    """Equations (1) and (2) and one for the length of a step, over the states of all places, w and v."""

    def __init__(self, flow: Flow, intervals: int, shape: np.ndarray, w: float, v: float) -> None:
        self.flow, self.N, self.n = flow, intervals, shape.size
        self.phases = 2 * np.pi * (np.arange(intervals)[:, None] + PLACES) / intervals
        size = np.abs(shape)
        counts = size > 1e-6 * size.max()
        self._scale = np.where(counts, 1.0 / np.where(counts, size, 1.0) ** 2, 0.0) / (1.5 * intervals * counts.sum())
        self._weight = np.concatenate([np.tile(self._scale, 3 * intervals), [0.0, 1.0 / v**2]])

    def length(self, step: np.ndarray) -> float:
        """Of a step."""
        return float(np.sqrt(np.sum(self._weight * step**2)))

    def share(self, change: float) -> float:
        """Of a change of v, in the size that counts as one."""
        return abs(change) * float(np.sqrt(self._weight[-1]))

    def size(self, at: np.ndarray) -> float:
        """Of a cycle, its mean left out."""
        z = at[:-2].reshape(-1, self.n)
        return self.length(np.concatenate([(z - z.mean(axis=0)).ravel(), [0.0, 0.0]]))

    def _rates(self, at: np.ndarray) -> np.ndarray:
        return self.flow.rates(at[:-2].reshape(-1, self.n), at[-1]).reshape(self.N, 3, self.n)

    def corrected(self, guess: np.ndarray, along: np.ndarray, before: np.ndarray) -> tuple[np.ndarray, np.ndarray, int] | None:
        """The cycle whose step from `before` is as long, the direction there, and how many steps it took; None for none."""
        at, last = guess, np.inf
        rows = np.zeros((2, guess.size))
        rows[0, :-2] = (self._rates(guess) * self._scale).ravel()
        rows[1] = self._weight * along
        for count in range(1, NEWTON + 1):
            try:
                step, ahead = self._newton(at, at - guess, rows)
            except np.linalg.LinAlgError:
                return None
            at, size = at + step, self.length(step)
            if not np.isfinite(size) or (size > 10 * last and count > 2):
                return None
            last = size
            if size < ENOUGH:
                return (at, ahead / self.length(ahead), count) if at[-2] > 0.0 else None
        return None

    def _newton(self, at: np.ndarray, away: np.ndarray, rows: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """A step of Newton's method, and what the unknowns do where the step along the branch gets longer."""
        N, n = self.N, self.n
        within, _ = self._intervals(at)  # of an interval's stages: by its begin, by w, by v, and alone; shape (N, 3 n, n + 3)
        total = np.zeros((N, 3 * n, n + 3))  # the same by the begin of the period
        begin = np.eye(n, n + 3)
        for i in range(N):
            total[i] = within[i, :, :n] @ begin
            total[i, :, n:] += within[i, :, n:]
            begin = total[i, 2 * n :]
        last = np.zeros((n + 2, n + 3))
        last[:n] = np.eye(n, n + 3) - begin
        flat = total.reshape(-1, n + 3)
        last[n:] = rows[:, :-2] @ flat
        last[n:, n : n + 2] += rows[:, -2:]
        value = -last[:, n + 2]
        value[n:] -= rows @ away
        found = np.linalg.solve(last[:, : n + 2], np.column_stack([value, np.eye(1, n + 2, n + 1).ravel()]))
        step = np.concatenate([flat[:, : n + 2] @ found[:, 0] + flat[:, n + 2], found[n:, 0]])
        return step, np.concatenate([flat[:, : n + 2] @ found[:, 1], found[n:, 1]])

    def _intervals(self, at: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Of every interval the linearised stages, shape (N, 3 n, n + 3), and what becomes of its begin, (N, n, n)."""
        N, n = self.N, self.n
        z, w, v = at[:-2].reshape(N, 3, n), at[-2], at[-1]
        h = 2 * np.pi / w / N
        rates, flat = self._rates(at), z.reshape(-1, n)
        slopes = self.flow.slopes(flat, v).reshape(N, 3, n, n)
        by_v = self.flow.by_parameter(flat, v).reshape(N, 3, n)
        matrix = -h * np.einsum("sr,irab->isarb", A, slopes).reshape(N, 3 * n, 3 * n)
        matrix[:, np.arange(3 * n), np.arange(3 * n)] += 1.0
        moved = h * np.einsum("sr,irn->isn", A, rates)
        right = np.empty((N, 3 * n, n + 3))
        right[:, :, :n] = np.tile(np.eye(n), (3, 1))
        right[:, :, n] = -moved.reshape(N, -1) / w
        right[:, :, n + 1] = h * np.einsum("sr,irn->isn", A, by_v).reshape(N, -1)
        right[:, :, n + 2] = (np.roll(z[:, 2], 1, axis=0)[:, None] + moved - z).reshape(N, -1)
        within = np.linalg.solve(matrix, right)
        return within, within[:, 2 * n :, :n]

    def fold(self, here: np.ndarray, along: np.ndarray, step: float, ahead: np.ndarray) -> np.ndarray:
        """Where v turns within a step, by the secant method over its length."""
        low, high, before, after = 0.0, step, along[-1], ahead[-1]
        at = here
        for _ in range(8):
            part = low + (high - low) * min(max(before / (before - after), 0.1), 0.9)
            found = self.corrected(here + part * along, along, here)
            if found is None:
                break
            at, turned, _ = found
            if turned[-1] * before > 0.0:
                low, before = part, turned[-1]
            else:
                high, after = part, turned[-1]
        return at

    def cycle(self, at: np.ndarray) -> Cycle:
        """What `at` says."""
        growth = np.eye(self.n)
        for one in self._intervals(at)[1]:
            growth = one @ growth
        values = np.linalg.eigvals(growth)
        own = int(np.argmin(np.abs(values - 1.0)))
        others = float(np.abs(np.delete(values, own)).max(initial=0.0))
        z = at[:-2].reshape(self.N, 3, self.n)
        return Cycle(float(at[-1]), float(at[-2]) / (2 * np.pi), z, others, float(abs(values[own] - 1.0)))
