"""What the inner loop of cosim/kernel/loop.py needs of a network, and whether it can run it at all."""

import ctypes
import sys
import time
from functools import lru_cache, partial
from typing import Any

import numpy as np

from ..coupling import Algorithm, GaussSeidel, Jacobi
from ..errors import SlaveError
from ..network import Network
from ..slaves.base import RawFmu
from . import ctypes_calls, loop

TIMED = 64  # the compiled loop times one step in so many: the clock takes as long as a small FMU's step
_FINISH = ctypes.CFUNCTYPE(ctypes.c_int, ctypes.c_double, ctypes.c_double, ctypes.c_int)
LONG = 15_000  # slave steps from which compiling, or loading what was compiled before, pays


class FastLoop:
    """The inner loop on a network of FMUs under Jacobi or Gauss-Seidel.

    Y, t, h : buffers of outputs, times and steps, whose rows before `row` hold the history when march() is called.
    used : shape (rows, 2 bonds, 3), the inputs of the power bonds that each step followed.
    """

    def __init__(
        self, network: Network, algorithm: Algorithm, Y: np.ndarray, t: np.ndarray, h: np.ndarray, used: np.ndarray
    ) -> None:
        self._network, self._degree = network, algorithm.degree
        self._sequential = isinstance(algorithm, GaussSeidel)
        sequence = network.sequence(algorithm.sequence) if isinstance(algorithm, GaussSeidel) else range(len(network.slaves))
        self._sequence, self._exchange = np.array(sequence, dtype=np.int64), np.array(network.order, dtype=np.int64)
        wires = [network.wires(i) for i in range(len(network.slaves))]
        first = np.cumsum([0, *map(len, wires)])  # of each slave's connected inputs; the others are given once, here
        joined = [wire for of_slave in wires for wire in of_slave]
        self._source = np.array([w[0] for w in joined], dtype=np.int64)
        self._scale, self._offset = (np.array([w[c] for w in joined], dtype=float) for c in (2, 3))
        self._fresh = np.zeros(len(joined), dtype=np.int64)
        if self._sequential:
            turn = np.empty(len(network.slaves), dtype=int)
            turn[self._sequence] = np.arange(turn.size)
            owner = np.repeat(np.arange(turn.size), [len(s.outputs) for s in network.slaves])
            self._fresh[:] = turn[owner[self._source]] < np.repeat(turn, [len(w) for w in wires])
        self._u, self._du = np.zeros(len(joined) + 1), np.zeros(2 * len(joined) + 1)
        self._orders = np.zeros(len(network.slaves), dtype=np.int64)
        self._Y, self._t, self._h, self._used = Y, t, h, used
        self._stops = np.array([network.place(stop.signal) for stop in network.system.stop_when], dtype=np.int64)
        self._above = np.array([stop.above for stop in network.system.stop_when], dtype=float)
        bond_inputs = [place for bond in network.bonds for place in (bond.motion_input, bond.effort_input)]
        self._bond_inputs = np.zeros((len(bond_inputs), 3), dtype=np.int64)
        for row, (i, j) in enumerate(bond_inputs):
            (place,) = (q for q, wire in enumerate(wires[i]) if wire[1] == j)
            self._bond_inputs[row] = first[i] + place, 2 * first[i] + place, 2 * first[i] + len(wires[i]) + place
        self._table = np.zeros((len(network.slaves), len(ctypes_calls.COLUMNS)), dtype=np.int64)
        self._raws: list[RawFmu] = []
        self._connected: list[slice] = []
        self._kept_alive: list[Any] = []  # what the table holds addresses of
        self._told = np.zeros((len(network.slaves), 16), dtype=np.uint8)
        self._due = np.full(len(network.slaves), np.inf)
        self._error: BaseException | None = None
        for i, slave in enumerate(network.slaves):
            raw = slave.raw
            assert raw is not None
            self._raws.append(raw)
            n_u, places = len(slave.inputs), np.array([w[1] for w in wires[i]], dtype=np.int64)
            later = np.concatenate([places, n_u + places])
            references = (raw.u_refs[places], raw.du_refs[later], raw.du_orders[later])
            self._kept_alive += references
            u_refs, du_refs, du_orders = (r.ctypes.data for r in references)
            feeds_through = bool(slave.feedthrough[:, places].any())
            self._connected.append(slice(first[i], first[i] + len(places)))
            finish = 0
            if raw.due is not None:
                self._due[i] = raw.due()
                callback = _FINISH(partial(self._finish_step, i, places))
                self._kept_alive.append(callback)
                finish = ctypes.cast(callback, ctypes.c_void_p).value or 0
            self._table[i] = (
                raw.instance, raw.set_real, raw.get_real, raw.do_step, raw.set_derivatives, u_refs, raw.y_refs.ctypes.data,
                du_refs, du_orders, raw.no_set_state, len(places), len(slave.outputs), network.slices[i].start, first[i],
                slave.input_degree, feeds_through, raw.version, self._told[i].ctypes.data, finish,
            )  # fmt: skip
            others = np.setdiff1d(np.arange(n_u), places)
            if others.size:
                refs, values = raw.u_refs[others], network.start_inputs(i)[others]
                status = ctypes_calls.move_values(
                    raw.version, raw.set_real, raw.instance, refs.ctypes.data, others.size, values.ctypes.data
                )
                raw.check(status, ctypes_calls.CALLS[raw.version][1], float(t[0]), 0.0)
        self._now = np.zeros(2, dtype=np.int64)
        self._kept, self._failure = np.zeros(len(joined) + 1), np.zeros(3, dtype=np.int64)
        buffers = (self._u, self._du, self._Y, self._now)
        self._clock = _clock_address()
        self._pointers = np.array(
            [*(b.ctypes.data for b in buffers), self._clock, getattr(time, "CLOCK_MONOTONIC", 0)], dtype=np.int64
        )
        self._spent = np.zeros(len(network.slaves))

    def march(self, row: int, rows: int, *, fast: bool) -> int:
        """`rows` macro steps after row `row` of the buffers; SlaveError for the slave that fails, with `done` rows before it.

        fast : run the compiled loop; else the same source as Python runs it.
        """
        function = compiled() if fast else None
        timed_every = 0 if not self._clock else TIMED if function else 1
        self._failure[:], self._spent[:] = 0, 0.0
        began = time.perf_counter()
        done = int(
            (function or loop.march)(
                self._table, self._source, self._fresh, self._scale, self._offset, self._u, self._du, self._orders,
                self._sequence, self._exchange, self._sequential, self._degree, self._Y, self._t, self._h, row, rows,
                self._stops, self._above, self._bond_inputs, self._used, timed_every, self._now, self._spent, self._pointers,
                self._kept, self._failure, self._told, self._told.view(float), self._due,
            )
        )  # fmt: skip
        took, inside = time.perf_counter() - began, float(self._spent.sum())
        share = min(1.0, took / inside) if inside > 0.0 else 1.0  # a timed step may be the one that had to wait for a core
        self._network.do_step_s = [a + share * b for a, b in zip(self._network.do_step_s, self._spent.tolist(), strict=True)]
        reached = self._Y[row + 1 : row + 1 + min(done + 1, rows)]  # with the row that a march that stopped has begun
        if done < rows or not np.isfinite(reached.sum()):
            bad = ~np.isfinite(reached).all(axis=1)
            done = min(done, int(np.argmax(bad))) if bad.any() else done
        return done

    def _finish_step(self, i: int, places: np.ndarray, t: float, h: float, begun: int) -> int:
        """What is left of a step of slave i, which is of FMI 3.0; called from within the march."""
        raw, u = self._raws[i], self._network.start_inputs(i)
        assert raw.finish_step is not None
        assert raw.told is not None
        assert raw.due is not None
        u[places] = self._u[self._connected[i]]
        raw.told[:] = self._told[i]
        try:
            raw.finish_step(np.array([u, np.zeros_like(u), np.zeros_like(u)]), t, h, bool(begun))
        except BaseException as error:  # it must not get lost in the machine code that calls this
            self._error = error
            return ctypes_calls.RAISED
        self._due[i] = raw.due()
        return 0

    def explain(self, row: int) -> None:
        """Raise the SlaveError of what stopped a march at the step after row `row`."""
        t, h = float(self._t[row]), float(self._h[row + 1])
        i, call, status = (int(x) for x in self._failure)
        infinite = np.flatnonzero(~np.isfinite(self._Y[row + 1]))
        if not infinite.size:
            raw = self._raws[i]
            if self._error is not None:
                raise self._error
            if ctypes_calls.CALLS[raw.version][call].endswith("DoStep"):
                if raw.told is not None:
                    raw.told[:] = self._told[i]
                raw.step_failed(status, t, h)
            raw.check(max(status, 3), ctypes_calls.CALLS[raw.version][call], t, h)
        network, c = self._network, int(infinite[0])
        (i,) = (i for i, part in enumerate(network.slices) if part.start <= c < part.stop)
        name = network.slaves[i].outputs[c - network.slices[i].start].name
        try:
            self._raws[i].check(3, "", t, h)
        except SlaveError as error:
            reason = f"output {name!r} must be finite, got {self._Y[row + 1, c]}"
            raise SlaveError(error.slave, t + h, 0.0, reason, error.log) from None


