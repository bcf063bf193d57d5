"""SUNDIALS as FMPy ships it: its libraries, loaded once, and the functions of CVODE with their types.

The decision is docs/decisions/0013. Arguments are those of the CVODE manual; a context, a vector, a matrix are addresses.
"""

import ctypes
import importlib.util
from functools import cache
from pathlib import Path
from typing import Any

from ..fmi.library import SUFFIX, folders

MAJOR = 7  # the version whose types these are
BDF, ONE_STEP, ROOT_RETURN = 2, 2, 2

_P, _R, _I, _N, _L = ctypes.c_void_p, ctypes.c_double, ctypes.c_int, ctypes.c_int64, ctypes.c_long
RATES = ctypes.CFUNCTYPE(_I, _R, _P, _P, _P)  # t, x, x', user data
ROOTS = ctypes.CFUNCTYPE(_I, _R, _P, _P, _P)  # t, x, values, user data
FAULT = ctypes.CFUNCTYPE(None, _I, ctypes.c_char_p, ctypes.c_char_p, ctypes.c_char_p, _I, _P, _P)

_FUNCTIONS: dict[str, dict[str, tuple[Any, ...]]] = {
    "core": {
        "SUNDIALSGetVersionNumber": (_I, _P, _P, _P, _P, _I), "SUNContext_Create": (_I, _I, _P), "SUNContext_Free": (_I, _P),
        "SUNContext_PushErrHandler": (_I, _P, FAULT, _P), "SUNLinSolFree": (_I, _P), "SUNMatDestroy": (None, _P),
    },
    "nvecserial": {"N_VMake_Serial": (_P, _N, _P, _P), "N_VDestroy_Serial": (None, _P), "N_VGetArrayPointer_Serial": (_P, _P)},
    "sunmatrixdense": {"SUNDenseMatrix": (_P, _N, _N, _P)},
    "sunlinsoldense": {"SUNLinSol_Dense": (_P, _P, _P, _P)},
    "cvode": {
        "CVodeCreate": (_P, _I, _P), "CVodeInit": (_I, _P, RATES, _R, _P), "CVodeReInit": (_I, _P, _R, _P),
        "CVodeSVtolerances": (_I, _P, _R, _P), "CVodeRootInit": (_I, _P, _I, ROOTS), "CVodeSetNoInactiveRootWarn": (_I, _P),
        "CVodeSetLinearSolver": (_I, _P, _P, _P), "CVodeSetStopTime": (_I, _P, _R),
        "CVode": (_I, _P, _R, _P, _P, _I), "CVodeFree": (None, _P), "CVodeSetMaxHnilWarns": (_I, _P, _I),
    },
}  # fmt: skip


class Sundials:
    """Its functions as attributes; ValueError where FMPy has none for this machine, or of another version."""

    def __init__(self) -> None:
        spec = importlib.util.find_spec("fmpy")  # not imported: that takes longer than a short run
        place = next(iter((spec.submodule_search_locations or ()) if spec else ()), "")
        folder = Path(place) / "sundials" / folders()[1]
        if not folder.is_dir():
            raise ValueError(f"Model Exchange needs SUNDIALS, which FMPy does not ship for {folder.name}: run by Co-Simulation")
        for part, functions in _FUNCTIONS.items():
            library = ctypes.CDLL(str(folder / f"sundials_{part}{SUFFIX}"), winmode=0x8)
            for name, (result, *types) in functions.items():
                function = library[name]
                function.restype, function.argtypes = result, types
                setattr(self, name, function)
        numbers = [ctypes.c_int() for _ in range(3)]
        label = ctypes.create_string_buffer(32)
        self.SUNDIALSGetVersionNumber(*map(ctypes.byref, numbers), label, len(label))
        if numbers[0].value != MAJOR:
            raise ValueError(f"Model Exchange needs SUNDIALS {MAJOR}, FMPy ships {numbers[0].value}: take another FMPy")

    def __getattr__(self, name: str) -> Any:
        raise AttributeError(name)


@cache
def sundials() -> Sundials:
    """The libraries, loaded at the first call."""
    return Sundials()
