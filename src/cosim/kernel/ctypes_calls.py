"""The calls of the inner loop: FMI functions through their addresses, and the table that holds these.

Each function stands here as Python runs it, through ctypes; kernel.c calls the same addresses, and has the same table.
"""

import ctypes
from functools import lru_cache
from typing import Any

# Columns of the table of slaves, int64. n_u counts connected inputs, which stand one after another from `first` on; n_y the
# outputs that are asked for, y_refs, the first n_polled of them in every step; their places in Y stand from y_first on in
# Plan.places, and follow one another where `direct`. feeds, feeds_polled: whether one of them depends on a connected input.
COLUMNS = (
    "instance", "set_real", "get_real", "do_step", "set_derivatives", "u_refs", "y_refs", "du_refs", "du_orders", "no_set_state",
    "n_u", "n_y", "n_polled", "y_first", "direct", "first", "degree", "feeds", "feeds_polled", "version", "told", "finish",
)  # fmt: skip
(INSTANCE, SET_REAL, GET_REAL, DO_STEP, SET_DERIVATIVES, U_REFS, Y_REFS, DU_REFS, DU_ORDERS, NO_SET_STATE, N_U, N_Y, N_POLLED,
 Y_FIRST, DIRECT, FIRST, DEGREE, FEEDS, FEEDS_POLLED, VERSION, TOLD, FINISH) = range(len(COLUMNS))  # fmt: skip
CALLS = {
    1: ("", "fmiSetReal", "fmiSetRealInputDerivatives", "fmiDoStep", "fmiGetReal"),
    2: ("", "fmi2SetReal", "fmi2SetRealInputDerivatives", "fmi2DoStep", "fmi2GetReal"),
    3: ("", "fmi3SetFloat64", "", "fmi3DoStep", "fmi3GetFloat64"),
}
RAISED = 5  # the status of a call that has left an exception behind


@lru_cache(maxsize=1024)
def _function(address: int, *types: Any) -> Any:
    return ctypes.CFUNCTYPE(ctypes.c_uint, *types)(address)  # a status that FMI does not know is above all that it does


_POINTER, _SIZE, _DOUBLE, _INT = ctypes.c_void_p, ctypes.c_size_t, ctypes.c_double, ctypes.c_int


def values_call(address: int, instance: int, references: int, n: int, values: int) -> int:
    """fmi2SetReal or fmi2GetReal through its address; all pointers are integers."""
    return int(_function(int(address), _POINTER, _POINTER, _SIZE, _POINTER)(int(instance), int(references), int(n), int(values)))


def values3_call(address: int, instance: int, references: int, n: int, values: int, n_values: int) -> int:
    """fmi3SetFloat64 or fmi3GetFloat64 through its address."""
    call = _function(int(address), _POINTER, _POINTER, _SIZE, _POINTER, _SIZE)
    return int(call(int(instance), int(references), int(n), int(values), int(n_values)))


def derivatives_call(address: int, instance: int, references: int, n: int, orders: int, values: int) -> int:
    """fmi2SetRealInputDerivatives through its address."""
    call = _function(int(address), _POINTER, _POINTER, _SIZE, _POINTER, _POINTER)
    return int(call(int(instance), int(references), int(n), int(orders), int(values)))


def step_call(address: int, instance: int, t: float, h: float, no_set_state: int) -> int:
    """fmi2DoStep through its address."""
    return int(_function(int(address), _POINTER, _DOUBLE, _DOUBLE, _INT)(int(instance), float(t), float(h), int(no_set_state)))


def step3_call(
    address: int, instance: int, t: float, h: float, no_set_state: int, event: int, ended: int, early: int, reached: int
) -> int:
    """fmi3DoStep through its address."""
    call = _function(int(address), _POINTER, _DOUBLE, _DOUBLE, _INT, _POINTER, _POINTER, _POINTER, _POINTER)
    answers = int(event), int(ended), int(early), int(reached)
    return int(call(int(instance), float(t), float(h), int(no_set_state), *answers))


def finish_call(address: int, t: float, h: float, begun: int) -> int:
    """FastLoop's own function that finishes a step of an FMI 3.0 FMU."""
    return int(_function(int(address), _DOUBLE, _DOUBLE, _INT)(float(t), float(h), int(begun)))


def move_values(version: int, address: int, instance: int, references: int, n: int, values: int) -> int:
    """The setter or getter of either version."""
    if version == 3:
        return values3_call(address, instance, references, n, values, n)
    return values_call(address, instance, references, n, values)
