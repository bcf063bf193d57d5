"""The inputs of an FMU for Model Exchange: continuous ones follow a polynomial, discrete ones change in event mode only.

Those that change with a clock are set where it ticks, see gyro_cosim.slaves.fmi.ticking.
"""

from collections.abc import Callable

import numpy as np

from ..fmi.buffers import Group, present
from ..fmi.fmu import FmuSlave
from ..fmi.rows import REAL
from ..fmi.signals import carried

Check = Callable[[int, str, float, float], None]


class Inputs:
    """What is set when.

    Attributes
    ----------
    smooth, discrete : ndarray of int
        Places in u of the continuous inputs, and of the others that no clock has.
    varying : bool
        Whether the continuous ones change within the step.
    """

    def __init__(self, fmu: FmuSlave) -> None:
        rows = carried(fmu.model, "input")
        follows = [row.type in REAL and row.variability == "continuous" for row in rows]
        follows = [one and row.name not in fmu.by_clock for row, one in zip(rows, follows, strict=True)]
        clocked = [row.name in fmu.by_clock for row in rows]
        sizes = [row.size for row in rows]
        places, ticked = (np.repeat(np.array(of, dtype=bool), sizes) for of in (follows, clocked))
        self.smooth, self.discrete = np.flatnonzero(places), np.flatnonzero(~places & ~ticked)
        self._n_u = places.size
        self._all: list[Group] = fmu.groups(rows, fmu.by_clock)
        self._some: list[Group] = fmu.groups([row for row, one in zip(rows, follows, strict=True) if one])
        self._fmu, self._t = fmu, 0.0
        self._U = np.zeros((3, self.smooth.size))
        self.varying = False

    def follow(self, U: np.ndarray, t: float) -> None:
        """From t (s) on the continuous ones follow U, shape (3, n_u)."""
        self._t, self._U = t, U[:, self.smooth]
        self.varying = bool(self._U[1:].any())

    def hold(self, value: np.ndarray, t: float) -> None:
        """From t (s) on the continuous ones are `value`."""
        self._t, self._U, self.varying = t, np.array([value, 0.0 * value, 0.0 * value]), False

    def at(self, t: float) -> np.ndarray:
        """The continuous ones at t (s)."""
        s = t - self._t
        value: np.ndarray = self._U[0] + s * (self._U[1] + (s / 2) * self._U[2])
        return value

    def put(self, t: float) -> tuple[int, str]:
        """Set the continuous ones to what they are at t (s); returns the worst status, and of which call."""
        value, worst, call = self.at(t), 0, ""
        for group in self._some:
            group.buffer[:] = value[group.places]
            status = group.set(self._fmu.instance)
            if status > worst:
                worst, call = status, group.label
        return worst, call

    def put_all(self, u: np.ndarray, t: float, h: float) -> None:
        """Set all of them to u, shape (n_u,), where that is allowed: in event mode."""
        for group in self._all:
            group.buffer[:] = u[group.places]
            self._fmu.check(group.set(self._fmu.instance), group.label, t, h)

    def told(self, t: float) -> tuple[float, ...]:
        """The discrete ones as the FMU has them."""
        groups = self._all if self.discrete.size else ()
        u = present(groups, self._fmu.instance, np.zeros(self._n_u), self._fmu.check, t)
        return tuple(u[self.discrete].tolist())
