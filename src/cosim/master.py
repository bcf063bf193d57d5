"""The master: runs a system over macro steps and says what it cost and how much energy the coupling made."""

import time
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import Literal

import numpy as np

from cosim import adaptive, fast
from cosim.adaptive import Adaptive
from cosim.checkpoint import Checkpoint, Resume
from cosim.coupling import Algorithm, History, Jacobi
from cosim.energy import BondEnergy, EnergyMeter
from cosim.errors import RunError
from cosim.network import Network
from cosim.recording import Recorder, Recording
from cosim.slaves import Slave, open_slave
from cosim.system import System
from cosim.trajectory import Trajectory

Progress = Callable[[float, float], None]
Status = Literal["done", "ended", "interrupted", "failed"]
HISTORY = 4  # rows of outputs before the newest that a chunk begins with
WATCHED = 64  # macro steps between two looks at the stop conditions
CHUNK_NUMBERS = 1_000_000  # outputs held between two visits of the recorder


@dataclass(frozen=True)
class Timing:
    """Seconds: opening and starting the slaves, the loop over macro steps, and in it each component's steps."""

    setup_s: float
    loop_s: float
    do_step_s: dict[str, float]

    @property
    def master_s(self) -> float:
        """What the loop spent outside the components' steps."""
        return self.loop_s - sum(self.do_step_s.values())


@dataclass(frozen=True, eq=False)
class Run:
    """What a run did.

    step : macro step (s), the first one where it adapts. steps : macro steps completed.
    status : "done", "ended" by one of the system's stop conditions, which `ended_by` tells, "interrupted" by the user, "failed".
    iterations : passes over macro steps where the algorithm iterates, in all.
    rejections : macro steps that were taken back to be done shorter.
    """

    system: System
    algorithm: Algorithm
    step: float
    steps: int
    trajectory: Trajectory
    energy: tuple[BondEnergy, ...]
    timing: Timing
    status: Status
    iterations: int = 0
    rejections: int = 0
    ended_by: str = ""

    @property
    def energy_residual(self) -> float:
        """Energy (J) that the coupling added over all power bonds."""
        return sum(bond.residual for bond in self.energy)


@dataclass(frozen=True)
class Options:
    """What a run may do besides stepping evenly and keeping everything; see the classes named.

    compiled : whether the inner loop runs compiled, with the same results to the last bit; None: where the run is long
    enough to pay for compiling, or loading, it once in this process. Who does many short runs says True.
    """

    record: Recording = field(default_factory=Recording)
    adaptive: Adaptive | None = None
    checkpoint: Checkpoint | None = None
    resume: Resume | None = None
    compiled: bool | None = None


def simulate(
    system: System,
    *,
    algorithm: Algorithm | None = None,
    step: float | None = None,
    stop: float | None = None,
    in_process: bool = False,
    isolate: bool = False,
    substeps: Mapping[str, int] | None = None,
    loops: Literal["solve", "refuse"] = "solve",
    options: Options | None = None,
    progress: Progress | None = None,
    before_step: Callable[[int], None] | None = None,
) -> Run:
    """Open the system's components, run it from 0 to `stop` (s) at macro step `step` (s), and close them.

    algorithm : Jacobi(1) where None. step, stop : the system's own where None.
    in_process : components of the catalogue run in this process instead of as FMUs. isolate : every FMU in a process of its own.
    substeps : component name -> in how many parts it does each macro step. loops : what to do with algebraic loops.
    progress : called now and then with the present time and the end (s). before_step : see run().
    Raises ValueError for wrong use, SlaveError for a component that fails, ConvergenceError for an iteration without end;
    their `partial` is the run up to there.
    """
    began = time.perf_counter()
    step, stop = system.step if step is None else step, system.stop if stop is None else stop
    macro_steps(step, stop)
    with open_network(system, in_process=in_process, isolate=isolate, substeps=substeps) as network:
        if loops == "refuse":
            network.refuse_loops()
        return run(
            network, algorithm or Jacobi(1), step, stop,
            options=options, progress=progress, before_step=before_step, began=began,
        )  # fmt: skip


def open_network(
    system: System, *, in_process: bool = False, isolate: bool = False, substeps: Mapping[str, int] | None = None
) -> Network:
    """The system's slaves, opened and wired; close it after use."""
    slaves: list[Slave] = []
    extra = {"isolate": True} if isolate else {}
    try:
        for part in system.parts:
            slaves.append(open_slave(part.name, part.source, in_process=in_process, **extra))
        return Network(system, slaves, substeps=substeps)
    except BaseException:
        for slave in slaves:
            slave.close()
        raise


