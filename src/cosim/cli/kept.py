"""A command that may run foreign code, in a process of its own that this one keeps: its exit code is right in any case."""

import atexit
import contextlib
import ctypes
import os
import signal
import sys
import tempfile
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import Any

from ..keeping.keeper import Ending, Keeper, Voice, split

__all__ = ["COMMANDS", "closing", "diverted", "kept_process", "voice"]

COMMANDS = ("run", "compare", "converge", "delay")  # that run FMUs in their process
CLOSING = 10.0  # s that FMUs may take to close, once the results are written
PATIENCE = 5.0  # s that they may take to come back after Ctrl-C
_voices: list[Voice] = []


def voice() -> Voice:
    """How this process tells its keeper what it has come to; into the void where it has none."""
    return _voices[0] if _voices else Voice(-1)


@contextmanager
def closing() -> Iterator[None]:
    """Left where only closing is left to do: it may not take for ever."""
    try:
        yield
    finally:
        voice().closing()


def kept_process(work: Callable[[], int]) -> int:
    """The exit code of `work`, done in a fork of this process; its own where it cannot be forked."""
    if sys.platform == "win32" or sys.gettrace() is not None:
        return work()
    side = split()
    if isinstance(side, Keeper):
        ending = side.ending(closing=CLOSING, patience=PATIENCE)
        code = _code(ending)
        if ending.done is None or ending.late:
            from ..slaves import scratch

            scratch.clean(tempfile.gettempdir())
        return code
    _voices.append(side)
    code = work()
    side.closing()  # a line has said what there is to say, and what is left is not worth waiting for
    side.done(code)
    atexit._run_exitfuncs()
    for stream in (sys.stdout, sys.stderr):
        with contextlib.suppress(OSError, ValueError, AttributeError):
            stream.flush()
    ctypes.CDLL(None).fflush(None)
    os._exit(code)  # not through exit(): what an FMU has left there, and in its library, is not called any more


def _code(ending: Ending) -> int:
    """The exit code of a command that has ended so; a line says what it has not said itself."""
    if ending.done is not None and not ending.late and ending.code == ending.done:
        return ending.code
    if ending.told or ending.done:
        return ending.done or 1
    if ending.late and ending.closing:
        what = f"an FMU does not close within {CLOSING:g} s; what results there are were written before"
    elif ending.late:
        what = "an FMU does not come back, the run was ended"
    elif ending.code < 0:
        name = signal.Signals(-ending.code).name
        written = "while FMUs were closed; what results there are were written before"
        where = written if ending.closing else "in the middle of its work"
        what = f"the process of the command was ended by signal {-ending.code} ({name}) {where}"
    else:
        what = f"the process of the command left with code {ending.code} before its work was done"
    print(f"cosim: {what}; --isolate gives each FMU a process of its own", file=sys.stderr)
    return 1


@contextmanager
def diverted(active: bool) -> Iterator[None]:
    """What foreign code writes on standard output goes to standard error; Python's own print still goes where it should."""
    if not active or sys.stdout is not sys.__stdout__ or sys.platform == "win32":
        yield
        return
    usual: Any = sys.stdout
    usual.flush()
    place = os.dup(1)
    os.dup2(2, 1)
    with os.fdopen(place, "w", encoding=usual.encoding, errors=usual.errors) as document:
        sys.stdout = document
        try:
            yield
        finally:
            sys.stdout = usual
            ctypes.CDLL(None).fflush(None)
            with contextlib.suppress(OSError, ValueError):
                document.flush()
                os.dup2(place, 1)
