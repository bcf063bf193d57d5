"""What the inner loop of cosim/loop.py needs of a network, and whether it can run it at all."""

import ctypes
import sys
import time
from functools import lru_cache
from typing import Any

import numpy as np

from cosim import loop
from cosim.coupling import Algorithm, GaussSeidel, Jacobi
from cosim.network import Network
from cosim.slaves.base import RawFmi2

LONG = 15_000  # slave steps from which compiling, or loading what was compiled before, pays


class FastLoop:
    """The inner loop on a network of FMI 2.0 FMUs under Jacobi or Gauss-Seidel.

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
        starts = np.cumsum([0, *(len(s.inputs) for s in network.slaves)])
        wires = [network.wires(i) for i in range(len(network.slaves))]
        joined = [wire for of_slave in wires for wire in of_slave]
        self._source, self._target = (np.array([w[c] for w in joined], dtype=np.int64) for c in (0, 1))
        self._scale, self._offset = (np.array([w[c] for w in joined], dtype=float) for c in (2, 3))
        self._u = np.concatenate([*(network.start_inputs(i) for i in range(len(network.slaves))), np.zeros(1)])
        self._du = np.zeros(2 * self._u.size)
        self._orders = np.zeros(len(network.slaves), dtype=np.int64)
        self._Y, self._t, self._h, self._used = Y, t, h, used
        bond_inputs = [place for bond in network.bonds for place in (bond.motion_input, bond.effort_input)]
        self._bond_inputs = np.zeros((len(bond_inputs), 3), dtype=np.int64)
        for row, (i, j) in enumerate(bond_inputs):
            n_u = len(network.slaves[i].inputs)
            self._bond_inputs[row] = starts[i] + j, 2 * starts[i] + j, 2 * starts[i] + n_u + j
        self._table = np.zeros((len(network.slaves), len(loop.COLUMNS)), dtype=np.int64)
        self._raws: list[RawFmi2] = []
        first = 0
        for i, slave in enumerate(network.slaves):
            raw = slave.raw
            assert raw is not None
            self._raws.append(raw)
            last = first + len(wires[i])
            feeds_through = bool(slave.feedthrough[:, [w[1] for w in wires[i]]].any()) if wires[i] else False
            self._table[i] = (
                raw.instance, raw.set_real, raw.get_real, raw.do_step, raw.set_derivatives,
                raw.u_refs.ctypes.data, raw.y_refs.ctypes.data, raw.du_refs.ctypes.data, raw.du_orders.ctypes.data,
                raw.no_set_state, len(slave.inputs), len(slave.outputs), starts[i], network.slices[i].start, first, last,
                slave.input_degree, feeds_through,
            )  # fmt: skip
            first = last
        self._now = np.zeros(2, dtype=np.int64)
        self._kept, self._failure = np.zeros(len(joined) + 1), np.zeros(3, dtype=np.int64)
        buffers = (self._u, self._du, self._Y, self._now)
        self._pointers = np.array([*(b.ctypes.data for b in buffers), getattr(time, "CLOCK_MONOTONIC", 0)], dtype=np.int64)
        self._clock = _clock_address()
        self._spent = np.zeros(len(network.slaves))

    def march(self, row: int, rows: int, *, fast: bool) -> int:
        """`rows` macro steps after row `row` of the buffers; SlaveError for the slave that fails, with `done` rows before it.

        fast : run the compiled loop; else the same source as Python runs it.
        """
        function = compiled() if fast else None
        done = int(
            (function or loop.march)(
                self._table, self._source, self._target, self._scale, self._offset, self._u, self._du, self._orders,
                self._sequence, self._exchange, self._sequential, self._degree, self._Y, self._t, self._h, row, rows,
                self._bond_inputs, self._used, self._clock, self._now, self._spent, self._pointers, self._kept, self._failure,
            )
        )  # fmt: skip
        self._network.do_step_s = self._spent.tolist()
        return done

    def explain(self, row: int) -> None:
        """Raise the SlaveError of what stopped a march at the step after row `row`."""
        i, call, status = (int(x) for x in self._failure)
        t, h = float(self._t[row]), float(self._h[row + 1])
        if call == 5:
            self._network.slaves[i].output(self._network.start_inputs(i), t + h)  # says which output is not finite
        self._raws[i].check(max(status, 3), loop.CALLS[call], t, h)


def fits(network: Network, algorithm: Algorithm) -> bool:
    """Whether the inner loop can run this: FMI 2.0 FMUs in this process, plain Jacobi or Gauss-Seidel, no extras."""
    plain = isinstance(algorithm, GaussSeidel) or (isinstance(algorithm, Jacobi) and not algorithm.nepce)
    return (
        plain
        and all(slave.raw is not None for slave in network.slaves)
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
        from cosim import loop_numba
    except ImportError:
        return None
    return loop_numba.compiled_march()


@lru_cache(maxsize=1)
def compiled_meter() -> Any | None:
    """The energy meter's arithmetic compiled, or None where numba is not installed."""
    try:
        from cosim import loop_numba
    except ImportError:
        return None
    return loop_numba.compiled_meter()
