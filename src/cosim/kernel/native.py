"""kernel.c as machine code: compiled once per machine by the compiler that builds the FMUs, cached, and called through ctypes."""

import ctypes
import hashlib
import logging
import os
import platform
import tempfile
from functools import lru_cache
from pathlib import Path
from typing import Any

import numpy as np

from ..systems import catalogue
from .energy import Bonds, Sums
from .loop import Data, Plan

__all__ = ["Kernel", "cached", "kernel"]

SOURCE = "kernel.c"
_log = logging.getLogger(__name__)
_POINTER, _INTEGER, _DOUBLE = ctypes.c_void_p, ctypes.c_int64, ctypes.c_double
_ACCUMULATE: list[Any] = [
    _INTEGER, *[_POINTER] * 4, _INTEGER, _POINTER, _INTEGER, _INTEGER, _POINTER, _POINTER, _DOUBLE, *[_POINTER] * 4,
]  # fmt: skip
_PLAN = ("slaves", "source", "scale", "offset", "fresh", "sequence", "exchange", "stops", "above", "bond_inputs")
_DATA = ("Y", "t", "h", "used", "u", "du", "kept", "orders", "told", "reached", "due", "spent", "failure")


class _Plan(ctypes.Structure):
    """Plan of kernel.c."""

    _fields_ = [
        *((name, _POINTER) for name in _PLAN),
        *((name, _INTEGER) for name in ("n_slaves", "n_stops", "n_bond_inputs", "degree", "sequential")),
        ("missed", _DOUBLE),
    ]


class _Data(ctypes.Structure):
    """Data of kernel.c."""

    _fields_ = [*((name, _POINTER) for name in _DATA), ("n_Y", _INTEGER)]


class Kernel:
    """The functions of the library in `file`; OSError if it cannot be loaded."""

    def __init__(self, file: Path) -> None:
        library = ctypes.CDLL(str(file))
        self._march, self._accumulate = library.march, library.accumulate
        self._march.argtypes, self._march.restype = (_POINTER, _POINTER, _INTEGER, _INTEGER, _INTEGER), _INTEGER
        self._accumulate.argtypes, self._accumulate.restype = _ACCUMULATE, None

    def loop(self, plan: Plan, data: Data) -> "Loop":
        """loop.march for one plan and its data, whose arrays must live as long as it does."""
        return Loop(self._march, plan, data)

    def accumulate(
        self, bonds: Bonds, past: np.ndarray, Y: np.ndarray, h: np.ndarray, before: float, used: np.ndarray, sums: Sums
    ) -> None:
        """energy.accumulate."""
        arrays = [np.ascontiguousarray(array, dtype=float) for array in (past, Y, h, used)]
        at_past, at_Y, at_h, at_used = (array.ctypes.data for array in arrays)
        of_bonds, of_sums = ([array.ctypes.data for array in record] for record in (bonds, sums))
        n_bonds = bonds.factor.size
        self._accumulate(n_bonds, *of_bonds, len(past), at_past, len(h), Y.shape[1], at_Y, at_h, before, at_used, *of_sums)


class Loop:
    """march() of kernel.c on one plan and its data."""

    def __init__(self, function: Any, plan: Plan, data: Data) -> None:
        self._function, self._kept = function, (plan, data)
        self._plan = _Plan(
            *(getattr(plan, name).ctypes.data for name in _PLAN), len(plan.slaves), plan.stops.size, len(plan.bond_inputs),
            plan.degree, plan.sequential, plan.missed,
        )  # fmt: skip
        self._data = _Data(*(getattr(data, name).ctypes.data for name in _DATA), data.Y.shape[1])

    def __call__(self, row: int, rows: int, timed_every: int) -> int:
        return int(self._function(ctypes.byref(self._plan), ctypes.byref(self._data), row, rows, timed_every))


@lru_cache(maxsize=1)
def kernel() -> Kernel | str:
    """The kernel, compiled if need be, once per process; or, in words, why there is none."""
    file = _file()
    try:
        if not file.is_file():
            _build(file)
        try:
            return Kernel(file)
        except (OSError, AttributeError) as error:  # cut short or something else: made anew, or every later run would be slow
            _log.info("%s cannot be loaded, so it is compiled anew: %s", file, error)
            _build(file)
            return Kernel(file)
    except (OSError, AttributeError, RuntimeError, ValueError) as error:
        _log.warning("no compiled kernel: %s", error)
        return " ".join(str(error).split())


def cached() -> bool:
    """Whether the kernel has been compiled already, so that to load it costs nothing."""
    return _file().is_file()


@lru_cache(maxsize=1)
def _file() -> Path:
    """Where the library is kept: its name holds all that decides what is in it."""
    text = Path(__file__).with_name(SOURCE).read_bytes()
    where = f"{platform.system()} {platform.machine()} {platform.libc_ver()} {os.environ.get('CC')} {catalogue.compiler_id()}"
    name = hashlib.sha256(where.encode() + b"\0" + text).hexdigest()[:20]
    return catalogue.cache_folder().parent / "kernel" / f"{name}.so"


def _build(file: Path) -> None:
    """Compile kernel.c to `file`, complete or not at all."""
    _log.info("compiling the kernel: %s", file)
    file.parent.mkdir(parents=True, exist_ok=True)
    with tempfile.TemporaryDirectory(dir=file.parent) as scratch:
        (Path(scratch) / SOURCE).write_bytes(Path(__file__).with_name(SOURCE).read_bytes())
        ready = Path(scratch) / "ready"
        ready.write_bytes(catalogue.compiled(Path(scratch), SOURCE, "kernel"))
        ready.replace(file)
