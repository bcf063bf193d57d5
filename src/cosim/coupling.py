"""Coupling algorithms: which input polynomial each slave follows over a macro step, and in which order they step.

With y known at t_n, t_n - h, ... a slave that steps from t_n to t_n + h follows the polynomial of degree k through the
last k + 1 values of its sources (extrapolation), or, where a source has stepped already, through that source's new value
and the k before it (interpolation). The inputs are then wrong by O(h^(k+1)) and so, at the end of a run, are the states:
the order is k + 1 for Jacobi and for Gauss-Seidel.

A cold start has no history. A step with inputs of degree k - 1 costs O(h^(k+1)) once, which keeps the order; so the first
steps are done twice where the slaves can go back: extrapolate, look at the outcome, go back, interpolate through it. That
gains one degree for each of them, and with it the order.
Source: Kuebler and Schiehlen, Modular simulation in multibody system dynamics (2000), for the schemes.
"""

from abc import ABC, abstractmethod
from collections.abc import Sequence
from dataclasses import dataclass, field
from functools import lru_cache

import numpy as np

from cosim.network import Network

MAX_DEGREE = 2


class History:
    """Outputs at the last communication points, newest first, `step` (s) apart; `t` (s) is the newest one's time."""

    def __init__(self, t: float, Y: np.ndarray, step: float) -> None:
        self.t, self.step = t, step
        self.Y: list[np.ndarray] = [Y]

    def push(self, t: float, Y: np.ndarray) -> None:
        """Add the newest point and forget what no degree needs."""
        self.t = t
        self.Y.insert(0, Y)
        del self.Y[MAX_DEGREE + 1 :]

    def polynomial(self, degree: int) -> np.ndarray:
        """C, shape (3, n_Y): value and derivatives at the newest point of the polynomial through the newest degree + 1."""
        weights = _weights(tuple(-j * self.step for j in range(degree + 1)))
        return weights @ np.array(self.Y[: degree + 1])

    def through(self, h: float, Y_next: np.ndarray, degree: int) -> np.ndarray:
        """As polynomial(), but through the values Y_next, h (s) ahead, and the newest `degree` points."""
        weights = _weights((h, *(-j * self.step for j in range(degree))))
        return weights @ np.array([Y_next, *self.Y[:degree]])


@lru_cache(maxsize=64)
def _weights(s: tuple[float, ...]) -> np.ndarray:
    """Shape (3, len(s)): value, first and second derivative at 0 of the polynomial through values at the times s (s)."""
    n = len(s)
    unit = max(map(abs, s)) or 1.0
    powers = np.vander(np.array(s) / unit, n, increasing=True)
    coefficients = np.linalg.inv(powers) / unit ** np.arange(n)[:, None]  # row m: coefficient of s^m
    weights = np.zeros((3, n))
    weights[:n] = coefficients * np.array([1.0, 1.0, 2.0])[:n, None]
    return weights


def projected(U: np.ndarray, h: float, degree: int) -> np.ndarray:
    """The least-squares projection over [0, h] of an input polynomial U, shape (3, n_u), on a lower degree.

    A slave that follows constant inputs then sees the mean, one that follows linear ones the best line: constant keeps
    order 2, linear order 3, where cutting the polynomial off would lose one.
    """
    if degree >= MAX_DEGREE or not U[degree + 1 :].any():
        return U
    value, slope, curvature = U[0].copy(), U[1].copy(), U[2]
    value -= curvature * h**2 / 12  # s^2 / 2 is on [0, h] nearest to h s / 2 - h^2 / 12
    slope += curvature * h / 2
    if degree == 0:
        value, slope = value + slope * h / 2, np.zeros_like(slope)
    return np.array([value, slope, np.zeros_like(slope)])


