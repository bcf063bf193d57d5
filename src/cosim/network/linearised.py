"""Slaves linearised where they stand, stepped exactly: for stability margins and interface Jacobians of any algorithm.

    x' = A x + B u,   y = C x + D u      (deviations from the present state and inputs)

Over a step of h with inputs u(s) = U_0 + U_1 s + U_2 s^2 / 2 the solution is exact:

    x(h) = e^{Ah} x + G_0 U_0 + G_1 U_1 + G_2 U_2,   G_k = integral of e^{A(h - s)} B s^k / k! ds,

all from one exponential of the matrix of (x, u, u', u'').
"""

from collections.abc import Mapping
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any

import numpy as np

from ..slaves.base import Linearisable, Restorable, Slave, StateSpace, linearisation
from .network import Network


def exact_step(
    A: np.ndarray, B: np.ndarray, h: float, rate: np.ndarray | None = None
) -> tuple[np.ndarray, list[np.ndarray], np.ndarray]:
    """The exact step of x' = A x + B u + rate over `h`, with u a polynomial of degree 2, from one matrix exponential.

    Parameters
    ----------
    A, B
        Shapes (n, n) and (n, m).
    h
        Length of the step, s.
    rate
        The constant part of x', shape (n,); zero where None.

    Returns
    -------
    transition, G, forced
        e^{Ah}, shape (n, n); the integrals of e^{A(h - s)} B s^k / k! for k = 0, 1, 2, each of shape (n, m); and that of
        e^{A(h - s)} rate, shape (n,).

    References
    ----------
    Van Loan, Computing integrals involving the matrix exponential, IEEE Trans. Automatic Control 23 (1978).
    """
    from scipy.linalg import expm

    n, m = B.shape
    whole = np.zeros((n + 3 * m + (rate is not None),) * 2)
    whole[:n, :n], whole[:n, n : n + m] = A, B
    whole[n : n + 2 * m, n + m : n + 3 * m] = np.eye(2 * m)
    if rate is not None:
        whole[:n, -1] = rate
    end = expm(whole * h)
    forced = end[:n, -1] if rate is not None else np.zeros(n)
    return end[:n, :n], [end[:n, n + k * m : n + (k + 1) * m] for k in range(3)], forced


class LinearSlave(Restorable, Linearisable):
    """A slave's linearisation in its place: same name, signals and abilities, values are deviations."""

    def __init__(self, slave: Slave, space: StateSpace) -> None:
        self.name, self.space = slave.name, space
        self.description = replace(
            slave.description, settable={}, initial_feedthrough=slave.description.feedthrough, can_restore=True,
            can_serialize=False, counts_events=False,
        )  # fmt: skip
        self.x = np.zeros(len(space.A))
        self._steps: dict[float, tuple[np.ndarray, list[np.ndarray]]] = {}

    def begin(self, values: Mapping[str, Any], t: float, stop: float) -> None:
        self.x = np.zeros(len(self.space.A))

    def finish(self) -> None:
        pass

    def output(self, u: np.ndarray, t: float) -> np.ndarray:
        return np.asarray(self.space.C @ self.x + self.space.D @ u)

    def step(self, U: np.ndarray, t: float, h: float) -> None:
        transition, G = self._over(h)
        self.x = transition @ self.x + G[0] @ U[0] + G[1] @ U[1] + G[2] @ U[2]

    def _over(self, h: float) -> tuple[np.ndarray, list[np.ndarray]]:
        """e^{Ah} and G_0, G_1, G_2, kept for the lengths seen."""
        if h not in self._steps:
            self._steps[h] = exact_step(self.space.A, self.space.B, h)[:2]
        return self._steps[h]

    def save(self) -> Any:
        return self.x.copy()

    def restore(self, snapshot: Any) -> None:
        self.x = snapshot.copy()

    def discard(self, snapshot: Any) -> None:
        pass

    def state_space(self) -> StateSpace:
        return self.space

    def close(self) -> None:
        pass


@dataclass(frozen=True, eq=False)
class Linearised:
    """A network of linear slaves in the place of another network's."""

    network: Network
    slaves: tuple[LinearSlave, ...]

    @cached_property
    def size(self) -> int:
        """Number of states of all slaves together."""
        return sum(slave.x.size for slave in self.slaves)

    def states(self) -> np.ndarray:
        """x of all slaves, shape (size,)."""
        return np.concatenate([slave.x for slave in self.slaves])

    def put(self, x: np.ndarray) -> None:
        """Set x of all slaves."""
        ends = np.cumsum([0, *(slave.x.size for slave in self.slaves)])
        for slave, a, b in zip(self.slaves, ends[:-1], ends[1:], strict=True):
            slave.restore(x[a:b])

    def joined(self) -> np.ndarray:
        """The matrix of the whole system without coupling error: x' = A x, shape (size, size)."""
        A = np.zeros((self.size, self.size))
        ends = np.cumsum([0, *(slave.x.size for slave in self.slaves)])
        for column in range(self.size):
            unit = np.zeros(self.size)
            unit[column] = 1.0
            self.put(unit)
            Y = self.network.outputs(np.zeros(len(self.network.names)), 0.0)
            C = np.vstack([Y, np.zeros((2, Y.size))])
            for i, slave in enumerate(self.slaves):
                A[ends[i] : ends[i + 1], column] = slave.space.A @ slave.x + slave.space.B @ self.network.inputs(i, C)[0]
        return A


def linearise_network(network: Network) -> Linearised | None:
    """The network with every slave linearised at its present state; None where a slave does not give its derivatives."""
    slaves: list[LinearSlave] = []
    if network.tabled or network.held.size:
        return None
    for slave in network.slaves:
        space = linearisation(slave)
        if space is None:
            return None
        slaves.append(LinearSlave(slave, space))
    return Linearised(network.of_deviations(slaves), tuple(slaves))
