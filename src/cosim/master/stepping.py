"""A run on its way: macro step after macro step, until its end, a stop condition or a failure.

    Stepper.go:  while not over: take as many macro steps as one way of stepping does at once; show progress; write checkpoints

Three ways, each an object with step(): one macro step by the algorithm itself (Plain), many by the inner loop (Inner), one
that adapts (Adapting). All of them write the points they reach into the same Rows, which recorder and energy meter take over.
"""

import logging
import time
from collections.abc import Callable
from dataclasses import dataclass, field, replace
from typing import Protocol

import numpy as np

from ..coupling import Algorithm, History
from ..coupling.base import Used
from ..kernel import driver, native
from ..network import Network
from .adaptive import Adaptive, Controller
from .checkpoint import Checkpoint, Resume, fingerprint
from .energy import EnergyMeter
from .progress import Progress
from .recording import Recorder, Recording
from .state import RunState
from .time_grid import TimeGrid

_log = logging.getLogger(__name__)

BEFORE = 4  # rows of outputs before the newest that a chunk begins with
FIRST_CHUNK = 4  # macro steps of the inner loop's first chunk
PATIENCE = 0.05  # s between two chunks of the inner loop: progress, Ctrl-C and checkpoints wait so long at most
CHUNK_NUMBERS = 1_000_000  # outputs held between two visits of the recorder
SHOWN_EVERY = 0.1  # s between two calls of progress
MOST_POINTS = 2  # that one step of Plain or Adapting adds


@dataclass(frozen=True)
class Options:
    """What a run may do besides stepping evenly and keeping everything.

    Parameters
    ----------
    record : Recording
        Which results are kept, and where.
    adaptive : Adaptive, optional
        Macro steps that adapt.
    checkpoint, resume : Checkpoint, Resume, optional
        Write the state of the run now and then; go on from such a state.
    compiled : bool, optional
        Whether the inner loop runs compiled, with the same results to the last bit; None: where it has been compiled on this
        machine already, or the run is long enough to pay for that.
    """

    record: Recording = field(default_factory=Recording)
    adaptive: Adaptive | None = None
    checkpoint: Checkpoint | None = None
    resume: Resume | None = None
    compiled: bool | None = None


