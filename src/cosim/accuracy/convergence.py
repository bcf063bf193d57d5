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
    """Errors of one algorithm at falling macro steps (s).

    errors : for each step the largest over outputs of max |y - y_ref| / max |y_ref|, on the grid of the coarsest step;
    infinite where a run did not reach its end.
    used : which of them the fit of `observed_order` rests on; NaN where fewer than two do.
    """

    algorithm: Algorithm
    steps: tuple[float, ...]
    errors: tuple[float, ...]
    used: tuple[bool, ...]
    observed_order: float


@dataclass(frozen=True)
class Convergence:
    """Ladders of several algorithms against one reference."""

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
    """Run `system` from its start to `stop` (s) with each algorithm at macro steps step, step / 2, ... (`rungs` of them; s).

    ValueError where that length is no multiple of `step`, or a component has no equations to make the reference from.
    """
    n = macro_steps(step, stop, system.start)
    length = stop - system.start
    if abs(n * step - length) > 1e-9 * length:
        since = f" after the start at {system.start:g} s" if system.start else ""
        raise ValueError(f"`stop` must be a multiple of the coarsest step {step:g} s{since}, got {stop:g} s")
    if rungs < 2:
        raise ValueError(f"`rungs` must be at least 2, got {rungs}")
    monolith = Monolith(system)
    reference = monolith.solve(np.arange(n + 1) * step).values  # over the time since the start: no component asks for more
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

    It is the same for all algorithms: the smallest error at which one of them comes to a stand at its finest steps.
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
    """The observed order from the errors at the steps (s) that neither rounding nor the components' own error spoils."""
    least = max(ASYMPTOTIC[0], 2 * of_components)
    used = tuple(least < e < ASYMPTOTIC[1] for e in errors)
    order = float("nan")
    if sum(used) >= 2:
        h, e = (np.log([value for value, u in zip(row, used, strict=True) if u]) for row in (steps, errors))
        order = float(np.polyfit(h, e, 1)[0])
    return Ladder(algorithm, tuple(steps), tuple(errors), used, order)
