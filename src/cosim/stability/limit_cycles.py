"""Limit cycles of an autonomous system over a parameter, by continuation.

A branch of cycles begins where a pair of roots of the equilibrium crosses the imaginary axis, and is followed by
pseudo-arclength, so that it goes round folds: where v turns, cycles appear or vanish. `collocation` has the equations of a cycle.

References
----------
Seydel 2010, Practical bifurcation and stability analysis, chapters 4 and 7; True 2013, Vehicle System Dynamics 51, 443, for what
it means to railways: the speed of the fold is the critical one.
"""

from dataclasses import dataclass

import numpy as np

from .collocation import Arc, Cycle, Flow

__all__ = ["FEWEST", "INTERVALS", "Branch", "branch"]

INTERVALS, FEWEST = 80, 4
QUICK = 4  # steps of Newton's method below which the next step of the branch is longer
BEGIN = 0.1  # of the size that counts as one: the first step
TURN = 0.05  # of the size that counts as one: how far v must go between two folds; a branch that stands upright wavers
SHORTEST = 1e-3  # the step below which the branch ends


@dataclass(frozen=True, eq=False)
class Branch:
    """Cycles in the order in which they were found, from the equilibrium on.

    Attributes
    ----------
    cycles : list of Cycle
        The first is the smallest.
    folds : list of Cycle
        Where v turns.
    ended : str
        Why the branch was not followed further.
    """

    cycles: list[Cycle]
    folds: list[Cycle]
    ended: str


def branch(
    flow: Flow,
    start: tuple[float, complex, np.ndarray],
    within: tuple[float, float],
    rest: np.ndarray | None = None,
    *,
    intervals: int = INTERVALS,
    most: int = 80,
    largest: float = np.inf,
    scale: float = 0.02,
    longest: float = 1.0,
) -> Branch:
    """Follow the cycles that begin where an equilibrium becomes unstable.

    Parameters
    ----------
    flow
        The system.
    start
        v there, the root i w on the imaginary axis, and its right vector, shape (n,), in the size that counts as one.
    within
        Lowest and highest v.
    rest
        The equilibrium there, shape (n,); zero where None.
    intervals
        N of (1).
    most
        Cycles.
    largest
        Size, in that of the vector, beyond which the branch is not followed.
    scale
        Change of v, of its own size, that counts as much as one such size.
    longest
        Step along the branch, in these.

    Returns
    -------
    Branch
        One cycle at least, where the first step is found.

    Raises
    ------
    ValueError
        For fewer than four intervals, or a start that does not oscillate or is not within.
    RuntimeError
        Where no cycle is found near the equilibrium.
    """
    v0, root, shape = start
    if intervals < FEWEST:
        raise ValueError(f"intervals of a cycle must be {FEWEST} or more, got {intervals}")
    if not root.imag > 0.0:
        raise ValueError(f"a branch of cycles begins at a pair of roots that oscillate, got the root {root:g}")
    if not within[0] <= v0 <= within[1]:
        raise ValueError(f"the branch begins at {v0:g}, which must lie from {within[0]:g} to {within[1]:g}")
    arc = Arc(flow, intervals, shape, root.imag, v0 * scale if v0 else scale)
    centre = np.zeros(shape.size) if rest is None else rest
    turning = np.real(np.exp(1j * arc.phases)[..., None] * shape)
    here = np.concatenate([np.broadcast_to(centre, turning.shape).ravel(), [root.imag, v0]])
    along = np.concatenate([turning.ravel(), [0.0, 0.0]])
    return _followed(arc, here, along / arc.length(along), within, most, largest, longest)


def _followed(
    arc: Arc, here: np.ndarray, along: np.ndarray, within: tuple[float, float], most: int, largest: float, longest: float
) -> Branch:
    """The branch from the equilibrium `here` on, in steps that grow where Newton's method is quick."""
    cycles: list[Cycle] = []
    folds: list[Cycle] = []
    step, ended = BEGIN, f"{most} cycles were found"
    while len(cycles) < most:
        found = arc.corrected(here + step * along, along, here)
        if found is None:
            step /= 2
            if step < SHORTEST:
                if not cycles:
                    raise RuntimeError("no limit cycle was found beside the equilibrium")
                ended = "Newton's method finds no further cycle"
                break
            continue
        there, ahead, steps = found
        if cycles and along[-1] * ahead[-1] < 0.0:
            turn = arc.cycle(arc.fold(here, along, step, ahead))
            if arc.share(turn.v - (folds[-1].v if folds else cycles[0].v)) > TURN:
                folds.append(turn)
        here, along = there, ahead
        if not within[0] <= here[-1] <= within[1]:
            ended = f"the parameter reaches {within[int(here[-1] > within[1])]:g}"
            break
        cycles.append(arc.cycle(here))
        size = arc.size(here)
        if size > largest:
            ended = f"the cycle is {largest:g} times the first size"
            break
        if len(cycles) > 2 and size < BEGIN / 2:
            ended = "the branch comes back to the equilibrium"
            break
        step = min(longest, step * (1.6 if steps <= QUICK else 0.7 if steps > 2 * QUICK else 1.0))
    return Branch(cycles, folds, ended)
