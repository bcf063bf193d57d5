"""Fast repeated evaluation of a CasADi function on fixed arrays."""

from collections.abc import Callable, Sequence

import casadi as ca
import numpy as np

__all__ = ["bound"]


def bound(function: ca.Function, arguments: Sequence[np.ndarray], result: np.ndarray) -> Callable[[], None]:
    """Bind a function to arrays that it reads and writes whenever it is called.

    Parameters
    ----------
    function : casadi.Function
        With one result.
    arguments : sequence of arrays
        Read at each call. Matrices are held column by column: a matrix of shape (a, b) is an array of shape (b, a).
    result : array
        Written at each call. May be one of the arguments.

    Returns
    -------
    callable
        Without arguments. It has memory of its own, so several may be bound to one function.
    """
    buffer, trigger = function.buffer()
    scratch = np.zeros_like(result)
    for i, argument in enumerate(arguments):
        buffer.set_arg(i, memoryview(argument))  # type: ignore[arg-type]
    buffer.set_res(0, memoryview(scratch))  # type: ignore[arg-type]
    keep = (buffer, tuple(arguments))  # the buffer holds bare pointers

    def call() -> None:
        trigger()
        result[:] = scratch

    call.__dict__["keep"] = keep
    return call
