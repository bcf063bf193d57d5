"""An FMU as C code drives it: addresses of its functions, references of its variables."""

from abc import abstractmethod
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from ..base import Slave


@dataclass(frozen=True, eq=False, kw_only=True)
class RawFmu:
    """What C code needs to drive an instance of an FMU: addresses as integers, value references as arrays.

    Parameters
    ----------
    version : int
        Of FMI: 1, 2 or 3.
    instance : int
        Of the FMU; valid until the slave starts anew or closes.
    set_real, get_real, do_step : int
        fmi2SetReal, fmi2GetReal, fmi2DoStep, those of FMI 1.0, or fmi3SetFloat64, fmi3GetFloat64, fmi3DoStep.
    set_derivatives : int
        fmi2SetRealInputDerivatives, or 0 where the FMU follows constant inputs only.
    u_refs, y_refs : ndarray of uint32, shapes (n_u,) and (n_y,)
        Of the inputs and outputs in the order of U and y.
    du_refs, du_orders : ndarray of uint32 and of int32, shape (2 n_u,)
        Of U[1], then of U[2]; the first n_u are those of U[1] alone.
    check : callable
        check(status, name of the call, t, h) raises the slave's SlaveError, with its log, for a status above 1.
    step_failed : callable
        step_failed(status, t, h) raises what a step with such a status means.
    asks : bool
        Whether it asks for its inputs within a step, which the slave answers: C code may then hold inputs only.
    told : ndarray of uint8, shape (16,), or None
        Of FMI 3.0, what doStep answers: flags of event, end and early return, and from byte 8 on the time reached.
    finish_step : callable or None
        Of FMI 3.0: finish_step(U, t, h, begun) does what is left of a step that returned with one of the flags or
        short of its end, or, where it has not begun, the whole of it.
    due : callable or None
        Of FMI 3.0: due() is the time (s) from which on a step must be left to finish_step from its begin.
    derivatives_told : callable or None
        Of FMI 1.0 and 2.0: derivatives_told() tells the slave that C code gives its FMU all derivatives.
    """

    version: int
    instance: int
    set_real: int
    get_real: int
    do_step: int
    set_derivatives: int
    u_refs: np.ndarray
    y_refs: np.ndarray
    du_refs: np.ndarray
    du_orders: np.ndarray
    check: Callable[[int, str, float, float], None]
    step_failed: Callable[[int, float, float], None]
    asks: bool = False
    told: np.ndarray | None = None
    finish_step: Callable[[np.ndarray, float, float, bool], None] | None = None
    due: Callable[[], float] | None = None
    derivatives_told: Callable[[], None] | None = None


class Direct(Slave):
    """A slave that C code may drive; ask with raw()."""

    @property
    @abstractmethod
    def raw(self) -> RawFmu | None:
        """From finish() on, how C code can step it; None where that cannot be done: it needs real signals only."""


def raw_access(slave: Slave) -> RawFmu | None:
    """How C code can step `slave` from finish() on; None where it cannot."""
    return slave.raw if isinstance(slave, Direct) else None
