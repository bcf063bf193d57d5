"""Fast repeated evaluation of a CasADi function on fixed arrays."""

from collections.abc import Callable, Sequence

import casadi as ca
import numpy as np


def bound(function: ca.Function, arguments: Sequence[np.ndarray], result: np.ndarray) -> Callable[[], None]:
    """A call that reads these very arrays and writes this one; matrices are held column by column, so a matrix argument
    of shape (a, b) is an array of shape (b, a). `result` may be one of the arguments. Every call has its own memory.
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
