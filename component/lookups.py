"""What a graph of CasADi looks up in an array: entries from a place on, or the interval in which a number lies.

Functions that are constant piece by piece, so that their derivatives are 0. They stay calls in a graph, named after their
numbers: the exporter prints them as calls of fmus/c/tables.h, and the array once (fmus/graph.py).
"""

import hashlib
from dataclasses import dataclass

import casadi as ca
import numpy as np

__all__ = ["Lookup", "entries", "interval", "is_lookup", "lookup_of"]

_ENTRIES, _INTERVAL = "table_entries_", "table_interval_"


@dataclass(frozen=True)
class Lookup:
    """What a function that a graph calls looks up.

    Attributes
    ----------
    name : str
        Of the array, which follows from its numbers.
    numbers : array, shape (n,)
        The array.
    searches : bool
        Whether the function finds the interval of the array in which its argument lies (0 to n - 2, those at the ends for
        what is beyond them), or reads the entries that follow the place which is its argument.
    """

    name: str
    numbers: np.ndarray
    searches: bool


def is_lookup(name: str) -> bool:
    """Whether a function of that name is one that looks up."""
    return name.startswith((_ENTRIES, _INTERVAL))


def lookup_of(function: ca.Function) -> Lookup | None:
    """What a function that a graph calls looks up; None where it is no part of a table."""
    if not is_lookup(function.name()):
        return None
    prefix = _INTERVAL if function.name().startswith(_INTERVAL) else _ENTRIES
    constants = (function.instruction_MX(k) for k in range(function.n_instructions()))
    numbers = next(c.to_DM() for c in constants if c.is_constant() and c.numel() > 1)
    return Lookup(f"table_{function.name().removeprefix(prefix)}", np.array(numbers).ravel(), prefix == _INTERVAL)


def entries(numbers: np.ndarray, count: int) -> ca.Function:
    """(place) -> the `count` entries from there on."""
    place = ca.MX.sym("place")
    array = ca.MX(ca.DM(numbers.ravel()))
    return _looking_up(_ENTRIES, numbers, place, [array[place + k] for k in range(count)])


def interval(points: np.ndarray) -> ca.Function:
    """(x) -> the interval in which x lies."""
    x = ca.MX.sym("x")
    return _looking_up(_INTERVAL, points, x, [ca.low(ca.DM(points), x, {"lookup_mode": "binary"})])


def _looking_up(prefix: str, numbers: np.ndarray, argument: ca.MX, results: list[ca.MX]) -> ca.Function:
    """A function that stays one call in a graph, named after its numbers."""
    name = prefix + hashlib.sha256(np.ascontiguousarray(numbers, "<f8").tobytes()).hexdigest()[:16]
    return ca.Function(name, [argument], results, {"never_inline": True})
