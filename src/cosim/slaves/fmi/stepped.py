"""What FMI 1.0 and 2.0 have in common in Co-Simulation: a step is one call, and inputs follow the derivatives that are told."""

import ctypes
import sys
import time
from abc import abstractmethod
from collections.abc import Callable
from typing import Any, ClassVar

import numpy as np

from .buffers import references
from .fmu import FmuSlave
from .library import POINTER, REFERENCES, SIZE, STATUS, Library
from .raw import RawFmu

_DO_STEP_STATUS, _LAST_SUCCESSFUL_TIME = 0, 2  # kinds of fmiStatus
DISCARD, PENDING = STATUS.index("discard"), STATUS.index("pending")


class SteppedFmu(FmuSlave):
    """Inputs of higher degree reach it by SetRealInputDerivatives.

    flag : the type of the flag that doStep is told beside t and h: newStep, or noSetFMUStatePriorToCurrentPoint. Both are true
        where nobody goes back.
    """

    flag: ClassVar[Any]

    def _bind_version(self, library: Library) -> None:
        real = [row for row in self.model.rows if row.type == "Real"]
        follows = [row.reference for row in real if row.causality == "input" and row.variability == "continuous"]
        n = self._n_smooth = len(follows)
        self._smooth = np.flatnonzero([s.smooth for s in self.inputs])
        self._du = np.zeros(2 * n)
        self._du_refs = (ctypes.c_uint * (2 * n))(*follows, *follows)
        self._du_orders = (ctypes.c_int * (2 * n))(*[1] * n, *[2] * n)
        self._du_pointer = self._du.ctypes.data_as(POINTER)
        if not self.model.exchanged:
            self._do_step = library.function(f"{self.prefix}DoStep", POINTER, ctypes.c_double, ctypes.c_double, self.flag)
        if self.description.input_degree and n:
            name = f"{self.prefix}SetRealInputDerivatives"
            self._set_derivatives = library.function(name, POINTER, REFERENCES, SIZE, POINTER, POINTER)
        self._bind_start(library)

    @abstractmethod
    def _bind_start(self, library: Library) -> None:
        """The functions by which this version starts."""

    def _kept_callbacks(self) -> tuple[Any, int, int]:
        """A logger that hands messages to the log, and where memory is taken from and given back to."""
        memory = ctypes.cdll.msvcrt if sys.platform == "win32" else ctypes.CDLL(None)
        taken, given = (ctypes.cast(function, POINTER).value or 0 for function in (memory.calloc, memory.free))
        return self._opened.logger_2(), taken, given

    def _moves(self, suffix: str, references: Any, n: int, buffer: np.ndarray) -> tuple[Callable[..., int], Callable[..., int]]:
        pointer = buffer.ctypes.data_as(POINTER)
        function = self._opened.library.function
        get, set_ = (function(f"{self.prefix}{d}{suffix}", POINTER, REFERENCES, SIZE, POINTER) for d in ("Get", "Set"))
        return lambda instance: get(instance, references, n, pointer), lambda instance: set_(instance, references, n, pointer)

    def try_derivatives(self, order: int, t: float) -> None:
        if self._n_smooth:
            self._du[:] = 0.0
            n = order * self._n_smooth
            status = self._set_derivatives(self._instance, self._du_refs, n, self._du_orders, self._du_pointer)
            self.check(status, f"{self.prefix}SetRealInputDerivatives", t, 0.0)

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
                    self.check(status, f"{self.prefix}SetRealInputDerivatives", t, h)
        status = self._do_step(instance, t, h, self.final(t))
        if status > 1:
            self._step_failed(status, t, h)

    def _step_failed(self, status: int, t: float, h: float) -> None:
        """With discard, the FMU may say how far it came and whether it wants the run to end; with pending, it is waited for."""
        if status == PENDING:
            status = self._awaited(t, h)
        if status == DISCARD:
            self._running = False
            self._judge_discard(t, h)
        self.check(status, f"{self.prefix}DoStep", t, h)

    @abstractmethod
    def _judge_discard(self, t: float, h: float) -> None:
        """EndRequest or SlaveError, as the FMU means it."""

    def _reached(self, t: float) -> float | None:
        """How far a step from t (s) came, where the FMU says."""
        reached = ctypes.c_double(t)
        real = self._opened.library.function(f"{self.prefix}GetRealStatus", POINTER, ctypes.c_int, POINTER)
        told = real(self._instance, _LAST_SUCCESSFUL_TIME, ctypes.byref(reached)) == 0
        return reached.value if told else None

    def _awaited(self, t: float, h: float) -> int:
        """The status of a step that was pending, once it has ended; it is asked for at intervals of 0.1 ms at least."""
        status, name = ctypes.c_uint(), f"{self.prefix}GetStatus"
        get = self._opened.library.function(name, POINTER, ctypes.c_int, POINTER)
        pause = 1e-4
        while True:
            self.check(get(self._instance, _DO_STEP_STATUS, ctypes.byref(status)), name, t, h)
            if status.value != PENDING:
                return status.value
            time.sleep(pause)
            pause = min(2 * pause, 0.05)

    def _make_raw(self) -> RawFmu | None:
        """See RawFmu; None where a signal is not real, or not smooth while derivatives would be set, or a step may be pending."""
        if self.model.exchanged or self.model.can("canRunAsynchronuously"):
            return None
        moved = (*self._input_groups, *self._output_groups)
        if any(g.label != f"{self.prefix}SetReal" or any(row.negated for row in g.rows) for g in moved):
            return None
        degree = self.description.input_degree
        if degree and self._n_smooth != self._u.size:
            return None
        address = self.library.address
        return RawFmu(
            version=int(self.model.version),
            instance=self._instance,
            set_real=address(f"{self.prefix}SetReal"),
            get_real=address(f"{self.prefix}GetReal"),
            do_step=address(f"{self.prefix}DoStep"),
            set_derivatives=address(f"{self.prefix}SetRealInputDerivatives") if degree and self._n_smooth else 0,
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
