"""What can go wrong: wrong use is a ValueError, a failed run is one of these.

Every message is one line that names the thing, the rule and the value.
"""

import difflib
from collections.abc import Iterable
from typing import Any


class RunError(RuntimeError):
    """A run that failed on the way; `partial` is the `Run` up to the last good point, once the master has attached it."""

    partial: Any = None

    def keeping(self, partial: Any) -> "RunError":
        """This error, with the run up to there."""
        self.partial = partial
        return self


class SlaveError(RunError):
    """A component failed in a run.

    Parameters
    ----------
    slave : str
        Its name in the system.
    t, h : float
        When, and over a step of which length, s; h is 0 outside a step.
    reason : str
        Why, in one line.
    log : str
        What the component itself has said last.
    """

    def __init__(self, slave: str, t: float, h: float, reason: str, log: str = "") -> None:
        over = f" over a step of {h:g} s" if h > 0.0 else ""
        super().__init__(f"component {slave!r} failed at t = {t:.9g} s{over}: {reason}" + (f"; it says: {log}" if log else ""))
        self.slave, self.t, self.h, self.reason, self.log = slave, t, h, reason, log


class OutputError(SlaveError):
    """A component has no finite outputs for the inputs that it was given. It is as it was, and may be asked with others."""


class EndRequest(RunError):
    """A component wants the run to end, as FMI lets it: no failure, the run is over.

    Parameters
    ----------
    slave : str
        Its name in the system.
    t : float
        When, s.
    """

    def __init__(self, slave: str, t: float) -> None:
        super().__init__(f"component {slave!r} asks to end the run at t = {t:.9g} s")
        self.slave, self.t = slave, t


class WiringError(ValueError):
    """A system whose connections cannot be made: unknown names, two sources, units that do not fit, an algebraic loop."""


class ConvergenceError(RunError):
    """An iteration that does not converge: a macro step of an iterated algorithm, or an algebraic loop."""


def unknown(what: str, name: str, known: Iterable[str]) -> ValueError:
    """The error for a name that is not there, with the nearest one that is."""
    names = sorted(known)
    near = difflib.get_close_matches(name, names, 1)
    hint = f"did you mean {near[0]!r}?" if near else f"known: {', '.join(names) or 'none'}"
    return ValueError(f"unknown {what} {name!r}; {hint}")


def nearest(name: str, known: Iterable[str]) -> str:
    """The nearest known name in brackets, with a blank in front, for the end of a sentence; empty where none is near."""
    near = difflib.get_close_matches(name, sorted(known), 1)
    return f" (did you mean {near[0]!r}?)" if near else ""