def macro_steps(step: float, stop: float) -> int:
    """How many macro steps of `step` (s) reach `stop` (s); the last may be shorter, so that it ends there exactly."""
    if not (np.isfinite(stop) and stop > 0.0):
        raise ValueError(f"`stop` must be positive, got {stop:g} s")
    if not (np.isfinite(step) and step > 0.0):
        raise ValueError(f"`step` must be positive, got {step:g} s")
    if step > stop * (1 + 1e-9):
        raise ValueError(f"`step` must be at most the run's length of {stop:g} s, got {step:g} s")
    return max(1, int(np.ceil(stop / step - 1e-9)))


def run(
    network: Network,
    algorithm: Algorithm,
    step: float,
    stop: float,
    *,
    options: Options | None = None,
    progress: Progress | None = None,
    before_step: Callable[[int], None] | None = None,
    began: float | None = None,
) -> Run:
    """As simulate(), on an open network, which stays open; it starts anew.

    before_step : called before macro step k = 1, 2, ... with k; what paces a run to a clock waits here.
    began : when the set-up began (time.perf_counter), for the timing.
    """
    began = time.perf_counter() if began is None else began
    options = options or Options()
    n = macro_steps(step, stop)
    algorithm.check(network)
    if options.checkpoint is not None:
        options.checkpoint.check(network)
        if options.adaptive is not None:
            raise ValueError("a checkpoint needs an even macro step, it cannot be combined with an adaptive one")
    march = _March(network, algorithm, step, stop, n, options)
    start = time.perf_counter()
    status: Status = "done"
    failure: RunError | None = None
    try:
        march.go(progress, before_step)
        status = "ended" if march.ended_by else "done"
        # Every slave is left with the inputs of the end, for what asks it afterwards.
        network.outputs(march.history.Y[0].copy(), march.history.t[0])
    except KeyboardInterrupt:
        status = "interrupted"
    except RunError as error:
        status, failure = "failed", error
    march.hand_over()
    loop = time.perf_counter() - start
    result = Run(
        network.system, algorithm, step, march.done, march.recorder.finish(), march.meter.result(),
        Timing(start - began, loop, dict(zip((s.name for s in network.slaves), network.do_step_s, strict=True))),
        status, march.history.iterations, march.rejections, march.ended_by,
    )  # fmt: skip
    if failure is not None:
        failure.partial = result
        raise failure
    return result


