"""The runs of one process: several at once where that pays, each in a thread with a worker of its own."""

from collections import deque
from collections.abc import Iterable, Mapping
from concurrent import futures
from concurrent.futures import Future, ThreadPoolExecutor
from typing import Protocol

from ..master.side_by_side import SideBySide
from .axes import Point
from .runner import Row

REPORT = 0.1  # s between a worker's reports


class Worker(Protocol):
    """Does the runs of a task, one after another, in one process."""

    def row(self, key: str, point: Point) -> Row:
        """Do the run and measure it; whatever goes wrong is said in the row, which begins with the key."""

    def close(self) -> None:
        """Close what was opened."""


class Task(Protocol):
    """What the processes of a pool do; it goes to each of them."""

    def open(self, files: Mapping[str, str], lanes: SideBySide) -> Worker:
        """What does runs in a process, one after another. files : key of an FMU -> its location; lanes : what does them."""

    def lost(self, key: str, point: Point, error: str) -> Row:
        """The row of a run whose process died."""

    def seconds(self, point: Point, row: Row) -> float:
        """How long the run took."""


class Crew:
    """Does runs in this process, as many at once as lanes are worth; each thread has a worker of its own.

    task, files : see Task. lanes : width, None for as wide as the processor has. expected : about how many runs will come.
    """

    def __init__(self, task: Task, files: Mapping[str, str], lanes: int | None, expected: int) -> None:
        self._task, self._files, self._lanes = task, files, SideBySide(lanes, expected)
        self._threads = ThreadPoolExecutor(self._lanes.width)
        self._idle: list[Worker] = [task.open(files, self._lanes)]
        self._busy: set[Future[Row]] = set()

    @property
    def free(self) -> int:
        """How many more runs may begin now."""
        return self._lanes.at_once - len(self._busy)

    @property
    def busy(self) -> bool:
        """Whether a run is under way."""
        return bool(self._busy)

    def begin(self, key: str, point: Point) -> None:
        """Begin a run."""
        self._busy.add(self._threads.submit(self._row, key, point))

    def rows(self, wait_for: float) -> list[Row]:
        """What has been done since, after waiting so long (s) for a run to end."""
        done, self._busy = futures.wait(self._busy, wait_for, futures.FIRST_COMPLETED)
        return [future.result() for future in done]

    def all_rows(self, runs: Iterable[tuple[str, Point]]) -> list[Row]:
        """Do so many runs."""
        waiting, rows = deque(runs), list[Row]()
        while waiting or self.busy:
            while waiting and self.free > 0:
                self.begin(*waiting.popleft())
            rows += self.rows(REPORT)
        return rows

    def close(self) -> None:
        """Close what was opened, when the runs under way have ended."""
        self._threads.shutdown()
        self._lanes.close()
        for worker in self._idle:
            worker.close()

    def _row(self, key: str, point: Point) -> Row:
        try:
            worker = self._idle.pop()
        except IndexError:
            worker = self._task.open(self._files, self._lanes)
        try:
            with self._lanes.taking_part():
                return worker.row(key, point)
        finally:
            self._idle.append(worker)
