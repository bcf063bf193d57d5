"""A run on its way: macro step after macro step, until its end, a stop condition or a failure.

    Stepper.go:  while not over: take as many macro steps as one way of stepping does at once; show progress; write checkpoints

The ways of stepping stand in ways.py. All of them write the points they reach into the same Rows, which recorder and energy
meter take over.
"""

import logging
import time
from collections.abc import Callable
from dataclasses import dataclass, field, replace

import numpy as np

from ..coupling import Algorithm, History
from ..kernel import driver, native
from ..network import Network
from .adaptive import Adaptive, Controller
from .checkpoint import Checkpoint, Resume, fingerprint
from .energy import EnergyMeter
from .progress import Progress
from .recording import Recorder, Recording
from .script import Happened, Script
from .state import RunState
from .time_grid import TimeGrid
from .usage import told
from .visiting import Visitor, changed
from .ways import MOST_POINTS, Adapting, Along, Inner, Plain, Rows, Way

_log = logging.getLogger(__name__)

SHOWN_EVERY = 0.1  # s between two calls of progress


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
    points : ndarray, shape (n + 1,), optional
        Communication points, s, from the start to the stop time, in the place of even ones: to do a run again in other steps.
    visitor : Visitor, optional
        Who looks at the run as it goes on.
    """

    record: Recording = field(default_factory=Recording)
    adaptive: Adaptive | None = None
    checkpoint: Checkpoint | None = None
    resume: Resume | None = None
    compiled: bool | None = None
    points: np.ndarray | None = None
    visitor: Visitor | None = None

    def __post_init__(self) -> None:
        if self.points is not None and self.adaptive is not None:
            raise ValueError("`points` are given communication points, they cannot be combined with `adaptive`")


class Stepper:
    """Takes a run from its start to its end.

    state : how far it is, see RunState. notes : what slaves cannot do, and how the run does without.
    without_kernel : why the compiled kernel cannot be had, where it was wanted.
    """

    def __init__(self, network: Network, algorithm: Algorithm, grid: TimeGrid, options: Options) -> None:
        self._network, self._algorithm, self._grid, self._options = network, algorithm, grid, options
        self._stops = [(network.place(stop.signal), stop.above, stop.says) for stop in network.system.stop_when]
        self._script = (
            Script(network, grid, adaptive=options.adaptive is not None or options.points is not None)
            if network.driving
            else None
        )
        self.notes = told(network, algorithm, grid, options)
        Y = network.initialize(grid.start, grid.stop)
        self._recorder = Recorder(options.record, network, grid.n)
        self._meter = EnergyMeter(network)
        self.state = RunState(0, History((grid.start,), (Y.copy(),), network.held), self._meter.begin(Y))
        if self._script is not None:
            self.state = self._script.at(replace(self.state, frozen=self._script.nothing_frozen))
            Y = self.state.history.Y[0]
            self.state = replace(self.state, energy=self._meter.begin(Y))
        self._fingerprint = ""
        if options.checkpoint is not None or options.resume is not None:
            self._fingerprint = fingerprint(network, algorithm, grid.step, self._recorder.names)
        if options.resume is None:
            self._recorder.begin()
            self._recorder.add(0, np.array([grid.start]), Y[None, :])
        else:
            self.state = options.resume.restore(self._fingerprint, network, self.state, self._recorder, grid)
            if self._script is not None:
                self._script.adopt(self.state)
        self._fits = options.adaptive is None and options.points is None and driver.fits(network, algorithm)
        self._kernel: native.Kernel | None = None
        self.without_kernel = "strings or binaries are passed on in it" if network.texts else ""
        self.without_kernel = "clocks tick one another in it" if network.clocks else self.without_kernel
        if self._fits and _pays(options.compiled, (grid.n - self.state.done) * len(network.slaves)):
            kernel = native.kernel()
            if isinstance(kernel, native.Kernel):
                self._kernel = kernel
            else:
                self.without_kernel = kernel
        self._rows = Rows(network)
        self._rows.begin(self.state.history)
        self._plain: Way = Plain(network, algorithm, grid, self._rows)
        if options.points is not None:
            self._plain = Along(network, algorithm, _checked(options.points, grid), self._rows)
        if options.adaptive is not None:
            until = None if self._script is None else self._script.next_jump
            self._plain = Adapting(Controller(options.adaptive, network, algorithm, grid.step, grid.stop), self._rows, until)
        self._inner: Inner | None = None
        self._changes: list[Happened] = []  # by the visitor

    def go(self, progress: Progress | None, before_step: Callable[[int], None] | None) -> None:
        """Step to the end. SlaveError, ConvergenceError: `state` is then that of the last good point."""
        shown, saved = time.perf_counter(), self.state.history.t[0]
        visitor = self._options.visitor
        if visitor is not None:
            visitor.saw(self.state.done, np.array([saved]), self.state.history.Y[0][None, self._recorder.columns])
            visitor.ready()
        while not self.over:
            way = self.way(paced=before_step is not None)
            if before_step is not None:
                before_step(self.state.done + 1)
            self.took(way, *way.step(self.state))
            if progress is not None and time.perf_counter() - shown > SHOWN_EVERY:
                shown = time.perf_counter()
                progress(self.state.history.t[0] - self._grid.start, self._grid.stop - self._grid.start)
            checkpoint = self._options.checkpoint
            if checkpoint is not None and self.state.history.t[0] - saved >= checkpoint.every - 1e-9 * self._grid.step:
                saved = self.state.history.t[0]
                self.hand_over()
                checkpoint.write(self._fingerprint, self._network, self.state, self._recorder)
                _log.info("wrote the checkpoint %s after macro step %d", checkpoint.file, self.state.done)

    def took(self, way: Way, state: RunState, failure: BaseException | None = None) -> None:
        """The steps that `way` has done from the state lead to `state`; raises the failure that stopped them."""
        visitor, rows, n = self._options.visitor, self._rows, state.done - self.state.done
        self.state = state
        self._watch()
        if visitor is not None and n:
            new = slice(rows.newest + 1 - n, rows.newest + 1)
            visitor.saw(state.done + 1 - n, rows.t[new], rows.Y[new][:, self._recorder.columns])
        if self._script is not None and failure is None and not self.over:
            self._let_happen(self._script)
        if visitor is not None and failure is None and not self.over and rows.count:
            self._receive(visitor)
        if way is self._inner or self._rows.room < MOST_POINTS:
            self.hand_over()
        if failure is not None:
            raise failure

    @property
    def over(self) -> bool:
        """Whether the run is at its end."""
        return self.state.history.t[0] >= self._grid.stop or bool(self.state.ended_by)

    def way(self, *, paced: bool = False) -> Way:
        """What steps next: the inner loop once there are as many points as it looks back to, for steps of the full length."""
        done, options = self.state.done, self._options
        known = len(self.state.history.Y) - 1
        if paced or not self._fits or done >= self._grid.even or known < self._algorithm.looks_back:
            return self._plain
        at_rest = self._grid.n if self._script is None else self._script.steps_at_rest(done)
        if not at_rest:
            return self._plain
        if self._inner is None:
            _log.info("inner loop from macro step %d on, %s", done + 1, "compiled" if self._kernel else "as Python runs it")
            checkpoint = options.checkpoint
            most = self._grid.n if checkpoint is None else max(1, round(checkpoint.every / self._grid.step))
            self._inner = Inner(
                self._network,
                self._algorithm,
                self._grid,
                self._rows,
                self._meter,
                self._recorder,
                kernel=self._kernel,
                most=most,
            )
        if self._rows.count:  # it numbers the used inputs from the first step that it does
            self.hand_over()
        if self._script is not None or self._changes:
            self._inner.loop.refresh(self.state.history.t[0])
        visitor = options.visitor
        self._inner.at_most = at_rest if visitor is None else min(at_rest, visitor.at_most)
        return self._inner

    def _let_happen(self, script: Script) -> None:
        """What takes effect at the newest point, which is recorded as it is afterwards; the energies see it as before."""
        after = script.at(self.state)
        if after is not self.state:
            self._goes_on_as(after)

    def _receive(self, visitor: Visitor) -> None:
        """Let a visitor see the newest point, at which what it changes takes effect."""
        changes = visitor.visit(self.state.history.t[0])
        if changes:
            t = self.state.history.t[0]
            self._changes += [Happened(t, t, change.words) for change in changes]
            self._goes_on_as(changed(self.state, self._network, changes))

    def _goes_on_as(self, after: RunState) -> None:
        """The run goes on from the state `after`, its newest point as something has made it that took effect there."""
        rows = self._rows
        self._sum_energy()
        rows.Y[rows.newest] = after.history.Y[0]
        energy = self.state.energy
        if len(after.history.Y) == 1:
            energy = self._meter.anew(energy, after.history.Y[0])
        self.state = replace(after, energy=energy)
        self._watch()
        self.hand_over()

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
            self._sum_energy()
        rows.begin(self.state.history)

    def _sum_energy(self) -> None:
        """Let the meter see the new points, unless it has."""
        rows, new = self._rows, slice(self._rows.first + 1, self._rows.newest + 1)
        if rows.count and not rows.metered:
            energy = self._meter.add(self.state.energy, rows.h[new], rows.Y[new], rows.used[: rows.count])
            self.state, rows.metered = replace(self.state, energy=energy), True

    @property
    def happened(self) -> tuple[Happened, ...]:
        """What a scenario and a visitor have done so far."""
        by_plan = () if self._script is None else self._script.happened(self.state)
        return tuple(sorted((*by_plan, *self._changes), key=lambda one: one.since))

    def rescue(self) -> str:
        """Hand over the points of steps that never come back, and name the component that they are at, where that is known."""
        self.hand_over()
        if self._inner is None:
            return ""
        rows, (count, slave) = self._rows, self._inner.loop.underway
        if count:
            new = slice(rows.newest + 1, rows.newest + 1 + count)
            self._recorder.add(self.state.done + 1, rows.t[new], rows.Y[new])
        return self._network.slaves[slave].name

    def finish(self, *, cut_off: bool) -> tuple["RunState", "EnergyMeter", "Recorder"]:
        """Hand over what is left: the state, and what the run's energy and results are made of.

        cut_off : a component has ended the run between two points; the newest one is kept only if its turn has come, for not
        all its outputs may have been asked for.
        """
        self.hand_over()
        if cut_off:
            self._recorder.forget_last()
        return self.state, self._meter, self._recorder


def _checked(points: np.ndarray, grid: TimeGrid) -> np.ndarray:
    """The communication points, which must lead from start to stop."""
    if (
        points.ndim != 1
        or points.size < 2
        or points[0] != grid.start
        or points[-1] != grid.stop
        or not (np.diff(points) > 0.0).all()
    ):
        raise ValueError(f"`points` must rise from the start {grid.start:g} s to the stop time {grid.stop:g} s")
    return points


def _pays(compiled: bool | None, slave_steps: int) -> bool:
    """Whether a run of so many steps takes the compiled kernel: as told, else where it need not or is worth to be compiled."""
    return slave_steps >= driver.LONG or native.cached() if compiled is None else compiled
