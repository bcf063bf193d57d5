"""An FMI 3.0 Co-Simulation FMU as a slave, with event mode where it has one; see gyro_cosim.slaves.fmi.events.

With event mode it may return early from a step, where an event is: the event is handled there, and the rest of the step
follows. So an event counts at its own time, whatever the macro step.
"""

import ctypes
from collections.abc import Callable
from dataclasses import replace
from typing import Any, ClassVar

import numpy as np

from ...errors import EndRequest
from .buffers import references
from .eventful import EventfulFmu
from .instantiation import Instantiation
from .library import POINTER, REFERENCES, SIZE, STATUS, Library
from .raw import RawFmu

BEYOND = 1e-3  # of a step, by which an FMU may be beyond its end by its own account
STUCK = 1000  # events and early returns at one time after which an FMU counts as stuck
_INTEGERS = {f"{sign}Int{bits}": f"{sign}Int{bits}" for bits in (8, 16, 32, 64) for sign in ("", "U")}


class Fmi3Slave(EventfulFmu):
    """Inputs of higher degree reach it by intermediate update, where it asks for them."""

    types: ClassVar = {
        "Float64": (np.float64, "Float64"), "Float32": (np.float32, "Float32"), "Boolean": (np.bool_, "Boolean"),
        "Enumeration": (np.int64, "Int64"), **{name: (getattr(np, name.lower()), name) for name in _INTEGERS},
    }  # fmt: skip
    prefix, state = "fmi3", "FMUState"

    def _bind_version(self, library: Library) -> None:
        function, double, boolean = library.function, ctypes.c_double, ctypes.c_bool
        self._bind_intermediate(library)
        self._smooth = np.flatnonzero([s.smooth for s in self.inputs])
        self._instances = Instantiation(self._opened, self.log.add)
        if not self.model.exchanged:
            self._do_step = function("fmi3DoStep", POINTER, double, double, boolean, POINTER, POINTER, POINTER, POINTER)
        self._enter = function("fmi3EnterInitializationMode", POINTER, boolean, double, double, boolean, double)
        self._exit = function("fmi3ExitInitializationMode", POINTER)
        self._answer = bytearray(16)
        self._event, self._ended, self._early = (boolean.from_buffer(self._answer, k) for k in range(3))
        self._reached = double.from_buffer(self._answer, 8)
        self._variable_step = self.model.can("canHandleVariableCommunicationStepSize")
        self._adopt(self.description)
        self._told_by_step = tuple(ctypes.byref(x) for x in (self._event, self._ended, self._early, self._reached))
        if self._differentiable:
            self._derivative = function(
                "fmi3GetDirectionalDerivative", POINTER, REFERENCES, SIZE, REFERENCES, SIZE, POINTER, SIZE, POINTER, SIZE
            )

    def _moves(self, suffix: str, references: Any, n: int, buffer: np.ndarray) -> tuple[Callable[..., int], Callable[..., int]]:
        pointer, size = buffer.ctypes.data_as(POINTER), buffer.size
        kinds = (POINTER, REFERENCES, SIZE, POINTER, SIZE)
        get, set_ = (self._opened.library.function(f"fmi3{direction}{suffix}", *kinds) for direction in ("Get", "Set"))
        return lambda it: get(it, references, n, pointer, size), lambda it: set_(it, references, n, pointer, size)

    def _instantiate(self) -> Any:
        self._inputs_known, self.intervals = False, {}
        return self._instances.instance(self.name, self._answers, with_events=self._event_mode is not None)

    def _enter_initialization(self, t: float, stop: float) -> None:
        self._forget_steps()
        given = (False, 0.0) if self.tolerance is None else (True, self.tolerance)
        self.check(self._enter(self._instance, *given, t, self.usage.ends, stop), "fmi3EnterInitializationMode", t, 0.0)
        if self._event_mode is not None:
            self.ticking.initialize(self.intervals, t)

    def _leave_initialization(self, t: float) -> None:
        self.check(self._exit(self._instance), "fmi3ExitInitializationMode", t, 0.0)
        self._first_events(t)
        self._answers.begin(self._instance, np.zeros((3, 0)), t)
        self._raw = self._make_raw()

    def try_derivatives(self, order: int, t: float) -> None:
        pass  # it asks for its inputs, and need not be told

    def step(self, U: np.ndarray, t: float, h: float) -> None:
        if self._note.ends:
            raise EndRequest(self.name, t)
        if self._u.size:
            self._put(U[0], t, h)
            if self.description.input_degree:
                self._answers.begin(self._instance, U if self._smooth.size == self._u.size else U[:, self._smooth], t)
        if self._event_mode is not None:
            self._step_through_events(U, t, h)
        else:
            self._advance(t, h)
            self._refuse_early_return(t, h)

    def _finish_step(self, U: np.ndarray, t: float, h: float, begun: bool) -> None:
        """See RawFmu."""
        if self._note.ends:
            raise EndRequest(self.name, t)
        if self._event_mode is not None:
            self._step_through_events(U, t, h, begun=begun)
        else:
            self._judge(t, h)
            self._refuse_early_return(t, h)

    def _step_through_events(self, U: np.ndarray, t: float, h: float, *, begun: bool = False) -> None:
        """In as many parts as events are in between, or times that the FMU has announced.

        begun : doStep has been called for all of it, and has answered.
        """
        end, now, stuck = t + h, t, 0
        close = 1e-9 * h + 4 * np.finfo(float).eps * abs(end)
        while end - now > close or self.ticking.due(self._note) <= now + close:
            due = min(self._note.due, self.ticking.due(self._note))
            if due > now + close:
                own = self.ticking.own_due(self._note)
                if own < end - close and not self._variable_step:
                    rule = "an FMU whose steps must not vary can have ticks at the ends of steps only (choose another macro step)"
                    self._fails(f"{rule}, a clock ticks at t = {own:.9g} s", t, h)
                part = (due if due < end - close and self._variable_step else end) - now
                reached = self._judge(now, part) if begun else self._advance(now, part)
                begun = False
                stuck = 0 if reached > now + close else stuck + 1
                now = reached
            else:
                self._event.value, stuck = True, stuck + 1
            if self._event.value or min(self._note.due, self.ticking.due(self._note)) <= now + close:
                s = now - t
                self._handle_event(U[0] + s * (U[1] + s * U[2] / 2), now, h)
                self._event.value = False
            elif end - now > close and self._u.size:  # it came back for another reason
                s = now - t
                self._set_inputs(U[0] + s * (U[1] + s * U[2] / 2), now, h)
            if self._note.ends and end - now > close:
                raise EndRequest(self.name, now)
            if stuck > STUCK:
                self._fails(f"the FMU must get on, stays at t = {now:.9g} s for {STUCK} events", t, h)

    def _advance(self, t: float, h: float) -> float:
        """fmi3DoStep; the time that it has reached."""
        self._reached.value = t + h
        status = self._do_step(self._instance, t, h, self.final(t), *self._told_by_step)
        self._step_failed(status, t, h)
        return self._judge(t, h)

    def _step_failed(self, status: int, t: float, h: float) -> None:
        how = f" (it reached t = {self._reached.value:.9g} s)" if status == 2 else ""
        self.check(status, f"fmi3DoStep{how}", t, h)

    def _judge(self, t: float, h: float) -> float:
        """What doStep has answered; the time that the FMU has reached."""
        self.check(self._answers.status, "fmi3SetFloat64 in the intermediate update", t, h)
        reached = self._reached.value
        behind = t + h - reached
        short = abs(behind) > 1e-9 * (h + abs(t))
        if short and 0.0 < -behind <= BEYOND * h and not (self._ended.value or self._early.value):
            text = f"says that a step from {t:.9g} s over {h:.9g} s ended at {reached:.9g} s, taken as its end"
            self.log.add(STATUS.index("warning"), b"lastSuccessfulTime", text.encode())
            return t + h
        if self._ended.value:
            if short and self._event_mode is None:
                raise EndRequest(self.name, reached)
            self._learn(replace(self._note, ends=True))
        elif short and not (self._event_mode is not None and self._early.value):
            if self._early.value or not 0.0 < behind < (1 + 1e-9) * self.model.own_step:
                self._refuse_short_step(t, h)
            return t + h  # it takes whole steps of its own, and the next one is not over yet
        return reached

    def _refuse_early_return(self, t: float, h: float) -> None:
        """Without event mode nobody has allowed it."""
        if self._early.value and not self._ended.value:
            self._refuse_short_step(t, h)

    def _refuse_short_step(self, t: float, h: float) -> None:
        hint = f" (its own step is fixed to {self.model.own_step:g} s)" if self.model.own_step else ""
        how = "returned early at" if self._reached.value <= t + h else "went on to"
        self._fails(f"the FMU must do the whole step, {how} t = {self._reached.value:.9g} s{hint}", t, h)

    def _make_raw(self) -> RawFmu | None:
        """See RawFmu; None where a signal is no Float64 or an array, or where discrete inputs may need event mode."""
        groups = (*self._input_groups, *self._output_groups)
        if self.model.exchanged or any(g.label != "fmi3SetFloat64" or any(row.size != 1 for row in g.rows) for g in groups):
            return None
        if self._inner is not None or (self._event_mode is not None and (self._discrete.size or self.by_clock)):
            return None
        none, address = np.zeros(2 * self._u.size, dtype=np.uint32), self.library.address
        return RawFmu(
            version=3,
            instance=self._instance,
            set_real=address("fmi3SetFloat64"),
            get_real=address("fmi3GetFloat64"),
            do_step=address("fmi3DoStep"),
            set_derivatives=0,
            u_refs=references(self._input_groups),
            y_refs=references(self._output_groups),
            du_refs=none,
            du_orders=none.astype(np.int32),
            check=self.check,
            step_failed=self._step_failed,
            asks=self.description.input_degree > 0,
            told=np.frombuffer(self._answer, dtype=np.uint8),
            finish_step=self._finish_step,
            due=lambda: -np.inf if self._note.ends else min(self._note.due, self.ticking.due(self._note)),
        )

    def _sensitivity(self, unknowns: list[int], known: int, result: np.ndarray) -> int:
        refs, knowns, seed = (ctypes.c_uint * len(unknowns))(*unknowns), (ctypes.c_uint * 1)(known), np.ones(1)
        pointers = seed.ctypes.data_as(POINTER), 1, result.ctypes.data_as(POINTER), result.size
        return int(self._derivative(self._instance, refs, len(unknowns), knowns, 1, *pointers))
