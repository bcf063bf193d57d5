"""An FMI 2.0 Co-Simulation FMU as a slave."""

import ctypes
import sys
import time
from collections.abc import Callable
from typing import Any, ClassVar

import numpy as np

from ...errors import EndRequest, SlaveError
from .buffers import references
from .fmu import FmuSlave
from .library import POINTER, REFERENCES, SIZE, STATUS, Library
from .raw import RawFmu
from .unpacked import Callbacks2

_DO_STEP_STATUS, _LAST_SUCCESSFUL_TIME, _TERMINATED = 0, 2, 3  # kinds of fmi2Status


class Fmi2Slave(FmuSlave):
    """Inputs of higher degree reach it by fmi2SetRealInputDerivatives."""

    types: ClassVar = {
        "Real": (np.float64, "Real"), "Integer": (np.int32, "Integer"), "Enumeration": (np.int32, "Integer"),
        "Boolean": (np.int32, "Boolean"),
    }  # fmt: skip
    prefix, state = "fmi2", "FMUstate"

    def _bind_version(self, library: Library) -> None:
        function, double = library.function, ctypes.c_double
        real = [row for row in self.model.rows if row.type == "Real"]
        follows = [row.reference for row in real if row.causality == "input" and row.variability == "continuous"]
        n = self._n_smooth = len(follows)
        self._smooth = np.flatnonzero([s.smooth for s in self.inputs])
        self._du = np.zeros(2 * n)
        self._du_refs = (ctypes.c_uint * (2 * n))(*follows, *follows)
        self._du_orders = (ctypes.c_int * (2 * n))(*[1] * n, *[2] * n)
        self._du_pointer = self._du.ctypes.data_as(POINTER)
        self._instantiate_call = function(
            "fmi2Instantiate", ctypes.c_char_p, ctypes.c_int, ctypes.c_char_p, ctypes.c_char_p, POINTER, ctypes.c_int,
            ctypes.c_int, result=POINTER,
        )  # fmt: skip
        self._setup = function("fmi2SetupExperiment", POINTER, ctypes.c_int, double, double, ctypes.c_int, double)
        self._enter = function("fmi2EnterInitializationMode", POINTER)
        self._exit = function("fmi2ExitInitializationMode", POINTER)
        if not self.model.exchanged:
            self._do_step = function("fmi2DoStep", POINTER, double, double, ctypes.c_int)
        if self.description.input_degree and n:
            self._set_derivatives = function("fmi2SetRealInputDerivatives", POINTER, REFERENCES, SIZE, POINTER, POINTER)
        if self._differentiable:
            self._derivative = function(
                "fmi2GetDirectionalDerivative", POINTER, REFERENCES, SIZE, REFERENCES, SIZE, POINTER, POINTER
            )
        self._callbacks = self._make_callbacks()

    def _make_callbacks(self) -> Callbacks2:
        """Kept as long as the FMU, which holds a bare pointer to them."""
        memory = ctypes.cdll.msvcrt if sys.platform == "win32" else ctypes.CDLL(None)
        address = [ctypes.cast(function, POINTER) for function in (memory.calloc, memory.free)]
        return Callbacks2(self._opened.logger_2(), *address, None, id(self))

    def _moves(self, suffix: str, references: Any, n: int, buffer: np.ndarray) -> tuple[Callable[..., int], Callable[..., int]]:
        pointer = buffer.ctypes.data_as(POINTER)
        function = self._opened.library.function
        get, set_ = (function(f"fmi2{d}{suffix}", POINTER, REFERENCES, SIZE, POINTER) for d in ("Get", "Set"))
        return lambda instance: get(instance, references, n, pointer), lambda instance: set_(instance, references, n, pointer)

    def _instantiate(self) -> Any:
        resources = (self._opened.folder / "resources").as_uri().encode()
        kind = 1 - self.model.exchanged
        return self._instantiate_call(
            self.name.encode(), kind, self.model.token.encode(), resources, ctypes.byref(self._callbacks), 0, 1
        )

    def _enter_initialization(self, t: float, stop: float) -> None:
        given = (0, 0.0) if self.tolerance is None else (1, self.tolerance)
        self.check(self._setup(self._instance, *given, t, self.usage.ends, stop), "fmi2SetupExperiment", t, 0.0)
        self.check(self._enter(self._instance), "fmi2EnterInitializationMode", t, 0.0)

    def _leave_initialization(self, t: float) -> None:
        self.check(self._exit(self._instance), "fmi2ExitInitializationMode", t, 0.0)
        self._raw = self._make_raw()

    def try_derivatives(self, order: int, t: float) -> None:
        if self._n_smooth:
            self._du[:] = 0.0
            n = order * self._n_smooth
            status = self._set_derivatives(self._instance, self._du_refs, n, self._du_orders, self._du_pointer)
            self.check(status, "fmi2SetRealInputDerivatives", t, 0.0)

    def step(self, U: np.ndarray, t: float, h: float) -> None:
        instance = self._instance
        if self._u.size:
            self._set_inputs(U[0], t, h)
            if self.description.input_degree and self._n_smooth:
                if self._told < 2:  # an FMU hears of a derivative from when it first differs from zero
                    self._told = 2 if U[2].any() else 1 if U[1].any() else self._told
                if self._told:
                    self._du[:] = (U[1:] if self._n_smooth == self._u.size else U[1:, self._smooth]).ravel()
                    n = self._told * self._n_smooth
                    status = self._set_derivatives(instance, self._du_refs, n, self._du_orders, self._du_pointer)
                    self.check(status, "fmi2SetRealInputDerivatives", t, h)
        status = self._do_step(instance, t, h, self.final(t))
        if status > 1:
            self._step_failed(status, t, h)

    def _step_failed(self, status: int, t: float, h: float) -> None:
        """With discard, the FMU may say how far it came and whether it wants the run to end; with pending, it is waited for."""
        if status == STATUS.index("pending"):
            status = self._awaited(t, h)
            if status <= 1:
                return
        if status == 2:
            kind, pointer = ctypes.c_int, ctypes.c_void_p
            reached, ended = ctypes.c_double(t), ctypes.c_int(0)
            real = self._opened.library.function("fmi2GetRealStatus", POINTER, kind, pointer)
            boolean = self._opened.library.function("fmi2GetBooleanStatus", POINTER, kind, pointer)
            told = real(self._instance, _LAST_SUCCESSFUL_TIME, ctypes.byref(reached)) == 0
            wants = boolean(self._instance, _TERMINATED, ctypes.byref(ended)) == 0 and ended.value
            how = f", having reached t = {reached.value:.9g} s" if told else ""
            self._running = False
            if wants:
                raise EndRequest(self.name, reached.value)
            raise SlaveError(self.name, t, h, f"fmi2DoStep answered discard{how}", self.log.said())
        self.check(status, "fmi2DoStep", t, h)

    def _awaited(self, t: float, h: float) -> int:
        """The status of a step that was pending, once it has ended; it is asked for at intervals of 0.1 ms at least."""
        status, get = ctypes.c_uint(), self._opened.library.function("fmi2GetStatus", POINTER, ctypes.c_int, ctypes.c_void_p)
        pause = 1e-4
        while True:
            self.check(get(self._instance, _DO_STEP_STATUS, ctypes.byref(status)), "fmi2GetStatus", t, h)
            if status.value != STATUS.index("pending"):
                return status.value
            time.sleep(pause)
            pause = min(2 * pause, 0.05)

    def _sensitivity(self, unknowns: list[int], known: int, result: np.ndarray) -> int:
        refs, knowns, seed = (ctypes.c_uint * len(unknowns))(*unknowns), (ctypes.c_uint * 1)(known), np.ones(1)
        pointers = seed.ctypes.data_as(POINTER), result.ctypes.data_as(POINTER)
        return int(self._derivative(self._instance, refs, len(unknowns), knowns, 1, *pointers))

    def _make_raw(self) -> RawFmu | None:
        """See RawFmu; None where a signal is not real, or not smooth while derivatives would be set, or a step may be pending."""
        if self.model.exchanged or self.model.can("canRunAsynchronuously"):
            return None
        if any(g.label != "fmi2SetReal" for g in (*self._input_groups, *self._output_groups)):
            return None
        degree = self.description.input_degree
        if degree and self._n_smooth != self._u.size:
            return None
        return RawFmu(
            version=2,
            instance=self._instance,
            set_real=self.library.address("fmi2SetReal"),
            get_real=self.library.address("fmi2GetReal"),
            do_step=self.library.address("fmi2DoStep"),
            set_derivatives=self.library.address("fmi2SetRealInputDerivatives") if degree and self._n_smooth else 0,
            u_refs=references(self._input_groups),
            y_refs=references(self._output_groups),
            du_refs=np.array(self._du_refs, dtype=np.uint32),
            du_orders=np.array(self._du_orders, dtype=np.int32),
            check=self.check,
            step_failed=self._step_failed,
            derivatives_told=self._derivatives_told,
        )

    def _derivatives_told(self) -> None:
        self._told = 2
