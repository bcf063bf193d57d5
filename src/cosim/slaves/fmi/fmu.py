"""What the slaves of FMI 2.0 and FMI 3.0 have in common: signals, values, outputs, states, failures.

The run calls the FMU's functions directly, on arrays that are bound once.
"""

from abc import abstractmethod
from collections.abc import Callable, Collection, Mapping, Sequence
from dataclasses import replace
from functools import partial
from types import MappingProxyType
from typing import Any, ClassVar

import numpy as np

from ...errors import OutputError, SlaveError
from ..base import Counting, Counts, Linearisable, StateSpace, Texting, Tunable
from ..signal import Given, Text, Value
from .buffers import Group, groups
from .events import EventState
from .fmu_state import States
from .library import POINTER, STATUS, Library, status_word
from .linearisation import derivatives
from .log import Log
from .promised import PromisedFmu, hint
from .raw import Direct, RawFmu
from .rows import TEXTS, Row
from .signals import by_variable, carried, names, texts
from .structure import STRUCTURAL, in_configuration_mode, refuse_other_sizes
from .surroundings import keeping, mind_floating_point
from .texts import Texts, changed_texts
from .unpacked import OpenedFmu

INITIALIZATION = " in initialization mode, where FMI wants inputs to be set and outputs to be there"


