"""A run on its way: macro step after macro step, in chunks that recorder and energy meter take over."""

import time
from collections.abc import Callable
from dataclasses import dataclass, field

import numpy as np

from ..coupling import Algorithm, History
from ..kernel import driver
from ..network import Network
from . import adaptive
from .adaptive import Adaptive
from .checkpoint import Checkpoint, Resume
from .energy import EnergyMeter
from .recording import Recorder, Recording

Progress = Callable[[float, float], None]
HISTORY = 4  # rows of outputs before the newest that a chunk begins with
FIRST_CHUNK = 4  # macro steps of the inner loop's first chunk
PATIENCE = 0.05  # s between two chunks of the inner loop: progress, Ctrl-C and checkpoints wait so long at most
CHUNK_NUMBERS = 1_000_000  # outputs held between two visits of the recorder


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


class Stepper:
    """The state of a run on its way. Outputs are collected in chunks, which recorder and energy meter then take over.

    Row `row` of the chunk holds macro step `done`; up to HISTORY rows before it are older points.
    """

    def __init__(
        self, network: Network, algorithm: Algorithm, step: float, start: float, stop: float, n: int, options: Options
    ) -> None:
        self.network, self.algorithm, self.step, self.start, self.stop, self.n = network, algorithm, step, start, stop, n
        self.options, self.done, self.rejections, self.ended_by = options, 0, 0, ""
        self._stops = [(network.place(stop.signal), stop.above, stop.says) for stop in network.system.stop_when]
        last = stop - (start + (n - 1) * step)
        rounding = 4 * np.finfo(float).eps * abs(start)  # far from 0 the times themselves are rounded
        self._last = step if abs(last - step) <= 1e-9 * step + rounding else last
        Y = network.initialize(start, stop)
        self.history = History(start, Y.copy(), network.held)
        self.meter = EnergyMeter(network, Y)
        resume = options.resume
        self.recorder = Recorder(options.record, network, n)
        rows = int(np.clip(CHUNK_NUMBERS // max(1, Y.size), 16, 4096))
        self._Y, self._t, self._h = np.zeros((HISTORY + rows, Y.size)), np.empty(HISTORY + rows), np.empty(HISTORY + rows)
        self._used = np.zeros((rows, 2 * len(network.bonds), 3))
        self._rows, self._chunk = rows, FIRST_CHUNK
        if resume is None:
            self.recorder.begin()
            self.recorder.add(0, np.array([start]), Y[None, :])
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
            compiled = (self.n - self.done) * len(self.network.slaves) >= driver.LONG
        while self.done < self.n and not self.ended_by:
            if (
                inner is None
                and before_step is None
                and self.done >= self.algorithm.degree
                and driver.fits(self.network, self.algorithm)
            ):
                inner = driver.FastLoop(self.network, self.algorithm, self._Y, self._t, self._h, self._used)
            if inner is not None and self._last_is_far():
                self._march(inner, compiled)
            else:
                if before_step is not None:
                    before_step(self.done + 1)
                self._advance(self._last if self.done + 1 == self.n else self.step, self._time(self.done + 1))
            if progress is not None and (now := time.perf_counter()) - shown > 0.1:
                shown = now
                progress(self.history.t[0] - self.start, self.stop - self.start)
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
                progress(self.history.t[0] - self.start, self.stop - self.start)

    def _time(self, k: int) -> float:
        return self.stop if k == self.n else self.start + k * self.step

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
        self._watch(self.row)
        if self.row == self._first + self._rows:
            self.hand_over()

    def _march(self, inner: driver.FastLoop, compiled: bool) -> None:
        """As many even macro steps as the chunk has room for, in the inner loop."""
        room = min(self._first + self._rows - self.row, self._chunk)
        even = self.n - self.done - (0 if self._last == self.step else 1)
        checkpoint = self.options.checkpoint
        ahead = min(room, even, 1 << 62 if checkpoint is None else max(1, round(checkpoint.every / self.step)))
        k = self.done + 1 + np.arange(ahead)
        self._t[self.row + 1 : self.row + 1 + ahead] = np.where(k == self.n, self.stop, self.start + k * self.step)
        self._h[self.row + 1 : self.row + 1 + ahead] = self.step
        if self.row != self._first:  # the inner loop numbers the used inputs from the first step it does
            self.hand_over()
            self._march(inner, compiled)
            return
        if compiled and self.meter.kernel is None:
            self.meter.kernel = driver.compiled_meter()
        began = time.perf_counter()
        done = inner.march(self.row, ahead, fast=compiled)
        took = time.perf_counter() - began
        self._chunk = max(1, self._chunk // 2) if took > PATIENCE else 2 * self._chunk if took < PATIENCE / 4 else self._chunk
        if done:
            self._watch(self.row + done)
        for m in range(max(0, done - HISTORY), done):
            self.history.push(float(self._t[self.row + 1 + m]), self._Y[self.row + 1 + m].copy())
        self.row += done
        self.done += done
        if done < ahead and not self.ended_by:
            inner.explain(self.row)
        self.hand_over()

    def _watch(self, row: int) -> None:
        """End the run if a stop condition holds in this row."""
        for place, above, says in self._stops:
            if self._Y[row, place] > above:
                self.ended_by = f"{says} at t = {self._t[row]:.6g} s"

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
