"""An FMI 2.0 FMU as a slave."""

import ctypes
from typing import Any, ClassVar

import numpy as np

from ...errors import EndRequest, SlaveError
from .library import POINTER, REFERENCES, SIZE, Library
from .stepped import SteppedFmu
from .unpacked import Callbacks2

_TERMINATED = 3  # kind of fmi2Status


class Fmi2Slave(SteppedFmu):
    """By Co-Simulation, or what exchange.ExchangeSlave integrates."""

    types: ClassVar = {
        "Real": (np.float64, "Real"), "Integer": (np.int32, "Integer"), "Enumeration": (np.int32, "Integer"),
        "Boolean": (np.int32, "Boolean"),
    }  # fmt: skip
    prefix, state, flag = "fmi2", "FMUstate", ctypes.c_int

    def _bind_start(self, library: Library) -> None:
        function, double = library.function, ctypes.c_double
        self._instantiate_call = function(
            "fmi2Instantiate", ctypes.c_char_p, ctypes.c_int, ctypes.c_char_p, ctypes.c_char_p, POINTER, ctypes.c_int,
            ctypes.c_int, result=POINTER,
        )  # fmt: skip
        self._setup = function("fmi2SetupExperiment", POINTER, ctypes.c_int, double, double, ctypes.c_int, double)
        self._enter = function("fmi2EnterInitializationMode", POINTER)
        self._exit = function("fmi2ExitInitializationMode", POINTER)
        if self._differentiable:
            self._derivative = function(
                "fmi2GetDirectionalDerivative", POINTER, REFERENCES, SIZE, REFERENCES, SIZE, POINTER, POINTER
            )
        self._callbacks = Callbacks2(*self._kept_callbacks(), None, id(self))  # the FMU holds a bare pointer to them

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

    def _judge_discard(self, t: float, h: float) -> None:
        reached, ended = self._reached(t), ctypes.c_int(0)
        boolean = self._opened.library.function("fmi2GetBooleanStatus", POINTER, ctypes.c_int, POINTER)
        if boolean(self._instance, _TERMINATED, ctypes.byref(ended)) == 0 and ended.value:
            raise EndRequest(self.name, t if reached is None else reached)
        how = "" if reached is None else f", having reached t = {reached:.9g} s"
        raise SlaveError(self.name, t, h, f"fmi2DoStep answered discard{how}", self.log.said())

    def _sensitivity(self, unknowns: list[int], known: int, result: np.ndarray) -> int:
        refs, knowns, seed = (ctypes.c_uint * len(unknowns))(*unknowns), (ctypes.c_uint * 1)(known), np.ones(1)
        pointers = seed.ctypes.data_as(POINTER), result.ctypes.data_as(POINTER)
        return int(self._derivative(self._instance, refs, len(unknowns), knowns, 1, *pointers))
