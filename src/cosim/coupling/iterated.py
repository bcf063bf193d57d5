"""Iterated coupling: repeat the macro step until the inputs agree with the outputs they led to.

Let z be the coupled outputs at the end of the step, as assumed for the input polynomials (of degree k, through z and the k
points before), and G(z) those that the slaves then reach. Sought is the fixed point z = G(z), where the inputs are
interpolated on all sides: order k + 1, and stable where one pass is not.

- "aitken": z + w (G(z) - z), with Aitken's w from the last two residuals.
- "newton": z + (I - J)^-1 (G(z) - z) with the interface Jacobian J = dG/dz. It starts from the components' own derivatives
  where they give them (directional derivatives of an FMU: the macro step is then done on the linearisations), else from
  differences, and is improved by Broyden's update in every iteration and kept from step to step.
Source: Kuettler and Wall, Fixed-point fluid-structure interaction solvers with dynamic relaxation (2008), for Aitken's w;
Sicklinger et al., Interface Jacobian-based co-simulation (2014).
"""

from abc import abstractmethod
from dataclasses import dataclass
from types import MappingProxyType
from typing import Protocol

import numpy as np

from ..errors import ConvergenceError
from ..network import Network
from ..network.linearised import linearise_network
from .base import Algorithm, Memory, Saved, Step, require_restore, save_all, step_all
from .history import History


class Update(Protocol):
    """How the next guess follows from the last: z + update(z, residual)."""

    def __call__(self, z: np.ndarray, residual: np.ndarray) -> np.ndarray:
        """What to add to z, shape (n_coupled,), after which G(z) - z was `residual`."""

    @property
    def memory(self) -> Memory:
        """For the next macro step."""


@dataclass(frozen=True)
class Repeated(Algorithm):
    """Macro steps repeated to agreement. Order degree + 1.

    Parameters
    ----------
    degree : {0, 1, 2}
        Of the interpolation.
    tolerance : float
        Largest change of a coupled output, relative to the largest size it has had, that counts as agreement.
    max_iterations : int
        ConvergenceError if more are needed.
    """

    tolerance: float = 1e-10
    max_iterations: int = 50

    def __post_init__(self) -> None:
        super().__post_init__()
        if not self.tolerance > 0.0:
            raise ValueError(f"tolerance must be positive, got {self.tolerance!r}")
        if self.max_iterations < 1 or self.max_iterations != int(self.max_iterations):
            raise ValueError(f"max_iterations must be a whole number of at least 1, got {self.max_iterations!r}")

    def check(self, network: Network) -> None:
        require_restore(network, f"algorithm {self.name!r}")

    @abstractmethod
    def update(
        self, network: Network, history: History, h: float, degree: int, largest: np.ndarray, before: Saved, memory: Memory
    ) -> Update:
        """What improves the guesses in one macro step, whose start is `before`; `largest` sizes, shape (n_coupled,)."""

    def advance(self, network: Network, history: History, h: float, memory: Memory) -> Step:
        """See Algorithm.advance. `memory` holds "largest", shape (n_coupled,): the largest size of each coupled output so far."""
        t, coupled = history.t[0], network.coupled
        guess = history.polynomial(min(self.degree, len(history.Y) - 1))
        Y = guess[0] + h * (guess[1] + h * guess[2] / 2)
        degree = min(self.degree, len(history.Y))
        largest = np.max(np.abs([y[coupled] for y in history.Y] + [Y[coupled]]), axis=0, initial=0.0)
        if "largest" in memory:
            largest = np.maximum(memory["largest"], largest)
        with save_all(network, f"algorithm {self.name!r}") as before:
            update = self.update(network, history, h, degree, largest, before, memory)
            for iteration in range(self.max_iterations):
                if iteration:
                    before.go_back()
                z = Y[coupled]
                used = step_all(network, history.through(h, Y, degree), t, h)
                reached = network.outputs(Y.copy(), t + h)
                residual = reached[coupled] - z
                if not np.any(np.abs(residual) > self.tolerance * np.maximum(largest, np.abs(reached[coupled]))):
                    return Step(reached, used, {"largest": largest, **update.memory}, iteration + 1)
                Y = reached
                Y[coupled] = z + update(z, residual)
        worst = network.names[coupled[int(np.argmax(np.abs(residual)))]]
        raise ConvergenceError(
            f"iteration of the macro step at t = {t:.9g} s over {h:g} s must converge within {self.max_iterations} iterations; "
            f"{worst} still changes by {np.abs(residual).max():.3g}"
        )


