"""Algebraic loops, outputs that depend on themselves without delay: the order of evaluation, the loops, their solution."""

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import Protocol

import numpy as np

from ..errors import ConvergenceError, OutputError

ITERATIONS = 50  # of Newton's method, after which a loop counts as one without a solution
HALVINGS = 12  # of a step, after which it is not worth taking
SHOWN = 6  # values of a loop that a message names


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

    Newton's method with the Jacobian by differences, kept from one communication point to the next as long as it serves. A step
    that is undefined (a root of something negative) or does not come closer is halved until it does.
    """

    def __init__(self, network: Evaluating, group: Sequence[int]) -> None:
        self._network, self._places = network, np.array(group)
        inside = set(group)
        self._slaves = [i for i, part in enumerate(network.slices) if inside & set(range(part.start, part.stop))]

    def solve(self, Y: np.ndarray, t: float, jacobian: np.ndarray | None) -> np.ndarray | None:
        """Write the solution into Y, from the Jacobian that the last solution returned, if any; returns the present one.

        The values that Y holds are where it starts. ConvergenceError if there is none within ITERATIONS.
        """
        z = Y[self._places]
        loop = f"the algebraic loop of {', '.join(self._network.names[k] for k in self._places)} must"
        try:
            residual = self._evaluated(Y, z, t) - z
        except OutputError as error:
            raise ConvergenceError(f"{loop} be defined where its solution begins, at {self._values(z)}: {error}") from None
        nearest = z, residual
        for iteration in range(ITERATIONS):
            if not np.any(np.abs(residual) > 1e-12 * np.maximum(1.0, np.abs(z))):
                # What is left is an error of residual / (1 - gain): one more step of Newton takes it away for any gain.
                J = np.zeros((z.size, z.size)) if jacobian is None else jacobian
                Y[self._places] = z + np.linalg.lstsq(np.eye(z.size) - J, residual)[0]
                return jacobian
            fresh = jacobian is None or iteration % 5 == 4
            if jacobian is None or fresh:
                jacobian = self._differences(Y, z, residual, t)
            taken = self._stepped(Y, z, residual, jacobian, t)
            if not taken.nearer and not fresh:
                jacobian = self._differences(Y, z, residual, t)
                taken = self._stepped(Y, z, residual, jacobian, t)
            z, residual = taken.z, taken.residual
            if _size(residual, z) < _size(nearest[1], nearest[0]):
                nearest = z, residual
        z, residual = nearest
        worst = int(np.argmax(np.abs(residual) / np.maximum(1.0, np.abs(z))))
        raise ConvergenceError(
            f"{loop} have a solution at t = {t:.9g} s, none found in {ITERATIONS} iterations; nearest is {self._values(z)}, "
            f"where {self._network.names[self._places[worst]]} becomes {z[worst] + residual[worst]:.6g} (an input's start "
            "value says where to begin)"
        )

    def _values(self, z: np.ndarray) -> str:
        """Some of them with their names, for a message."""
        more = f" and {z.size - SHOWN} more" if z.size > SHOWN else ""
        named = zip(self._places[:SHOWN], z[:SHOWN], strict=True)
        return ", ".join(f"{self._network.names[k]} = {value:.6g}" for k, value in named) + more

    def _stepped(self, Y: np.ndarray, z: np.ndarray, residual: np.ndarray, jacobian: np.ndarray, t: float) -> "_Step":
        """Newton's step from z, whole or the longest of its halves that comes nearer; where none does, the longest defined."""
        whole = np.linalg.lstsq(np.eye(z.size) - jacobian, residual)[0]
        scale, longest = np.maximum(1.0, np.abs(z)), None
        before = np.linalg.norm(residual / scale)
        for halvings in range(HALVINGS):
            to = z + whole * 0.5**halvings
            try:
                there = self._evaluated(Y, to, t) - to
            except OutputError:
                continue
            if np.linalg.norm(there / scale) < before:
                return _Step(to, there, nearer=True)
            longest = longest or _Step(to, there, nearer=False)
        return longest or _Step(z, residual, nearer=False)

    def _evaluated(self, Y: np.ndarray, z: np.ndarray, t: float) -> np.ndarray:
        """The outputs of the loop after one evaluation of its slaves from the values z; OutputError where they have none."""
        before = Y.copy()
        before[self._places] = z
        after = before.copy()
        for i in self._slaves:
            trial = before.copy()
            self._network.evaluate(i, trial, t)
            after[self._network.slices[i]] = trial[self._network.slices[i]]
        return np.asarray(after[self._places])

    def _differences(self, Y: np.ndarray, z: np.ndarray, residual: np.ndarray, t: float) -> np.ndarray:
        J, base = np.zeros((z.size, z.size)), z + residual
        for column in range(z.size):
            moved = z.copy()
            moved[column] += 1e-6 * max(1.0, abs(z[column]))
            try:
                there = self._evaluated(Y, moved, t)
            except OutputError:  # the other way, then
                moved[column] = z[column] - 1e-6 * max(1.0, abs(z[column]))
                there = self._evaluated(Y, moved, t)
            J[:, column] = (there - base) / (moved[column] - z[column])
        return J


@dataclass(frozen=True, eq=False)
class _Step:
    """Values of a loop, what evaluating them changes, and whether that is less than before."""

    z: np.ndarray
    residual: np.ndarray
    nearer: bool


def _size(residual: np.ndarray, z: np.ndarray) -> float:
    return float(np.max(np.abs(residual) / np.maximum(1.0, np.abs(z))))
