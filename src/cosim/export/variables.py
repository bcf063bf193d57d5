"""The variables of a coupled system's FMU, and what its outputs depend on.

Inputs that nothing is connected to and all outputs are called `component.signal`; so are parameters and start values. The
coupling adds three of its own: algorithm, degree and macro step.
"""

from collections import Counter
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field
from functools import cached_property

import numpy as np

from gyro_cosim.component.units import Unit

from ..coupling import MAX_DEGREE, Algorithm
from ..network import Network
from ..slaves.fmi.rows import Row
from ..slaves.fmi.signals import read as start_of
from ..systems import System
from .components import Packed

__all__ = ["ALGORITHMS", "LEAST", "Reach", "Variable", "Variables"]

ALGORITHMS = {"jacobi": 1, "gauss-seidel": 2, "nepce": 3}
ABOUT = (
    "coupling algorithm: jacobi, all components step side by side; gauss-seidel, one after another; "
    "nepce, Jacobi that corrects its inputs"
)
LEAST = 1000  # the macro step may be so many times shorter than the system's
TYPES = {"Real": "real", "Float64": "real", "Integer": "integer", "Int32": "integer", "Enumeration": "enumeration",
         "Boolean": "boolean", "String": "string"}  # fmt: skip


@dataclass(frozen=True, eq=False)
class Variable:
    """A variable of the FMU. Its value reference is its place in the list.

    Parameters
    ----------
    kind : str
        "time", "algorithm", "degree", "macro_step", "input", "output", "derivative" of a state, or "forwarded" for what else a
        component is asked itself.
    name, type, description, unit : str
        Type "real", "integer", "enumeration", "boolean" or "string".
    causality, variability, initial : str
        As FMI has them; initial "" where there is none.
    component : int
        Whose it is.
    reference : int
        Its value reference there.
    index : int
        Place among the unconnected inputs, or in Y.
    start : float, str or None
        None where it is calculated.
    state : int
        Of a derivative, the value reference of its state in the component; else -1.
    """

    kind: str
    name: str
    type: str
    description: str
    causality: str
    variability: str
    initial: str = ""
    unit: str = ""
    definition: Unit | None = None
    component: int = 0
    reference: int = 0
    index: int = 0
    start: float | str | None = None
    min: float | None = None
    max: float | None = None
    items: tuple[tuple[str, int], ...] = field(default=())
    state: int = -1


