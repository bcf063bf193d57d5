"""Does the result converge as the macro step shrinks, and how fast? A ladder of steps against the monolith."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from ..coupling import Algorithm
from ..errors import RunError
from ..master import Progress, macro_steps, open_network, run
from ..network import Network
from ..systems import System
from .monolith import Monolith

# The fit leaves out errors outside this range: above it the error is no longer proportional to a power of the step,
# below it rounding shows.
ASYMPTOTIC = (1e-9, 0.1)
STAGNANT = 1.5  # half the step should halve the error at least: where it falls by less, the components' own error has come


@dataclass(frozen=True)
class Ladder:
    """Errors of one algorithm at falling macro steps.

    Parameters
    ----------
    algorithm
        With its degree of extrapolation.
    steps
        The macro steps, s.
    errors
        For each step the largest over outputs of max |y - y_ref| / max |y_ref|, on the grid of the coarsest step; infinite
        where a run did not reach its end.
    used
        Which of the errors the fit of `observed_order` uses.
    observed_order
        Of accuracy; NaN where the fit has fewer than two errors to use.
    """

    algorithm: Algorithm
    steps: tuple[float, ...]
    errors: tuple[float, ...]
    used: tuple[bool, ...]
    observed_order: float


@dataclass(frozen=True)
class Convergence:
    """Ladders of several algorithms against one reference.

    Parameters
    ----------
    system
        What was run.
    stop
        The end of the runs, s.
    reference
        How the reference was computed.
    ladders
        One for each algorithm.
    """

    system: System
    stop: float
    reference: str
    ladders: tuple[Ladder, ...]


def converge(
    system: System,
    algorithms: Sequence[Algorithm],
    *,
    step: float,
    rungs: int,
    stop: float,
    in_process: bool = False,
    progress: Progress | None = None,
) -> Convergence:
    """Run a system with each algorithm at ever smaller macro steps, and compare with the same system without coupling.

    Parameters
    ----------
    system
        Of catalogue components, from whose equations the reference is made.
    algorithms
        Each runs at all steps.
    step
        The coarsest macro step, s; the others are step / 2, step / 4, ...
    rungs
        How many steps there are, at least 2.
    stop
        The end of the runs, s.
    in_process
        Whether components run in this process, not as FMUs.
    progress
        Called with the work done and the work in all.

    Returns
    -------
    Convergence

    Raises
    ------
    ValueError
        Where the length of a run is no multiple of `step`, or a component has no equations.
    """
    n = macro_steps(step, stop, system.start)
    length = stop - system.start
    if abs(n * step - length) > 1e-9 * length:
        since = f" after the start at {system.start:g} s" if system.start else ""
        raise ValueError(f"`stop` must be a multiple of the coarsest step {step:g} s{since}, got {stop:g} s")
    if rungs < 2:
        raise ValueError(f"`rungs` must be at least 2, got {rungs}")
    monolith = Monolith(system)
    reference = monolith.solve(np.arange(n + 1) * step).values  # over the time since the start: no component requires more
    steps = tuple(step / 2**i for i in range(rungs))
    work, done, errors_of_all = len(algorithms) * sum(2**i for i in range(rungs)), 0, []
    with open_network(system, in_process=in_process) as network:
        for algorithm in algorithms:
            errors = []
            for i, h in enumerate(steps):
                errors.append(_error(network, algorithm, h, stop, 2**i, reference))
                done += 2**i
                if progress is not None:
                    progress(done, work)
            errors_of_all.append(errors)
    of_components = own_error(errors_of_all)
    ladders = tuple(ladder(a, steps, errors, of_components) for a, errors in zip(algorithms, errors_of_all, strict=True))
    return Convergence(system, stop, "matrix exponential" if monolith.is_linear else "monolith, DOP853", ladders)


def own_error(ladders: Sequence[Sequence[float]]) -> float:
    """The error that the components make by themselves, which no smaller macro step takes away; 0 where none shows.

    Parameters
    ----------
    ladders
        For each algorithm its errors from the coarsest to the finest step.

    Returns
    -------
    error
        The same for all algorithms: the smallest error at which one of them stagnates at its finest steps.
    """
    last = [(e[-2], e[-1]) for e in ladders if e[-1] < ASYMPTOTIC[1]]
    return min((fine for coarse, fine in last if fine > coarse / STAGNANT), default=0.0)


def _error(network: Network, algorithm: Algorithm, h: float, stop: float, every: int, reference: np.ndarray) -> float:
    """The largest error of an output relative to its size; infinite where the run does not reach its end."""
    try:
        result = run(network, algorithm, h, stop)
    except RunError:  # too coarse a step to get through: that is a result of the ladder
        return float("inf")
    if result.status != "done":
        return float("inf")
    size = np.abs(reference).max(axis=0)
    moving = size > 0.0
    return float((np.abs(result.trajectory.values[::every] - reference).max(axis=0)[moving] / size[moving]).max())


def ladder(algorithm: Algorithm, steps: Sequence[float], errors: Sequence[float], of_components: float) -> Ladder:
    """The ladder of one algorithm: its order from the errors that neither rounding nor the components' own error spoils.

    Parameters
    ----------
    algorithm
        Of the ladder.
    steps, errors
        Macro steps, s, and the relative error at each.
    of_components
        The error that the components make by themselves, see `own_error`.

    Returns
    -------
    Ladder
    """
    least = max(ASYMPTOTIC[0], 2 * of_components)
    used = tuple(least < e < ASYMPTOTIC[1] for e in errors)
    order = float("nan")
    if sum(used) >= 2:
        h, e = (np.log([value for value, u in zip(row, used, strict=True) if u]) for row in (steps, errors))
        order = float(np.polyfit(h, e, 1)[0])
    return Ladder(algorithm, tuple(steps), tuple(errors), used, order)
