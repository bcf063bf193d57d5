"""What the inner loop needs of a network, whether it can run it at all, and in which of its lives it does."""

import ctypes
import time
from functools import partial
from typing import Any

import numpy as np

from ..coupling import Algorithm, GaussSeidel, Jacobi, Nepce
from ..coupling.explicit import MISSED
from ..errors import SlaveError
from ..network import Network
from ..slaves.fmi.raw import RawFmu, raw_access
from ..slaves.fmi.surroundings import kept
from . import ctypes_calls, loop, native
from .energy import Bonds, Sums

TIMED = 64  # the compiled loop times one step in so many: the clock takes as long as a small FMU's step
_FINISH = ctypes.CFUNCTYPE(ctypes.c_int, ctypes.c_double, ctypes.c_double, ctypes.c_int)
LONG = 15_000  # slave steps from which compiling the kernel pays, where that has not been done before


class FastLoop:
    """The inner loop on a network of FMUs under Jacobi, NEPCE or Gauss-Seidel.

    Y, t, h : buffers of outputs, times and steps, whose rows before `row` hold the history when march() is called.
    whole : bytes, of which rows all outputs that are asked for are read: those of `recorded`, places in Y; of the others
    those alone that are coupled or end the run.
    used : shape (rows, 2 bonds, 3), the inputs of the power bonds that each step followed; only the plain loop keeps them.
    kernel : the compiled kernel, which sums the energy of `bonds` itself; None: loop.march, as Python runs it.

    polled, asked : ndarray of int, places in Y that are read in every step, and in whole rows.
    """

    def __init__(
        self, network: Network, algorithm: Algorithm, Y: np.ndarray, t: np.ndarray, h: np.ndarray, whole: np.ndarray,
        used: np.ndarray, recorded: np.ndarray, bonds: Bonds, kernel: native.Kernel | None,
    ) -> None:  # fmt: skip
        self._network = network
        stops = np.array([network.place(stop.signal) for stop in network.system.stop_when], dtype=np.int64)
        self.polled = np.unique(np.concatenate([network.coupled, bonds.signals, stops]))
        self.asked = np.union1d(self.polled, recorded)
        outputs = [self._in_order(part) for part in network.slices]
        sequential = isinstance(algorithm, GaussSeidel)
        sequence = network.sequence(algorithm.sequence) if isinstance(algorithm, GaussSeidel) else range(len(network.slaves))
        n = len(network.slaves)
        wires = [network.wires(i) for i in range(n)]
        first = np.cumsum([0, *map(len, wires)])  # of each slave's connected inputs; the others are given once, here
        joined = [wire for of_slave in wires for wire in of_slave]
        bond_inputs = [place for bond in network.bonds for place in (bond.motion_input, bond.effort_input)]
        self._plan = loop.Plan(
            slaves=np.zeros((n, len(ctypes_calls.COLUMNS)), dtype=np.int64),
            places=np.concatenate(outputs),
            source=np.array([w[0] for w in joined], dtype=np.int64),
            scale=np.array([w[2] for w in joined], dtype=float),
            offset=np.array([w[3] for w in joined], dtype=float) + 0.0,  # not -0.0, which would leave a -0.0 as it is
            fresh=np.zeros(len(joined), dtype=np.int64),
            sequence=np.array(sequence, dtype=np.int64),
            exchange=np.array(network.order, dtype=np.int64),
            stops=stops,
            above=np.array([stop.above for stop in network.system.stop_when], dtype=float),
            bond_inputs=np.zeros((len(bond_inputs), 3), dtype=np.int64),
            pointers=np.zeros(4, dtype=np.int64),
            degree=algorithm.degree,
            sequential=sequential,
            missed=MISSED[algorithm.degree] if isinstance(algorithm, Nepce) else 0.0,
        )
        told = np.zeros((n, 16), dtype=np.uint8)
        self._data = loop.Data(
            Y=Y, t=t, h=h, whole=whole, used=used,
            u=np.zeros(len(joined) + 1), du=np.zeros(2 * len(joined) + 1), kept=np.zeros(len(joined) + 1),
            read=np.zeros(max(map(len, outputs), default=0) + 1), orders=np.zeros(n, dtype=np.int64), told=told,
            reached=told.view(float), due=np.full(n, np.inf), spent=np.zeros(n), failure=np.zeros(5, dtype=np.int64),
        )  # fmt: skip
        if sequential:
            turn = np.empty(n, dtype=int)
            turn[self._plan.sequence] = np.arange(n)
            owner = np.repeat(np.arange(n), [len(s.outputs) for s in network.slaves])
            self._plan.fresh[:] = turn[owner[self._plan.source]] < np.repeat(turn, [len(w) for w in wires])
        for row, (i, j) in enumerate(bond_inputs):
            (place,) = (q for q, wire in enumerate(wires[i]) if wire[1] == j)
            self._plan.bond_inputs[row] = first[i] + place, 2 * first[i] + place, 2 * first[i] + len(wires[i]) + place
        self._raws: list[RawFmu] = []
        self._connected: list[slice] = []
        self._open: list[np.ndarray] = []
        self._kept_alive: list[Any] = []  # what the table holds addresses of
        self._error: BaseException | None = None
        for i, slave in enumerate(network.slaves):
            fmu = raw_access(slave)
            assert fmu is not None
            self._raws.append(fmu)
            n_u, places = len(slave.inputs), np.array([w[1] for w in wires[i]], dtype=np.int64)
            later = np.concatenate([places, n_u + places])
            mine = outputs[i] - network.slices[i].start
            references = (fmu.u_refs[places], fmu.du_refs[later], fmu.du_orders[later], fmu.y_refs[mine])
            self._kept_alive += references
            u_refs, du_refs, du_orders, y_refs = (r.ctypes.data for r in references)
            feeds = slave.description.feedthrough[np.ix_(mine, places)].any(axis=1)
            n_polled = int(np.isin(outputs[i], self.polled).sum())
            self._connected.append(slice(first[i], first[i] + len(places)))
            finish = 0
            if fmu.due is not None:
                self._data.due[i] = fmu.due()
                callback = _FINISH(partial(self._finish_step, i, places))
                self._kept_alive.append(callback)
                finish = ctypes.cast(callback, ctypes.c_void_p).value or 0
            self._plan.slaves[i] = (
                fmu.instance, fmu.set_real, fmu.get_real, fmu.do_step, fmu.set_derivatives, u_refs, y_refs, du_refs, du_orders,
                1, len(places), mine.size, n_polled, sum(map(len, outputs[:i])), bool((np.diff(mine) == 1).all()),
                first[i], slave.description.input_degree, bool(feeds.any()), bool(feeds[:n_polled].any()), fmu.version,
                told[i].ctypes.data, finish,
            )  # fmt: skip
            self._open.append(np.setdiff1d(np.arange(n_u), places))
            self._give_open_inputs(i, float(t[0]))
        self._plan.pointers[:] = [b.ctypes.data for b in (self._data.u, self._data.du, self._data.Y, self._data.read)]
        self.compiled = None if kernel is None else kernel.loop(self._plan, self._data, bonds)

    def refresh(self, t: float) -> None:
        """Take over what has changed in the network by t (s), without the loop's knowledge: connections, open inputs."""
        plan, network = self._plan, self._network
        for i, of_slave in enumerate(self._connected):
            wires = network.present_wires(i)
            plan.scale[of_slave] = [wire[2] for wire in wires]
            plan.offset[of_slave] = [wire[3] + 0.0 for wire in wires]
            self._give_open_inputs(i, t)
            told = self._raws[i].derivatives_told
            if told is not None and self._raws[i].set_derivatives and plan.degree:
                self._data.orders[i] = 2  # whoever has stepped in between may have told it some, and whoever steps next
                told()

    def _give_open_inputs(self, i: int, t: float) -> None:
        """The inputs of slave i that nothing is connected to, as they are at t (s)."""
        fmu, others = self._raws[i], self._open[i]
        if others.size:
            refs, values = fmu.u_refs[others], self._network.start_inputs(i, t)[others]
            status = ctypes_calls.move_values(
                fmu.version, fmu.set_real, fmu.instance, refs.ctypes.data, others.size, values.ctypes.data
            )
            fmu.check(status, ctypes_calls.CALLS[fmu.version][1], t, 0.0)

    @property
    def slaves(self) -> np.ndarray:
        """The table of slaves, shape (n_slaves, len(ctypes_calls.COLUMNS))."""
        table: np.ndarray = self._plan.slaves
        return table

    @property
    def meters(self) -> bool:
        """Whether march() adds to the sums of energy that it is given."""
        return self.compiled is not None

    def _in_order(self, part: slice) -> np.ndarray:
        """The outputs of one slave that are asked for, as places in Y: those that are read in every step first."""
        mine = self.asked[(self.asked >= part.start) & (self.asked < part.stop)]
        polled = np.isin(mine, self.polled)
        return np.concatenate([mine[polled], mine[~polled]])

    def march(self, row: int, rows: int, past: np.ndarray, before: float, sums: Sums) -> tuple[int, np.ndarray, bool]:
        """`rows` macro steps after row `row` of the buffers, fewer where a stop condition holds or something fails.

        past, before, sums : see energy.accumulate; left alone unless `meters`.

        Returns how many were done, the seconds that each slave has spent in steps, shape (n_slaves,), and whether a stop
        condition has ended it. Where fewer were done for another reason, failure() tells it.
        """
        data = self._data
        self.begin()
        with kept("a component"):
            began = time.perf_counter()
            if self.compiled is not None:
                done = self.compiled(row, rows, TIMED, past, before, sums)
            else:
                done = loop.march(self._plan, data, row, rows, 1)
            took = time.perf_counter() - began
        data.failure[3:] = 0
        ended = done > 0 and bool(np.any(data.Y[row + done, self._plan.stops] > self._plan.above))
        return done, self.spent(took), ended

    @property
    def underway(self) -> tuple[int, int]:
        """Of a march that does not come back: the macro steps that it has done, and the slave that it is at."""
        return int(self._data.failure[3]), int(self._data.failure[4])

    def begin(self) -> None:
        """Forget the failure and the times of the march before."""
        self._data.failure[:], self._data.spent[:] = 0, 0.0

    def spent(self, took: float) -> np.ndarray:
        """The seconds that each slave has spent in steps since begin(), of the `took` that all took."""
        inside = float(self._data.spent.sum())
        share = min(1.0, took / inside) if inside > 0.0 else 1.0  # a timed step may be the one that had to wait for a core
        times: np.ndarray = share * self._data.spent
        return times

    def _finish_step(self, i: int, places: np.ndarray, t: float, h: float, begun: int) -> int:
        """What is left of a step of slave i, which is of FMI 3.0; called from within the march."""
        fmu, u = self._raws[i], self._network.start_inputs(i, t)
        assert fmu.finish_step is not None
        assert fmu.told is not None
        assert fmu.due is not None
        u[places] = self._data.u[self._connected[i]]
        fmu.told[:] = self._data.told[i]
        try:
            fmu.finish_step(np.array([u, np.zeros_like(u), np.zeros_like(u)]), t, h, bool(begun))
        except BaseException as error:  # it must not get lost in the machine code that calls this
            self._error = error
            return ctypes_calls.RAISED
        self._data.due[i] = fmu.due()
        return 0

    def failure(self, row: int) -> BaseException:
        """What stopped a march at the step after row `row`."""
        try:
            self._explain(row)
        except BaseException as error:
            return error
        raise AssertionError("a march that was not stopped has no failure")

    def _explain(self, row: int) -> None:
        t, h = float(self._data.t[row]), float(self._data.h[row + 1])
        i, call, status = (int(x) for x in self._data.failure[:3])
        status = ctypes.c_uint(status).value  # as the slaves' functions return it
        infinite = self.asked[~np.isfinite(self._data.Y[row + 1, self.asked])]
        if not infinite.size:
            fmu = self._raws[i]
            if self._error is not None:
                raise self._error
            if ctypes_calls.CALLS[fmu.version][call].endswith("DoStep"):
                if fmu.told is not None:
                    fmu.told[:] = self._data.told[i]
                fmu.step_failed(status, t, h)
            fmu.check(max(status, 3), ctypes_calls.CALLS[fmu.version][call], t, h)
        network, c = self._network, int(infinite[0])
        (i,) = (i for i, part in enumerate(network.slices) if part.start <= c < part.stop)
        name = network.slaves[i].outputs[c - network.slices[i].start].name
        try:
            self._raws[i].check(3, "", t, h)
        except SlaveError as error:
            reason = f"output {name!r} must be finite, got {self._data.Y[row + 1, c]}"
            raise SlaveError(error.slave, t + h, 0.0, reason, error.log) from None


def fits(network: Network, algorithm: Algorithm) -> bool:
    """Whether the inner loop can run this: FMUs in this process, an explicit algorithm, no extras. Ask after initialize()."""
    fmus = [raw_access(slave) for slave in network.slaves]
    return (
        isinstance(algorithm, Jacobi | Nepce | GaussSeidel)
        and all(fmu is not None and (algorithm.degree == 0 or not fmu.asks) for fmu in fmus)
        and all(parts == 1 for parts in network.substeps)
        and not network.held.size
        and not network.tabled
        and not network.texts
        and not network.clocks
        and not network.loops
        and network.one_pass
    )
