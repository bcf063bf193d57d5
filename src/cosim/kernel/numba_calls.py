"""numba's side of the inner loop: the foreign calls as machine code. Imported only when a run is long enough to pay for it."""

import hashlib
from collections.abc import Callable
from pathlib import Path
from typing import Any

from llvmlite import ir
from numba import config, njit, types
from numba.extending import intrinsic, overload

from . import ctypes_calls, energy, loop


def _foreign(name: str, *kinds: str) -> Callable[..., Any]:
    """An intrinsic that calls the function at an address with arguments of `kinds`: p pointer, i int, z size_t, d double."""
    numba_types = {"p": types.int64, "i": types.int32, "z": types.int64, "d": types.float64}
    llvm_types = {"p": ir.IntType(64), "i": ir.IntType(32), "z": ir.IntType(64), "d": ir.DoubleType()}
    signature = types.int32(types.int64, *(numba_types[kind] for kind in kinds))

    def codegen(context: Any, builder: Any, _: Any, arguments: Any) -> Any:
        function = ir.FunctionType(ir.IntType(32), [llvm_types[kind] for kind in kinds])
        return builder.call(builder.inttoptr(arguments[0], function.as_pointer()), arguments[1:])

    # numba wants an intrinsic's parameters by name.
    names = ", ".join(f"a{k}" for k in range(len(kinds) + 1))
    scope: dict[str, Any] = {"signature": signature, "codegen": codegen}
    exec(f"def {name}(context, {names}):\n    return signature, codegen\n", scope)
    call: Callable[..., Any] = intrinsic(scope[name])
    return call


_values = _foreign("values", "p", "p", "z", "p")
_values3 = _foreign("values3", "p", "p", "z", "p", "z")
_derivatives = _foreign("derivatives", "p", "p", "z", "p", "p")
_step = _foreign("step", "p", "d", "d", "i")
_step3 = _foreign("step3", "p", "d", "d", "i", "p", "p", "p", "p")
_finish = _foreign("finish", "d", "d", "i")
_clock = _foreign("clock", "i", "p")


@overload(ctypes_calls.values_call, strict=False)
def _values_call(address: Any, instance: Any, references: Any, n: Any, values: Any) -> Any:
    return lambda address, instance, references, n, values: _values(address, instance, references, n, values)


@overload(ctypes_calls.derivatives_call, strict=False)
def _derivatives_call(address: Any, instance: Any, references: Any, n: Any, orders: Any, values: Any) -> Any:
    return lambda address, instance, references, n, orders, values: _derivatives(address, instance, references, n, orders, values)


@overload(ctypes_calls.step_call, strict=False)
def _step_call(address: Any, instance: Any, t: Any, h: Any, no_set_state: Any) -> Any:
    return lambda address, instance, t, h, no_set_state: _step(address, instance, t, h, no_set_state)


@overload(ctypes_calls.clock_call, strict=False)
def _clock_call(address: Any, clock: Any, time: Any) -> Any:
    return lambda address, clock, time: _clock(address, clock, time)


@overload(ctypes_calls.values3_call, strict=False)
def _values3_call(address: Any, instance: Any, references: Any, n: Any, values: Any, n_values: Any) -> Any:
    return lambda address, instance, references, n, values, n_values: _values3(address, instance, references, n, values, n_values)


@overload(ctypes_calls.step3_call, strict=False)
def _step3_call(
    address: Any, instance: Any, t: Any, h: Any, no_set_state: Any, event: Any, ended: Any, early: Any, reached: Any
) -> Any:
    return lambda address, instance, t, h, no_set_state, event, ended, early, reached: _step3(
        address, instance, t, h, no_set_state, event, ended, early, reached
    )


@overload(ctypes_calls.finish_call, strict=False)
def _finish_call(address: Any, t: Any, h: Any, begun: Any) -> Any:
    return lambda address, t, h, begun: _finish(address, t, h, begun)


@overload(ctypes_calls.move_values, strict=False)
def _move_values(version: Any, address: Any, instance: Any, references: Any, n: Any, values: Any) -> Any:
    return ctypes_calls.move_values


def compiled_march() -> Any:
    """`march` as machine code. No fast mathematics: the bits are Python's."""
    return _compiled(loop.march)


def compiled_meter() -> Any:
    """`accumulate` of gyro_cosim.kernel.energy as machine code."""
    return _compiled(energy.accumulate)


def _compiled(function: Callable[..., Any]) -> Any:
    """Machine code, kept on disk from one process to the next in a folder named by all the sources that it is made of.

    numba itself would look at the function's own file only, and not see that the table or the calls have changed.
    """
    sources = (
        b"".join(Path(str(module.__file__)).read_bytes() for module in (ctypes_calls, energy, loop)) + Path(__file__).read_bytes()
    )
    before = config.CACHE_DIR
    config.CACHE_DIR = str(
        Path(before or Path(__file__).parent / "__pycache__") / f"numba-{hashlib.sha256(sources).hexdigest()[:16]}"
    )
    try:
        return njit(cache=True, nogil=True)(function)
    finally:
        config.CACHE_DIR = before