class Rows:
    """Points reached since the recorder and the energy meter were here last.

    Row `first` holds the point before them, with older ones before it; row `newest` the newest. Y, t, h : outputs, times and
    the steps that led there. used : shape (rows, 2 n_bonds, 3), per new point the inputs of the power bonds on the way to it.
    """

    def __init__(self, network: Network) -> None:
        n_Y = len(network.names)
        self.size = int(np.clip(CHUNK_NUMBERS // max(1, n_Y), 16, 4096))
        self.Y, self.t, self.h = np.zeros((BEFORE + self.size, n_Y)), np.empty(BEFORE + self.size), np.empty(BEFORE + self.size)
        self.used = np.zeros((self.size, 2 * len(network.bonds), 3))
        self._ends = [place for bond in network.bonds for place in (bond.motion_input, bond.effort_input)]
        self.first = self.newest = 0

    @property
    def count(self) -> int:
        """New points."""
        return self.newest - self.first

    @property
    def room(self) -> int:
        """How many more find a place."""
        return self.size - self.count

    def begin(self, history: History) -> None:
        """Forget the points; the next ones follow those of `history`."""
        kept = len(history.Y)
        for m in range(kept):
            self.Y[kept - 1 - m], self.t[kept - 1 - m] = history.Y[m], history.t[m]
        self.newest = self.first = kept - 1

    def filled(self, count: int) -> None:
        """So many points have been written behind the newest, with their steps and inputs."""
        self.newest += count

    def add(self, h: float, t: float, Y: np.ndarray, used: Used) -> None:
        """The point Y at t (s), reached over h (s) under the inputs `used`."""
        for q, (i, j) in enumerate(self._ends):
            self.used[self.count, q] = used[i][:, j]
        self.newest += 1
        self.Y[self.newest], self.t[self.newest], self.h[self.newest] = Y, t, h


class Way(Protocol):
    """A way of stepping."""

    def step(self, state: RunState) -> tuple[RunState, BaseException | None]:
        """One or more macro steps from `state`, with their points added to the rows; and what stopped them, if something did."""


class Plain:
    """One macro step by the algorithm."""

    def __init__(self, network: Network, algorithm: Algorithm, grid: TimeGrid, rows: Rows) -> None:
        self._network, self._algorithm, self._grid, self._rows = network, algorithm, grid, rows

    def step(self, state: RunState) -> tuple[RunState, BaseException | None]:
        """See Way."""
        h, t = self._grid.length(state.done + 1), self._grid.time(state.done + 1)
        step = self._algorithm.advance(self._network, state.history, h, state.memory)
        self._rows.add(h, t, step.Y, step.used)
        return state.after(step, t), None


class Inner:
    """As many macro steps as there is room for, by the inner loop. most : bound on how many."""

    def __init__(
        self, network: Network, algorithm: Algorithm, grid: TimeGrid, rows: Rows, *, kernel: native.Kernel | None, most: int
    ) -> None:
        self._loop = driver.FastLoop(network, algorithm, rows.Y, rows.t, rows.h, rows.used, kernel)
        self._network, self._grid, self._rows, self._most = network, grid, rows, most
        self._chunk = FIRST_CHUNK

    def step(self, state: RunState) -> tuple[RunState, BaseException | None]:
        """See Way. The rows hold no new points before it."""
        rows, row = self._rows, self._rows.newest
        ahead = min(rows.room, self._chunk, self._grid.even - state.done, self._most)
        rows.t[row + 1 : row + 1 + ahead] = self._grid.times(state.done + 1 + np.arange(ahead))
        rows.h[row + 1 : row + 1 + ahead] = self._grid.step
        began = time.perf_counter()
        done, spent, ended = self._loop.march(row, ahead)
        took = time.perf_counter() - began
        self._chunk = max(1, self._chunk // 2) if took > PATIENCE else 2 * self._chunk if took < PATIENCE / 4 else self._chunk
        self._network.count_time(spent)
        rows.filled(done)
        history = state.history
        for m in range(row + 1 + max(0, done - BEFORE), row + 1 + done):
            history = history.push(float(rows.t[m]), rows.Y[m].copy())
        state = replace(state, done=state.done + done, history=history)
        return state, None if done == ahead or ended else self._loop.failure(rows.newest)


class Adapting:
    """One macro step as long as its error estimate allows."""

    def __init__(self, controller: Controller, rows: Rows) -> None:
        self._controller, self._rows = controller, rows

    def step(self, state: RunState) -> tuple[RunState, BaseException | None]:
        """See Way."""
        steps, rejections = self._controller.advance(state.history, state.memory)
        for h, t, step in steps:
            self._rows.add(h, t, step.Y, step.used)
            state = state.after(step, t)
        return replace(state, rejections=state.rejections + rejections), None


class Stepper:
    """Takes a run from its start to its end.

    state : how far it is, see RunState. without_kernel : why the compiled kernel cannot be had, where it was wanted.
    """

    def __init__(self, network: Network, algorithm: Algorithm, grid: TimeGrid, options: Options) -> None:
        self._network, self._algorithm, self._grid, self._options = network, algorithm, grid, options
        self._stops = [(network.place(stop.signal), stop.above, stop.says) for stop in network.system.stop_when]
        Y = network.initialize(grid.start, grid.stop)
        self._recorder = Recorder(options.record, network, grid.n)
        history = History((grid.start,), (Y.copy(),), network.held)
        self.state = RunState(0, history, EnergyMeter(network).begin(Y))
        self._fingerprint = ""
        if options.checkpoint is not None or options.resume is not None:
            self._fingerprint = fingerprint(network, algorithm, grid.step, self._recorder.names)
        if options.resume is None:
            self._recorder.begin()
            self._recorder.add(0, np.array([grid.start]), Y[None, :])
        else:
            self.state = options.resume.restore(self._fingerprint, network, self.state, self._recorder)
        self._fits = options.adaptive is None and driver.fits(network, algorithm)
        self._kernel: native.Kernel | None = None
        self.without_kernel = ""
        if self._fits and _pays(options.compiled, (grid.n - self.state.done) * len(network.slaves)):
            kernel = native.kernel()
            if isinstance(kernel, native.Kernel):
                self._kernel = kernel
            else:
                self.without_kernel = kernel
        self._meter = EnergyMeter(network, None if self._kernel is None else self._kernel.accumulate)
        self._rows = Rows(network)
        self._rows.begin(self.state.history)
        self._plain: Way = Plain(network, algorithm, grid, self._rows)
        if options.adaptive is not None:
            self._plain = Adapting(Controller(options.adaptive, network, algorithm, grid.step, grid.stop), self._rows)
        self._inner: Inner | None = None

    def go(self, progress: Progress | None, before_step: Callable[[int], None] | None) -> None:
        """Step to the end. SlaveError, ConvergenceError: `state` is then that of the last good point."""
        shown, saved = time.perf_counter(), self.state.history.t[0]
        while not self._over():
            way = self._way(paced=before_step is not None)
            if before_step is not None:
                before_step(self.state.done + 1)
            self.state, failure = way.step(self.state)
            self._watch()
            if way is self._inner or self._rows.room < MOST_POINTS:
                self.hand_over()
            if failure is not None:
                raise failure
            if progress is not None and time.perf_counter() - shown > SHOWN_EVERY:
                shown = time.perf_counter()
                progress(self.state.history.t[0] - self._grid.start, self._grid.stop - self._grid.start)
            checkpoint = self._options.checkpoint
            if checkpoint is not None and self.state.history.t[0] - saved >= checkpoint.every - 1e-9 * self._grid.step:
                saved = self.state.history.t[0]
                self.hand_over()
                checkpoint.write(self._fingerprint, self._network, self.state, self._recorder)
                _log.info("wrote the checkpoint %s after macro step %d", checkpoint.file, self.state.done)

    def _over(self) -> bool:
        return self.state.history.t[0] >= self._grid.stop or bool(self.state.ended_by)

    def _way(self, *, paced: bool) -> Way:
        """The inner loop, once there are as many points as it looks back to, and for steps of the full length only."""
        done, options = self.state.done, self._options
        if paced or not self._fits or not self._algorithm.looks_back <= done < self._grid.even:
            return self._plain
        if self._inner is None:
            _log.info("inner loop from macro step %d on, %s", done + 1, "compiled" if self._kernel else "as Python runs it")
            checkpoint = options.checkpoint
            most = self._grid.n if checkpoint is None else max(1, round(checkpoint.every / self._grid.step))
            self._inner = Inner(self._network, self._algorithm, self._grid, self._rows, kernel=self._kernel, most=most)
        if self._rows.count:  # it numbers the used inputs from the first step that it does
            self.hand_over()
        return self._inner

    def _watch(self) -> None:
        """End the run if a stop condition holds at the newest point."""
        if not self._rows.count:
            return
        for place, above, says in self._stops:
            if self._rows.Y[self._rows.newest, place] > above:
                self.state = replace(self.state, ended_by=f"{says} at t = {self._rows.t[self._rows.newest]:.6g} s")

    def hand_over(self) -> None:
        """Give the new points to recorder and meter."""
        rows, count = self._rows, self._rows.count
        if count:
            new = slice(rows.first + 1, rows.newest + 1)
            self._recorder.add(self.state.done - count + 1, rows.t[new], rows.Y[new])
            energy = self._meter.add(self.state.energy, rows.h[new], rows.Y[new], rows.used[:count])
            self.state = replace(self.state, energy=energy)
        rows.begin(self.state.history)

    def finish(self) -> tuple["RunState", "EnergyMeter", "Recorder"]:
        """Hand over what is left: the state, and what the run's energy and results are made of."""
        self.hand_over()
        return self.state, self._meter, self._recorder


def _pays(compiled: bool | None, slave_steps: int) -> bool:
    """Whether a run of so many steps takes the compiled kernel: as told, else where it need not or is worth to be compiled."""
    return slave_steps >= driver.LONG or native.cached() if compiled is None else compiled
