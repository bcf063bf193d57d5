"""The slaves of a system, opened and wired: whose output feeds which input, in which unit, in which order."""

from collections.abc import Mapping, Sequence
from contextlib import ExitStack
from copy import copy
from functools import partial
from itertools import pairwise
from time import perf_counter

import numpy as np

from ..errors import WiringError, unknown
from ..slaves import Counts, Slave, counts
from ..systems import Connection, System
from .bonds import power_bonds
from .clocks import ClockWires
from .driving import what_drives
from .evaluation import Evaluation
from .inputs import Inputs, first_guess
from .joining import Transfer, transfer
from .projection import projected
from .texts import TextWires
from .told import notes_of
from .wiring import check_ports, connections, refuse_excluded, sequence, start_inputs, sub_steps


class Network:
    """The slaves of a system with their wiring. Y, shape (n_Y,), holds the outputs of all slaves one after another.

    Parameters
    ----------
    system : System
        What is wired.
    slaves : sequence of Slave
        Its components, opened, in its order.
    substeps : mapping of str to int, optional
        In how many parts a component, by its name, does each macro step.

    Attributes
    ----------
    names, units : tuple of str, n_Y of each
        Of Y, as `component.variable`.
    slices : tuple of slice
        Where the outputs of each slave stand in Y.
    start : float
        When initialize() was, s.
    order, stepping : tuple of int
        Slaves, sources before what feeds through; Gauss-Seidel steps in this order where it is told no other. The order in which
        others step.
    one_pass : bool
        Whether one evaluation of each slave in that order makes all outputs consistent.
    loops, initial_loops : tuple of str
        Each algebraic loop spelled out, which outputs() solves; those of initialization mode, where they are others.
    notes : tuple of str
        What is to be told: the system's own notes, and values of parameter files that fit no variable.
    texts, clocks : TextWires, ClockWires
        The connections between strings or binaries, and between clocks; true where there are any.
    coupled, held : ndarray of int
        Places in Y that feed an input; places that are never extrapolated.
    driving : Driving
        What time series and a scenario come to.

    Raises
    ------
    WiringError
        Connections that cannot be made.
    ValueError
        Values that do not fit.
    """

    def __init__(self, system: System, slaves: Sequence[Slave], *, substeps: Mapping[str, int] | None = None) -> None:
        self.system, self.slaves = system, tuple(slaves)
        place = {s.name: i for i, s in enumerate(self.slaves)}
        ends = np.cumsum([0, *(len(s.outputs) for s in self.slaves)])
        self.slices = tuple(slice(int(a), int(b)) for a, b in pairwise(ends))
        self.names = tuple(f"{s.name}.{y.name}" for s in self.slaves for y in s.outputs)
        self._where = {name: k for k, name in enumerate(self.names)}
        self.units = tuple(y.unit for s in self.slaves for y in s.outputs)
        self.values = tuple(
            s.description.start_values(s.name, part.values, part.bound)
            for s, part in zip(self.slaves, system.components, strict=True)
        )
        for part, slave in zip(system.components, self.slaves, strict=True):
            check_ports(part, slave)
        self.notes = notes_of(system, self.slaves)
        made: list[Inputs] = []
        signals = tuple(y for s in self.slaves for y in s.outputs)
        wires = {c.end: c for c in connections(system, self.slaves)}
        self.clocks = ClockWires(self.slaves, wires)
        self.feeds: dict[int, list[tuple[int, int]]] = {}  # place in Y -> the (slave, place in u) it feeds
        for i, slave in enumerate(self.slaves):
            joined = []
            for j, signal in enumerate(slave.inputs):
                wire = wires.pop((slave.name, signal.name), None)
                if wire is not None:
                    source = self._place(wire, place)
                    self.feeds.setdefault(source, []).append((i, j))
                    joined.append((source, j, transfer(wire, signals[source], signal)))
            made.append(Inputs(joined, start_inputs(slave, self.values[i])))
        self.texts = TextWires(self.slaves, wires)
        for end, wire in wires.items():
            slave = self.slaves[place[end[0]]]
            refuse_excluded(wire, 1, slave)
            raise unknown(f"input of {slave.name!r}:", end[1], [s.name for s in slave.inputs])
        self._do_step_s, self.start = np.zeros(len(self.slaves)), 0.0
        self.substeps = sub_steps(self.slaves, substeps or {})
        self.held = np.flatnonzero([not y.smooth for s in self.slaves for y in s.outputs])
        self.coupled = np.array(sorted(self.feeds), dtype=int)
        self._evaluate()
        self.notes += tuple(self.clocks.late(self.order))
        self.bonds = power_bonds(system, self._where, self.units, self.feeds)
        connected = {end: self.names[k] for k, ends in self.feeds.items() for end in ends}
        self.driving = what_drives(system, self.slaves, connected, self.values, [inputs.start for inputs in made])
        self._wired = tuple(inputs.following(self.driving.of_slave(i)) for i, inputs in enumerate(made))
        self._inputs = list(self._wired)

    def refuse_loops(self) -> None:
        """WiringError if the system has an algebraic loop."""
        for found, when in ((self.loops, ""), (self.initial_loops, " in initialization mode")):
            if found:
                raise WiringError(f"system {self.system.name!r} must have no algebraic loop{when}, has {found[0]}")

    def place(self, signal: tuple[str, str]) -> int:
        """Where the output (component, variable) stands in Y."""
        name = ".".join(signal)
        if name not in self._where:
            raise unknown("output:", name, self.names)
        return self._where[name]

    def _place(self, wire: Connection, place: Mapping[str, int]) -> int:
        """Where the source of a connection stands in Y."""
        place_in_Y = self._where.get(".".join(wire.start))
        if place_in_Y is None:
            refuse_excluded(wire, 0, self.slaves[place[wire.start[0]]])
            names = [y.name for y in self.slaves[place[wire.start[0]]].outputs]
            raise unknown(f"output of {wire.start[0]!r}:", wire.start[1], names)
        return place_in_Y

    def inputs(self, i: int, C: np.ndarray, t: float = 0.0, h: float = 0.0) -> np.ndarray:
        """The input polynomial U, shape (m, n_u), of slave i from C, shape (m, n_Y): value and derivatives of all outputs.

        t, h : where a step begins and how long it is, s, for inputs that follow a time series; h = 0 for values alone.
        """
        return self._inputs[i].of(C, t, h)

    def wires(self, i: int) -> list[tuple[int, int, float, float]]:
        """The connected inputs of slave i: place in Y of the source, place in u, factor and offset between their units."""
        return self._wired[i].joined

    def present_wires(self, i: int) -> list[tuple[int, int, float, float]]:
        """The same with what alter() has made of them."""
        return self._inputs[i].joined

    def start_inputs(self, i: int, t: float | None = None) -> np.ndarray:
        """The start values of slave i's inputs, shape (n_u,), which unconnected ones keep; what they are at t (s) where given."""
        return self._inputs[i].start.copy() if t is None else self._inputs[i].at_rest(t)

    def alter(self, changes: Mapping[tuple[int, int], tuple[float, float]]) -> None:
        """Make of connected inputs, (slave, place in u), factor * what comes + value; all others are as the system says."""
        for i, inputs in enumerate(self._wired):
            own = {j: change for (k, j), change in changes.items() if k == i}
            self._inputs[i] = inputs.altered(own) if own else inputs

    def outputs(self, Y: np.ndarray, t: float) -> np.ndarray:
        """All outputs at t (s), consistent with the inputs they cause; Y, which may be old, is written in place."""
        self._evaluation.outputs(Y, t)
        self.texts.settle(t, partial(self._evaluation.outputs, Y, t))
        return Y

    def evaluate(self, i: int, Y: np.ndarray, t: float) -> None:
        """The outputs of slave i at t (s) for the inputs that Y gives it, written into Y."""
        Y[self.slices[i]] = self.slaves[i].output(self._inputs[i].of(Y[None, :], t)[0], t)

    def step(self, i: int, U: np.ndarray, t: float, h: float) -> np.ndarray:
        """Step slave i from t over h (s) under U, shape (3, n_u), in as many parts as `substeps` says.

        Returns the U that it followed: what the slave cannot follow is projected on what it can. The time that the slave
        takes is counted in `do_step_s`.
        """
        slave, parts = self.slaves[i], self.substeps[i]
        began = perf_counter()
        if parts == 1:
            U = projected(U, h, slave.description.input_degree)
            slave.step(U, t, h)
        else:
            part = h / parts
            for m in range(parts):
                s = m * part
                moved = np.array([U[0] + U[1] * s + U[2] * (s * s / 2), U[1] + U[2] * s, U[2]])
                slave.step(projected(moved, part, slave.description.input_degree), t + s, part)
        self._do_step_s[i] += perf_counter() - began
        if self.clocks:
            self.clocks.pass_on(i, self._inputs, self.slices)
        return U

    def of_deviations(self, slaves: Sequence[Slave]) -> "Network":
        """The same wiring and sub-steps for slaves that carry deviations from this network's values: no offsets, no starts."""
        twin = copy(self)
        twin.slaves, twin._do_step_s = tuple(slaves), np.zeros(len(slaves))
        twin.values, twin.clocks = ({},) * len(slaves), ClockWires((), {})
        twin._inputs = [
            Inputs([(k, j, Transfer(factor)) for k, j, factor, _ in inputs.joined], np.zeros_like(inputs.start))
            for inputs in self._inputs
        ]
        twin._wired = tuple(twin._inputs)
        twin._evaluate()
        return twin

    @property
    def tabled(self) -> bool:
        """Whether a mapping table stands between two connectors."""
        return any(inputs.tables for inputs in self._wired)

    @property
    def initial_exchange(self) -> tuple[int, ...]:
        """The slaves in the order in which a round of initialization mode evaluates them, where there is no algebraic loop."""
        return self._initial.exchange

    def initialize(self, t: float, stop: float) -> np.ndarray:
        """Start every slave at t (s); returns the first Y.

        All enter initialization mode, exchange outputs and inputs there until these agree, and leave it together.
        """
        self._do_step_s, self.start = np.zeros(len(self.slaves)), t
        self._inputs = list(self._wired)
        for i, (slave, values) in enumerate(zip(self.slaves, self.values, strict=True)):
            slave.begin(values | self.driving.starts(i, slave, t), t, stop)
        self._evaluation.recall()  # a run must not depend on the one before
        self._initial.recall()
        Y = np.zeros(len(self.names))
        for k in {*self._initial.looping, *self._evaluation.looping}:
            output = next(s.outputs[k - part.start] for s, part in zip(self.slaves, self.slices, strict=True) if k < part.stop)
            Y[k] = first_guess(output, self.feeds[k], self.slaves, self._inputs, self.values)
        self._initial.settle(Y, t)
        self.texts.settle(t, partial(self._initial.settle, Y, t))
        self.clocks.begin()
        for i in self.stepping:
            self.slaves[i].finish()
            self.clocks.pass_on(i, self._inputs, self.slices)
        return self.outputs(Y, t)

    def _evaluate(self) -> None:
        """How outputs are made consistent, at communication points and in initialization mode."""
        through = [s.description.feedthrough for s in self.slaves]
        self._evaluation = self._initial = Evaluation(self, through, self.feeds)
        self.loops, self.one_pass = self._evaluation.loops, self._evaluation.one_pass
        self.order = self.clocks.ordered(self._evaluation.order)
        self.stepping = self.order if self.clocks else tuple(range(len(self.slaves)))
        self.initial_loops: tuple[str, ...] = ()
        initial = [s.description.initial_feedthrough for s in self.slaves]
        if any(not np.array_equal(a, b) for a, b in zip(through, initial, strict=True)):
            self._initial = Evaluation(self, initial, self.feeds)
            self.initial_loops = self._initial.loops

    def sequence(self, names: Sequence[str] = ()) -> tuple[int, ...]:
        """Slave indices in the order in which Gauss-Seidel steps them: as given, else the order of evaluation."""
        return sequence(self.slaves, names) if names else self.order

    @property
    def do_step_s(self) -> dict[str, float]:
        """Seconds that each slave has spent in steps since initialize()."""
        return dict(zip((s.name for s in self.slaves), self._do_step_s.tolist(), strict=True))

    def count_time(self, spent: np.ndarray) -> None:
        """Add seconds, shape (number of slaves,), that were spent in steps by a loop of its own."""
        self._do_step_s = self._do_step_s + spent

    @property
    def kept(self) -> tuple[np.ndarray | None, ...]:
        """What the algebraic loops keep from one communication point to the next; a part of the state of a run."""
        return self._evaluation.kept

    def recall(self, kept: Sequence[np.ndarray | None]) -> None:
        """Put back what `kept` was."""
        self._evaluation.recall(kept)

    def counts(self) -> dict[str, Counts]:
        """What each slave has counted since the start: events, warnings."""
        return {s.name: counts(s) for s in self.slaves}

    def close(self) -> None:
        """Close every slave, also where one fails to."""
        with ExitStack() as stack:
            for slave in reversed(self.slaves):
                stack.callback(slave.close)

    def __enter__(self) -> "Network":
        return self

    def __exit__(self, *error: object) -> None:
        self.close()
