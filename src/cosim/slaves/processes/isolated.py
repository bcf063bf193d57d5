"""A slave in a process of its own: an FMU that crashes, leaves or hangs there ends as an error message here.

The child runs fmu_process.py; requests and answers are pickled over a socket pair. What the FMU prints
and logs goes to an unnamed file, from which its last lines are read. Linux and macOS.
"""

import contextlib
import os
import pickle
import signal
import subprocess
import sys
import tempfile
from collections.abc import Mapping
from multiprocessing.connection import Pipe
from typing import Any

import numpy as np

from ...errors import EndRequest, OutputError, SlaveError
from ..base import Counting, Counts, Linearisable, Serializable, StateSpace
from ..description import SlaveDescription
from ..fmi.log import Log
from ..scratch import ScratchFolder
from ..signal import Value
from . import child

PROGRAM = "gyro_cosim.slaves.processes.fmu_process"
PATIENCE = 60.0  # s that one call may take


class IsolatedSlave(Serializable, Linearisable, Counting):
    """Passes every call on to the FMU at `location` in a child process; `patience` (s) bounds each call."""

    def __init__(self, name: str, location: str, patience: float = PATIENCE) -> None:
        if sys.platform == "win32":
            raise ValueError("FMUs can be isolated on Linux and macOS only")
        self.name, self._patience, self._log = name, patience, Log(name)
        self._events: int | None = None
        self._scratch = ScratchFolder()  # the child's temporary files: it may not live to remove them
        self._words = tempfile.TemporaryFile()  # noqa: SIM115 (closed by close())
        self._connection, theirs = Pipe()
        try:
            self._process = child.start(PROGRAM, (), descriptor=theirs.fileno(), words=self._words, temporary=self._scratch.path)
        except BaseException:
            self._remove()
            raise
        finally:
            theirs.close()
        try:
            self.description: SlaveDescription = self._ask("open", 0.0, 0.0, name, location)
        except BaseException:
            self.close()
            raise

    def _ask(self, what: str, t: float, h: float, *arguments: Any) -> Any:
        """The answer of the child to a request; SlaveError if it fails, dies, or does not answer in time."""
        try:
            self._connection.send((what, arguments))
            if not self._connection.poll(self._patience):
                self._process.kill()
                raise SlaveError(self.name, t, h, f"{what} does not end, given up after {self._patience:g} s", self._last_lines())
            kind, answer, self._events, messages = self._connection.recv()
        except (EOFError, OSError, pickle.UnpicklingError):
            with contextlib.suppress(subprocess.TimeoutExpired):
                self._process.wait(child.TIME_TO_LEAVE)
            raise SlaveError(self.name, t, h, f"its process {self._ending()} in {what}", self._last_lines()) from None
        for message in messages:
            self._log.say(*message)
        if kind == "slave":
            raise SlaveError(self.name, *answer)
        if kind == "output":
            raise OutputError(self.name, *answer)
        if kind == "end":
            raise EndRequest(self.name, answer)
        if kind == "value":
            raise ValueError(answer)
        if kind == "other":
            raise SlaveError(self.name, t, h, answer, self._last_lines())
        return answer

    def _ending(self) -> str:
        code = self._process.poll()
        if code is None:
            return "broke the connection"
        if code < 0:
            return f"was ended by signal {-code} ({signal.Signals(-code).name})"
        return f"exited with code {code}"

    def _last_lines(self) -> str:
        """The last lines that the child has printed or its FMU logged."""
        size = self._words.seek(0, os.SEEK_END)
        self._words.seek(max(0, size - 4096))
        lines = [" ".join(line.split()) for line in self._words.read().decode(errors="replace").splitlines()]
        return "; ".join([line for line in lines if line][-3:])

    def begin(self, values: Mapping[str, Value], t: float, stop: float) -> None:
        self._start = t
        self._log.clear()
        self._ask("begin", t, 0.0, dict(values), t, stop)

    def finish(self) -> None:
        self._ask("finish", self._start, 0.0)

    def output(self, u: np.ndarray, t: float) -> np.ndarray:
        y: np.ndarray = self._ask("output", t, 0.0, u, t)
        return y

    def step(self, U: np.ndarray, t: float, h: float) -> None:
        self._ask("step", t, h, U, t, h)

    def save(self) -> Any:
        return self._ask("save", 0.0, 0.0)

    def restore(self, snapshot: Any) -> None:
        self._ask("restore", 0.0, 0.0, snapshot)

    def discard(self, snapshot: Any) -> None:
        if self._process.poll() is None:
            self._ask("discard", 0.0, 0.0, snapshot)

    def serialize(self) -> bytes:
        data: bytes = self._ask("serialize", 0.0, 0.0)
        return data

    def deserialize(self, data: bytes) -> None:
        self._ask("deserialize", 0.0, 0.0, data)

    @property
    def counts(self) -> Counts:
        return Counts(self._events, self._log.warnings, self._log.first_warning)

    def state_space(self) -> StateSpace | None:
        space: StateSpace | None = self._ask("state_space", 0.0, 0.0)
        return space

    def close(self) -> None:
        if self._process.poll() is None:
            with contextlib.suppress(OSError):
                self._connection.send(("close", ()))
        child.end(self._process)
        self._remove()

    def _remove(self) -> None:
        self._connection.close()
        self._words.close()
        self._scratch.remove()
