"""Algebraic loops, outputs that depend on themselves without delay: the order of evaluation, the loops, their solution."""

from collections.abc import Iterable, Mapping, Sequence
from typing import Protocol

import numpy as np

from ..errors import ConvergenceError


def strong_components(nodes: Iterable[int], needs: Mapping[int, Sequence[int]]) -> list[list[int]]:
    """Groups of nodes that need one another, each group after all that it needs. Tarjan's algorithm, without recursion."""
    index: dict[int, int] = {}
    low: dict[int, int] = {}
    stack: list[int] = []
    on_stack: set[int] = set()
    groups: list[list[int]] = []
    for root in nodes:
        if root in index:
            continue
        work = [(root, iter(needs.get(root, ())))]
        index[root] = low[root] = len(index)
        stack.append(root)
        on_stack.add(root)
        while work:
            node, successors = work[-1]
            for other in successors:
                if other not in index:
                    index[other] = low[other] = len(index)
                    stack.append(other)
                    on_stack.add(other)
                    work.append((other, iter(needs.get(other, ()))))
                    break
                if other in on_stack:
                    low[node] = min(low[node], index[other])
            else:
                work.pop()
                if work:
                    low[work[-1][0]] = min(low[work[-1][0]], low[node])
                if low[node] == index[node]:
                    group = []
                    while True:
                        last = stack.pop()
                        on_stack.discard(last)
                        group.append(last)
                        if last == node:
                            break
                    groups.append(sorted(group))
    return groups


def self_dependent(nodes: Iterable[int], needs: Mapping[int, Sequence[int]]) -> list[list[int]]:
    """The groups of nodes that depend on themselves."""
    return [g for g in strong_components(nodes, needs) if len(g) > 1 or g[0] in needs.get(g[0], ())]


def cycle(group: Sequence[int], needs: Mapping[int, Sequence[int]]) -> list[int]:
    """One way round a loop, first and last node the same, in the direction of the data: each feeds the next."""
    inside, path = set(group), [group[0]]
    while True:
        ahead = next(node for node in needs[path[-1]] if node in inside)
        if ahead in path:
            return [ahead, *reversed(path[path.index(ahead) :])]
        path.append(ahead)


class Evaluating(Protocol):
    """What the solver needs of a network."""

    names: tuple[str, ...]
    slices: tuple[slice, ...]

    def evaluate(self, i: int, Y: np.ndarray, t: float) -> None:
        """The outputs of slave i at t (s) for the inputs that Y gives it, written into Y."""


class LoopSolver:
    """Solves one algebraic loop: the outputs in it, at the places `group` of Y, such that evaluating them changes nothing.

    Newton's method with the Jacobian by differences, kept from one communication point to the next as long as it serves.
    """

    def __init__(self, network: Evaluating, group: Sequence[int]) -> None:
        self._network, self._places = network, np.array(group)
        inside = set(group)
        self._slaves = [i for i, part in enumerate(network.slices) if inside & set(range(part.start, part.stop))]

    def solve(self, Y: np.ndarray, t: float, jacobian: np.ndarray | None) -> np.ndarray | None:
        """Write the solution into Y, from the Jacobian that the last solution returned, if any; returns the present one.

        ConvergenceError if there is none within 50 iterations.
        """
        z = Y[self._places]
        for iteration in range(50):
            residual = self._evaluated(Y, z, t) - z
            if not np.any(np.abs(residual) > 1e-12 * np.maximum(1.0, np.abs(z))):
                # What is left is an error of residual / (1 - gain): one more step of Newton takes it away for any gain.
                J = np.zeros((z.size, z.size)) if jacobian is None else jacobian
                Y[self._places] = z + np.linalg.lstsq(np.eye(z.size) - J, residual)[0]
                return jacobian
            if jacobian is None or iteration % 5 == 4:
                jacobian = self._differences(Y, z, z + residual, t)
            z = z + np.linalg.lstsq(np.eye(z.size) - jacobian, residual)[0]
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
        return np.asarray(after[self._places])

    def _differences(self, Y: np.ndarray, z: np.ndarray, base: np.ndarray, t: float) -> np.ndarray:
        J = np.zeros((z.size, z.size))
        for column in range(z.size):
            moved = z.copy()
            moved[column] += 1e-6 * max(1.0, abs(z[column]))
            J[:, column] = (self._evaluated(Y, moved, t) - base) / (moved[column] - z[column])
        return J
