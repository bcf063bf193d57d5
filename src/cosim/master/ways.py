"""Ways of stepping, each an object with step(): one macro step by the algorithm itself (Plain), to points that are given (Along),
many by the inner loop (Inner), one that adapts (Adapting). All of them write the points they reach into the same Rows.
"""

import time
from collections.abc import Callable
from dataclasses import replace
from typing import Protocol

import numpy as np

from ..coupling import Algorithm, History
from ..coupling.base import Used
from ..kernel import driver, native
from ..kernel.energy import Sums
from ..network import Network
from .adaptive import Controller
from .energy import EnergyMeter
from .recording import Recorder
from .state import RunState
from .time_grid import TimeGrid

BEFORE = 4  # rows of outputs before the newest that a chunk begins with
FIRST_CHUNK = 4  # macro steps of the inner loop's first chunk
GROWTH = 8  # of a chunk that took little time, to the next
PATIENCE = 0.05  # s between two chunks of the inner loop: progress, Ctrl-C and checkpoints wait so long at most
CHUNK_NUMBERS = 1_000_000  # outputs held between two visits of the recorder
MOST_POINTS = 2  # that one step of Plain or Adapting adds


class Rows:
    """Points reached since the recorder and the energy meter were here last.

    Row `first` holds the point before them, with older ones before it; row `newest` the newest. Y, t, h : outputs, times and
    the steps that led there. used : shape (rows, 2 n_bonds, 3), per new point the inputs of the power bonds on the way to it.
    whole : which rows hold all outputs that are asked for. metered : whether the energy of the new points has been summed.
    """

    def __init__(self, network: Network) -> None:
        n_Y = len(network.names)
        self.size = int(np.clip(CHUNK_NUMBERS // max(1, n_Y), 16, 4096))
        self.Y, self.t, self.h = np.zeros((BEFORE + self.size, n_Y)), np.empty(BEFORE + self.size), np.empty(BEFORE + self.size)
        self.used = np.zeros((self.size, 2 * len(network.bonds), 3))
        self.whole = np.ones(BEFORE + self.size, dtype=np.uint8)
        self._ends = [place for bond in network.bonds for place in (bond.motion_input, bond.effort_input)]
        self.first = self.newest = 0
        self.metered = False

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
        self.metered = False

    def filled(self, count: int, *, metered: bool) -> None:
        """So many points have been written behind the newest, with their steps and, unless `metered`, inputs."""
        self.newest += count
        self.metered = metered

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


class Along:
    """One macro step by the algorithm, to the next of given communication points, shape (n + 1,), s."""

    def __init__(self, network: Network, algorithm: Algorithm, points: np.ndarray, rows: Rows) -> None:
        self._network, self._algorithm, self._points, self._rows = network, algorithm, points, rows

    def step(self, state: RunState) -> tuple[RunState, BaseException | None]:
        """See Way."""
        t = float(self._points[state.done + 1])
        h = t - float(self._points[state.done])
        step = self._algorithm.advance(self._network, state.history, h, state.memory)
        self._rows.add(h, t, step.Y, step.used)
        return state.after(step, t), None


class Inner:
    """As many macro steps as there is room for, by the inner loop. most : bound on how many.

    loop : the inner loop, which several runs may march in step with one another between prepare() and concluded().
    at_most : how many steps may come next, since something changes then.
    """

    def __init__(
        self, network: Network, algorithm: Algorithm, grid: TimeGrid, rows: Rows, meter: EnergyMeter, recorder: Recorder,
        *, kernel: native.Kernel | None, most: int,
    ) -> None:  # fmt: skip
        self.loop = driver.FastLoop(
            network, algorithm, rows.Y, rows.t, rows.h, rows.whole, rows.used, recorder.columns, meter.bonds, kernel
        )
        self._network, self._grid, self._rows, self._meter, self._most = network, grid, rows, meter, most
        self._chunk, self.at_most = FIRST_CHUNK, grid.n
        asked, polled = self.loop.asked, self.loop.polled
        self._every = recorder.every if asked.size > polled.size else 1
        self._passed_over, self._unasked = np.setdiff1d(asked, polled), np.setdiff1d(np.arange(len(network.names)), asked)

    def step(self, state: RunState) -> tuple[RunState, BaseException | None]:
        """See Way. The rows hold no new points before it."""
        ahead = self.ahead(state)
        sums, before = self.prepare(state, ahead)
        began = time.perf_counter()
        done, spent, ended = self.loop.march(self._rows.newest, ahead, state.energy.past, before, sums)
        self.paced(time.perf_counter() - began)
        state = self.concluded(state, ahead, done, spent, sums, ended=ended)
        return state, None if done == ahead or ended else self.loop.failure(self._rows.newest)

    @property
    def row(self) -> int:
        """Of the newest point in the buffers of the loop."""
        return self._rows.newest

    def ahead(self, state: RunState) -> int:
        """How many macro steps may come next."""
        return min(self._rows.room, self._chunk, self._grid.even - state.done, self._most, self.at_most)

    def prepare(self, state: RunState, ahead: int) -> tuple[Sums, float]:
        """Make the rows of so many steps ready. Sums to be added to, and the length (s) of the step before."""
        rows, row = self._rows, self._rows.newest
        new = slice(row + 1, row + 1 + ahead)
        rows.t[new] = self._grid.times(state.done + 1 + np.arange(ahead))
        rows.h[new] = self._grid.step
        if self._every > 1:
            rows.whole[new] = (state.done + 1 + np.arange(ahead)) % self._every == 0
            rows.whole[row + ahead] = True
        return state.energy.copies(), state.energy.step or self._grid.step

    def paced(self, took: float) -> None:
        """Choose how many steps come next time from the seconds that these took."""
        if took > PATIENCE:
            self._chunk = max(1, self._chunk // 2)
        elif GROWTH * took < PATIENCE:
            self._chunk *= GROWTH

    def concluded(self, state: RunState, ahead: int, done: int, spent: np.ndarray, sums: Sums, *, ended: bool) -> RunState:
        """The state after `done` of the steps that were prepared; the rows hold their points."""
        rows, row, history = self._rows, self._rows.newest, state.history
        self._network.count_time(spent)
        rows.filled(done, metered=self.loop.meters)
        energy, latest = state.energy, range(row + done, row + max(0, done - BEFORE), -1)
        if self.loop.meters:
            energy = self._meter.after(energy, sums, rows.Y[row + 1 : row + 1 + done], rows.h[row + 1 : row + 1 + done])
        for m in latest if self._unasked.size else ():
            rows.Y[m, self._unasked] = rows.Y[row, self._unasked]
        history = history.extended([float(rows.t[m]) for m in latest], [rows.Y[m].copy() for m in latest])
        if done and self._every > 1:
            history = self._completed(history, state.done + done, state.history.Y[0] if done < ahead and not ended else None)
        return replace(state, done=state.done + done, history=history, energy=energy)

    def _completed(self, history: History, done: int, before: np.ndarray | None) -> History:
        """The history with what was passed over at its points: as at the newest one, so that chunks cannot be seen in it.

        before : what the newest point itself takes it from, where the march was cut off there.
        """
        places, points = self._passed_over, [Y.copy() for Y in history.Y]
        if before is not None and done % self._every:
            points[0][places] = before[places]
        for m, Y in enumerate(points):
            if (done - m) % self._every:
                Y[places] = points[0][places]
        return History(history.t, tuple(points), history.held)


class Adapting:
    """One macro step as long as its error estimate allows. until : of a time (s), where the step ends at the latest."""

    def __init__(self, controller: Controller, rows: Rows, until: Callable[[float], float] | None = None) -> None:
        self._controller, self._rows, self._until = controller, rows, until

    def step(self, state: RunState) -> tuple[RunState, BaseException | None]:
        """See Way."""
        until = float("inf") if self._until is None else self._until(state.history.t[0])
        steps, rejections = self._controller.advance(state.history, state.memory, until)
        for h, t, step in steps:
            self._rows.add(h, t, step.Y, step.used)
            state = state.after(step, t)
        return replace(state, rejections=state.rejections + rejections), None
