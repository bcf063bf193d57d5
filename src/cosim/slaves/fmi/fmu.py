"""What the slaves of FMI 2.0 and FMI 3.0 have in common: signals, values, outputs, states, failures.

The run calls the FMU's functions directly, on arrays that are bound once.
"""

import ctypes
from abc import abstractmethod
from collections.abc import Callable, Mapping, Sequence
from typing import Any, ClassVar

import numpy as np

from ...errors import OutputError, SlaveError
from ..base import Counting, Counts, Linearisable, Serializable, StateSpace, Tunable
from ..signal import Value
from .buffers import Group, group, groups
from .description import Row
from .events import EventState
from .fmu_state import States
from .library import POINTER, STATUS, Library
from .log import Log
from .raw import Direct, RawFmu
from .signals import by_variable, carried, names
from .unpacked import OpenedFmu

INITIALIZATION = " in initialization mode, where FMI wants inputs to be set and outputs to be there"


class FmuSlave(Serializable, Linearisable, Counting, Tunable, Direct):
    """Runs an FMU that is open already, and releases it in close(); begin() instantiates it anew.

    model : the FMU's own description. log : what the FMU says.
    _start, _mode : when the run begins, and what is to be said of the mode that the FMU is in.
    _note : what is known of the FMU beside its state. _put : gives it its inputs, as _put(u, t, h).
    _told : highest order of input derivatives that the FMU has heard of.
    types : FMI type -> (numpy type, how the functions call it); `prefix` and `state` make the functions' names.
    """

    types: ClassVar[Mapping[str, tuple[Any, str]]]
    prefix: ClassVar[str]
    state: ClassVar[str]

    def __init__(self, name: str, opened: OpenedFmu) -> None:
        self.name, self._opened, self.model = name, opened, opened.model
        self.description = opened.description
        self.log = Log(name)
        opened.logs[id(self)] = self.log
        self._instance: Any = None
        self._raw: RawFmu | None = None
        self._running = self._dead = self._closed = False
        self._start, self._mode, self._note = 0.0, "", EventState()
        self._put: Callable[[np.ndarray, float, float], None] = self._set_inputs
        try:
            self._describe()
            self._bind()
            self._bind_version(opened.library)
        except BaseException:
            self.close()
            raise

    # ---- what the two versions do in their own way

    @property
    def file(self) -> tuple[str, str]:
        """Location and instantiation token of the FMU."""
        return self._opened.location, self.model.token

    @abstractmethod
    def _bind_version(self, library: Library) -> None:
        """The functions and arrays that only this version has."""

    @abstractmethod
    def _instantiate(self) -> Any:
        """A new instance, or None."""

    @abstractmethod
    def _enter_initialization(self, t: float, stop: float) -> None:
        """Into initialization mode."""

    @abstractmethod
    def _leave_initialization(self, t: float) -> None:
        """Out of it, ready for steps."""

    @abstractmethod
    def _set_text(self, row: Row, values: Sequence[Value]) -> None:
        """Give a string or binary variable its values."""

    @abstractmethod
    def _moves(self, suffix: str, references: Any, n: int, buffer: np.ndarray) -> tuple[Callable[..., int], Callable[..., int]]:
        """The calls get(instance) and set(instance) of variables of one type."""

    @abstractmethod
    def _sensitivity(self, unknowns: list[int], known: int, result: np.ndarray) -> int:
        """Write d(unknowns) / d(known), given by value references, into result, shape (n,); returns the status."""

    # ---- what integrates it, where it is run by Model Exchange

    @property
    def instance(self) -> Any:
        """The FMU's, from begin() on."""
        return self._instance

    @property
    def library(self) -> Library:
        """Its functions."""
        return self._opened.library

    def groups(self, rows: Sequence[Row]) -> list[Group]:
        """Variables by the functions that move them, with their places among those given."""
        return groups(rows, self.types, self.prefix, self._moves)

    # ---- signals

    def _describe(self) -> None:
        d = self.model
        self._rows = {row.name: row for row in d.rows}
        self._differentiable = d.can("providesDirectionalDerivative") or d.can("providesDirectionalDerivatives")
        self._u, self._y = np.zeros(len(self.inputs)), np.zeros(len(self.outputs))
        self._input_groups, self._output_groups = (self.groups(carried(d, kind)) for kind in ("input", "output"))

    def _bind(self) -> None:
        """The functions that both versions have, under much the same names."""
        function, prefix, state = self._opened.library.function, self.prefix, self.state
        self._terminate = function(f"{prefix}Terminate", POINTER)
        self._free = function(f"{prefix}FreeInstance", POINTER, result=None)
        if self.description.can_restore:
            self._states = States(self._opened.library, prefix, state, self.check, serialize=self.description.can_serialize)

    # ---- what C code needs, see RawFmu

    def _address(self, name: str) -> int:
        return ctypes.cast(self._opened.library.function(name), POINTER).value or 0

    def _references(self, parts: Sequence[Group]) -> np.ndarray:
        return np.array([row.reference for part in parts for row in part.rows], dtype=np.uint32)

    # ---- the run

    def begin(self, values: Mapping[str, Value], t: float, stop: float) -> None:
        self._free_instance()
        self.log.clear()
        self._instance = self._instantiate()
        if self._instance is None:
            raise SlaveError(self.name, t, 0.0, f"{self.prefix}Instantiate gave no instance", self.log.said())
        for row, given in by_variable(self._rows, values):
            self._set_start(row, given, t)
        self._enter_initialization(t, stop)
        self._start, self._mode = t, INITIALIZATION
        self._learn(EventState())

    def finish(self) -> None:
        self._mode = ""
        self._leave_initialization(self._start)
        self._running, self._told = True, 0

    def _set_start(self, row: Row, values: list[Value], t: float) -> None:
        if row.type in ("String", "Binary"):
            self._set_text(row, values)
            return
        one = group([row], (), self.types, self.prefix, self._moves)
        one.buffer[:] = values
        self.check(one.set(self._instance), f"{one.label} of {row.name!r}", t, 0.0)

    def tune(self, values: Mapping[str, Value], t: float) -> None:
        for name, value in values.items():
            row = self._rows[name] if name in self._rows else self._rows[name[: name.rindex("[")]]
            one = group([row], (), self.types, self.prefix, self._moves)
            self.check(one.get(self._instance), f"{one.label.replace('Set', 'Get')} of {row.name!r}", t, 0.0)
            one.buffer[0 if name == row.name else names(row).index(name)] = value
            self.check(one.set(self._instance), f"{one.label} of {row.name!r}", t, 0.0)

    def output(self, u: np.ndarray, t: float) -> np.ndarray:
        instance = self._instance
        if u.size:
            self._put(u, t, 0.0)
        for part in self._output_groups:
            status = part.get(instance)
            if status > 1:
                self._moved(status, part.label.replace("Set", "Get"), t, 0.0)
            if part.wide and (rounded := part.rounded()) is not None:
                name = self.outputs[rounded[0]].name
                reason = f"output {name!r} must be at most 2^53 in size to be carried exactly{self._mode}, got {rounded[1]}"
                raise SlaveError(self.name, t, 0.0, reason, self.log.said())
            self._y[part.places] = part.buffer
        if not np.isfinite(self._y).all():
            for signal, value in zip(self.outputs, self._y, strict=True):
                if not np.isfinite(value):
                    reason = f"output {signal.name!r} must be finite{self._mode}, got {value}"
                    raise OutputError(self.name, t, 0.0, reason, self.log.said())
        return self._y.copy()

    def _set_inputs(self, u: np.ndarray, t: float, h: float) -> None:
        for part in self._input_groups:
            part.buffer[:] = u[part.places]
            status = part.set(self._instance)
            if status > 1:
                self._moved(status, part.label, t, h)

    def state_space(self) -> StateSpace | None:
        states = self.model.states
        plain = all(row.size == 1 for part in (*self._input_groups, *self._output_groups) for row in part.rows)
        if not self._differentiable or not plain or any(not s.smooth for s in (*self.inputs, *self.outputs)):
            return None
        if self._output_groups and len(self._output_groups) != 1:
            return None
        n_x, n_u, n_y = len(states), len(self.inputs), len(self.outputs)
        unknowns = [derivative for _, derivative in states] + [self._rows[s.name].reference for s in self.outputs]
        knowns = [state for state, _ in states] + [self._rows[s.name].reference for s in self.inputs]
        M, column = np.zeros((n_x + n_y, n_x + n_u)), np.zeros(n_x + n_y)
        for k, known in enumerate(knowns if unknowns else []):
            if self._sensitivity(unknowns, known, column) > 1:
                return None  # states as knowns are beyond what the standard asks of Co-Simulation
            M[:, k] = column
        return StateSpace(M[:n_x, :n_x], M[:n_x, n_x:], M[n_x:, :n_x], M[n_x:, n_x:])

    # ---- states

    def save(self) -> Any:
        return self._states.save(self._instance), self._note

    def restore(self, snapshot: Any) -> None:
        self._states.restore(self._instance, snapshot[0])
        self._learn(snapshot[1])

    def discard(self, snapshot: Any) -> None:
        if self._instance is not None:
            self._states.discard(self._instance, snapshot[0])

    def serialize(self) -> bytes:
        self._must_serialize()
        state = self._states.serialize(self._instance)
        return state + self._note.packed() if self.description.counts_events else state

    def deserialize(self, data: bytes) -> None:
        self._must_serialize()
        if self.description.counts_events:
            data, note = EventState.split(data, len(self._note.discrete))
            self._learn(note)
        self._states.deserialize(self._instance, data)
        self._told = 2

    def _learn(self, note: EventState) -> None:
        self._note = note

    @property
    def counts(self) -> Counts:
        return Counts(self._note.events if self.description.counts_events else None, self.log.warnings, self.log.first_warning)

    @property
    def raw(self) -> RawFmu | None:
        return self._raw

    def _must_serialize(self) -> None:
        if not self.description.can_serialize:
            raise ValueError(f"component {self.name!r} must be able to serialize its state, FMU {self._opened.location!r} cannot")

    # ---- failure and the end

    def check(self, status: int, call: str, t: float, h: float) -> None:
        """SlaveError, with what the FMU has logged, for a status worse than a warning."""
        if status > 1:
            self._running = False
            self._dead = self._dead or status == STATUS.index("fatal")  # it must not be called any more
            what = STATUS[status] if status < len(STATUS) else f"status {status}"
            raise SlaveError(self.name, t, h, f"{call} answered {what}{self._mode}", self.log.said())

    def _moved(self, status: int, call: str, t: float, h: float) -> None:
        """check() of a call that sets or gets variables: an FMU that discards it is as it was."""
        if status == STATUS.index("discard"):
            raise OutputError(self.name, t, h, f"{call} answered discard{self._mode}", self.log.said())
        self.check(status, call, t, h)

    def close(self) -> None:
        self._free_instance()
        if not self._closed:
            self._closed = True
            self._opened.logs.pop(id(self), None)
            self._opened.release()

    def _free_instance(self) -> None:
        self._raw, self._mode = None, ""
        instance, self._instance = self._instance, None
        if instance is None or self._dead:
            self._running = self._dead = False
            return
        if self._running:
            self._running = False
            self._terminate(instance)  # one that refuses is freed all the same
        self._free(instance)
