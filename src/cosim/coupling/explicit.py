"""Jacobi and Gauss-Seidel: every slave steps once.

With y known at t_n, t_n - h, ... a slave that steps from t_n to t_n + h follows the polynomial of degree k through the
last k + 1 values of its sources (extrapolation), or, where a source has stepped already, through that source's new value
and the k before it (interpolation). The inputs are then wrong by O(h^(k+1)) and so, at the end of a run, are the states:
the order is k + 1 for both.

A cold start has no history. A step with inputs of degree k - 1 costs O(h^(k+1)) once, which keeps the order; so the first
steps are done twice where the slaves can go back: extrapolate, look at the outcome, go back, interpolate through it. That
gains one degree for each of them, and with it the order.

NEPCE (nearly energy preserving coupling): after a step the true course of a signal is known better than the extrapolation
that was used; the next step's input is raised by the mean of what was missing. For power bonds this returns the energy that
the delay withheld, and the mean of the input becomes right to one order more.
Source: Kuebler and Schiehlen, Modular simulation in multibody system dynamics (2000); for NEPCE Benedikt, Watzenig and Hofer,
Modelling and analysis of the non-iterative coupling process for co-simulation (2013).
"""

from abc import abstractmethod
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from ..network import Network
from .base import Algorithm, Memory, Step, Used, can_restore, save_all, step_all
from .history import History

# Integral over the next step of what extrapolation of degree k misses, in steps times the difference of order k + 1.
MISSED = (1 / 2, 5 / 12, 3 / 8)


@dataclass(frozen=True)
class Explicit(Algorithm):
    """Every slave steps once, but for the first steps of a run."""

    @abstractmethod
    def sweep(self, network: Network, history: History, h: float, degree: int) -> Step:
        """One macro step with inputs of `degree`, which may be lower than the algorithm's own at the start of a run."""

    def advance(self, network: Network, history: History, h: float, memory: Memory) -> Step:
        degree = min(self.degree, len(history.Y) - 1)
        if degree == self.degree or not can_restore(network):
            return self.sweep(network, history, h, degree)
        with save_all(network) as before:
            Y = self.sweep(network, history, h, degree).Y
            before.go_back()
        used = step_all(network, history.through(h, Y, degree + 1), history.t[0], h)
        return Step(network.outputs(Y.copy(), history.t[0] + h), used)


@dataclass(frozen=True)
class Jacobi(Explicit):
    """All slaves step from the same extrapolation, as if side by side. Order degree + 1.

    Parameters
    ----------
    degree : {0, 1, 2}
        Of the extrapolation.
    """

    @property
    def name(self) -> str:
        return "jacobi"

    def sweep(self, network: Network, history: History, h: float, degree: int) -> Step:
        return _side_by_side(network, history, h, history.polynomial(degree))


@dataclass(frozen=True)
class Nepce(Explicit):
    """Jacobi that corrects the coupled signals, those of power bonds among them, for what the last step's extrapolation missed.

    Order degree + 2, at most 3. It needs even macro steps.

    Parameters
    ----------
    degree : {0, 1, 2}
        Of the extrapolation.

    References
    ----------
    Benedikt, Watzenig and Hofer, Modelling and analysis of the non-iterative coupling process for co-simulation (2013).
    """

    @property
    def name(self) -> str:
        return "nepce"

    @property
    def order(self) -> int:
        return min(self.degree + 2, 3)  # the cold start allows no more

    @property
    def looks_back(self) -> int:
        return self.degree + 1

    def sweep(self, network: Network, history: History, h: float, degree: int) -> Step:
        C = history.polynomial(degree)
        C[0] += _missing(network, history, degree)
        return _side_by_side(network, history, h, C)


def _side_by_side(network: Network, history: History, h: float, C: np.ndarray) -> Step:
    """Every slave steps under the polynomials C, shape (3, n_Y), of all outputs."""
    used = step_all(network, C, history.t[0], h)
    return Step(network.outputs(history.Y[0].copy(), history.t[0] + h), used)


def _missing(network: Network, history: History, degree: int) -> np.ndarray:
    """The mean of what the last step's extrapolation missed, shape (n_Y,); nothing for signals that are held."""
    missing = np.zeros_like(history.Y[0])
    if len(history.Y) < degree + 2:
        return missing
    places = np.setdiff1d(network.coupled, network.held)
    difference = np.diff(np.array([Y[places] for Y in history.Y[: degree + 2]])[::-1], degree + 1, axis=0)[0]
    missing[places] = MISSED[degree] * difference
    return missing


@dataclass(frozen=True)
class GaussSeidel(Explicit):
    """Slaves step one after another; the later ones interpolate what the earlier ones have reached. Order degree + 1.

    Parameters
    ----------
    degree : {0, 1, 2}
        Of the extrapolation.
    sequence : sequence of str
        Component names in the order of stepping; empty for the order in which outputs depend on inputs.
    """

    sequence: Sequence[str] = ()

    @property
    def name(self) -> str:
        return "gauss-seidel"

    def check(self, network: Network) -> None:
        network.sequence(self.sequence)

    def sweep(self, network: Network, history: History, h: float, degree: int) -> Step:
        t = history.t[0]
        C = history.polynomial(degree)
        Y = C[0] + h * (C[1] + h * C[2] / 2)  # a guess, replaced slave by slave
        used: Used = [np.empty(0)] * len(network.slaves)
        for i in network.sequence(self.sequence):
            U = used[i] = network.step(i, network.inputs(i, C, t, h), t, h)
            part = network.slices[i]
            Y[part] = network.slaves[i].output(U[0] + h * (U[1] + h * U[2] / 2), t + h)
            C[:, part] = history.through(h, Y, min(self.degree, len(history.Y)))[:, part]
        return Step(network.outputs(Y, t + h), used)
