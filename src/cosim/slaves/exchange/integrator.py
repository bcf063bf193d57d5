"""x' = f(t, x) over one step after another with CVODE: variable order and step, implicit (BDF), roots of z(t, x) located."""

import ctypes
from collections.abc import Callable
from typing import Any

import numpy as np

from .sundials import BDF, FAULT, ONE_STEP, RATES, ROOT_RETURN, ROOTS, sundials

Function = Callable[[float, int, int], int]  # of t, the address of x, where to write; 0: done, 1: try a shorter step
REASONS = {
    -2: "the tolerance is smaller than rounding",
    -3: "the error cannot be held with any step",
    -4: "Newton's iteration does not converge with any step",
    -6: "the Jacobian is singular",
    -8: "the derivatives cannot be computed",
    -9: "the derivatives cannot be computed where the step begins",
    -10: "the derivatives cannot be computed for any step",
    -11: "the derivatives cannot be computed for any step",
    -12: "the event indicators cannot be computed",
}


class IntegrationError(Exception):
    """The integrator cannot go on; the text says why."""


class Integrator:
    """CVODE for n_x states and n_z event indicators.

    Parameters
    ----------
    n_x, n_z : int
        Without states there is one that stands still, so that roots are located all the same.
    rates, roots : callable
        f(t, address of x, address of x') and z(t, address of x, address of z).

    Attributes
    ----------
    x : ndarray, shape (n_x,)
        The states reached; to be written before restart().
    """

    def __init__(self, n_x: int, n_z: int, rates: Function, roots: Function) -> None:
        self._s = s = sundials()
        n = max(n_x, 1)
        whole = np.zeros((2, n))
        self.x, self._whole = whole[0, :n_x], whole
        self._rates, self._roots, self._still = rates, roots, n_x == 0
        self._failure: BaseException | None = None
        self._fault, self._stop, self._begun = "", np.nan, False
        self._reached = ctypes.c_double()
        self._context, self._memory = ctypes.c_void_p(), ctypes.c_void_p()
        # What C calls is kept as long as C may call it.
        self._called = RATES(self._on_rates), ROOTS(self._on_roots), FAULT(self._on_fault)
        s.SUNContext_Create(0, ctypes.byref(self._context))
        s.SUNContext_PushErrHandler(self._context, self._called[2], None)
        self._vectors = [s.N_VMake_Serial(n, row.ctypes.data, self._context) for row in whole]
        self._matrix = s.SUNDenseMatrix(n, n, self._context)
        self._solver = s.SUNLinSol_Dense(self._vectors[0], self._matrix, self._context)
        self._memory.value = s.CVodeCreate(BDF, self._context)
        self._n_z = n_z

    def restart(self, t: float, relative: float, absolute: np.ndarray) -> None:
        """Begin anew at t (s) from `x`, whose errors are held below relative |x| + absolute, shape (n_x,)."""
        s, memory, (x, tolerance) = self._s, self._memory, self._vectors
        self._whole[1] = 1.0
        self._whole[1, : self.x.size] = absolute
        if self._begun:
            self._asked(s.CVodeReInit(memory, t, x), t)
            self._asked(s.CVodeSVtolerances(memory, relative, tolerance), t)
        else:
            self._begun = True
            self._asked(s.CVodeInit(memory, self._called[0], t, x), t)
            self._asked(s.CVodeSVtolerances(memory, relative, tolerance), t)
            self._asked(s.CVodeSetLinearSolver(memory, self._solver, self._matrix), t)
            self._asked(s.CVodeRootInit(memory, self._n_z, self._called[1]), t)
            s.CVodeSetNoInactiveRootWarn(memory)
            s.CVodeSetMaxHnilWarns(memory, -1)
        self._stop = np.nan

    def advance(self, stop: float) -> tuple[float, bool]:
        """One step of its own towards `stop` (s), which it does not pass: the time reached, and whether a root is there.

        After a root it has to be restarted. IntegrationError, or what `rates` and the others raise.
        """
        if stop != self._stop:
            self._stop = stop
            self._asked(self._s.CVodeSetStopTime(self._memory, stop), stop)
        flag = self._s.CVode(self._memory, stop, self._vectors[0], ctypes.byref(self._reached), ONE_STEP)
        self._asked(flag, stop)
        return self._reached.value, flag == ROOT_RETURN

    def close(self) -> None:
        """Free everything."""
        if self._context.value:
            s = self._s
            s.CVodeFree(ctypes.byref(self._memory))
            s.SUNLinSolFree(self._solver)
            s.SUNMatDestroy(self._matrix)
            for vector in self._vectors:
                s.N_VDestroy_Serial(vector)
            s.SUNContext_Free(ctypes.byref(self._context))
            self._context.value = None

    def _asked(self, flag: int, t: float) -> None:
        failure, self._failure = self._failure, None
        if flag >= 0:
            return
        if failure is not None:
            raise failure
        raise IntegrationError(REASONS.get(flag, f"CVODE says {self._fault or flag}"))

    # ---- what CVODE calls; an exception cannot pass through C

    def _guarded(self, function: Function, t: float, x: Any, place: int) -> int:
        try:
            return function(t, self._s.N_VGetArrayPointer_Serial(x), place)
        except BaseException as error:
            self._failure = error
            return -1

    def _on_rates(self, t: float, x: Any, rates: Any, data: Any) -> int:
        place = self._s.N_VGetArrayPointer_Serial(rates)
        if self._still:
            ctypes.memset(place, 0, 8)
            return 0
        return self._guarded(self._rates, t, x, place)

    def _on_roots(self, t: float, x: Any, values: Any, data: Any) -> int:
        return self._guarded(self._roots, t, x, values)

    def _on_fault(self, line: int, function: bytes, file: bytes, message: bytes, code: int, data: Any, context: Any) -> None:
        self._fault = " ".join((message or b"").decode(errors="replace").split())
