"""An FMI 1.0 Co-Simulation FMU as a slave.

FMI 1.0 has no initialization mode: fmiInitializeSlave comes with the first values of the inputs, and what is set afterwards
reaches outputs, but no states that are computed from inputs at the start. It can go back nowhere, and hears of no tolerance.
"""

import ctypes
from collections.abc import Collection, Mapping, Sequence
from dataclasses import replace
from typing import Any, ClassVar

import numpy as np

from ...errors import SlaveError
from ..signal import Value
from .buffers import Group
from .library import POINTER, Library
from .rows import Row
from .stepped import SteppedFmu
from .unpacked import LOGGER_2

MIME_TYPE = b"application/x-fmu-sharedlibrary"


class Callbacks1(ctypes.Structure):
    """fmiCallbackFunctions, handed over by value."""

    _fields_ = (
        ("logger", LOGGER_2), ("allocate", ctypes.c_void_p), ("free", ctypes.c_void_p), ("step_finished", ctypes.c_void_p),
    )  # fmt: skip


class Fmi1Slave(SteppedFmu):
    """_stop : when the run ends (s), until the FMU is initialized; None from then on."""

    types: ClassVar = {
        "Real": (np.float64, "Real"), "Integer": (np.int32, "Integer"), "Enumeration": (np.int32, "Integer"),
        "Boolean": (np.int8, "Boolean"),
    }  # fmt: skip
    prefix, state, flag = "fmi", "", ctypes.c_byte

    def _bind_start(self, library: Library) -> None:
        text, flag, double = ctypes.c_char_p, ctypes.c_byte, ctypes.c_double
        self._instantiate_call = library.function(
            "fmiInstantiateSlave", text, text, text, text, double, flag, flag, Callbacks1, flag, result=POINTER
        )
        self._initialize_call = library.function("fmiInitializeSlave", POINTER, double, flag, double)
        self._callbacks = Callbacks1(*self._kept_callbacks(), None)
        self._stop: float | None = None

    def _bind_end(self, library: Library) -> None:
        self._terminate = library.function("fmiTerminateSlave", POINTER)
        self._free = library.function("fmiFreeSlaveInstance", POINTER, result=None)

    def groups(self, rows: Sequence[Row], left_out: Collection[str] = ()) -> list[Group]:
        """With the values that the variables have, where those of their value references are the opposite."""
        found = super().groups(rows, left_out)
        return [_opposed(one) if any(row.negated for row in one.rows) else one for one in found]

    def _instantiate(self) -> Any:
        name, place = self.name.encode(), self._opened.folder.as_uri().encode()
        return self._instantiate_call(name, self.model.token.encode(), place, MIME_TYPE, 0.0, 0, 0, self._callbacks, 1)

    def _enter_initialization(self, t: float, stop: float) -> None:
        self._stop = stop

    def begin(self, values: Mapping[str, Value], t: float, stop: float) -> None:
        super().begin(values, t, stop)
        self._mode = ""

    def output(self, u: np.ndarray, t: float) -> np.ndarray:
        if self._stop is not None:
            if u.size:
                self._put(u, t, 0.0)
            self._initialize(t)
        return super().output(u, t)

    def _leave_initialization(self, t: float) -> None:
        self._initialize(t)
        self._raw = self._make_raw()

    def _initialize(self, t: float) -> None:
        if self._stop is not None:
            status = self._initialize_call(self._instance, t, self.usage.ends, self._stop)
            self._stop = None
            self.check(status, "fmiInitializeSlave", t, 0.0)

    def _judge_discard(self, t: float, h: float) -> None:
        reached = self._reached(t)
        how = "" if reached is None else f", having reached t = {reached:.9g} s"
        raise SlaveError(self.name, t, h, f"fmiDoStep answered discard{how}", self.log.said())

    def _sensitivity(self, unknowns: list[int], known: int, result: np.ndarray) -> int:
        raise AssertionError("FMI 1.0 has no directional derivatives")


def _opposed(group: Group) -> Group:
    """The group with -v instead of v, and not v for a truth value, where a row is negated."""
    sign = np.array([-1 if row.negated else 1 for row in group.rows], dtype=group.buffer.dtype)
    offset = np.array([row.negated and row.type == "Boolean" for row in group.rows], dtype=group.buffer.dtype)

    def turn() -> None:
        group.buffer[:] = offset + sign * group.buffer

    def get(instance: Any) -> int:
        status = group.get(instance)
        turn()
        return status

    def set_(instance: Any) -> int:
        turn()
        status = group.set(instance)
        turn()
        return status

    return replace(group, get=get, set=set_)
