"""How long work tells how far it has come."""

from collections.abc import Callable

Progress = Callable[[float, float], None]  # called with how much is done and how much there is


def stage(progress: Progress | None, begin: float, end: float) -> Progress | None:
    """A share of some work, told as a whole of its own, so that one bar runs through several pieces of work.

    Parameters
    ----------
    progress : Progress or None
        What the whole is told to; None: nobody.
    begin, end : float
        Where the piece begins and ends in the whole, from 0 to 1.
    """
    if progress is None:
        return None
    return lambda done, total: progress(begin + (end - begin) * (done / total if total else 1.0), 1.0)
