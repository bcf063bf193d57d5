"""A system of components as its master sees it, linearised at the start: sampled at the communication points, with delays.

Between communication points each component follows, exactly, x' = A x + B u + f and y = C x + D u, deviations from the start,
where f is the rate there. Under the inputs of Jacobi with degree k, u(s) = U_0 + U_1 s + U_2 s^2 / 2 through the last k + 1
values, a macro step is

    x_{n+1} = Phi x_n + F + sum_j G_j U_j,   U_j = L sum_i P_ji w_{n-i},   w_n = (delay, compensator) v_n,
    v_n = C x_n + D L w_n,

L the wiring, v what components send, w what arrives, a filter of hil/compensation.py on the delayed rows. Together: s_{n+1} =
M s_n + m with s = (x, old v of the delayed rows, old w), whose eigenvalues decide on stability.
"""

from dataclasses import dataclass

import casadi as ca
import numpy as np

from ..accuracy.monolith import with_equations
from ..network import Network
from ..network.linearised import exact_step
from ..slaves.in_process import ComponentSlave
from ..systems import System
from .compensation import Taps

__all__ = ["SampledModel", "linearise"]


@dataclass(frozen=True, eq=False)
class SampledModel:
    """The linearised system, with n states, u inputs and y outputs of all components.

    Parameters
    ----------
    A, B, C, D
        Shapes (n, n), (n, u), (y, n) and (y, u); see the module's docstring.
    L
        The wiring, shape (u, y).
    rate, start
        x' and the outputs at the start, shapes (n,) and (y,).
    names, units
        Of the outputs.
    delayed
        Places in y of the efforts that the delayed components send over their bonds.
    """

    A: np.ndarray
    B: np.ndarray
    C: np.ndarray
    D: np.ndarray
    L: np.ndarray
    rate: np.ndarray
    start: np.ndarray
    names: tuple[str, ...]
    units: tuple[str, ...]
    delayed: np.ndarray

    def one_step(self, taps: Taps, degree: int, h: float) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """The map of a macro step, for deviations from the start.

        Parameters
        ----------
        taps
            Of delay and compensator.
        degree
            Of the extrapolation of inputs.
        h
            The macro step, s.

        Returns
        -------
        M, m, W
            Shapes (s, s), (s,) and (y, s); what arrives is w = W s.
        """
        y, n = self.C.shape
        transition, G, forced = exact_step(self.A, self.B, h, self.rate)
        wired = np.flatnonzero(np.abs(self.L).any(axis=0))
        q, r, nb, na = self.delayed.size, wired.size, taps.b.size - 1, taps.a.size
        kept = max(degree, na)  # old w of the wired rows
        size = n + nb * q + kept * r
        mine = [list(wired).index(k) for k in self.delayed]

        # what arrives now: w = E w + H s, with E from direct feedthrough
        E, H = self.D @ self.L, np.zeros((y, size))
        H[:, :n] = self.C
        E[self.delayed] *= taps.b[0]
        H[self.delayed] *= taps.b[0]
        for j in range(nb):
            H[self.delayed, n + j * q + np.arange(q)] += taps.b[1 + j]
        for j in range(na):
            H[self.delayed, n + nb * q + j * r + np.array(mine, dtype=int)] += taps.a[j]
        W = np.linalg.solve(np.eye(y) - E, H)

        # w of this and earlier points, as rows over s
        past = [W] + [np.zeros((y, size)) for _ in range(degree)]
        for j in range(degree):
            past[1 + j][wired, n + nb * q + j * r + np.arange(r)] = 1.0
        M = np.zeros((size, size))
        M[:n, :n] = transition
        for G_j, row in zip(G, _derivatives(degree, h), strict=True):
            M[:n] += G_j @ self.L @ sum(weight * w for weight, w in zip(row, past, strict=True))
        if nb:
            sent = self.C[self.delayed] @ np.eye(n, size) + (self.D @ self.L)[self.delayed] @ W
            M[n : n + q] = sent
            M[n + q : n + nb * q, n : n + (nb - 1) * q] = np.eye((nb - 1) * q)
        if kept:
            M[n + nb * q : n + nb * q + r] = W[wired]
            M[n + nb * q + r :, n + nb * q : n + nb * q + (kept - 1) * r] = np.eye((kept - 1) * r)
        m = np.zeros(size)
        m[:n] = forced
        return M, m, W

    def radius(self, taps: Taps, degree: int, h: float) -> float:
        """The largest size of an eigenvalue of the macro step; above 1 the run grows."""
        M, _, _ = self.one_step(taps, degree, h)
        return float(np.abs(np.linalg.eigvals(M)).max())

    def run(self, taps: Taps, degree: int, h: float, steps: int) -> np.ndarray:
        """All arriving values at 0, h, ..., shape (steps + 1, y), from the start state."""
        M, m, W = self.one_step(taps, degree, h)
        s, rows = np.zeros(m.size), []
        for _ in range(steps + 1):
            rows.append(W @ s)
            s = M @ s + m
        return np.asarray(np.array(rows) + self.start)


