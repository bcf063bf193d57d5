"""Algebraic loops: outputs that depend on themselves without delay, solved at every communication point."""

from collections.abc import Sequence
from typing import Protocol

import numpy as np

from gyro_cosim.errors import ConvergenceError


class Evaluating(Protocol):
    """What the solver needs of a network."""

    names: tuple[str, ...]
    slices: tuple[slice, ...]

    def evaluate(self, i: int, Y: np.ndarray, t: float) -> None:
        """The outputs of slave i at t (s) for the inputs that Y gives it, written into Y."""


class LoopSolver:
    """Solves one algebraic loop: the outputs in it, at the places `group` of Y, such that evaluating them changes nothing.

    Newton's method with the Jacobian by differences, kept from one communication point to the next as long as it serves.

    jacobian : the one that is kept, None where there is none yet.
    """

    def __init__(self, network: Evaluating, group: Sequence[int]) -> None:
        self._network, self._places = network, np.array(group)
        inside = set(group)
        self._slaves = [i for i, part in enumerate(network.slices) if inside & set(range(part.start, part.stop))]
        self.jacobian: np.ndarray | None = None

    def solve(self, Y: np.ndarray, t: float) -> None:
        """Write the solution into Y; ConvergenceError if there is none within 50 iterations."""
        z = Y[self._places]
        for iteration in range(50):
            residual = self._evaluated(Y, z, t) - z
            if not np.any(np.abs(residual) > 1e-12 * np.maximum(1.0, np.abs(z))):
                # What is left is an error of residual / (1 - gain): one more step of Newton takes it away for any gain.
                J = np.zeros((z.size, z.size)) if self.jacobian is None else self.jacobian
                Y[self._places] = z + np.linalg.lstsq(np.eye(z.size) - J, residual)[0]
                return
            if self.jacobian is None or iteration % 5 == 4:
                self.jacobian = self._differences(Y, z, z + residual, t)
            z = z + np.linalg.lstsq(np.eye(z.size) - self.jacobian, residual)[0]
        names = ", ".join(self._network.names[k] for k in self._places)
        raise ConvergenceError(
            f"the algebraic loop of {names} must have a solution at t = {t:.9g} s, none found in 50 iterations"
        )

    def _evaluated(self, Y: np.ndarray, z: np.ndarray, t: float) -> np.ndarray:
        """The outputs of the loop after one evaluation of its slaves from the values z."""
        before = Y.copy()
        before[self._places] = z
        after = before.copy()
        for i in self._slaves:
            trial = before.copy()
            self._network.evaluate(i, trial, t)
            after[self._network.slices[i]] = trial[self._network.slices[i]]
        return after[self._places]

    def _differences(self, Y: np.ndarray, z: np.ndarray, base: np.ndarray, t: float) -> np.ndarray:
        J = np.zeros((z.size, z.size))
        for column in range(z.size):
            moved = z.copy()
            moved[column] += 1e-6 * max(1.0, abs(z[column]))
            J[:, column] = (self._evaluated(Y, moved, t) - base) / (moved[column] - z[column])
        return J
