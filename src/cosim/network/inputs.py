"""How the inputs of one slave follow from all outputs: values and polynomials, by factor, offset, table, and as whole numbers."""

from collections.abc import Mapping, Sequence
from types import MappingProxyType

import numpy as np

from ..errors import WiringError
from ..slaves import Signal, Slave, Value
from ..systems.courses import Course
from .joining import Transfer


class Inputs:
    """How the inputs of one slave follow from all outputs.

    joined : (place in Y, place in u, factor, offset) of each connected input; factor 1, offset 0 where a table is in between.
    tables : place in u -> table of the inputs that have one.
    start : shape (n_u,), what unconnected inputs keep.
    courses : place in u -> what an unconnected input follows instead.
    """

    def __init__(
        self, wires: Sequence[tuple[int, int, Transfer]], start: np.ndarray, courses: Mapping[int, Course] = MappingProxyType({})
    ) -> None:
        self._wires, self.courses = tuple(wires), courses
        self.joined = [(k, j, t.factor, t.offset) for k, j, t in wires]
        self.tables = {j: t.table for _, j, t in wires if t.table is not None}
        self._rounded = {j: t.whole for _, j, t in wires if t.whole is not None}
        self.start = start
        self._source, self._into = _slice([wire[0] for wire in wires]), _slice([wire[1] for wire in wires])
        self._scale, self._offset = np.array([w[2] for w in self.joined]), np.array([w[3] for w in self.joined])
        self._scaled, self._shifted = bool((self._scale != 1.0).any()), bool(self._offset.any())
        self._followed = tuple(courses.items())
        self._whole = len(wires) == start.size and not self._shifted and not self.tables and not self._rounded
        self._template = np.vstack([start, np.zeros((2, start.size))])

    def following(self, courses: Mapping[int, Course]) -> "Inputs":
        """The same with courses, by place in u."""
        return Inputs(self._wires, self.start, courses) if courses else self

    def altered(self, changes: Mapping[int, tuple[float, float]]) -> "Inputs":
        """The same with connected inputs, by place in u, made factor * what comes + value."""
        wires = []
        for k, j, given in self._wires:
            factor, value = changes.get(j, (1.0, 0.0))
            table = None if factor == 0.0 else given.table
            wires.append((k, j, Transfer(given.factor * factor, given.offset * factor + value, table, given.whole)))
        return Inputs(wires, self.start, self.courses)

    def some(self, places: Sequence[int], Y: np.ndarray, t: float) -> list[tuple[int, float]]:
        """Connected inputs at these places in u, with their places, from outputs Y, shape (n_Y,), that may hold nothing else."""
        alone = Inputs([wire for wire in self._wires if wire[1] in places], self.start)
        u = alone.of(Y[None, :], t)[0]
        return [(j, float(u[j])) for j in places]

    def at_rest(self, t: float) -> np.ndarray:
        """What unconnected inputs are at t (s), shape (n_u,)."""
        u = self.start.copy()
        for j, course in self._followed:
            u[j] = course.at(t)
        return u

    def of(self, C: np.ndarray, t: float = 0.0, h: float = 0.0) -> np.ndarray:
        """U, shape (m, n_u), from C, shape (m, n_Y), m = 1 (values only) or 3, over h (s) from t (s) on.

        No -0.0 is in it: a derivative that is zero must not differ from one that is not set."""
        part = C[:, self._source]
        if self._scaled:
            part = part * self._scale
        part = part + 0.0  # not a view, either: the caller may keep it
        if self._whole:
            return part
        U = self._template[: len(C)].copy()
        U[:, self._into] = part
        if self._shifted:
            U[0, self._into] += self._offset
        for j, course in self._followed:
            if len(C) > 1 and h > 0.0:
                U[0, j], U[1, j] = course.over(t, h)
            else:
                U[0, j] = course.at(t)
        for j, table in self.tables.items():
            if U[0, j] not in table:
                raise WiringError(f"a mapping between connectors must have an entry for {U[0, j]:g}")
            U[0, j] = table[U[0, j]]
        for j, signal in self._rounded.items():
            U[:, j] = [_nearest(U[0, j], signal), *U[1:, j] * 0.0]
        return U


def first_guess(
    output: Signal, feeds: Sequence[tuple[int, int]], slaves: Sequence[Slave], inputs: Sequence[Inputs],
    values: Sequence[Mapping[str, Value]],
) -> float:  # fmt: skip
    """Where an output of an algebraic loop begins: as given to an input that it feeds, else declared, else zero.

    feeds : (slave, place in u) of the inputs that it feeds. values : of each slave, by name.
    """
    declared = output.start
    for i, j in feeds:
        signal, start = slaves[i].inputs[j], inputs[i].start[j]
        factor, offset = next((factor, offset) for _, place, factor, offset in inputs[i].joined if place == j)
        if factor == 0.0 or j in inputs[i].tables:
            continue
        if signal.name in values[i]:
            return float((start - offset) / factor)
        if declared is None and signal.start is not None:
            declared = float((start - offset) / factor)
    return declared or 0.0


def _nearest(number: float, signal: Signal) -> float:
    """The whole number that `signal` takes for a real one; true from 0.5 on."""
    if signal.type == "boolean":
        return float(number >= 0.5)
    low, high = (-np.inf if signal.min is None else signal.min), (np.inf if signal.max is None else signal.max)
    if not low <= np.rint(number) <= high:
        raise WiringError(f"a transformation must keep {signal.name} within {low:g} and {high:g}, it gives {number:g}")
    return float(np.rint(number))


def _slice(places: list[int]) -> slice | np.ndarray:
    """`places` as a slice where they follow one another, which numpy serves without copying."""
    if places and places == list(range(places[0], places[0] + len(places))):
        return slice(places[0], places[0] + len(places))
    return np.array(places, dtype=int)
