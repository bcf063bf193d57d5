"""Variables sorted by the FMI functions that move them, each group with a buffer that the functions are bound to once."""

import ctypes
from collections.abc import Callable, Collection, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from .rows import Row

EXACT = 2**53  # integers up to here are exact in float64

Move = Callable[[Any], int]  # of an instance; returns the status
Binding = Callable[[str, Any, int, np.ndarray], tuple[Move, Move]]  # FmuSlave._moves


@dataclass(frozen=True, eq=False)
class Group:
    """Inputs or outputs of one FMI type: their places in u or y, a buffer, and the calls that move it, as call(instance).

    wide : integers that may be beyond what float64 holds exactly.
    """

    rows: tuple[Row, ...]
    places: slice | np.ndarray
    buffer: np.ndarray
    get: Move
    set: Move
    label: str
    wide: bool

    def rounded(self) -> tuple[int, int] | None:
        """(place among all inputs or outputs, value) of an integer in the buffer that float64 does not hold exactly."""
        for value in (int(self.buffer.max(initial=0)), int(self.buffer.min(initial=0))):
            if abs(value) > EXACT:
                element = int(np.flatnonzero(self.buffer == value)[0])
                where = self.places
                return (where.start + element if isinstance(where, slice) else int(where[element])), value
        return None


def group(rows: Sequence[Row], places: Sequence[int], types: Mapping[str, tuple[Any, str]], prefix: str, bind: Binding) -> Group:
    """The group of variables that one function moves; see groups()."""
    kind, suffix = types[rows[0].type]
    buffer = np.zeros(sum(row.size for row in rows), dtype=kind)
    references = (ctypes.c_uint * len(rows))(*(row.reference for row in rows))
    get, set_ = bind(suffix, references, len(rows), buffer)
    whole = bool(places) and list(places) == list(range(places[0], places[0] + len(places)))
    where = slice(places[0], places[0] + len(places)) if whole else np.array(places, dtype=int)
    wide = buffer.dtype.kind in "iu" and buffer.dtype.itemsize == 8
    return Group(tuple(rows), where, buffer, get, set_, f"{prefix}Set{suffix}", wide)


def groups(
    rows: Sequence[Row], types: Mapping[str, tuple[Any, str]], prefix: str, bind: Binding, left_out: Collection[str] = ()
) -> list[Group]:
    """The variables sorted by the functions that move them.

    types : FMI type -> (numpy type, how the functions call it). prefix : of their names. left_out : names of those that have a
    place and no group.
    """
    places: dict[str, list[int]] = {}
    members: dict[str, list[Row]] = {}
    count = 0
    for row in rows:
        suffix = types[row.type][1]
        if row.name not in left_out:
            members.setdefault(suffix, []).append(row)
            places.setdefault(suffix, []).extend(range(count, count + row.size))
        count += row.size
    return [group(members[suffix], places[suffix], types, prefix, bind) for suffix in members]


def references(parts: Sequence[Group]) -> np.ndarray:
    """The value references of several groups, for C code."""
    return np.array([row.reference for part in parts for row in part.rows], dtype=np.uint32)


def present(
    parts: Sequence[Group], instance: Any, u: np.ndarray, check: Callable[[int, str, float, float], None], t: float
) -> np.ndarray:
    """u, shape (n,), with what the variables have at t (s); `check` raises for a bad status."""
    for part in parts:
        check(part.get(instance), part.label.replace("Set", "Get"), t, 0.0)
        u[part.places] = part.buffer
    return u
