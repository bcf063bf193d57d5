"""Runs that several threads ask for, done side by side in lanes where that pays (lanes.py).

A thread that calls SideBySide.run() waits for its result; a thread of its own marches what is waiting, up to as many runs at
once as the processor has lanes. Whoever has many runs to do starts so many threads, each with a network of its own, and
need not know what is done how: the bits are those of gyro_cosim.master.run().
"""

import logging
import threading
import time
from collections import deque
from collections.abc import Hashable, Iterator, Sequence
from concurrent.futures import Future
from contextlib import contextmanager
from functools import partial

from ..coupling import Algorithm, GaussSeidel, Jacobi, Nepce
from ..errors import RunError
from ..kernel import native
from ..network import Network
from ..slaves.fmi.lanes import LaneCode, widest
from .lanes import Job, Lanes, lane_codes
from .results import Run
from .simulation import run
from .stepping import Options

_log = logging.getLogger(__name__)

LARGE = 2e-6  # s that the components' steps take in a macro step, from which on lanes gain more than they cost
LONG = 10.0  # s of runs from which on compiling for lanes pays


class SideBySide:
    """Does runs side by side.

    Parameters
    ----------
    width : int, optional
        Of the lanes, at most; as wide as the processor has where None, 1 for one run at a time.
    expected : int
        About how many runs there will be.
    """

    def __init__(self, width: int | None = None, expected: int = 1) -> None:
        self.width = widest() if width is None else max(w for w in (1, 2, 4, 8) if w <= min(width, widest()))
        self._expected = expected
        self._codes: dict[Hashable, Sequence[LaneCode] | None] = {}
        self._waiting: deque[Job] = deque()
        self._asked: set[Future[tuple[Run | Exception, float]]] = set()  # whom a thread waits for
        self._parties = 0  # threads that have runs to ask for
        self._changed = threading.Condition()
        self._marching: threading.Thread | None = None
        self._closed = False

    @property
    def at_once(self) -> int:
        """How many threads have something to gain: 1 until a run was long enough for lanes."""
        return self.width if any(codes is not None for codes in self._codes.values()) else 1

    def run(
        self, network: Network, algorithm: Algorithm, step: float, stop: float, options: Options | None = None
    ) -> tuple[Run, float]:
        """As gyro_cosim.master.run(), with the seconds that were this run's own; errors as there."""
        kind = self._kind(network, algorithm)
        if self.width > 1 and self._codes.get(kind) is not None:
            job = Job((kind, Future()), network, algorithm, step, stop, options)
            with self._changed:
                self._waiting.append(job)
                self._asked.add(job.key[1])
                if self._marching is None:
                    self._marching = threading.Thread(target=self._march, daemon=True)
                    self._marching.start()
                self._changed.notify_all()
            result, seconds = job.key[1].result()
            if isinstance(result, Exception):
                raise result
            return result, seconds
        began = time.perf_counter()
        try:
            result = run(network, algorithm, step, stop, options=options)
        except RunError as failure:
            self._judge(kind, network, failure.partial, time.perf_counter() - began)
            raise
        seconds = time.perf_counter() - began
        self._judge(kind, network, result, seconds)
        return result, seconds

    @contextmanager
    def taking_part(self) -> Iterator[None]:
        """Tell that this thread will ask for runs: the others wait while it prepares one, so that its lane is not left empty.

        Nothing is lost by that, since threads that are at work in Python take turns anyhow.
        """
        with self._changed:
            self._parties += 1
        try:
            yield
        finally:
            with self._changed:
                self._parties -= 1
                self._changed.notify_all()

    def close(self) -> None:
        """End the thread, which has nothing left to do."""
        with self._changed:
            self._closed = True
            self._changed.notify_all()
        if self._marching is not None:
            self._marching.join()

    def _kind(self, network: Network, algorithm: Algorithm) -> Hashable:
        """What runs must have in common to march in step; None where they cannot."""
        if not isinstance(algorithm, Jacobi | Nepce | GaussSeidel) or network.driving:
            return None
        order = tuple(network.sequence(algorithm.sequence)) if isinstance(algorithm, GaussSeidel) else None
        return tuple(part.source for part in network.system.components), order, tuple(network.order)

    def _judge(self, kind: Hashable, network: Network, result: Run | None, seconds: float) -> None:
        """After the first run of a kind: whether the next ones go into lanes."""
        if kind is None or kind in self._codes or self.width == 1 or result is None or result.steps == 0:
            return
        inside = sum(result.timing.do_step_s.values()) / result.steps
        codes: Sequence[LaneCode] | str | None = None
        if inside >= LARGE and seconds * self._expected >= LONG and not result.without_kernel:
            codes = lane_codes(network, self.width)
            if isinstance(codes, str):
                _log.warning("runs of %s go one at a time: %s", network.system.name, codes)
            else:
                _log.info("runs of %s go %d at once, in lanes", network.system.name, self.width)
        self._codes[kind] = None if isinstance(codes, str) else codes

    def _march(self) -> None:
        """Do what is waiting, kind after kind, until there will be no more."""
        try:
            self._march_on()
        except Exception as error:  # nobody must wait for ever
            _log.exception("runs side by side have stopped")
            with self._changed:
                self._waiting.clear()
                self._codes = dict.fromkeys(self._codes)
                self._marching = None
                asked, self._asked = self._asked, set()
            for future in asked:
                future.set_result((error, 0.0))

    def _march_on(self) -> None:
        kernel = native.kernel()
        assert isinstance(kernel, native.Kernel)
        while True:
            with self._changed:
                while not self._waiting and not self._closed:
                    self._changed.wait()
                if not self._waiting:
                    return
                kind = self._waiting[0].key[0]
            codes = self._codes[kind]
            assert codes is not None
            for (_, future), result, seconds in Lanes(kernel, codes, self.width).results(partial(self._next, kind)):
                with self._changed:
                    self._asked.discard(future)
                future.set_result((result, seconds))

    def _next(self, kind: Hashable, slot: int) -> Job | None:
        """A job of this kind, waited for while a thread that takes part has none; any slot will do."""
        del slot
        with self._changed:
            while True:
                for job in self._waiting:
                    if job.key[0] == kind:
                        self._waiting.remove(job)
                        return job
                if self._parties <= len(self._asked):
                    return None
                self._changed.wait()
