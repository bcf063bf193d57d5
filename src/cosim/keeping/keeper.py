"""A process that does nothing but keep another one, its fork, in which foreign code runs: it knows how that one ended.

The fork tells what it has come to by single bytes: `told`, a line has said what went wrong; `closing`, the results are safe;
`done`, it leaves by itself with the code that follows. Whoever it has started goes with it: on Linux orphans, too, are given
to their keeper, which ends them. Linux and macOS; the keeper itself runs no foreign code.
"""

import contextlib
import ctypes
import os
import select
import signal
import sys
import time
from collections.abc import Callable
from dataclasses import dataclass, field
from pathlib import Path
from types import FrameType

__all__ = ["DIE_WITH_PARENT", "Ending", "Keeper", "Voice", "split"]

DIE_WITH_PARENT = 1  # prctl's PR_SET_PDEATHSIG
LAST_WORD = 10.0  # s
_ADOPT, _LOOK = 36, 0.2  # prctl's PR_SET_CHILD_SUBREAPER; s between two looks at what no signal tells
_TOLD, _CLOSING, _DONE = b"T", b"C", b"D"
ASK = signal.SIGUSR1 if sys.platform != "win32" else signal.SIGTERM  # for the last word of a fork that does not come back


class Voice:
    """How the fork tells its keeper what it has come to."""

    def __init__(self, descriptor: int) -> None:
        self._descriptor = descriptor

    def told(self) -> None:
        """A line has said what went wrong."""
        self._say(_TOLD)

    def closing(self) -> None:
        """What there is is on disk; closing should not take long."""
        self._say(_CLOSING)

    def done(self, code: int) -> None:
        """The process leaves by itself."""
        self._say(_DONE + bytes([code & 255]))

    def _say(self, word: bytes) -> None:
        with contextlib.suppress(OSError):  # foreign code may have closed it
            os.write(self._descriptor, word)


@dataclass(frozen=True)
class Ending:
    """How a fork has ended.

    code : its exit code, negative for a signal. done : the code that it has told, None where it left without a word.
    told : a line has said what went wrong. closing : its results were safe. late : its keeper had to end it.
    """

    code: int
    done: int | None
    told: bool
    closing: bool
    late: bool


@dataclass
class Keeper:
    """The parent's side of split()."""

    pid: int
    _pipe: int
    _words: bytes = b""
    _asked: list[int] = field(default_factory=list)

    def ending(self, *, closing: float, patience: float, gone: Callable[[], bool] = lambda: False) -> Ending:
        """Wait for the fork.

        Parameters
        ----------
        closing : float
            Seconds that it may take from `closing` or `done` on.
        patience : float
            Seconds that it may take to leave after SIGINT, SIGTERM or `gone`, before it is asked for its last word, for which it
            has LAST_WORD.
        gone : callable
            Whether the one for whom all this is done has gone away.
        """
        before = {number: signal.signal(number, self._hear) for number in (signal.SIGINT, signal.SIGTERM)}
        watched = [self._pipe]
        pidfd = -1
        with contextlib.suppress(OSError, AttributeError):
            pidfd = os.pidfd_open(self.pid)
            watched.append(pidfd)
        since = asked = None
        late = False
        try:
            while True:
                pid, status = os.waitpid(self.pid, os.WNOHANG)
                self._listen(watched)
                if pid:
                    break
                now = time.monotonic()
                if _CLOSING in self._words or _DONE in self._words:
                    since = since or now
                    if now - since > closing:
                        late = True
                        os.kill(self.pid, signal.SIGKILL)
                if self._asked or gone():
                    asked = asked or now
                    if now - asked > patience and (gone() or now - asked > patience + LAST_WORD):
                        late = True
                        os.kill(self.pid, signal.SIGKILL)
                    elif now - asked > patience:  # again and again: the first may find Ctrl-C still to be heard
                        os.kill(self.pid, ASK)
                with contextlib.suppress(InterruptedError):
                    select.select(watched, [], [], _LOOK if pidfd >= 0 else 0.02)
        finally:
            for number, handler in before.items():
                signal.signal(number, handler)
            if pidfd >= 0:
                os.close(pidfd)
            os.close(self._pipe)
            self._end_orphans()
        place = self._words.find(_DONE)
        done = self._words[place + 1] if 0 <= place < len(self._words) - 1 else None
        words = self._words if place < 0 else self._words[:place]
        return Ending(os.waitstatus_to_exitcode(status), done, _TOLD in words, _CLOSING in words or place >= 0, late)

    def _hear(self, number: int, frame: FrameType | None) -> None:
        """Ctrl-C reaches the fork by itself; what ends this process alone is passed on as that."""
        self._asked.append(number)
        if number == signal.SIGTERM:
            with contextlib.suppress(OSError):
                os.kill(self.pid, signal.SIGINT)

    def _listen(self, watched: list[int]) -> None:
        while self._pipe in watched and select.select([self._pipe], [], [], 0)[0]:
            word = os.read(self._pipe, 64)
            self._words += word
            if not word:
                watched.remove(self._pipe)

    def _end_orphans(self) -> None:
        """End what the fork has started and left, which is a child of this process now."""
        children = Path(f"/proc/self/task/{os.getpid()}/children")
        for _ in range(1000):
            with contextlib.suppress(OSError, ValueError):
                left = [int(pid) for pid in children.read_text().split()] if children.exists() else []
                for pid in left:
                    os.kill(pid, signal.SIGKILL)
            try:
                if os.waitpid(-1, os.WNOHANG)[0] == 0:
                    time.sleep(0.001)
            except ChildProcessError:
                return


def split() -> Keeper | Voice:
    """Fork: the parent gets a Keeper, the fork, which goes on, a Voice. No thread may be running."""
    reading, writing = os.pipe()
    libc = ctypes.CDLL(None)
    if sys.platform == "linux":
        libc.prctl(_ADOPT, 1)
    parent = os.getpid()
    sys.stdout.flush()
    sys.stderr.flush()
    pid = os.fork()
    if pid:
        os.close(writing)
        return Keeper(pid, reading)
    os.close(reading)
    if sys.platform == "linux":
        libc.prctl(DIE_WITH_PARENT, signal.SIGKILL)
        if os.getppid() != parent:
            os._exit(1)
    return Voice(writing)
