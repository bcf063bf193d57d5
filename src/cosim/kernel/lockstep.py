"""The inner loop of several runs in step with one another: lockstep.c, from Python."""

import ctypes
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from ..slaves.fmi.lanes import LaneCode
from . import native
from .ctypes_calls import N_POLLED, N_Y, Y_REFS
from .driver import TIMED, FastLoop

__all__ = ["Lane", "Lockstep"]

_POINTER, _INTEGER = ctypes.c_void_p, ctypes.c_int64


class _Run(ctypes.Structure):
    """Run of lockstep.c."""

    _fields_ = [
        *((name, _POINTER) for name in ("plan", "data", "meter", "computed")),
        *((name, _INTEGER) for name in ("row", "bad", "over")),
    ]


class Lane:
    """A run that marches in step with others.

    Parameters
    ----------
    loop : FastLoop
        Its inner loop, with a compiled kernel.
    codes : sequence of LaneCode
        For each slave.
    """

    def __init__(self, loop: FastLoop, codes: Sequence[LaneCode]) -> None:
        assert loop.compiled is not None
        self.loop = loop
        asked = [
            (code.computes(int(s[Y_REFS]), int(s[n])))
            for s, code in zip(loop.slaves, codes, strict=True)
            for n in (N_Y, N_POLLED)
        ]
        self._computed = np.array(asked, dtype=np.uint8)
        self.record = _Run(*loop.compiled.records, self._computed.ctypes.data, 0, 0, 0)


@dataclass(frozen=True)
class Marched:
    """What became of each run, by its lane: whether its last step failed, and whether a stop condition holds behind it."""

    done: int
    bad: Sequence[bool]
    over: Sequence[bool]


class Lockstep:
    """Marches runs of the same components in step with one another.

    Parameters
    ----------
    kernel : native.Kernel
        The compiled kernel.
    codes : sequence of LaneCode
        For each slave.
    """

    def __init__(self, kernel: native.Kernel, codes: Sequence[LaneCode]) -> None:
        self._march, self._codes = kernel.march_lanes, codes
        self._batch = np.array([(code.step, code.output) for code in codes], dtype=np.int64)

    def lane(self, loop: FastLoop) -> Lane:
        """A lane for a run; the next march finds other instances in the lanes."""
        for code in self._codes:
            code.forget()
        return Lane(loop, self._codes)

    def march(self, lanes: Sequence[Lane | None], starts: Sequence[int], rows: int) -> Marched:
        """March all runs over `rows` macro steps, or less where one of them ends or fails.

        Parameters
        ----------
        lanes : sequence of Lane or None
            As many as the code is wide; begin() of their loops and of their meters has been called.
        starts : sequence of int
            The row that each stands at.
        rows : int
            How many steps their buffers are ready for.

        Returns
        -------
        Marched
            What was done. The last row of a run that is bad is void.
        """
        pointers = (_POINTER * len(lanes))()
        for k, (lane, row) in enumerate(zip(lanes, starts, strict=True)):
            if lane is not None:
                lane.record.row, lane.record.bad, lane.record.over = row, 0, 0
                pointers[k] = ctypes.addressof(lane.record)
        done = int(self._march(pointers, len(lanes), self._batch.ctypes.data, rows, TIMED))
        flags = [(False, False) if lane is None else (bool(lane.record.bad), bool(lane.record.over)) for lane in lanes]
        return Marched(done, [bad for bad, _ in flags], [over for _, over in flags])
