"""The functions of a component as machine code in this process: the code that its FMU has, without the FMU."""

import ctypes
import logging
from collections.abc import Callable, Sequence
from functools import partial
from typing import Any

import numpy as np

from ..systems import machine_code

__all__ = ["MachineCode", "compiled_component"]

_log = logging.getLogger(__name__)


class MachineCode:
    """The library of a component, of fmus/c/library.c.

    Parameters
    ----------
    component : gyro_cosim.component.Component
        What it is of; it is compiled if need be.

    Raises
    ------
    RuntimeError, OSError, ValueError
        There is no compiler, the library cannot be kept or loaded, or the component has no C code.
    """

    def __init__(self, component: Any) -> None:
        self._library = machine_code.loaded(partial(machine_code.of_component, component))  # its work space: one call at a time
        n_p, n_q = (ctypes.c_int * 2).in_dll(self._library, "SIZES")
        self.prepared = n_p + n_q

    def bound(self, name: str, arguments: Sequence[np.ndarray], result: np.ndarray) -> Callable[[], None]:
        """As component.calling.bound, for the function `name`: arrays that it reads and writes whenever it is called.

        Parameters
        ----------
        name : str
            Of the C function; parameters go in as prepare() leaves them.
        arguments : sequence of arrays
            Read at each call. Matrices are held column by column.
        result : array
            Written at each call. May be one of the arguments.

        Returns
        -------
        callable
            Without arguments.
        """
        function = getattr(self._library, name)
        scratch = np.zeros_like(result)
        call = [ctypes.c_void_p(a.ctypes.data) for a in (*arguments, scratch)]
        keep: list[Any] = [*arguments, scratch]  # for the addresses

        def trigger() -> None:
            function(*call)
            result[:] = keep[-1]

        return trigger


def compiled_component(component: Any) -> MachineCode | None:
    """The library of a component, built if need be; None, with a line in the log, where that cannot be done."""
    try:
        return MachineCode(component)
    except (OSError, RuntimeError, ValueError) as error:
        reason = " ".join(str(error).split())
        _log.warning("%s runs in CasADi's interpreter, which rounds sines and the like otherwise: %s", component.spec, reason)
        return None
