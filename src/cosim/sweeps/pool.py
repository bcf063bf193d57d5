"""Workers on this machine: processes that do runs, fed so that none waits and none holds more than a moment's work.

A worker that dies (a crash in an FMU, a signal, memory) costs only the runs it held. They are done again, one at a time;
a run whose process dies once more is a row with that error. A worker that is killed while it starts held none; it is replaced.
Workers are spawned, so a script that sweeps needs the usual `if __name__ == "__main__":`.

What a run is, is the Task's to say: of a sweep, one run of its system (SweepTask); of another study, what it likes.
"""

import contextlib
import ctypes
import multiprocessing
import os
import signal
import sys
import tempfile
import time
from collections import deque
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from multiprocessing.connection import Connection, wait
from multiprocessing.process import BaseProcess
from pathlib import Path

from ..keeping.keeper import DIE_WITH_PARENT
from ..master.side_by_side import SideBySide
from ..slaves.scratch import ScratchFolder
from .axes import Point
from .crew import REPORT, Crew, Task, Worker
from .plan import FIXED, SweepContext
from .runner import Row, Runner, row_of

AHEAD = 0.5  # s of work that a worker may hold
THREADS = ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS")  # read when the libraries are loaded
STARTS = 3  # processes in a row that a signal may end before they are ready
MOST = 100  # runs that a worker may hold; they must fit a pipe's buffer, or both sides could wait for the other to read


@dataclass(frozen=True)
class SweepTask:
    """The runs of a sweep."""

    context: SweepContext

    def open(self, files: Mapping[str, str], lanes: SideBySide) -> Worker:
        """See Task."""
        return Runner(self.context, files, lanes)

    def lost(self, key: str, point: Point, error: str) -> Row:
        """See Task."""
        return row_of(self.context, key, point, None, error, 0.0)

    def seconds(self, point: Point, row: Row) -> float:
        """See Task."""
        return float(row[1 + len(point) + FIXED.index("wall_s")])


def cores() -> int:
    """Cores that this process may use."""
    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1


def _work(connection: Connection, task: Task, files: Mapping[str, str], scratch: str, lanes: int | None, expected: int) -> None:
    """The life of a worker: runs come in, as (key, point); rows go out. It ends when the other side does.

    scratch : where its temporary files go; the parent removes it, so that a worker that is killed leaves nothing behind.
    """
    signal.signal(signal.SIGINT, signal.SIG_IGN)  # Ctrl-C is the parent's to handle
    if sys.platform == "linux":  # a run may take long, and nobody wants its row any more
        ctypes.CDLL(None).prctl(DIE_WITH_PARENT, signal.SIGKILL)
    os.environ["TMPDIR"], tempfile.tempdir = scratch, None
    crew = Crew(task, files, lanes, expected)
    held: deque[tuple[str, Point]] = deque()
    rows: list[Row] = []
    try:
        connection.send([])  # ready
        reported = time.perf_counter()
        while True:
            while not (held or crew.busy) or connection.poll():
                held.extend(connection.recv())
            while held and crew.free > 0:
                crew.begin(*held.popleft())
            rows += crew.rows(REPORT)
            if rows and (not (held or crew.busy) or time.perf_counter() - reported > REPORT):
                connection.send(rows)
                rows, reported = [], time.perf_counter()
    except (EOFError, OSError):
        return
    finally:
        crew.close()
        with contextlib.suppress(OSError):  # not empty: another worker is there still, or the parent will see to it
            Path(scratch).rmdir()


@contextlib.contextmanager
def _single_threaded() -> Iterator[None]:
    """Processes started inside use one thread each for linear algebra: there is one process a core, and waiting threads spin."""
    before = {name: os.environ.get(name) for name in THREADS}
    os.environ.update({name: "1" for name, value in before.items() if value is None})
    try:
        yield
    finally:
        for name in [name for name, value in before.items() if value is None]:
            del os.environ[name]


@dataclass(eq=False)
class _Process:
    """A process and what it holds: the runs it was given and has not reported, in order."""

    process: BaseProcess
    connection: Connection
    held: dict[str, Point] = field(default_factory=dict)
    ready: bool = False

    def close(self) -> None:
        self.connection.close()
        self.process.join(2.0)
        if self.process.is_alive():
            self.process.kill()
            self.process.join()
        self.process.close()


