"""How a run will use its slaves: told to each before it begins, so that an FMU is promised exactly what will be done."""

from collections.abc import Mapping
from dataclasses import dataclass

from .base import Promised, Slave
from .signal import Value


@dataclass(frozen=True)
class Usage:
    """What a run does with its slaves, and what it needs of them.

    Parameters
    ----------
    degree : {0, 1, 2}
        Of the input polynomials that they are given.
    uneven : str
        Why not all steps have the same length; empty where they do.
    goes_back : str
        What saves states and restores them, such as "algorithm 'iterated'"; empty where nothing does.
    can_do_without : bool
        Whether the run can do without going back: it then loses accuracy in its first steps.
    tolerance : float or None
        The relative tolerance that every FMU is told; None: that of its own DefaultExperiment, where it has one.
    step : float
        Length of its steps (s), of the longest where they differ; 0 where that is not known.
    ends : bool
        Whether the stop time is final; False where a checkpoint lets the run go on beyond it.
    """

    degree: int = 0
    uneven: str = ""
    goes_back: str = ""
    can_do_without: bool = False
    tolerance: float | None = None
    step: float = 0.0
    ends: bool = True

    def __post_init__(self) -> None:
        if self.tolerance is not None and not 0.0 < self.tolerance < float("inf"):
            raise ValueError(f"tolerance must be positive, got {self.tolerance!r}")


def promise(slave: Slave, usage: Usage, values: Mapping[str, Value], t: float, stop: float) -> tuple[str, ...]:
    """Tell `slave` how the run from `t` to `stop` (s) with these start values will use it.

    Returns
    -------
    tuple of str
        What the slave cannot do and how the run does without it, one line each; `slave.description` then says so, too.

    Raises
    ------
    ValueError
        What it cannot do and the run cannot do without.
    """
    return slave.promise(usage, values, t, stop) if isinstance(slave, Promised) else ()
