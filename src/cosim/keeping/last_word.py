"""The last word of a process that an FMU ends: it calls exit, crashes, or does not come back when it is interrupted.

While a LastWord listens, such an end calls it: the results so far are written, one line says what happened, and the process
leaves with code 1. What is left of the process is used once, for that; whoever wants more than the best that a wrecked
process can do takes --isolate. Linux and macOS; nothing is done elsewhere.
"""

import ctypes
import os
import signal
import sys
import threading
from collections.abc import Callable
from types import FrameType, TracebackType
from typing import Any

from .keeper import ASK

__all__ = ["LastWord"]

CRASHES = ("SIGSEGV", "SIGBUS", "SIGFPE", "SIGILL", "SIGABRT")
LONGEST = 30  # s that the last word may take: it may wait for what the wrecked process holds
_ON_STACK, _STACK = 0x08000000, 1 << 22  # SA_ONSTACK of Linux; bytes of a stack of its own, for a stack that has overflowed
_HEARD = ctypes.CFUNCTYPE(None, ctypes.c_int)
_LEFT = ctypes.CFUNCTYPE(None, ctypes.c_void_p, ctypes.c_int)


class _Stack(ctypes.Structure):
    _fields_ = [("place", ctypes.c_void_p), ("flags", ctypes.c_int), ("size", ctypes.c_size_t)]


class _Action(ctypes.Structure):
    """struct sigaction of Linux."""

    _fields_ = [
        ("handler", ctypes.c_void_p), ("mask", ctypes.c_ubyte * 128), ("flags", ctypes.c_int), ("restorer", ctypes.c_void_p)
    ]  # fmt: skip


class LastWord:
    """Calls `word` with what is happening to the process, once; `word` must not return.

    A context: it listens inside. Only one may.
    """

    _heard: Any = None  # what C code calls, and where: made once, kept as long as the process lives
    _room: Any = None
    _speaking: "LastWord | None" = None

    def __init__(self, word: Callable[[str], None]) -> None:
        self._word = word
        self._handle: ctypes.Array[ctypes.c_char] | None = None

    def __enter__(self) -> "LastWord":
        self._before: dict[int, Any] = {}
        if sys.platform == "win32":
            return self
        libc = ctypes.CDLL(None)
        if hasattr(libc, "__cxa_finalize"):
            self._listen_for_exit(libc)
        LastWord._speaking = self
        handler = LastWord._heard = LastWord._heard or _HEARD(_crashed)
        numbers = [getattr(signal, name) for name in CRASHES] + [ASK]
        self._before = {number: signal.getsignal(number) for number in numbers}
        if (
            signal.getsignal(signal.SIGINT) is signal.default_int_handler
            and threading.current_thread() is threading.main_thread()
        ):
            self._before[signal.SIGINT] = signal.signal(signal.SIGINT, _interrupted)
        if sys.platform == "linux":
            room = LastWord._room = LastWord._room or ctypes.create_string_buffer(_STACK)
            libc.sigaltstack(ctypes.byref(_Stack(ctypes.addressof(room), 0, _STACK)), None)
        for number in numbers:
            if sys.platform == "linux":
                action = _Action(ctypes.cast(handler, ctypes.c_void_p).value, (ctypes.c_ubyte * 128)(), _ON_STACK, None)
                libc.sigaction(number, ctypes.byref(action), None)
            else:
                libc.signal(number, handler)
        return self

    def __exit__(self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None) -> None:
        LastWord._speaking = None
        for number, before in self._before.items():
            signal.signal(number, signal.SIG_DFL if before is None else before)
        if self._handle is not None:  # calls what is registered under it, which has nothing to say any more, and drops it
            getattr(ctypes.CDLL(None), "__cxa_finalize")(self._handle)

    def say(self, reason: str) -> None:
        """Whatever happens, the process ends here."""
        LastWord._speaking = None
        libc = ctypes.CDLL(None)
        for name in CRASHES:
            libc.signal(getattr(signal, name), None)
        libc.signal(signal.SIGALRM, None)
        libc.alarm(LONGEST)
        try:
            self._word(reason)
        finally:
            os._exit(1)

    def _listen_for_exit(self, libc: ctypes.CDLL) -> None:
        """exit() calls what is registered, on Linux with its code. Under a handle, since what Python has lent must be taken
        back before the interpreter goes: on_exit and atexit would call it when it is no longer there.
        """
        self._handle = ctypes.create_string_buffer(1)
        self._leaving = _LEFT(lambda _, code: _left(code if sys.platform == "linux" else None))
        getattr(libc, "__cxa_atexit")(self._leaving, None, self._handle)


def _interrupted(number: int, frame: FrameType | None) -> None:
    """As usual, unless Ctrl-C is heard only now that the last word has begun: nothing comes back to where it was pressed."""
    if frame is None or frame.f_code is not _crashed.__code__:
        raise KeyboardInterrupt


def _crashed(number: int) -> None:
    speaking = LastWord._speaking
    if speaking is None and number == ASK:
        return
    if speaking is None:
        ctypes.CDLL(None).signal(number, None)  # as it would be without us, at once
        os.kill(os.getpid(), number)
    elif number == ASK:
        speaking.say("does not come back")
    else:
        speaking.say(f"crashed ({signal.Signals(number).name})")


def _left(code: int | None) -> None:
    speaking = LastWord._speaking
    if speaking is not None:
        speaking.say("ended the process" + ("" if code is None else f" with code {code}"))