class Pool:
    """`workers` processes for the runs of one sweep, or of another task; results() yields rows as they come."""

    def __init__(self, what: SweepContext | Task, files: Mapping[str, str], workers: int, lanes: int | None = None) -> None:
        self._task = SweepTask(what) if isinstance(what, SweepContext) else what
        self._files, self._count, self._lanes, self._expected = files, workers, lanes, 0
        self._least = 2 * SideBySide(lanes).width  # runs that a worker holds, so that its lanes are full
        self._workers: list[_Process] = []
        self._scratch = ""
        self._suspects: deque[tuple[str, Point]] = deque()  # were held by a worker that died: done alone
        self._once: set[str] = set()  # keys of runs that were held by a worker that died
        self._killed = 0  # processes in a row that a signal ended before they were ready
        self._pace = AHEAD  # s that a run takes, a mean over the latest

    def results(self, todo: Mapping[str, Point]) -> Iterator[list[Row]]:
        """Rows of all runs in `todo`, in any order; the processes end with the generator."""
        waiting = deque(todo.items())
        self._expected = len(waiting) // self._count
        scratch = ScratchFolder()
        self._scratch = str(scratch.path)
        try:
            for _ in range(min(self._count, len(waiting))):
                self._workers.append(self._start())
            left = len(waiting)
            while left:
                for connection in wait([w.connection for w in self._workers]):
                    worker = next(w for w in self._workers if w.connection is connection)
                    try:
                        rows = worker.connection.recv()
                    except (EOFError, OSError):
                        rows = self._lost(worker, waiting)
                    else:
                        worker.ready, self._killed = True, 0
                        self._took(worker, rows)
                        self._feed(worker, waiting)
                    left -= len(rows)
                    if rows:
                        yield rows
        finally:
            for worker in self._workers:
                worker.connection.close()
            for worker in self._workers:
                worker.close()
            self._workers.clear()
            scratch.remove()

    def _start(self) -> _Process:
        spawning = multiprocessing.get_context("spawn")
        ours, theirs = spawning.Pipe()
        args = theirs, self._task, dict(self._files), self._scratch, self._lanes, self._expected
        process = spawning.Process(target=_work, args=args, daemon=True)
        with _single_threaded():
            process.start()
        theirs.close()
        return _Process(process, ours)

    def _took(self, worker: _Process, rows: list[Row]) -> None:
        for row in rows:
            point = worker.held.pop(row[0])
            self._pace += 0.2 * (self._task.seconds(point, row) - self._pace)

    def _feed(self, worker: _Process, waiting: deque[tuple[str, Point]]) -> None:
        """Give a worker what it may hold: a suspect alone, else runs for AHEAD seconds, and enough not to wait."""
        if self._suspects:
            if not worker.held:
                self._give(worker, [self._suspects.popleft()])
            return
        share = max(2, len(waiting) // self._count)
        most = min(MOST, max(self._least, int(AHEAD / max(self._pace, 1e-6))), share)
        if len(worker.held) <= most // 2:
            self._give(worker, [waiting.popleft() for _ in range(min(most - len(worker.held), len(waiting)))])

    def _give(self, worker: _Process, runs: list[tuple[str, Point]]) -> None:
        if runs:
            worker.held.update(runs)
            try:
                worker.connection.send(runs)
            except OSError:  # it has died: wait() will say so
                return

    def _lost(self, worker: _Process, waiting: deque[tuple[str, Point]]) -> list[Row]:
        """A worker has died: replace it. Its runs are suspects, or, if it held one alone that was one already, a row."""
        self._workers.remove(worker)
        worker.connection.close()
        worker.process.join()
        code = worker.process.exitcode or 0
        worker.process.close()
        reason = f"signal {signal.Signals(-code).name}" if code < 0 else f"exit code {code}"
        if not worker.ready:
            self._killed += 1
            if code >= 0 or self._killed == STARTS:  # it cannot start, whoever tries
                raise RuntimeError(f"a worker process must start, it ended with {reason}")
        rows = []
        for key, point in worker.held.items():
            if key in self._once and len(worker.held) == 1:
                error = f"the process that ran it ended with {reason}, twice"
                rows.append(self._task.lost(key, point, error))
            else:
                self._once.add(key)
                self._suspects.append((key, point))
        if self._suspects or waiting:
            self._workers.append(self._start())
        return rows