def fits(network: Network, algorithm: Algorithm) -> bool:
    """Whether the inner loop can run this: FMUs in this process, plain Jacobi or Gauss-Seidel, no extras."""
    plain = isinstance(algorithm, GaussSeidel) or (isinstance(algorithm, Jacobi) and not algorithm.nepce)
    return (
        plain
        and all(slave.raw is not None and (algorithm.degree == 0 or not slave.raw.asks) for slave in network.slaves)
        and all(parts == 1 for parts in network.substeps)
        and not network.held.size
        and not network.tabled
        and not network.loops
        and network.one_pass
    )


def _clock_address() -> int:
    """The address of clock_gettime, or 0 where there is none."""
    if not sys.platform.startswith(("linux", "darwin")):
        return 0
    library = ctypes.CDLL(None)
    return ctypes.cast(library.clock_gettime, ctypes.c_void_p).value or 0


@lru_cache(maxsize=1)
def compiled() -> Any | None:
    """`march` compiled to machine code, or None where numba is not installed."""
    try:
        from . import numba_calls
    except ImportError:
        return None
    return numba_calls.compiled_march()


@lru_cache(maxsize=1)
def compiled_meter() -> Any | None:
    """The energy meter's arithmetic compiled, or None where numba is not installed."""
    try:
        from . import numba_calls
    except ImportError:
        return None
    return numba_calls.compiled_meter()
