"""Whether two results are the same to the last bit, and where they first differ."""

from dataclasses import dataclass

import numpy as np

from .signals import Trajectory


@dataclass(frozen=True)
class Difference:
    """Where two results first differ.

    Parameters
    ----------
    what : str
        "signals", "units", "time", "value" or "length".
    signal : str
        Which one; empty where that is of no signal.
    time : float or None
        When, s.
    before, after : str
        What stands there.
    points : int
        At how many points any value differs.
    """

    what: str
    signal: str
    time: float | None
    before: str
    after: str
    points: int = 0

    def __str__(self) -> str:
        when = "" if self.time is None else f" at t = {self.time:.17g} s"
        of = f" of {self.signal}" if self.signal else ""
        more = f" (and at {self.points - 1} points more)" if self.points > 1 else ""
        return f"{self.what}{of}{when} was {self.before}, is {self.after}{more}"


def first_difference(before: Trajectory, after: Trajectory) -> Difference | None:
    """The first difference: signals, then units, then the earliest time and there the first signal; None where all is the same.

    A NaN is the same as one of the same bits, 0.0 is not the same as -0.0.
    """
    if before.names != after.names:
        lost = [n for n in before.names if n not in after.names]
        new = [n for n in after.names if n not in before.names]
        name = (lost or new or [a for a, b in zip(before.names, after.names, strict=True) if a != b])[0]
        words = ("there", "lost") if lost else ("not there", "there") if new else ("in another place", "here")
        return Difference("signals", name, None, *words)
    for name, old, new_ in zip(before.names, before.units, after.units, strict=True):
        if old != new_:
            return Difference("units", name, None, repr(old), repr(new_))
    n = min(len(before), len(after))
    times, values = _bits(before.t[:n]) != _bits(after.t[:n]), _bits(before.values[:n]) != _bits(after.values[:n])
    rows = np.flatnonzero(times | values.any(axis=1))
    if rows.size:
        k = int(rows[0])
        at = float(before.t[k])
        if times[k]:
            return Difference("time", "", at, repr(at), repr(float(after.t[k])), rows.size)
        j = int(np.flatnonzero(values[k])[0])
        numbers = repr(float(before.values[k, j])), repr(float(after.values[k, j]))
        return Difference("value", before.names[j], at, *numbers, rows.size)
    if len(before) != len(after):
        longer = before if len(before) > n else after
        return Difference("length", "", float(longer.t[n]), f"{len(before)} points", f"{len(after)} points")
    return None


def _bits(numbers: np.ndarray) -> np.ndarray:
    return np.ascontiguousarray(numbers, dtype=float).view(np.uint64)
