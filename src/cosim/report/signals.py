"""Recorded signals as text in a page: thinned so that no peak is lost, in single precision, deflated, in base 64."""

import base64
import zlib
from typing import Any

import numpy as np

from ..trajectory import Trajectory

ROWS = 3000  # up to which every recorded row is in the page
CHECKED = 200  # rows, about, whose bits are compared when the page has run the system again

FNV_START, FNV_PRIME = 0xCBF29CE484222325, 0x100000001B3


def packed(numbers: np.ndarray, kind: str = "<f4") -> str:
    """Numbers as text: of the type `kind`, row by row, deflated, in base 64."""
    return deflated(np.ascontiguousarray(numbers, dtype=kind).tobytes())


def deflated(content: bytes) -> str:
    """Bytes as text, deflated, in base 64."""
    return base64.b64encode(zlib.compress(content, 9)).decode()


def thinned(trajectory: Trajectory, rows: int = ROWS) -> tuple[np.ndarray, np.ndarray, int]:
    """A trajectory with at most `rows` rows.

    Parameters
    ----------
    trajectory : Trajectory
        n rows of m signals.
    rows : int
        The most rows to give, at least 2.

    Returns
    -------
    t : ndarray, shape (k,)
        Time, s.
    values : ndarray, shape (k, m)
        All rows where there are no more than `rows`. Otherwise two rows for every group of recorded ones: the least and the
        greatest value in it, in the order in which they occur, so that every peak is kept in size and nearly in its place.
    group : int
        Recorded rows that two rows stand for; 1 where every row is there.
    """
    n = len(trajectory)
    if n <= rows:
        return trajectory.t, trajectory.values, 1
    group = -(-n // (rows // 2))
    starts = np.arange(0, n, group)
    t, values = np.empty(2 * starts.size), np.empty((2 * starts.size, len(trajectory.names)))
    for k, start in enumerate(starts.tolist()):
        part = trajectory.values[start : start + group]
        t[2 * k], t[2 * k + 1] = trajectory.t[start], trajectory.t[min(start + group // 2, n - 1)]
        least, greatest = part.min(axis=0), part.max(axis=0)
        first = part.argmin(axis=0) <= part.argmax(axis=0)
        values[2 * k], values[2 * k + 1] = np.where(first, least, greatest), np.where(first, greatest, least)
    return t, values, group


def fingerprint(rows: np.ndarray) -> str:
    """FNV-1a, 64 bits, of the bytes of numbers in double precision, row by row; 16 hexadecimal digits."""
    state = FNV_START
    for byte in np.ascontiguousarray(rows, dtype="<f8").tobytes():
        state = ((state ^ byte) * FNV_PRIME) & 0xFFFFFFFFFFFFFFFF
    return f"{state:016x}"


def document(trajectory: Trajectory) -> dict[str, Any]:
    """The signals as the page reads them: names, units, time, one packed column a signal, how far they are thinned."""
    t, values, group = thinned(trajectory)
    return {
        "names": list(trajectory.names),
        "units": list(trajectory.units),
        "rows": len(trajectory),
        "group": group,
        "t": packed(t, "<f8"),
        "columns": [packed(values[:, k]) for k in range(values.shape[1])],
    }