def linearise(system: System, component: str) -> SampledModel:
    """Linearise a system at its start.

    Parameters
    ----------
    system
        Of catalogue components, without sampled parts.
    component
        The component whose efforts arrive late, or what addresses several ("gyro").

    Returns
    -------
    SampledModel

    Raises
    ------
    ValueError
        Where a component has no equations here, or `component` has no power bonds.
    """
    components = with_equations(system)
    network = Network(system, [ComponentSlave(p.name, c) for p, c in zip(system.components, components, strict=True)])
    Y = network.initialize(0.0, 1.0)
    n, m = sum(len(c.states) for c in components), sum(len(c.inputs) for c in components)
    A, B, C = np.zeros((n, n)), np.zeros((n, m)), np.zeros((Y.size, n))
    D, L, rate = np.zeros((Y.size, m)), np.zeros((m, Y.size)), np.zeros(n)
    a = b = 0
    for i, c in enumerate(components):
        values, rows = network.values[i], network.slices[i]
        x, p = (np.array([values.get(v.name, v.start) for v in part]) for part in (c.states, c.parameters))
        u = network.inputs(i, Y[None, :])[0]
        X, U = ca.MX.sym("x", x.size), ca.MX.sym("u", u.size)
        here, there = slice(a, a + x.size), slice(b, b + u.size)
        for function, by_x, by_u in ((c.rhs, A[here, here], B[here, there]), (c.output, C[rows, here], D[rows, there])):
            value = function(X, U, p)
            jacobians = ca.Function("j", [X, U], [ca.densify(ca.jacobian(value, X)), ca.densify(ca.jacobian(value, U))])
            by_x[:], by_u[:] = (np.array(part) for part in jacobians(x, u))
        rate[here] = np.array(c.rhs(x, u, p)).ravel()
        for wire in network.wires(i):
            L[b + wire[1], wire[0]] = wire[2]
        a, b = a + x.size, b + u.size
    chosen = system.addressed(component)
    delayed = [bond.effort for bond in network.bonds if network.slaves[bond.motion_input[0]].name in chosen]
    if not delayed:
        raise ValueError(f"system {system.name!r} must have power bonds with {component!r}")
    return SampledModel(A, B, C, D, L, rate, Y, network.names, network.units, np.array(sorted(set(delayed))))


def _derivatives(degree: int, h: float) -> np.ndarray:
    """Shape (3, degree + 1): value and derivatives at the newest point of the polynomial through the last degree + 1."""
    return {
        0: np.array([[1.0], [0.0], [0.0]]),
        1: np.array([[1.0, 0.0], [1 / h, -1 / h], [0.0, 0.0]]),
        2: np.array([[1.0, 0.0, 0.0], [1.5 / h, -2 / h, 0.5 / h], [1 / h**2, -2 / h**2, 1 / h**2]]),
    }[degree]
