"""numba's side of the inner loop: the foreign calls as machine code. Imported only when a run is long enough to pay for it."""

from collections.abc import Callable
from typing import Any

from llvmlite import ir
from numba import njit, types
from numba.extending import intrinsic, overload

from cosim import energy, loop


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
    return intrinsic(scope[name])


_values = _foreign("values", "p", "p", "z", "p")
_derivatives = _foreign("derivatives", "p", "p", "z", "p", "p")
_step = _foreign("step", "p", "d", "d", "i")
_clock = _foreign("clock", "i", "p")


@overload(loop.values_call, strict=False)
def _values_call(address: Any, instance: Any, references: Any, n: Any, values: Any) -> Any:
    return lambda address, instance, references, n, values: _values(address, instance, references, n, values)


@overload(loop.derivatives_call, strict=False)
def _derivatives_call(address: Any, instance: Any, references: Any, n: Any, orders: Any, values: Any) -> Any:
    return lambda address, instance, references, n, orders, values: _derivatives(address, instance, references, n, orders, values)


@overload(loop.step_call, strict=False)
def _step_call(address: Any, instance: Any, t: Any, h: Any, no_set_state: Any) -> Any:
    return lambda address, instance, t, h, no_set_state: _step(address, instance, t, h, no_set_state)


@overload(loop.clock_call, strict=False)
def _clock_call(address: Any, clock: Any, time: Any) -> Any:
    return lambda address, clock, time: _clock(address, clock, time)


def compiled_march() -> Any:
    """`march` as machine code, kept on disk from one process to the next. No fast mathematics: the bits are Python's."""
    return njit(cache=True, nogil=True)(loop.march)


def compiled_meter() -> Any:
    """`accumulate` of cosim.energy as machine code."""
    return njit(cache=True, nogil=True)(energy.accumulate)
