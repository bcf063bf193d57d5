"""A system linearised at rest, over a few of its parameters, without the coordinates that nothing depends on.

    z' = A(q) z

z are the states less their values at rest, which are zero. A vehicle on straight track may stand anywhere along it: a common
shift of all distances run changes no rate, so A has a root at zero that says nothing about stability. It is removed by
structure: the distances are replaced by their differences from the first one, and that such a shift does nothing is
checked, not assumed.
"""

from collections.abc import Sequence
from functools import cached_property

import casadi as ca
import numpy as np

from ..accuracy.monolith import Monolith
from ..errors import unknown
from ..systems import System
from ..trajectory import matching

NEWTON, SETTLED = 20, 1e-10  # steps; the last one is smaller than this, each state in its SI unit
SAME = 1e-9  # of the matrix's largest element: what a shift may change of a rate by rounding


class AtRest:
    """A system linearised at rest; see the module's docstring.

    Parameters
    ----------
    system
        Of catalogue components, at rest where all its states are zero.
    free
        The parameters q, as `component.parameter`; "gyro.rotor_speed" sets that of gyro_front and gyro_rear alike.
    ignorable
        Patterns such as "vehicle.*_distance"; the states of each may be shifted together without changing any rate.
    settled
        Look for the equilibrium near z = 0 and linearise there, for systems whose states are not all zero at rest.

    Attributes
    ----------
    states
        Names of z, n of them; the difference of two states is called "one - other".
    q0
        The system's values of q, shape (n_q,); where a name addresses several components, that of the first.

    Raises
    ------
    ValueError
        Where the system is not at rest, a shift changes a rate, or a name means nothing.
    """

    def __init__(self, system: System, free: Sequence[str], ignorable: Sequence[str] = (), *, settled: bool = False) -> None:
        self.system, self.free, self.settled = system, tuple(free), settled
        owners = [system.addressed(name.partition(".")[0]) for name in self.free]
        names = [f"{owner}.{n.partition('.')[2]}" for n, of in zip(self.free, owners, strict=True) for owner in of]
        self.monolith = Monolith(system, free=names)
        self._spread = np.zeros((len(names), len(self.free)))  # from q to the parameters of all components
        self._spread[np.arange(len(names)), np.repeat(np.arange(len(self.free)), [len(o) for o in owners])] = 1.0
        firsts = np.cumsum([0, *(len(o) for o in owners)])[:-1]
        self.q0 = self.monolith.q0[firsts] if len(names) else np.zeros(0)
        self._reduce(ignorable)
        self.matrix(self.q0)
        error = self.rest_error(self.q0)
        if not (settled or error < 1e-6):
            raise ValueError(f"system {system.name!r} must be at rest where its states are zero; it is {error:g} away from there")

    def _reduce(self, ignorable: Sequence[str]) -> None:
        """z = T x, x = S z + a shift; `_shifts`, shape (n_x, number of patterns)."""
        all_states = self.monolith.states
        n = len(all_states)
        T, labels = np.eye(n), list(all_states)
        self._patterns, self._shifts = tuple(ignorable), np.zeros((n, len(ignorable)))
        dropped = []
        for column, pattern in enumerate(ignorable):
            meant = matching(pattern, all_states)
            rows = [i for i, name in enumerate(all_states) if name in meant]
            if not rows:
                raise unknown("ignorable states:", pattern, all_states)
            self._shifts[rows, column] = 1.0
            dropped.append(rows[0])
            for i in rows[1:]:
                T[i, rows[0]] = -1.0
                labels[i] = f"{all_states[i]} - {all_states[rows[0]]}"
        keep = [i for i in range(n) if i not in dropped]
        self._T, self._S = T[keep], np.eye(n)[:, keep]
        self.states = tuple(labels[i] for i in keep)

    def parameters(self, q: Sequence[float] | np.ndarray) -> np.ndarray:
        """The monolith's free parameters for q, shape (n_q,)."""
        q = np.asarray(q, dtype=float)
        if q.shape != (len(self.free),):
            raise ValueError(f"`q` must hold a value for each of {', '.join(self.free)}, got {q.size}")
        return np.asarray(self._spread @ q)

    def matrix(self, q: Sequence[float] | np.ndarray) -> np.ndarray:
        """A at parameters q, shape (n_q,).

        Returns
        -------
        A
            Shape (n, n).

        Raises
        ------
        ValueError
            Where a shift of ignorable states changes a rate.
        """
        A = self.monolith.matrix(self.parameters(q), self.equilibrium(q) if self.settled else None)
        drift = np.abs(A @ self._shifts)
        if drift.size and drift.max() > SAME * np.abs(A).max():
            row, column = np.unravel_index(drift.argmax(), drift.shape)
            raise ValueError(
                f"states {self._patterns[column]!r} must be ignorable: a shift by 1 changes the rate of "
                f"{self.monolith.states[row]!r} by {drift.max():g}"
            )
        return np.asarray(self._T @ A @ self._S)

    @cached_property
    def _sensitivity(self) -> ca.Function:
        x, p = ca.SX.sym("x", self.monolith.x0.size), ca.SX.sym("p", self.monolith.q0.size)
        A = self.monolith.jacobian(x, p)
        rates = [ca.jtimes(ca.vec(A), p, ca.DM(column)) for column in self._spread.T]
        return ca.Function("sensitivity", [x, p], [ca.cse(ca.horzcat(*rates))])

    def derivatives(self, q: Sequence[float] | np.ndarray) -> np.ndarray:
        """dA/dq, exact, shape (n_q, n, n)."""
        n = self.monolith.x0.size
        whole = np.array(self._sensitivity(np.zeros(n), self.parameters(q)))
        return np.array([self._T @ column.reshape((n, n), order="F") @ self._S for column in whole.T])

    def equilibrium(self, q: Sequence[float] | np.ndarray) -> np.ndarray:
        """All states where nothing accelerates, near zero, shape (n_x,): Newton steps, the smallest where many would do.

        Raises
        ------
        ValueError
            Where the steps do not get smaller.
        """
        p, x = self.parameters(q), np.zeros(self.monolith.x0.size)
        for _ in range(NEWTON):
            rates = self._T @ np.array(self.monolith.f(x, p)).ravel()
            A = self._T @ self.monolith.matrix(p, x) @ self._S
            step = np.linalg.lstsq(A, rates, rcond=1e-12)[0]
            x = x - self._S @ step
            if np.abs(step).max() < SETTLED:
                return np.asarray(x)
        raise ValueError(f"system {self.system.name!r} must have an equilibrium near where its states are zero; none was found")

    def rest_error(self, q: Sequence[float] | np.ndarray) -> float:
        """How far the equilibrium is from z = 0 (the largest of the states, each in its SI unit), by one Newton step."""
        rates = np.array(self.monolith.f(np.zeros(self.monolith.x0.size), self.parameters(q))).ravel()
        return float(np.abs(np.linalg.lstsq(self.matrix(q), self._T @ rates, rcond=None)[0]).max())

    def driven(self, slope: ca.Function, q: Sequence[float]) -> np.ndarray:
        """Derivative of z' by the first of the parameters q, shape (n,); `slope` is that of the monolith's rates by its own."""
        whole = np.array(slope(self.parameters(q))) @ self._spread[:, 0]
        return np.asarray(self._T @ whole)

    def flow(self) -> "_Flow":
        """z' as a function of z and the first of the parameters q, the others as the system has them, for `limit_cycles`."""
        return _Flow(self)

    def starts(self, z: np.ndarray) -> dict[str, float]:
        """Start values, by `component.state`, that put the system at z, shape (n,): for runs in time."""
        names = (label.partition(" - ")[0] for label in self.states)
        return {name: float(value) for name, value in zip(names, z, strict=True)}

    def roots(self, q: Sequence[float] | np.ndarray) -> np.ndarray:
        """The eigenvalues of A(q), shape (n,), in order of falling real part."""
        roots = np.linalg.eigvals(self.matrix(q))
        return roots[np.lexsort((roots.imag, -roots.real))]

    def growth(self, q: Sequence[float] | np.ndarray, *, creeping: bool = True) -> float:
        """The largest real part of a root.

        Parameters
        ----------
        q
            Parameters, shape (n_q,).
        creeping
            Whether roots count that decay without oscillating.

        Returns
        -------
        growth
            In 1/s.
        """
        roots = self.roots(q)
        if not creeping:
            roots = roots[(roots.imag != 0.0) | (roots.real > 0.0)]
        return float(roots.real.max())

    def damping(self, q: Sequence[float] | np.ndarray) -> float:
        """The least damping ratio -Re s / |s| of the roots that oscillate or grow; 1 where none does."""
        roots = self.roots(q)
        roots = roots[(roots.imag != 0.0) | (roots.real > 0.0)]
        return float((-roots.real / np.abs(roots)).min(initial=1.0))

    def paths(self, q: np.ndarray) -> np.ndarray:
        """The roots along a series of parameters, sorted into continuous paths.

        Parameters
        ----------
        q
            Shape (m, n_q).

        Returns
        -------
        paths
            1/s, complex, shape (m, n); each column is one path.
        """
        from scipy.optimize import linear_sum_assignment

        along = [self.roots(q[0])]
        for values in q[1:]:
            new = self.roots(values)
            # where each root goes if it goes on as it did: paths that cross do not change hands
            ahead = 2 * along[-1] - along[-2] if len(along) > 1 else along[-1]
            _, order = linear_sum_assignment(np.abs(ahead[:, None] - new[None, :]))
            along.append(new[order])
        return np.array(along)

    def mode(self, q: Sequence[float] | np.ndarray, near: complex) -> tuple[complex, np.ndarray, np.ndarray]:
        """The root nearest to `near`, its shape and its derivatives by the parameters.

        With A v = s v and w A = s w the derivative is w dA v / (w v); where roots coincide it does not exist.

        Parameters
        ----------
        q
            Parameters, shape (n_q,).
        near
            In 1/s.

        Returns
        -------
        s, v, slope
            The root in 1/s; its vector, shape (n,), whose largest element is 1; ds/dq, shape (n_q,).
        """
        from scipy.linalg import eig

        values, left, right = eig(self.matrix(q), left=True, right=True)
        k = int(np.abs(values - near).argmin())
        w, v = left[:, k].conj(), right[:, k]
        slope = np.array([w @ dA @ v for dA in self.derivatives(q)]) / (w @ v)
        return complex(values[k]), v / v[np.abs(v).argmax()], slope


class _Flow:
    """z' = T f(S z, q) for many z at once, and its derivatives."""

    def __init__(self, rest: AtRest) -> None:
        self._rest, n = rest, len(rest.states)
        z, v = ca.SX.sym("z", n), ca.SX.sym("v")
        q = ca.vertcat(v, *map(float, rest.q0[1:]))
        rates = ca.DM(rest._T) @ rest.monolith.f(ca.DM(rest._S) @ z, ca.DM(rest._spread) @ q)
        self._functions = [
            ca.Function(name, [z, v], [ca.cse(made)])
            for name, made in (
                ("rates", rates),
                ("slopes", ca.densify(ca.jacobian(rates, z))),
                ("by_parameter", ca.densify(ca.jacobian(rates, v))),
            )
        ]

    def rates(self, z: np.ndarray, v: float) -> np.ndarray:
        return np.array(self._functions[0](z.T, v)).T

    def slopes(self, z: np.ndarray, v: float) -> np.ndarray:
        m, n = z.shape
        return np.array(self._functions[1](z.T, v)).reshape(n, m, n).transpose(1, 0, 2)

    def by_parameter(self, z: np.ndarray, v: float) -> np.ndarray:
        return np.array(self._functions[2](z.T, v)).T
