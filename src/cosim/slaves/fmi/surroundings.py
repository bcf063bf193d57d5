"""What an FMU may change of the process that it runs in, beside its own memory: put back after each group of calls.

Of the floating-point mode, signal handlers, timers, current folder, file mode mask, locale and limits, each has been changed
by an FMU somewhere, and each changes what happens to others: numbers that are rounded upwards, Ctrl-C that does nothing,
results in another folder.
"""

import contextlib
import ctypes
import functools
import locale
import logging
import os
import signal
import sys
import threading
from collections.abc import Callable, Iterator
from typing import Any, Concatenate, ParamSpec

__all__ = ["floating_point_kept", "keeping", "kept", "mind_floating_point"]

P = ParamSpec("P")
_log = logging.getLogger(__name__)
_HEARD = ("SIGHUP", "SIGINT", "SIGQUIT", "SIGUSR2", "SIGPIPE", "SIGALRM", "SIGTERM", "SIGCHLD", "SIGTSTP", "SIGWINCH")
_LIMITS = ("RLIMIT_NOFILE", "RLIMIT_FSIZE", "RLIMIT_STACK", "RLIMIT_CPU", "RLIMIT_AS")
_ONE, _TINY, _LEAST = 1.0, 1e-30, 5e-324
_ROOM = 512  # bytes, more than a floating-point environment takes anywhere


def _environment_calls() -> tuple[Any, Any] | None:
    """fegetenv and fesetenv; None where the C library is not at hand."""
    if sys.platform == "win32":
        return None
    for name in (None, "libm.so.6"):
        try:
            library = ctypes.CDLL(name)
            return library.fegetenv, library.fesetenv
        except (OSError, AttributeError):
            continue
    return None


_CALLS = _environment_calls()
_USUAL = ctypes.create_string_buffer(_ROOM)
if _CALLS is not None:
    _CALLS[0](_USUAL)


def floating_point_kept() -> bool:
    """Whether numbers are rounded to nearest, and small ones are not flushed to zero."""
    return _ONE + _TINY == _ONE and _ONE - _TINY == _ONE and _LEAST * _ONE != 0.0


def mind_floating_point(who: str) -> None:
    """Put the floating-point mode back if it is not as it was; costs next to nothing where it is."""
    if not floating_point_kept():
        _log.warning("%s has changed the floating-point mode, which is put back", who)
        if _CALLS is not None:
            _CALLS[1](_USUAL)


@contextlib.contextmanager
def kept(who: str) -> Iterator[None]:
    """Calls of the FMU that is called `who` stand inside; what they change of the process is as before afterwards."""
    before = _Now()
    try:
        yield
    finally:
        for what in before.restore():
            _log.info("%s has changed the %s, which is put back", who, what)


def keeping(method: Callable[Concatenate[Any, P], None]) -> Callable[Concatenate[Any, P], None]:
    """A method of a slave that calls its FMU, with the process as before afterwards; see kept()."""

    @functools.wraps(method)
    def guarded(slave: Any, /, *arguments: P.args, **keywords: P.kwargs) -> None:
        with kept(slave.name):
            method(slave, *arguments, **keywords)

    return guarded


class _Now:
    """What the process is like."""

    def __init__(self) -> None:
        self.mode = ctypes.create_string_buffer(_ROOM)
        if _CALLS is not None:
            _CALLS[0](self.mode)
        self.folder = _folder()
        self.locale = locale.setlocale(locale.LC_ALL)
        self.limits = _limits()
        self.main = threading.current_thread() is threading.main_thread()
        self.mask = _mask() if self.main else None  # to ask for it is to change it
        self.handlers = {}
        self.timer = 0.0
        if self.main and sys.platform != "win32":
            self.handlers = {n: signal.getsignal(n) for n in (getattr(signal, name) for name in _HEARD)}
            self.timer = signal.getitimer(signal.ITIMER_REAL)[0]

    def restore(self) -> list[str]:
        """Put it back; what was different, as far as that can be seen."""
        changed = []
        if _CALLS is not None:  # first of all: where inexact results are trapped, hardly anything can be computed
            _CALLS[1](self.mode)
        if self.folder and _folder() != self.folder:
            with contextlib.suppress(OSError):  # it may be gone
                os.chdir(self.folder)
            changed.append("current folder")
        if self.mask is not None and _mask() != self.mask:
            os.umask(self.mask)
            changed.append("file mode mask")
        if locale.setlocale(locale.LC_ALL) != self.locale:
            locale.setlocale(locale.LC_ALL, self.locale)
            changed.append("locale")
        if self.limits != _limits():
            _put_limits(self.limits)
            changed.append("limits")
        if self.main and sys.platform != "win32":
            if self.timer == 0.0 and signal.getitimer(signal.ITIMER_REAL)[0] > 0.0:
                signal.setitimer(signal.ITIMER_REAL, 0.0)
                changed.append("timer")
            for number, handler in self.handlers.items():
                if handler is not None:
                    signal.signal(number, handler)  # Python does not know whether it is still there
        return changed


def _folder() -> str:
    try:
        return os.getcwd()  # noqa: PTH109 (a string is enough)
    except OSError:
        return ""


def _mask() -> int:
    mask = os.umask(0o022)
    os.umask(mask)
    return mask


def _limits() -> dict[int, tuple[int, int]]:
    if sys.platform == "win32":
        return {}
    import resource

    return {n: resource.getrlimit(n) for n in (getattr(resource, name, None) for name in _LIMITS) if n is not None}


def _put_limits(limits: dict[int, tuple[int, int]]) -> None:
    if sys.platform == "win32":
        return
    import resource

    for number, (soft, hard) in limits.items():
        with contextlib.suppress(ValueError, OSError):  # a hard limit that was lowered stays
            resource.setrlimit(number, (min(soft, hard), hard))
