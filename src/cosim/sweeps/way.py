"""Which way the runs of a sweep go, in one line: side by side in the lanes of the processor, or one at a time."""

from ..coupling import GaussSeidel, Jacobi, Nepce, algorithm
from ..slaves.fmi.lanes import widest, without_lanes
from .plan import Plan

EXPLICIT = (Jacobi, GaussSeidel, Nepce)


def way_of(plan: Plan, lanes: int | None = None, *, elsewhere: bool = False) -> str:
    """The line.

    Parameters
    ----------
    plan
        Of the sweep.
    lanes
        What was asked for; None for as many as the processor has.
    elsewhere
        Whether other machines do the runs, whose processors decide.

    Returns
    -------
    str
    """
    if lanes == 1:
        return "one run at a time in each worker, as asked for"
    why = "; ".join(filter(None, map(without_lanes, plan.files.values())))
    named = {str(point.get("algorithm", plan.context.defaults.get("algorithm"))) for point in plan.runs.values()}
    coupled = sorted(name for name in named if not issubclass(type(algorithm(name, 1)), EXPLICIT))
    if why or len(coupled) == len(named):
        return f"one run at a time in each worker: {why or ' and '.join(coupled) + ' iterates'}"
    many = "" if elsewhere else f"{min(widest(), lanes or widest())} "
    others = f"; those of {' and '.join(coupled)} one at a time" if coupled else ""
    return f"{many}runs at once in each worker, in the lanes of its processor, where their steps take long{others}"
