"""What a release costs: the integral of squared signals after a system at rest is let go from displaced states.

    J(q, s) = sum over releases of  integral_0^inf e^{-2 s t} |W z|^2 dt,    z' = A(q) z,  z(0) = z_0

Two Lyapunov equations give J and all its derivatives, without any simulation:

    A_s' P + P A_s + W' W = 0,   A_s X + X A_s' + Z = 0,   A_s = A - s I,   Z = sum z_0 z_0'
    J = tr(P Z),   dJ/dq = 2 tr(P dA/dq X),   dJ/ds = -2 tr(P X)

The decay rate of the slowest root has a kink wherever two roots change places, and where two meet its slope is infinite:
no gradient method can trust it. J is smooth in q wherever the roots stay left of s. Held at a large value instead, s
itself is a smooth measure of stability, just to the right of the slowest root, for systems that nothing stabilises too:
the smoothed spectral abscissa of Vanbiervliet et al. 2009, SIAM J. Optim. 20, p. 156.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from ..errors import unknown
from .at_rest import AtRest

START = 0.1  # 1/s, how far right of the rightmost root the search for a level begins
LONGEST_STEP = 5.0  # where Newton leads astray on the way to the right, in the logarithm of that distance
MOST_STEPS = 60  # of Newton; some five are needed
CLOSE = 1e-4  # the step that is the last: Newton squares it


@dataclass(frozen=True, eq=False)
class Release:
    """What is let go, and what of it counts; see the module's docstring.

    Parameters
    ----------
    rest
        The system linearised at rest.
    starts
        For each release the states, by their names in `rest.states`, that are not zero at its begin.
    scales
        State -> size, in its unit, that counts as 1 in the integral; other states do not count.
    """

    rest: AtRest
    starts: Sequence[Mapping[str, float]]
    scales: Mapping[str, float]

    def __post_init__(self) -> None:
        """Refuse names that are no states, and scales that are not positive."""
        for name in (*self.scales, *(name for start in self.starts for name in start)):
            if name not in self.rest.states:
                raise unknown("state at rest:", name, self.rest.states)
        for name, scale in self.scales.items():
            if not (np.isfinite(scale) and scale > 0.0):
                raise ValueError(f"scale of {name!r} must be positive, got {scale:g}")

    def _row(self, values: Mapping[str, float]) -> np.ndarray:
        z = np.zeros(len(self.rest.states))
        for name, value in values.items():
            z[self.rest.states.index(name)] = value
        return z

    @property
    def begin(self) -> np.ndarray:
        """z at the begin of each release, shape (n, number of releases)."""
        return np.array([self._row(start) for start in self.starts]).reshape(-1, len(self.rest.states)).T

    @property
    def weight(self) -> np.ndarray:
        """W' W, shape (n, n)."""
        return np.diag(self._row({name: scale**-2 for name, scale in self.scales.items()}))

    def cost(self, q: Sequence[float] | np.ndarray, *, until: float = np.inf) -> float:
        """The cost of the releases, exact.

        Parameters
        ----------
        q
            Parameters, shape (n_q,).
        until
            The end of the integral, s; infinite for all time.

        Returns
        -------
        J
            In s; infinite where all time counts and a root is not left of the imaginary axis.
        """
        A = self.rest.matrix(q)
        if np.isfinite(until):
            P = _gramian(A, self.weight, until)
        elif np.linalg.eigvals(A).real.max() < 0.0:
            P = _lyapunov(A.T, self.weight)
        else:
            return np.inf
        return float(np.sum(self.begin * (P @ self.begin)))

    def gradient(self, q: Sequence[float] | np.ndarray, shift: float = 0.0) -> tuple[float, np.ndarray, float]:
        """The cost over all time and its derivatives.

        Parameters
        ----------
        q
            Parameters, shape (n_q,).
        shift
            s, in 1/s.

        Returns
        -------
        J, by_q, by_s
            The cost in s; dJ/dq, shape (n_q,); dJ/ds. Infinite and NaN where a root is not left of `shift`.
        """
        A = self.rest.matrix(q) - shift * np.eye(len(self.rest.states))
        if np.linalg.eigvals(A).real.max() >= 0.0:
            return np.inf, np.full(len(self.rest.free), np.nan), np.nan
        Z = self.begin @ self.begin.T
        P, X = _lyapunov(A.T, self.weight), _lyapunov(A, Z)
        slopes = np.array([2 * np.sum((P @ dA) * X) for dA in self.rest.derivatives(q)])
        return float(np.sum(P * Z)), slopes, float(-2 * np.sum(P * X))

    def smoothed_growth(self, q: Sequence[float] | np.ndarray, level: float) -> tuple[float, np.ndarray]:
        """The growth, smoothed from the right: the s at which J(q, s) has a given size.

        Parameters
        ----------
        q
            Parameters, shape (n_q,).
        level
            The size, s; the larger, the nearer is s to the largest real part of a root.

        Returns
        -------
        s, slope
            In 1/s; ds/dq, shape (n_q,).

        Raises
        ------
        ValueError
            Where the releases do not reach the level.
        """
        if not (np.isfinite(level) and level > 0.0):
            raise ValueError(f"`level` must be positive, got {level:g} s")
        roots = self.rest.roots(q)
        low, least = float(roots.real.max()), 1e-10 * float(np.abs(roots).max())  # within it of the root all is rounding
        left, right, x = np.log(least), np.inf, np.log(START)
        for _ in range(MOST_STEPS):  # Newton over x = log(s - low): next to a root J is as 1 / (s - low), log J as -x
            J, by_q, by_s = self.gradient(q, low + np.exp(x))
            if not J > 0.0:
                break
            excess = np.log(J / level)
            step = excess / (-by_s / J * np.exp(x)) if np.isfinite(J) else 1.0
            if abs(step) < CLOSE:
                return low + float(np.exp(x + step)), -by_q / by_s
            left, right = (x, right) if excess > 0.0 else (left, x)
            x = x + step if left < x + step < right else (left + right) / 2 if right < np.inf else x + LONGEST_STEP
            if right - np.log(least) < CLOSE:  # the releases hardly excite the root
                break
        raise ValueError(f"`level` must be one that the releases reach to the right of {low:g} 1/s, got {level:g} s")