class _March:
    """The state of a run on its way. Outputs are collected in chunks, which recorder and energy meter then take over.

    Row `row` of the chunk holds macro step `done`; up to HISTORY rows before it are older points.
    """

    def __init__(self, network: Network, algorithm: Algorithm, step: float, stop: float, n: int, options: Options) -> None:
        self.network, self.algorithm, self.step, self.stop, self.n = network, algorithm, step, stop, n
        self.options, self.done, self.rejections, self.ended_by = options, 0, 0, ""
        self._stops = [(network.place(stop.signal), stop.above, stop.says) for stop in network.system.stop_when]
        last = stop - (n - 1) * step
        self._last = step if abs(last - step) <= 1e-9 * step else last
        Y = network.initialize(0.0, stop)
        self.history = History(0.0, Y.copy(), network.held)
        self.meter = EnergyMeter(network, Y)
        resume = options.resume
        position = resume.position() if resume is not None else None
        self.recorder = Recorder(options.record, network, n, position)
        rows = int(np.clip(CHUNK_NUMBERS // max(1, Y.size), 16, 4096))
        self._Y, self._t, self._h = np.empty((HISTORY + rows, Y.size)), np.empty(HISTORY + rows), np.empty(HISTORY + rows)
        self._used = np.zeros((rows, 2 * len(network.bonds), 3))
        self._rows = rows
        if resume is None:
            self.recorder.add(0, np.zeros(1), Y[None, :])
        else:
            self.done = resume.restore(network, algorithm, step, self.history, self.meter, self.recorder)
        self._begin_chunk()

    def go(self, progress: Progress | None, before_step: Callable[[int], None] | None) -> None:
        """Step to the end."""
        if self.options.adaptive is not None:
            self._go_adaptively(self.options.adaptive, progress, before_step)
            return
        shown, saved = time.perf_counter(), self.history.t[0]
        inner = None
        compiled = self.options.compiled
        if compiled is None:
            compiled = (self.n - self.done) * len(self.network.slaves) >= fast.LONG
        while self.done < self.n and not self.ended_by:
            if (
                inner is None
                and before_step is None
                and self.done >= self.algorithm.degree
                and fast.fits(self.network, self.algorithm)
            ):
                inner = fast.FastLoop(self.network, self.algorithm, self._Y, self._t, self._h, self._used)
            if inner is not None and self._last_is_far():
                self._march(inner, compiled)
            else:
                if before_step is not None:
                    before_step(self.done + 1)
                self._advance(self._last if self.done + 1 == self.n else self.step, self._time(self.done + 1))
            if progress is not None and (now := time.perf_counter()) - shown > 0.1:
                shown = now
                progress(self.history.t[0], self.stop)
            checkpoint = self.options.checkpoint
            if checkpoint is not None and self.history.t[0] - saved >= checkpoint.every - 1e-9 * self.step:
                saved = self.history.t[0]
                self.hand_over()
                checkpoint.write(self.network, self.algorithm, self.step, self.done, self.history, self.meter, self.recorder)

    def _go_adaptively(self, how: Adaptive, progress: Progress | None, before_step: Callable[[int], None] | None) -> None:
        controller = adaptive.Controller(how, self.network, self.algorithm, self.step, self.stop)
        while self.history.t[0] < self.stop and not self.ended_by:
            if before_step is not None:
                before_step(self.done + 1)
            steps = controller.advance(self.history)
            self.rejections = controller.rejections
            for h, t, Y, used in steps:
                self._accept(h, t, Y, used)
            if progress is not None and self.done % 16 == 0:
                progress(self.history.t[0], self.stop)

    def _time(self, k: int) -> float:
        return self.stop if k == self.n else k * self.step

    def _last_is_far(self) -> bool:
        """Whether the next step is an even one: a shorter last step is left to the plain path."""
        return self.done + 1 < self.n or self._last == self.step

    def _advance(self, h: float, t: float) -> None:
        """One macro step the plain way."""
        Y, used = self.algorithm.advance(self.network, self.history, h)
        self._accept(h, t, Y, used)

    def _accept(self, h: float, t: float, Y: np.ndarray, used: list[np.ndarray]) -> None:
        self.row += 1
        self._Y[self.row], self._t[self.row], self._h[self.row] = Y, t, h
        for q, bond in enumerate(self.network.bonds):
            for p, (i, j) in enumerate((bond.motion_input, bond.effort_input)):
                self._used[self.row - self._first - 1, 2 * q + p] = used[i][:, j]
        self.history.push(t, Y)
        self.done += 1
        self._watch(self.row, 1)
        if self.row == self._first + self._rows:
            self.hand_over()

    def _march(self, inner: fast.FastLoop, compiled: bool) -> None:
        """As many even macro steps as the chunk has room for, in the inner loop."""
        room = min(self._first + self._rows - self.row, WATCHED if self._stops else self._rows)
        even = self.n - self.done - (0 if self._last == self.step else 1)
        checkpoint = self.options.checkpoint
        ahead = min(room, even, 1 << 62 if checkpoint is None else max(1, round(checkpoint.every / self.step)))
        k = self.done + 1 + np.arange(ahead)
        self._t[self.row + 1 : self.row + 1 + ahead] = np.where(k == self.n, self.stop, k * self.step)
        self._h[self.row + 1 : self.row + 1 + ahead] = self.step
        if self.row != self._first:  # the inner loop numbers the used inputs from the first step it does
            self.hand_over()
            self._march(inner, compiled)
            return
        done = inner.march(self.row, ahead, fast=compiled)
        kept = self._watch(self.row + 1, done)
        if kept < done:  # the slaves are some steps further; what they did there is dropped
            done = ahead = kept
        for m in range(max(0, done - HISTORY), done):
            self.history.push(float(self._t[self.row + 1 + m]), self._Y[self.row + 1 + m].copy())
        self.row += done
        self.done += done
        if done < ahead and not self.ended_by:
            inner.explain(self.row)
        self.hand_over()

    def _watch(self, row: int, rows: int) -> int:
        """How many of the `rows` rows from `row` on count: all, or up to the first where a stop condition holds."""
        for place, above, says in self._stops:
            over = np.flatnonzero(self._Y[row : row + rows, place] > above)
            if over.size:
                rows = int(over[0]) + 1
                self.ended_by = f"{says} at t = {self._t[row + rows - 1]:.6g} s"
        return rows

    def hand_over(self) -> None:
        """Give the steps of the chunk to recorder and meter, and begin the next chunk with what the history needs."""
        new = slice(self._first + 1, self.row + 1)
        count = self.row - self._first
        if count:
            self.recorder.add(self.done - count + 1, self._t[new], self._Y[new])
            self.meter.add(self._h[new], self._Y[new], self._used[:count])
        self._begin_chunk()

    def _begin_chunk(self) -> None:
        kept = len(self.history.Y)
        for m in range(kept):
            self._Y[kept - 1 - m], self._t[kept - 1 - m] = self.history.Y[m], self.history.t[m]
        self.row = self._first = kept - 1
