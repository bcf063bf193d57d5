"""kernel.c and lockstep.c as machine code: compiled once per machine by the compiler of the FMUs, cached, called by ctypes."""

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

from ..systems import catalogue, machine_code
from .energy import Bonds, Sums
from .loop import Data, Plan

__all__ = ["Kernel", "cached", "kernel"]

SOURCES = ("lockstep.c", "kernel.c")  # the first includes the other
_log = logging.getLogger(__name__)
_POINTER, _INTEGER, _DOUBLE = ctypes.c_void_p, ctypes.c_int64, ctypes.c_double
_PLAN = ("slaves", "places", "source", "scale", "offset", "fresh", "sequence", "exchange", "stops", "above", "bond_inputs")
_DATA = (
    "Y", "t", "h", "whole", "used", "u", "du", "kept", "read", "orders", "told", "reached", "due", "spent", "failure",
)  # fmt: skip
_METER = ("signals", "inverse", "offset", "factor", "residual", "exchanged", "peak", "past", "before")


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


class _Meter(ctypes.Structure):
    """Meter of kernel.c."""

    _fields_ = [*((name, _POINTER) for name in _METER), ("n_bonds", _INTEGER), ("known", _INTEGER)]


class Kernel:
    """The functions of the library in `file`; OSError if it cannot be loaded."""

    def __init__(self, file: Path) -> None:
        self._march = ctypes.CDLL(str(file)).march
        self._march.argtypes, self._march.restype = (*[_POINTER] * 3, *[_INTEGER] * 3), _INTEGER
        self.march_lanes = ctypes.PyDLL(str(file)).march_lanes  # what it calls works in one place only
        self.march_lanes.argtypes, self.march_lanes.restype = (_POINTER, _INTEGER, _POINTER, _INTEGER, _INTEGER), _INTEGER

    def loop(self, plan: Plan, data: Data, bonds: Bonds) -> "Loop":
        """loop.march and energy.accumulate for one plan and its data, whose arrays must live as long as it does."""
        return Loop(self._march, plan, data, bonds)


class Loop:
    """march() of kernel.c on one plan and its data."""

    def __init__(self, function: Any, plan: Plan, data: Data, bonds: Bonds) -> None:
        self._function, self._kept = function, (plan, data, bonds)
        self._plan = _Plan(
            *(getattr(plan, name).ctypes.data for name in _PLAN), len(plan.slaves), plan.stops.size, len(plan.bond_inputs),
            plan.degree, plan.sequential, plan.missed,
        )  # fmt: skip
        self._data = _Data(*(getattr(data, name).ctypes.data for name in _DATA), data.Y.shape[1])
        n_bonds = bonds.factor.size
        self._sums, self._past, self._before = np.zeros((3, n_bonds)), np.zeros((3, 2 * n_bonds)), np.zeros(1)
        arrays = (*bonds, *self._sums, self._past, self._before)
        self._meter = _Meter(*(array.ctypes.data for array in arrays), n_bonds, 0)
        self.records = [ctypes.addressof(record) for record in (self._plan, self._data, self._meter)]

    def __call__(self, row: int, rows: int, timed_every: int, past: np.ndarray, before: float, sums: Sums) -> int:
        """loop.march, with energy.accumulate on the steps that it does: `past` and `before` as there, `sums` are added to."""
        self.begin(past, before, sums)
        done = int(self._function(*self.records, row, rows, timed_every))
        self.end(sums)
        return done

    def begin(self, past: np.ndarray, before: float, sums: Sums) -> None:
        """Put the meter where the steps before have left it."""
        known = self._meter.known = len(past)
        self._past[:known], self._before[0], self._sums[:] = past[::-1], before, sums

    def end(self, sums: Sums) -> None:
        """Take over what the meter has summed."""
        for total, new in zip(sums, self._sums, strict=True):
            total[:] = new


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
    text = b"\0".join(Path(__file__).with_name(source).read_bytes() for source in SOURCES)
    where = f"{platform.system()} {platform.machine()} {platform.libc_ver()} {os.environ.get('CC')} {machine_code.compiler_id()}"
    name = hashlib.sha256(where.encode() + b"\0" + text).hexdigest()[:20]
    return catalogue.cache_folder().parent / "kernel" / f"{name}.so"


def _build(file: Path) -> None:
    """Compile the kernel to `file`, complete or not at all."""
    _log.info("compiling the kernel: %s", file)
    file.parent.mkdir(parents=True, exist_ok=True)
    with tempfile.TemporaryDirectory(dir=file.parent) as scratch:
        for source in SOURCES:
            (Path(scratch) / source).write_bytes(Path(__file__).with_name(source).read_bytes())
        ready = Path(scratch) / "ready"
        ready.write_bytes(machine_code.compiled(Path(scratch), SOURCES[0], "kernel"))
        ready.replace(file)