class Variables:
    """All variables of the FMU of a system, in the order of their value references.

    Parameters
    ----------
    system : System
        What is packed.
    network : Network
        Its slaves, opened.
    components : sequence of Packed
        The same.
    algorithm : Algorithm
        What the coupling starts with.
    """

    def __init__(self, system: System, network: Network, components: Sequence[Packed], algorithm: Algorithm) -> None:
        self._system, self._network, self._components, self._algorithm = system, network, components, algorithm
        self.external = tuple((i, j) for i, part in enumerate(components) for j in part.unconnected)

    @property
    def derivable(self) -> bool:
        """Whether every component gives directional derivatives, so that the whole can."""
        names = "providesDirectionalDerivative", "providesDirectionalDerivatives"
        return all(any(part.model.can(name) for name in names) for part in self._components)

    @cached_property
    def derivatives(self) -> list[tuple[int, int]]:
        """Value references of each derivative and of its state; none where the whole has no directional derivatives."""
        place = {(v.component, v.reference): k for k, v in enumerate(self.all) if v.kind in ("output", "forwarded")}
        return [(k, place[v.component, v.state]) for k, v in enumerate(self.all) if v.kind == "derivative"]

    @cached_property
    def all(self) -> tuple[Variable, ...]:
        """Every variable; ValueError where two have one name."""
        found = [*self._of_the_coupling(), *(v for i in range(len(self._components)) for v in self._of_component(i))]
        for name, times in Counter(v.name for v in found).items():
            if times > 1:
                what = f"system {self._system.name!r} as one FMU"
                raise ValueError(f"{what}: variables must differ in name, {times} are called {name!r}")
        return tuple(found)

    def _of_the_coupling(self) -> Iterator[Variable]:
        yield Variable("time", "time", "real", "simulation time", "independent", "continuous", unit="s")
        fixed, step = ("parameter", "fixed", "exact"), self._system.step
        items, start = tuple(ALGORITHMS.items()), ALGORITHMS[self._algorithm.name]
        yield Variable("algorithm", "algorithm", "enumeration", ABOUT, *fixed, start=start, items=items)
        degree = "degree of the input extrapolation"
        yield Variable("degree", "degree", "integer", degree, *fixed, start=self._algorithm.degree, min=0, max=MAX_DEGREE)
        about, low = "macro step of the coupling", step / LEAST
        yield Variable("macro_step", "macro_step", "real", about, *fixed, unit="s", start=step, min=low)

    def _of_component(self, i: int) -> Iterator[Variable]:
        part = self._components[i]
        given = {row.name: value for row, value in part.given}
        inputs = {part.slave.inputs[j].name: j for j in part.unconnected}
        first = self._network.slices[i].start
        states = {derivative: state for state, derivative in part.model.states} if self.derivable else {}
        outputs = {signal.name: first + k for k, signal in enumerate(part.slave.outputs)}
        for row in part.model.rows:
            start = given.get(row.name, start_of(row, row.start[0]) if row.start else None)
            if row.name in outputs:
                initial = row.initial if row.settable and start is not None else "calculated"
                start = None if initial == "calculated" else start
                yield self._variable(i, row, "output", outputs[row.name], start, initial)
            elif row.name in inputs:
                start = float(self._network.start_inputs(i)[inputs[row.name]])
                yield self._variable(i, row, "input", self.external.index((i, inputs[row.name])), start, "")
            elif row.reference in states and row.causality == "local":
                yield self._variable(i, row, "derivative", 0, None, "calculated", states[row.reference])
            elif row.reference in states.values() and not row.settable:
                yield self._variable(i, row, "forwarded", 0, None, "calculated")
            elif row.causality != "input" and row.settable and row.type in TYPES and not row.shape and start is not None:
                yield self._variable(i, row, "forwarded", 0, start, row.initial)

    def _variable(
        self, i: int, row: Row, kind: str, index: int, start: float | str | bytes | None, initial: str, state: int = -1
    ) -> Variable:
        name = f"{self._components[i].name}.{row.name}"
        if state >= 0 and row.name.startswith("der("):  # as FMI writes the derivative of something with a dot
            name = f"der({self._components[i].name}.{row.name.removeprefix('der(')}"
        value = start if isinstance(start, str) or start is None else float(start)
        return Variable(
            kind, name, TYPES[row.type], row.description, row.causality, row.variability, initial, row.unit, row.definition,
            i, row.reference, index, value, row.min, row.max, row.items, state,
        )  # fmt: skip

    # ---- what depends on what

    def reach(self, k: int, *, start: bool = False) -> "Reach":
        """What output k in Y depends on; `start`: in initialization mode instead of at communication points."""
        if start not in self._reached:
            self._reached[start] = {}
        return self._followed(k, start, self._reached[start])

    @cached_property
    def _reached(self) -> dict[bool, dict[int, "Reach"]]:
        return {}

    def _followed(self, k: int, start: bool, known: dict[int, "Reach"]) -> "Reach":
        """There are no loops, so this ends."""
        if k in known:
            return known[k]
        i = int(np.searchsorted([part.stop for part in self._network.slices], k, side="right"))
        part, place = self._components[i], k - self._network.slices[i].start
        row = (part.slave.initial_feedthrough if start else part.slave.feedthrough)[place]
        source = {j: y for y, j, _, _ in self._network.wires(i)}
        stated = part.model.dependencies.get(part.slave.outputs[place].name)
        states = {r.reference for r in part.model.rows if stated is None or r.name in stated}
        found = Reach(frozenset(), frozenset({i}), frozenset((i, state) for state, _ in part.model.states if state in states))
        for j in map(int, np.flatnonzero(row)):
            more = (
                self._followed(source[j], start, known) if j in source else Reach(frozenset({(i, j)}), frozenset(), frozenset())
            )
            found = Reach(found.inputs | more.inputs, found.components | more.components, found.states | more.states)
        known[k] = found
        return found


@dataclass(frozen=True)
class Reach:
    """What an output depends on directly.

    Parameters
    ----------
    inputs : frozenset of (int, int)
        Unconnected inputs: component, place among its inputs.
    components : frozenset of int
        Its own and those whose outputs feed through to it.
    states : frozenset of (int, int)
        Component, value reference there.
    """

    inputs: frozenset[tuple[int, int]]
    components: frozenset[int]
    states: frozenset[tuple[int, int]]