@dataclass(frozen=True)
class Algorithm(ABC):
    """A coupling algorithm with input polynomials of `degree` 0, 1 or 2."""

    degree: int = 1

    def __post_init__(self) -> None:
        if self.degree not in range(MAX_DEGREE + 1):
            raise ValueError(f"degree must be 0, 1 or 2, got {self.degree!r}")

    @property
    def order(self) -> int:
        """The order of the error of the states in the macro step."""
        return self.degree + 1

    @property
    @abstractmethod
    def name(self) -> str:
        """As the command line writes it."""

    @abstractmethod
    def sweep(self, network: Network, history: History, h: float, degree: int) -> tuple[np.ndarray, list[np.ndarray]]:
        """Step every slave from the newest point over h (s); returns consistent Y there and the inputs that were used."""

    def advance(self, network: Network, history: History, h: float) -> tuple[np.ndarray, list[np.ndarray]]:
        """One macro step; as sweep(), with the first steps repeated where the history is too short for the order."""
        degree = min(self.degree, len(history.Y) - 1)
        if degree == self.degree or not all(slave.can_restore for slave in network.slaves):
            return self.sweep(network, history, h, degree)
        states = [slave.save() for slave in network.slaves]
        Y, _ = self.sweep(network, history, h, degree)
        for slave, state in zip(network.slaves, states, strict=True):
            slave.restore(state)
            slave.discard(state)
        C = history.through(h, Y, degree + 1)
        used = [step(network, i, C, history.t, h) for i in range(len(network.slaves))]
        return network.outputs(Y.copy(), history.t + h), used


def step(network: Network, i: int, C: np.ndarray, t: float, h: float) -> np.ndarray:
    """Step slave i over h (s) under the polynomials C of all outputs; returns the U that it followed."""
    slave = network.slaves[i]
    U = projected(network.inputs(i, C), h, slave.input_degree)
    network.step(i, U, t, h)
    return U


@dataclass(frozen=True)
class Jacobi(Algorithm):
    """All slaves step from the same extrapolation, as if side by side. Order degree + 1."""

    @property
    def name(self) -> str:
        return "jacobi"

    def sweep(self, network: Network, history: History, h: float, degree: int) -> tuple[np.ndarray, list[np.ndarray]]:
        t = history.t
        C = history.polynomial(degree)
        used = [step(network, i, C, t, h) for i in range(len(network.slaves))]
        return network.outputs(history.Y[0].copy(), t + h), used


@dataclass(frozen=True)
class GaussSeidel(Algorithm):
    """Slaves step one after another; the later ones interpolate what the earlier ones have reached. Order degree + 1.

    sequence : component names in the order of stepping; empty for the order in which outputs depend on inputs.
    """

    sequence: Sequence[str] = field(default=())

    @property
    def name(self) -> str:
        return "gauss-seidel"

    def sweep(self, network: Network, history: History, h: float, degree: int) -> tuple[np.ndarray, list[np.ndarray]]:
        t = history.t
        C = history.polynomial(degree)
        Y = history.Y[0] + h * (C[1] + h * C[2] / 2)  # a guess, replaced slave by slave
        used: list[np.ndarray] = [np.empty(0)] * len(network.slaves)
        for i in network.sequence(self.sequence):
            U = used[i] = step(network, i, C, t, h)
            part = network.slices[i]
            Y[part] = network.slaves[i].output(U[0] + h * (U[1] + h * U[2] / 2), t + h)
            C[:, part] = history.through(h, Y, min(self.degree, len(history.Y)))[:, part]
        return network.outputs(Y, t + h), used


ALGORITHMS: dict[str, type[Algorithm]] = {"jacobi": Jacobi, "gauss-seidel": GaussSeidel}


def algorithm(name: str, degree: int, sequence: Sequence[str] = ()) -> Algorithm:
    """The algorithm that the command line calls `name`."""
    if name not in ALGORITHMS:
        raise ValueError(f"algorithm must be one of {', '.join(ALGORITHMS)}, got {name!r}")
    if sequence and name != "gauss-seidel":
        raise ValueError(f"a sequence of components goes with gauss-seidel only, got {name!r}")
    return GaussSeidel(degree, tuple(sequence)) if name == "gauss-seidel" else ALGORITHMS[name](degree)
