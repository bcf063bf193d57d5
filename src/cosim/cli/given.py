"""What the command line was: kept here while a command runs, for its results to tell."""

import shlex
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from contextvars import ContextVar

__all__ = ["arguments", "of_command", "repeated"]

_arguments: ContextVar[tuple[str, ...]] = ContextVar("arguments", default=())


@contextmanager
def of_command(given: Sequence[str]) -> Iterator[None]:
    """While it lasts, the command is `cosim` with these arguments."""
    token = _arguments.set(tuple(given))
    try:
        yield
    finally:
        _arguments.reset(token)


def arguments() -> tuple[str, ...]:
    """Those of the present command; none where it was not called as one."""
    return _arguments.get()


def repeated() -> str:
    """The present command as a shell takes it."""
    return shlex.join(["cosim", *arguments()])
