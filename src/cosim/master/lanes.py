"""Several runs of the same components at once, in the lanes of a vector register, with the bits that each has alone.

A run begins and ends as any other: its first steps, which look back to none, and a last short one are its own. In between the
runs march in step with one another (kernel/lockstep.c); one that is at its end makes room for the next. A run that fails in its
lane is done again alone, so that its error is the one that it has alone, and disturbs no neighbour.
"""

import time
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, field, replace
from typing import Any

from ..coupling import Algorithm, GaussSeidel, Jacobi, Nepce
from ..errors import RunError
from ..kernel import lockstep, native
from ..network import Network
from ..slaves.fmi.fmi2 import Fmi2Slave
from ..slaves.fmi.lanes import LaneCode, lane_code
from .results import Run
from .simulation import Running, run
from .stepping import Options
from .ways import Inner

__all__ = ["Job", "Lanes", "lane_codes"]


FEW = 4  # this part of the lanes, or less, is done sooner one by one: a step of all lanes takes as long as two or three alone


@dataclass(frozen=True)
class Job:
    """A run to be done.

    Parameters
    ----------
    key : object
        What the result comes back with.
    network : Network
        No other run's until the result is there.
    algorithm, step, stop, options
        See gyro_cosim.master.run().
    """

    key: Any
    network: Network
    algorithm: Algorithm
    step: float
    stop: float
    options: Options | None = None


@dataclass
class _Busy:
    """A run in its lane."""

    job: Job
    running: Running
    inner: Inner
    lane: lockstep.Lane
    began: float = field(default_factory=time.perf_counter)


def lane_codes(network: Network, width: int) -> Sequence[LaneCode] | str:
    """The code of each slave of an open network for so many lanes; or, in words, why there is none."""
    codes = []
    for slave in network.slaves:
        if not isinstance(slave, Fmi2Slave):
            return f"component {slave.name!r} is no FMU of FMI 2.0 in this process"
        try:
            codes.append(lane_code(*slave.file, width))
        except (AttributeError, OSError, RuntimeError, ValueError) as error:  # the library may lack what is asked of it
            return " ".join(str(error).split())
    return codes


class Lanes:
    """Runs of networks whose slaves are instances of the same FMUs.

    Parameters
    ----------
    kernel : native.Kernel
        The compiled kernel.
    codes : sequence of LaneCode
        Of lane_codes(), for as many lanes as `width`.
    width : int
        How many.
    """

    def __init__(self, kernel: native.Kernel, codes: Sequence[LaneCode], width: int) -> None:
        self._lockstep, self._width = lockstep.Lockstep(kernel, codes), width

    def results(self, take: Callable[[int], Job | None]) -> Iterator[tuple[Any, Run | Exception, float]]:
        """Do all runs that take() gives.

        Parameters
        ----------
        take : callable
            take(slot) returns the next job or None if there is none now. Jobs that run at the same time must have instances
            of the same FMUs, and step them in the same order.

        Yields
        ------
        key : object
            Of the job.
        run : Run or Exception
            What gyro_cosim.master.run() returns or raises.
        seconds : float
            The share of the time that was this run's.
        """
        busy: list[_Busy | None] = [None] * self._width
        spent = [0.0] * self._width
        while True:
            for slot in range(self._width):
                while busy[slot] is None:
                    job = take(slot)
                    if job is None:
                        break
                    began = time.perf_counter()
                    started = self._started(job)
                    spent[slot] = time.perf_counter() - began
                    if isinstance(started, _Busy):
                        busy[slot] = started
                    else:
                        yield job.key, started, spent[slot]
            runs = [one for one in busy if one is not None]
            if not runs:
                return
            began = time.perf_counter()
            ended = self._march(busy)
            share = (time.perf_counter() - began) / len(runs)
            for slot, one in enumerate(busy):
                spent[slot] += share
                if one is not None and slot in ended:
                    busy[slot] = None
                    began = time.perf_counter()
                    result = _alone(one.job) if ended[slot] else _concluded(one)
                    yield one.job.key, result, spent[slot] + time.perf_counter() - began

    def _started(self, job: Job) -> "_Busy | Run | Exception":
        """The run of a job up to where the inner loop takes over, or its result where that does not happen."""
        try:
            if not isinstance(job.algorithm, Jacobi | Nepce | GaussSeidel):
                return _alone(job)
            running = Running(job.network, job.algorithm, job.step, job.stop, options=_compiled(job))
            stepper = running.stepper
            while not stepper.over:
                way = stepper.way()
                if isinstance(way, Inner):
                    if not way.loop.meters:
                        return _alone(job)
                    return _Busy(job, running, way, self._lockstep.lane(way.loop))
                stepper.took(way, *way.step(stepper.state))
            return running.result(running.reached())
        except Exception:  # it will be met again, and told as it is alone
            return _alone(job)

    def _march(self, busy: Sequence[_Busy | None]) -> dict[int, bool]:
        """A chunk of steps of all runs; the slots of those that are at the end of their lane, and whether they failed there."""
        runs = [one for one in busy if one is not None]
        if len(runs) <= max(1, self._width // FEW):
            return {slot: failed for slot, one in enumerate(busy) if one is not None and (failed := _stepped(one)) is not None}
        rows = min(one.inner.ahead(one.running.stepper.state) for one in runs)
        prepared = {}
        for one in runs:
            state = one.running.stepper.state
            sums, before = prepared[id(one)] = one.inner.prepare(state, rows)
            one.inner.loop.begin()
            assert one.inner.loop.compiled is not None
            one.inner.loop.compiled.begin(state.energy.past, before, sums)
        began = time.perf_counter()
        starts = [0 if one is None else one.inner.row for one in busy]
        marched = self._lockstep.march([None if one is None else one.lane for one in busy], starts, rows)
        took = time.perf_counter() - began
        ended = {}
        for slot, lane in enumerate(busy):
            if lane is None:
                continue
            if marched.bad[slot]:
                ended[slot] = True
                continue
            one, stepper = lane, lane.running.stepper
            sums, _ = prepared[id(one)]
            assert one.inner.loop.compiled is not None
            one.inner.loop.compiled.end(sums)
            one.inner.paced(took)
            spent = one.inner.loop.spent(took / len(runs))
            over = marched.over[slot]
            stepper.took(one.inner, one.inner.concluded(stepper.state, rows, marched.done, spent, sums, ended=over))
            if stepper.over or stepper.way() is not one.inner:
                ended[slot] = False
        return ended


def _stepped(one: _Busy) -> bool | None:
    """A chunk of steps of a run by itself: None if it goes on, else whether it has failed."""
    stepper = one.running.stepper
    state, failure = one.inner.step(stepper.state)
    if failure is not None:
        return True
    stepper.took(one.inner, state)
    return False if stepper.over or stepper.way() is not one.inner else None


def _concluded(one: _Busy) -> Run | Exception:
    """The result of a run that has left its lane."""
    stepper = one.running.stepper
    try:
        while not stepper.over:
            way = stepper.way()
            stepper.took(way, *way.step(stepper.state))
        return one.running.result(one.running.reached())
    except Exception:
        return _alone(one.job)


def _compiled(job: Job) -> Options:
    return replace(job.options or Options(), compiled=True)


def _alone(job: Job) -> Run | Exception:
    try:
        return run(job.network, job.algorithm, job.step, job.stop, options=_compiled(job))
    except (RunError, ArithmeticError, ValueError, OSError, RuntimeError) as error:
        return error