@dataclass(frozen=True)
class Iterated(Repeated):
    """Macro steps repeated with relaxation by Aitken's factor: z + w (G(z) - z). Order degree + 1.

    Parameters
    ----------
    degree : {0, 1, 2}
        Of the interpolation.
    tolerance : float
        Largest change of a coupled output, relative to the largest size it has had, that counts as agreement.
    max_iterations : int
        ConvergenceError if more are needed.

    References
    ----------
    Kuettler and Wall, Fixed-point fluid-structure interaction solvers with dynamic relaxation (2008).
    """

    @property
    def name(self) -> str:
        return "iterated"

    def update(
        self, network: Network, history: History, h: float, degree: int, largest: np.ndarray, before: Saved, memory: Memory
    ) -> Update:
        return _Aitken()


@dataclass(frozen=True)
class Newton(Repeated):
    """Macro steps repeated with Newton's method and the interface Jacobian J = dG/dz: z + (I - J)^-1 (G(z) - z).

    Order degree + 1. `memory` holds J as "jacobian", shape (n_coupled, n_coupled).

    Parameters
    ----------
    degree : {0, 1, 2}
        Of the interpolation.
    tolerance : float
        Largest change of a coupled output, relative to the largest size it has had, that counts as agreement.
    max_iterations : int
        ConvergenceError if more are needed.

    References
    ----------
    Sicklinger et al., Interface Jacobian-based co-simulation (2014).
    """

    @property
    def name(self) -> str:
        return "newton"

    def update(
        self, network: Network, history: History, h: float, degree: int, largest: np.ndarray, before: Saved, memory: Memory
    ) -> Update:
        kept = memory.get("jacobian")
        return _Newton(_interface_jacobian(network, history, h, degree, largest, before) if kept is None else kept)


class _Aitken:
    """Relaxation whose factor follows from the last two residuals."""

    memory: Memory = MappingProxyType({})  # it starts anew with every macro step; not to be changed

    def __init__(self) -> None:
        self._factor, self._last = 1.0, np.empty(0)

    def __call__(self, z: np.ndarray, residual: np.ndarray) -> np.ndarray:
        if self._last.size:
            change = residual - self._last
            size = float(change @ change)
            if size > 0.0:
                self._factor *= -float(self._last @ change) / size
        self._last = residual
        return self._factor * residual


class _Newton:
    """Newton's method from the Jacobian J, shape (n, n), which Broyden's update improves."""

    def __init__(self, J: np.ndarray) -> None:
        self._J = J
        self._last_z, self._last = np.empty(0), np.empty(0)

    @property
    def memory(self) -> Memory:
        """For the next macro step."""
        return {"jacobian": self._J}

    def __call__(self, z: np.ndarray, residual: np.ndarray) -> np.ndarray:
        if self._last.size:  # G changed by dz + d(residual); make J explain it
            dz = z - self._last_z
            size = float(dz @ dz)
            if size > 0.0:
                self._J = self._J + np.outer(dz + residual - self._last - self._J @ dz, dz) / size
        self._last_z, self._last = z, residual
        correction: np.ndarray = np.linalg.lstsq(np.eye(z.size) - self._J, residual)[0]
        return correction


def _interface_jacobian(
    network: Network, history: History, h: float, degree: int, largest: np.ndarray, before: Saved
) -> np.ndarray:
    """dG/dz by repeating the macro step once for every coupled output: on the slaves' linearisations, which stand at zero,
    where all give them; else on the slaves themselves, from `before`, with moves relative to `largest`."""
    linear = linearise_network(network)
    if linear is None:
        return _by_differences(network, history, h, degree, before, 1e-6 * np.maximum(1.0, largest))
    still = History(history.t, tuple(np.zeros_like(history.Y[0]) for _ in history.Y), history.held)
    with save_all(linear.network) as start:
        return _by_differences(linear.network, still, h, degree, start, np.ones(network.coupled.size))


def _by_differences(network: Network, history: History, h: float, degree: int, start: Saved, moves: np.ndarray) -> np.ndarray:
    """Column k is the change of the coupled outputs reached when the k-th one assumed is moved by moves[k], over the move."""
    coupled, t = network.coupled, history.t[0]

    def reached(Y: np.ndarray) -> np.ndarray:
        step_all(network, history.through(h, Y, degree), t, h)
        result: np.ndarray = network.outputs(Y.copy(), t + h)[coupled]
        start.go_back()
        return result

    origin = history.Y[0]
    still, J = reached(origin), np.zeros((coupled.size, coupled.size))
    for column, k in enumerate(coupled):
        moved = origin.copy()
        moved[k] += moves[column]
        J[:, column] = (reached(moved) - still) / (moved[k] - origin[k])
    return J
