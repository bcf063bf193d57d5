"""A slave in a process of its own: an FMU that crashes, leaves or hangs there ends as an error message here.

The child runs fmu_process.py; frames of protocol.py go over a socket pair: numbers, and JSON of which every field is checked.
Nothing that comes from there is executed. What the FMU prints and logs goes to an unnamed file, from which its last lines are
read. Linux and macOS.
"""

import contextlib
import json
import os
import signal
import socket
import struct
import subprocess
import sys
import tempfile
import time
from collections.abc import Mapping
from dataclasses import asdict
from types import MappingProxyType
from typing import Any

import numpy as np

from ...errors import EndRequest, OutputError, SlaveError
from ..base import Counting, Counts, Linearisable, Promised, Serializable, StateSpace
from ..fmi.log import Log
from ..scratch import ScratchFolder
from ..signal import Given, Value
from ..usage import Usage
from . import child
from .messages import Messaging
from .protocol import Kind, Link, ProtocolError, array, document, numbers
from .telling import carried_values, described, number, told_notes

PROGRAM = "gyro_cosim.slaves.processes.fmu_process"
PATIENCE = 60.0  # s that one call may take
LARGEST = 1 << 28  # bytes of a saved state


class IsolatedSlave(Messaging, Serializable, Linearisable, Counting, Promised):
    """Passes every call on to the FMU at `location` in a child process; `patience` (s) bounds each call.

    implementation : see open_slave(). sizes : values of structural parameters. note : what is to be told of its being here.
    """

    def __init__(
        self, name: str, location: str, patience: float = PATIENCE, *, implementation: str = "",
        sizes: Mapping[str, Given] = MappingProxyType({}), note: str = "",
    ) -> None:  # fmt: skip
        if sys.platform == "win32":
            raise ValueError("FMUs can be isolated on Linux and macOS only")
        self.name, self._patience, self._log = name, patience, Log(name)
        self._events: int | None = None
        self._note = note
        self._sequence = 0
        self._scratch = ScratchFolder()  # the child's temporary files: it may not live to remove them
        self._words = tempfile.TemporaryFile()  # noqa: SIM115 (closed by close())
        ours, theirs = socket.socketpair()
        self._link = Link(ours, LARGEST)
        try:
            self._process = child.start(PROGRAM, (), descriptor=theirs.fileno(), words=self._words, temporary=self._scratch.path)
        except BaseException:
            self._remove()
            raise
        finally:
            theirs.close()
        try:
            asked = {"name": name, "location": location, "implementation": implementation, "sizes": dict(sizes)}
            told = self._ask(Kind.OPEN, json.dumps(asked).encode())
            try:
                self.description = described(document(told))
            except ProtocolError as error:
                raise SlaveError(name, 0.0, 0.0, f"its process sent a malformed frame: {error}", self._last_lines()) from None
        except BaseException:
            self.close()
            raise

    def _ask(self, kind: Kind, payload: bytes = b"", t: float = 0.0, h: float = 0.0) -> bytes:
        """The answer of the child to a request; SlaveError if it fails, dies, or does not answer in time."""
        what = kind.name.lower()
        self._sequence += 1
        patience = max(self._patience, PATIENCE) if kind == Kind.OPEN else self._patience  # Python itself must start, too
        end = time.perf_counter() + patience
        try:
            self._link.send(kind, self._sequence, payload, patience)
            while True:
                answer, sequence, content = self._link.receive(max(1e-3, end - time.perf_counter()))
                if sequence != self._sequence or answer not in (Kind.OK, Kind.ERROR, Kind.END, Kind.LOG):
                    raise ProtocolError(f"{answer.name} with number {sequence} answers nothing")
                if answer != Kind.LOG:
                    break
                self._repeat(document(content))
            if answer == Kind.OK:
                return content
            if answer == Kind.END:
                raise EndRequest(self.name, float(array(content, 1)[0]))
            told = document(content)
            reason, of = str(told.get("reason"))[:4000], told.get("kind")
            if of == "value":
                raise ValueError(reason)
            if of in ("slave", "output"):
                when, over = number(told, "t"), number(told, "h")
                failed = OutputError if of == "output" else SlaveError
                raise failed(self.name, when, over, reason, str(told.get("log", ""))[:4000])
            raise SlaveError(self.name, t, h, reason, self._last_lines())
        except TimeoutError:
            self._process.kill()
            reason = f"{what} does not end, given up after {patience:g} s"
            raise SlaveError(self.name, t, h, reason, self._last_lines()) from None
        except ProtocolError as error:
            self._process.kill()
            raise SlaveError(
                self.name, t, h, f"its process sent a malformed frame in {what}: {error}", self._last_lines()
            ) from None
        except (EOFError, OSError):
            with contextlib.suppress(subprocess.TimeoutExpired):
                self._process.wait(child.TIME_TO_LEAVE)
            raise SlaveError(self.name, t, h, f"its process {self._ending()} in {what}", self._last_lines()) from None

    def _repeat(self, told: Mapping[str, Any]) -> None:
        """What the FMU has said, into the log of this process."""
        lines = told.get("lines")
        if not isinstance(lines, list) or not all(_is_line(line) for line in lines):
            raise ProtocolError("lines of the log must be status, category and text")
        for line in lines:
            self._log.say(*line)

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

    def promise(self, usage: Usage, values: Mapping[str, Value], t: float, stop: float) -> tuple[str, ...]:
        told = {"usage": asdict(usage), "values": carried_values(values), "t": t, "stop": stop}
        try:
            answer = document(self._ask(Kind.PROMISE, json.dumps(told).encode(), t))
            self.description, notes = described(answer), told_notes(answer)
        except ProtocolError as error:
            raise self._malformed("promise", str(error), t) from None
        return (self._note, *notes) if self._note else notes

    def begin(self, values: Mapping[str, Value], t: float, stop: float) -> None:
        self._start = t
        self._log.clear()
        self._ask(Kind.BEGIN, json.dumps({"values": carried_values(values), "t": t, "stop": stop}).encode(), t)

    def finish(self) -> None:
        self._ask(Kind.FINISH, t=self._start)

    def output(self, u: np.ndarray, t: float) -> np.ndarray:
        events, *y = self._numbers(Kind.OUTPUT, self._ask(Kind.OUTPUT, numbers(t, u), t), 1 + len(self.outputs), t)
        self._events = int(events) if np.isfinite(events) else None
        return np.array(y)

    def step(self, U: np.ndarray, t: float, h: float) -> None:
        self._ask(Kind.STEP, numbers(t, h, U), t, h)

    def save(self) -> Any:
        return self._snapshot(self._ask(Kind.SAVE))

    def restore(self, snapshot: Any) -> None:
        self._ask(Kind.RESTORE, struct.pack("<Q", snapshot))

    def discard(self, snapshot: Any) -> None:
        if self._process.poll() is None:
            self._ask(Kind.DISCARD, struct.pack("<Q", snapshot))

    def serialize(self) -> bytes:
        return self._ask(Kind.SERIALIZE)

    def deserialize(self, data: bytes) -> None:
        self._ask(Kind.DESERIALIZE, data)

    @property
    def counts(self) -> Counts:
        return Counts(self._events, self._log.warnings, self._log.first_warning)

    def state_space(self) -> StateSpace | None:
        content = self._ask(Kind.LINEARISE)
        if not content:
            return None
        whole = self._numbers(Kind.LINEARISE, content, len(content) // 8)
        n_x, n_u, n_y = (int(n) if 0 <= n <= 1e5 else -1 for n in (*whole[:3], -1, -1, -1)[:3])
        shapes = ((n_x, n_x), (n_x, n_u), (n_y, n_x), (n_y, n_u))
        sizes = np.cumsum([3, *(rows * columns for rows, columns in shapes)])
        if min(n_x, n_u, n_y) < 0 or sizes[-1] != whole.size:
            raise self._malformed("linearise", f"{whole.size} numbers are no A, B, C, D")
        parts = zip(sizes[:-1], sizes[1:], shapes, strict=True)
        return StateSpace(*(whole[first:end].reshape(shape) for first, end, shape in parts))

    def _snapshot(self, content: bytes) -> int:
        if len(content) != 8:
            raise self._malformed("save", f"{len(content)} bytes are no number of a snapshot")
        return int.from_bytes(content, "little")

    def _numbers(self, kind: Kind, content: bytes, size: int, t: float = 0.0) -> np.ndarray:
        try:
            return array(content, size)
        except ProtocolError as error:
            raise self._malformed(kind.name.lower(), str(error), t) from None

    def _malformed(self, what: str, how: str, t: float = 0.0) -> SlaveError:
        self._process.kill()
        return SlaveError(self.name, t, 0.0, f"its process sent a malformed frame in {what}: {how}", self._last_lines())

    def close(self) -> None:
        if self._process.poll() is None:
            with contextlib.suppress(OSError):
                self._link.send(Kind.BYE, self._sequence + 1, timeout=child.TIME_TO_LEAVE)
        child.end(self._process)
        self._remove()

    def _remove(self) -> None:
        self._link.close()
        self._words.close()
        self._scratch.remove()


def _is_line(line: Any) -> bool:
    return isinstance(line, list) and len(line) == 3 and type(line[0]) is int and all(isinstance(text, str) for text in line[1:])
