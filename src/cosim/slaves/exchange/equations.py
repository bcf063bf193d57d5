"""The equations that an FMU for Model Exchange brings, as the integrator asks for them: x' and event indicators at t and x."""

import ctypes

import numpy as np

from ..fmi.fmu import FmuSlave
from .functions import Functions
from .inputs import Inputs


class Equations:
    """Of an instance that has left initialization mode at t (s).

    Attributes
    ----------
    n_x, n_z : int
        Continuous states and event indicators.
    trouble : str
        Why the integrator was asked last to try a shorter step.
    """

    def __init__(self, fmu: FmuSlave, calls: Functions, inputs: Inputs, t: float) -> None:
        self._fmu, self._calls, self._inputs, self._instance = fmu, calls, inputs, fmu.instance
        self.n_x, self.n_z = calls.sizes(self._instance, t)
        self.trouble = ""
        self._x, self._z, self._finite = np.zeros(self.n_x), np.zeros(self.n_z), np.ones(self.n_x, dtype=bool)
        self._x_place, self._z_place = self._x.ctypes.data, self._z.ctypes.data
        names = {row.reference: repr(row.name) for row in reversed(fmu.model.rows)}
        stated = [names[rate] for _, rate in fmu.model.states]
        self._names = stated if len(stated) == self.n_x else [str(k + 1) for k in range(self.n_x)]

    # ---- for the integrator: at t (s), from and to addresses; 0: done, 1: a shorter step may help

    def rates(self, t: float, x: int, rates: int) -> int:
        """x'."""
        status = max(self._go(t, x), self._calls.rates(self._instance, self._x_place, self.n_x))
        if status < 2 and not np.isfinite(self._x, out=self._finite).all():
            k = int(np.flatnonzero(~self._finite)[0])
            self.trouble = f"derivative {self._names[k]} must be finite, is {self._x[k]} at t = {t:.9g} s"
            return 1
        ctypes.memmove(rates, self._x_place, 8 * self.n_x)
        return self._judged(status, self._calls.rates_name, t)

    def roots(self, t: float, x: int, z: int) -> int:
        """The event indicators."""
        status = max(self._go(t, x), self._calls.indicators(self._instance, z, self.n_z))
        return self._judged(status, f"{self._calls.prefix}GetEventIndicators", t)

    def _go(self, t: float, x: int) -> int:
        status = int(self._calls.set_time(self._instance, t))
        if self._inputs.varying:
            status = max(status, self._inputs.put(t)[0])
        if self.n_x:
            status = max(status, self._calls.set_states(self._instance, x, self.n_x))
        return status

    def _judged(self, status: int, call: str, t: float) -> int:
        if status < 2:
            return 0
        if status > 2:
            self._fmu.check(status, call, t, 0.0)
        self.trouble = f"{call} answered discard at t = {t:.9g} s"
        return 1

    # ---- where the FMU stands

    def present_rates(self, t: float, h: float) -> np.ndarray:
        """x' there; NaN where the FMU discards it."""
        status = self._calls.rates(self._instance, self._x_place, self.n_x)
        self._fmu.check(status if status > 2 else 0, self._calls.rates_name, t, h)
        return self._x.copy() if status < 2 else np.full(self.n_x, np.nan)

    def signs(self, t: float, h: float) -> tuple[bool, ...]:
        """Which event indicators are above zero."""
        if not self.n_z:
            return ()
        status = self._calls.indicators(self._instance, self._z_place, self.n_z)
        self._fmu.check(status, f"{self._calls.prefix}GetEventIndicators", t, h)
        return tuple((self._z > 0.0).tolist())

    def read_states(self, x: int, t: float, h: float) -> None:
        """The continuous states, to an address."""
        if self.n_x:
            status = self._calls.get_states(self._instance, x, self.n_x)
            self._fmu.check(status, f"{self._calls.prefix}GetContinuousStates", t, h)

    def nominals(self, t: float, h: float) -> np.ndarray:
        """Nominal values of the states, all positive: 1 where the FMU says nothing of use."""
        if not self.n_x:
            return np.ones(0)
        status = self._calls.nominals(self._instance, self._x_place, self.n_x)
        self._fmu.check(status, f"{self._calls.prefix}GetNominalsOfContinuousStates", t, h)
        sizes = np.abs(self._x)
        sizes[~(np.isfinite(sizes) & (sizes > 0.0))] = 1.0
        return sizes
