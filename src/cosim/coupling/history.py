"""What the coupling remembers: outputs at the last communication points, and polynomials through them.

With values Y_0, Y_1, Y_2 at the times s_0, s_1, s_2 (from the newest point) Newton's divided differences

    a = (Y_1 - Y_0) / (s_1 - s_0),   b = ((Y_2 - Y_1) / (s_2 - s_1) - a) / (s_2 - s_0)

give p(s) = Y_0 + a (s - s_0) + b (s - s_0)(s - s_1), so at s = 0

    p = Y_0 - a s_0 + b s_0 s_1,   p' = a - b (s_0 + s_1),   p'' = 2 b.

Every operation is elementwise and in this order, in kernel/loop.py as well, so that both give the same bits.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

MAX_DEGREE = 2


@dataclass(frozen=True, eq=False)
class History:
    """Outputs at the last communication points, newest first; a value, to which push() gives the next.

    Parameters
    ----------
    t : tuple of float
        Times (s).
    Y : tuple of ndarray, each of shape (n_Y,)
        Outputs there; nobody writes into them.
    held : ndarray of int
        Places in Y that are never extrapolated (integers, booleans, discrete signals).
    """

    t: tuple[float, ...]
    Y: tuple[np.ndarray, ...]
    held: np.ndarray

    def push(self, t: float, Y: np.ndarray) -> "History":
        """With the newest point added, and what nothing needs forgotten."""
        return self.extended((t,), (Y,))

    def extended(self, t: Sequence[float], Y: Sequence[np.ndarray]) -> "History":
        """With points added, newest first, and what nothing needs forgotten."""
        return History((*t, *self.t)[: MAX_DEGREE + 2], (*Y, *self.Y)[: MAX_DEGREE + 2], self.held)

    def polynomial(self, degree: int) -> np.ndarray:
        """C, shape (3, n_Y): value and derivatives at the newest point of the polynomial through the newest degree + 1."""
        now = self.t[0]
        return self._newton([t - now for t in self.t[: degree + 1]], self.Y[: degree + 1])

    def through(self, h: float, Y_next: np.ndarray, degree: int) -> np.ndarray:
        """As polynomial(), but through the values Y_next, h (s) ahead, and the newest `degree` points."""
        now = self.t[0]
        return self._newton([h, *(t - now for t in self.t[:degree])], [Y_next, *self.Y[:degree]])

    def _newton(self, s: Sequence[float], Y: Sequence[np.ndarray]) -> np.ndarray:
        C = np.zeros((3, Y[0].size))
        C[0] = Y[0]
        if len(s) > 1:
            a = (Y[1] - Y[0]) / (s[1] - s[0])
            if len(s) == 2:
                C[0] = Y[0] - a * s[0]
                C[1] = a
            else:
                b = ((Y[2] - Y[1]) / (s[2] - s[1]) - a) / (s[2] - s[0])
                C[0] = Y[0] - a * s[0] + b * (s[0] * s[1])
                C[1] = a - b * (s[0] + s[1])
                C[2] = 2.0 * b
            if self.held.size:
                C[0, self.held], C[1:, self.held] = Y[0][self.held], 0.0
        return C