class FmuSlave(PromisedFmu, Linearisable, Counting, Texting, Tunable, Direct):
    """Runs an FMU that is open already, and releases it in close(); begin() instantiates it anew.

    model : the FMU's own description. log : what the FMU says.
    _start, _mode : when the run begins, and what is to be said of the mode that the FMU is in.
    _note : what is known of the FMU beside its state. _put : gives it its inputs, as _put(u, t, h).
    _told : highest order of input derivatives that the FMU has heard of.
    values : given at the start, of which structural parameters count already here.
    final : whether nobody goes back to a time before a step from t (s), as final(t). by_clock : inputs that change with a clock.
    types : FMI type -> (numpy type, how the functions call it); `prefix` and `state` make the functions' names.
    """

    types: ClassVar[Mapping[str, tuple[Any, str]]]
    prefix: ClassVar[str]
    state: ClassVar[str]

    def __init__(self, name: str, opened: OpenedFmu, values: Mapping[str, Given] = MappingProxyType({})) -> None:
        super().__init__(name, opened, values)
        self.log = Log(name)
        opened.logs[id(self)] = self.log
        self._instance: Any = None
        self._raw: RawFmu | None = None
        self._running = self._dead = self._closed = False
        self._start, self._mode, self._note = 0.0, "", EventState()
        self._put: Callable[[np.ndarray, float, float], None] = self._set_inputs
        self.final: Callable[[float], bool] = lambda t: True
        try:
            self._describe()
            self._bind()
            self._bind_version(opened.library)
        except BaseException:
            self.close()
            raise

    # ---- what the two versions do in their own way

    @abstractmethod
    def _bind_version(self, library: Library) -> None:
        """The functions and arrays that only this version has."""

    def _bind_end(self, library: Library) -> None:
        """Those that end it."""
        self._terminate = library.function(f"{self.prefix}Terminate", POINTER)
        self._free = library.function(f"{self.prefix}FreeInstance", POINTER, result=None)

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

    def groups(self, rows: Sequence[Row], left_out: Collection[str] = ()) -> list[Group]:
        """Variables by the functions that move them, with their places among those given."""
        return groups(rows, self.types, self.prefix, self._moves, left_out)

    # ---- signals

    def _describe(self) -> None:
        d = self.model
        self._rows = {row.name: row for row in d.rows}
        self._differentiable = d.can("providesDirectionalDerivative") or d.can("providesDirectionalDerivatives")
        self._u, self._y = np.zeros(len(self.inputs)), np.zeros(len(self.outputs))
        self.by_clock = {row.name for row in d.rows if self.description.clocked.keys() & set(names(row))}
        self._input_groups, self._output_groups = (self.groups(carried(d, kind), self.by_clock) for kind in ("input", "output"))

    def _bind(self) -> None:
        """The functions that both versions have, under much the same names."""
        prefix, state = self.prefix, self.state
        self._bind_end(self._opened.library)
        self._texts = Texts(self._opened.library, prefix, self.check)
        if self.description.can_restore:
            self._states = States(self._opened.library, prefix, state, self.check, serialize=self.description.can_serialize)
            self.final = self._states.final

    # ---- the run

    @keeping
    def begin(self, values: Mapping[str, Value], t: float, stop: float) -> None:
        self._free_instance()
        if self.described.can_restore:
            self._states.forget()
        self.log.clear()
        self._instance = self._instantiate()
        if self._instance is None:
            reason = f"{self.prefix}Instantiate answered with no instance{hint(self.model)}"
            raise SlaveError(self.name, t, 0.0, reason, self.log.said())
        rows = list(by_variable(self._rows, values))
        structure = [(row, given) for row, given in rows if row.causality == STRUCTURAL]
        refuse_other_sizes(self.name, structure)
        if structure:
            in_configuration_mode(self.library, self._instance, self.check, t, partial(self._set_starts, structure, t))
        self._set_starts([(row, given) for row, given in rows if row.causality != STRUCTURAL], t)
        self._enter_initialization(t, stop)
        self._start, self._mode = t, INITIALIZATION
        self._learn(EventState())

    @keeping
    def finish(self) -> None:
        self._mode = ""
        self._leave_initialization(self._start)
        self._running, self._told = True, 0

    def _set_starts(self, rows: Sequence[tuple[Row, list[Value]]], t: float) -> None:
        for row, values in rows:
            if row.type in TEXTS:
                self._texts.write(self._instance, row, values, t)
                continue
            (one,) = self.groups([row])
            one.buffer[:] = values
            self.check(one.set(self._instance), f"{one.label} of {row.name!r}", t, 0.0)

    def tune(self, values: Mapping[str, Value], t: float) -> None:
        for name, value in values.items():
            row = self._rows[name] if name in self._rows else self._rows[name[: name.rindex("[")]]
            (one,) = self.groups([row])
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
        mind_floating_point(self.name)
        if not np.isfinite(self._y).all():
            k = int(np.argmin(np.isfinite(self._y)))
            reason = f"output {self.outputs[k].name!r} must be finite{self._mode}, got {self._y[k]}"
            raise OutputError(self.name, t, 0.0, reason, self.log.said())
        return self._y.copy()

    def _set_inputs(self, u: np.ndarray, t: float, h: float) -> None:
        for part in self._input_groups:
            part.buffer[:] = u[part.places]
            status = part.set(self._instance)
            if status > 1:
                self._moved(status, part.label, t, h)

    def texts(self, t: float) -> tuple[Text, ...]:
        return tuple(v for row in texts(self.model, "output") for v in self._texts.read(self._instance, row, t))

    def give_texts(self, texts: Mapping[str, Text], t: float) -> bool:
        rows = self.changed_texts(texts)
        if rows:
            self.put_texts(rows, t)
        return bool(rows)

    def changed_texts(self, texts: Mapping[str, Text]) -> list[tuple[Row, list[Value]]]:
        """The text inputs to be written now, whole, since `texts` has other ones than before; it counts as done."""
        rows, after = changed_texts(self._rows, dict(self._note.texts), texts)
        self._learn(replace(self._note, texts=after))
        return [(row, values) for row, values in rows if row.name not in self.by_clock]

    def put_texts(self, rows: Sequence[tuple[Row, list[Value]]], t: float) -> None:
        """Give text inputs their values at t (s)."""
        for row, values in rows:
            self._texts.write(self._instance, row, values, t)

    def state_space(self) -> StateSpace | None:
        groups = self._input_groups, self._output_groups
        return derivatives(self.model, self.description, *groups, self._sensitivity) if self._differentiable else None

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
            data, note = EventState.split(data)
            self._learn(note)
        else:
            self._learn(EventState())  # its texts are those of the state, which nobody here knows
        self._states.deserialize(self._instance, data)
        self._told = self.description.input_degree

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
            raise SlaveError(self.name, t, h, f"{call} answered {status_word(status)}{self._mode}", self.log.said())

    def _moved(self, status: int, call: str, t: float, h: float) -> None:
        """check() of a call that sets or gets variables: an FMU that discards it is as it was."""
        if status == STATUS.index("discard"):
            raise OutputError(self.name, t, h, f"{call} answered discard{self._mode}", self.log.said())
        self.check(status, call, t, h)

    @keeping
    def close(self) -> None:
        self._free_instance()
        if not self._closed:
            self._closed = True
            self._opened.logs.pop(id(self), None)
            self._opened.release()

    def _free_instance(self) -> None:
        self._raw, self._mode = None, ""
        instance, self._instance = self._instance, None
        running, dead, self._running, self._dead = self._running, self._dead, False, False
        if instance is not None and not dead:
            if running:
                self._terminate(instance)  # one that refuses is freed all the same
            self._free(instance)
