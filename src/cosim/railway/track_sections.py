"""Straight track, transitions and curves that a run has passed, from the curvature that it recorded. SI units."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Literal

import numpy as np

__all__ = ["Section", "sections", "words"]

STRAIGHT = 1e-6  # 1/m: what is less is no curve
EVEN = 1e-3  # of the tightest curvature a metre: what changes faster is a transition
SHORTEST = 2.0  # m: what is shorter belongs to what stands before it
Kind = Literal["straight", "transition", "curve"]


@dataclass(frozen=True)
class Section:
    """A piece of track of one kind, as far as a run has passed it.

    Parameters
    ----------
    kind : {"straight", "transition", "curve"}
        What it is.
    begin, end : float
        Along the track, m, begin < end.
    curvature : float
        The largest in size, 1/m, positive to the left.
    whole : bool
        Whether the run passed all of it. Straight track has no end that a run could miss; a transition or curve that a run
        begins or ends in is not whole.
    """

    kind: Kind
    begin: float
    end: float
    curvature: float
    whole: bool

    @property
    def words(self) -> str:
        """Such as "curve of R = 50 m"."""
        return self.kind if self.kind != "curve" else f"curve of R = {1.0 / abs(self.curvature):.4g} m"

    @property
    def short(self) -> str:
        """Such as "curve 50 m"."""
        return self.kind if self.kind != "curve" else f"curve {1.0 / abs(self.curvature):.4g} m"


def sections(distance: np.ndarray, curvature: np.ndarray) -> tuple[Section, ...]:
    """The pieces of track that a run has passed.

    Parameters
    ----------
    distance
        Along the track, m, growing, shape (n,).
    curvature
        There, 1/m, shape (n,).

    Returns
    -------
    tuple of Section
        In their order; each begins where the one before ends.

    Raises
    ------
    ValueError
        For fewer than two points, or a distance that does not grow.
    """
    s, k = np.asarray(distance, dtype=float), np.asarray(curvature, dtype=float)
    if s.shape != k.shape or s.ndim != 1 or s.size < 2 or not np.all(np.diff(s) > 0.0):
        raise ValueError("distance must grow and be as long as curvature, with two points at least")
    bent = np.maximum(np.abs(k[1:]), np.abs(k[:-1])) > STRAIGHT  # between two points
    changing = np.abs(np.diff(k) / np.diff(s)) > EVEN * max(float(np.abs(k).max()), STRAIGHT)
    kinds = np.where(~bent, 0, np.where(changing, 1, 2))
    starts = [0, *(np.flatnonzero(np.diff(kinds)) + 1).tolist()]
    runs = [(a, b, int(kinds[a])) for a, b in zip(starts, [*starts[1:], kinds.size], strict=True)]
    joined: list[tuple[int, int, int]] = []
    for a, b, kind in runs:
        if joined and (kind == joined[-1][2] or s[b] - s[a] < SHORTEST):
            joined[-1] = (joined[-1][0], b, joined[-1][2])
        else:
            joined.append((a, b, kind))
    names: tuple[Kind, Kind, Kind] = ("straight", "transition", "curve")
    return tuple(
        Section(
            names[kind], float(s[a]), float(s[b]), float(k[a : b + 1][np.argmax(np.abs(k[a : b + 1]))]),
            kind == 0 or (a > 0 and b < kinds.size),
        )
        for a, b, kind in joined
    )  # fmt: skip


def words(passed: Sequence[Section]) -> str:
    """What a run went through, in words: "on straight track", "through the curve of R = 50 m"."""
    curves = list(dict.fromkeys(section.words for section in passed if section.kind == "curve" and section.whole))
    if curves:
        return f"through the {' and the '.join(curves)}"
    return "on straight track" if all(section.kind == "straight" for section in passed) else "through no whole curve"