def _lyapunov(A: np.ndarray, Q: np.ndarray) -> np.ndarray:
    """P of A P + P A' + Q = 0, in scaled states: rates from a metre per hour to kilohertz would cost half the digits."""
    from scipy.linalg import matrix_balance, solve_continuous_lyapunov

    scaled, (t, _) = matrix_balance(A, permute=False, separate=True)
    return np.asarray(t[:, None] * solve_continuous_lyapunov(scaled, -Q / t[:, None] / t) * t)


def _gramian(A: np.ndarray, Q: np.ndarray, until: float) -> np.ndarray:
    """The integral of e^{A' t} Q e^{A t} from 0 to `until` (s), whether or not anything decays.

    Van Loan's exponential over a time so short that no root explodes in it, then doubled: P(2T) = P(T) + E(T)' P(T) E(T).
    """
    from scipy.linalg import expm, matrix_balance

    n = len(A)
    scaled, (t, _) = matrix_balance(A, permute=False, separate=True)
    doublings = max(0, int(np.ceil(np.log2(np.abs(scaled).sum(axis=0).max() * until))))
    whole = expm(np.block([[-scaled.T, t[:, None] * Q * t], [np.zeros((n, n)), scaled]]) * (until / 2**doublings))
    E = whole[n:, n:]
    P = E.T @ whole[:n, n:]
    for _ in range(doublings):
        P, E = P + E.T @ P @ E, E @ E
    return np.asarray(P / t[:, None] / t)
