"""A unit in another process or on another machine, behind the same interface as every slave.

    process:gyro_unit:nonlinear         a component or FMU in a child process, which ends with this one
    tcp://HOST:PORT                     whatever speaks gyro_cosim.slaves.processes.protocol there: `cosim serve`, a rig, a device

Options follow a question mark, joined by &: "tcp://rig:5000?timeout=0.5ms&late=hold&patience=20".

    timeout     how long an answer may take (1 s)
    late        what counts for one that takes longer: `hold` the last answer, `extrapolate` the line through the last two, or
                `stop` the run (the default). An answer that comes later still is dropped.
    patience    how many answers in a row may be missing before the run stops after all (10)
    secret      a file with the secret that the unit knows, too, see `cosim serve --secret`
    tls         a file with the certificates that are trusted, see `cosim serve --certificate`

A unit that is gone, or sends what is no frame, stops the run in any case: SlaveError, and the results so far are kept. A step
is not waited for; what comes of it is asked with the outputs, so a macro step costs one question and its answer.
"""

import json
import socket
import ssl
import struct
import subprocess
from collections.abc import Mapping
from contextlib import ExitStack
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any, Literal
from urllib.parse import parse_qsl

import numpy as np

from gyro_cosim.component.units import quantity

from ...errors import EndRequest, SlaveError, unknown
from ..base import Restorable
from ..description import SlaveDescription
from ..signal import Value
from . import child
from .admission import WANTED, Admission, read_secret
from .messages import MESSAGES, Messaging
from .protocol import Kind, Link, ProtocolError, array, document, numbers
from .telling import carried_values, described, truth

_TERMS = ("timeout", "late", "patience", "secret", "tls")
SCHEMES = ("process:", "tcp://")
PREPARATION = 60.0  # s that opening, starting, saving and restoring may take


@dataclass(frozen=True)
class ResponseTerms:
    """What is expected of the unit's answers; see the module's docstring. timeout in s."""

    timeout: float = 1.0
    late: Literal["hold", "extrapolate", "stop"] = "stop"
    patience: int = 10
    secret: str = ""
    tls: str = ""

    def __post_init__(self) -> None:
        if not 0.0 < self.timeout < float("inf"):
            raise ValueError(f"timeout must be positive, got {self.timeout:g} s")
        if self.late not in ("hold", "extrapolate", "stop"):
            raise ValueError(f"late must be hold, extrapolate or stop, got {self.late!r}")
        if self.patience < 1:
            raise ValueError(f"patience must be at least 1, got {self.patience}")


def parse(source: str) -> tuple[str, ResponseTerms]:
    """The place and the terms in `source`; ValueError names it and the rule."""
    place, _, options = source.partition("?")
    chosen = dict(parse_qsl(options))
    try:
        for name in chosen:
            if name not in _TERMS:
                raise unknown("option", name, _TERMS)
        timeout, patience = quantity(chosen.get("timeout", "1"), "s"), int(chosen.get("patience", "10"))
        terms = ResponseTerms(timeout, chosen.get("late", "stop"), patience,  # type: ignore[arg-type]
                              chosen.get("secret", ""), chosen.get("tls", ""))  # fmt: skip
    except ValueError as error:
        raise ValueError(f"unit {source!r}: {error}") from None
    return place, terms


class RemoteSlave(Messaging, Restorable):
    """See the module's docstring. late : how many answers came too late or never, in this run."""

    def __init__(self, name: str, source: str) -> None:
        self.name, self.late = name, 0
        place, self._terms = parse(source)
        self._child: subprocess.Popen[bytes] | None = None
        self._sequence = self._missing = 0
        self._preparing = True
        self._place = place
        self._last: list[tuple[float, np.ndarray]] = []
        self._link = self._started(place.removeprefix("process:")) if place.startswith("process:") else self._connected(place)
        try:
            self._introduce(document(self._ask(Kind.HELLO, b"", 0.0)))
        except ProtocolError as error:
            self.close()
            raise self._failed(0.0, f"sent a malformed frame: {error}") from None
        except BaseException:
            self.close()
            raise

    def _connected(self, place: str) -> Link:
        host, colon, port = place.removeprefix("tcp://").rpartition(":")
        if not colon or not port.isdigit() or not 0 < int(port) < 65536:
            raise ValueError(f"unit {place!r} must be tcp://HOST:PORT")
        secret = read_secret(Path(self._terms.secret)) if self._terms.secret else None
        try:
            context = ssl.create_default_context(cafile=self._terms.tls) if self._terms.tls else None
            stream = socket.create_connection((host, int(port)), timeout=5.0)
            with ExitStack() as stack:
                stack.callback(stream.close)
                link = Admission(secret, context).enter(stream, host)
                stack.pop_all()
                return link
        except (ProtocolError, EOFError) as error:
            raise self._failed(0.0, f"lets nobody in: {error or 'it has closed the connection'}") from None
        except OSError as error:
            raise self._failed(0.0, f"does not answer: {error.strerror or error}") from None

    def _started(self, source: str) -> Link:
        here, there = socket.socketpair()
        with there:
            self._child = child.start("gyro_cosim.slaves.processes.serving", (source,), descriptor=there.fileno())
        return Link(here)

    def _introduce(self, told: Mapping[str, Any]) -> None:
        """Signals and abilities from the unit's own words; ProtocolError where they do not fit together."""
        try:
            told_of = described(told)
        except ProtocolError as error:
            raise ProtocolError(f"it does not introduce itself: {error}") from None
        # a repeated step must find every answer
        strict = self._terms.late == "stop"
        self.description = replace(told_of, can_restore=told_of.can_restore and strict)
        if not truth(told, "messages", False):
            self.description = replace(self.description, tunable=frozenset())
        if not (strict and truth(told, "messages", False)):  # no frame carries them, or one may be missing
            self.description = _without_messages(self.description)
        self._initializes = truth(told, "initialization", False)

    def begin(self, values: Mapping[str, Value], t: float, stop: float) -> None:
        self._last, self._missing, self.late = [], 0, 0
        self._start, self._preparing = t, True
        payload = json.dumps({"values": carried_values(values), "t": t, "stop": stop}).encode()
        self._ask(Kind.BEGIN if self._initializes else Kind.START, payload, t)

    def finish(self) -> None:
        if self._initializes:
            self._ask(Kind.FINISH, b"", self._start)
        self._last, self._preparing = [], False

    def output(self, u: np.ndarray, t: float) -> np.ndarray:
        patient = self._preparing or not self._last
        try:
            y = array(self._ask(Kind.OUTPUT, numbers(t, u), t, None if patient else self._terms.timeout), len(self.outputs))
        except TimeoutError:
            return self._substitute(t)
        except ProtocolError as error:
            raise self._failed(t, f"sent a malformed frame: {error}") from None
        self._missing = 0
        if not np.isfinite(y).all():
            bad = self.outputs[int(np.flatnonzero(~np.isfinite(y))[0])].name
            raise self._failed(t, f"output {bad!r} must be finite")
        if self._last and self._last[0][0] == t:
            del self._last[0]
        self._last.insert(0, (t, y))
        del self._last[2:]
        return y.copy()

    def _substitute(self, t: float) -> np.ndarray:
        """What counts for an answer that is not there."""
        self.late += 1
        self._missing += 1
        if self._terms.late == "stop" or self._missing > self._terms.patience:
            times = "" if self._missing == 1 else f", {self._missing} times in a row"
            raise self._failed(t, f"gave no answer within {self._terms.timeout:g} s{times}")
        (t1, y1), (t0, y0) = self._last[0], self._last[-1]
        if self._terms.late == "hold" or t1 <= t0:
            return y1.copy()
        return np.asarray(y1 + (y1 - y0) * ((t - t1) / (t1 - t0)))

    def step(self, U: np.ndarray, t: float, h: float) -> None:
        self._sequence += 1
        try:
            self._link.send(Kind.STEP, self._sequence, numbers(t, h, U), PREPARATION)
        except OSError as error:
            raise self._failed(t, self._gone(error), h) from None

    def save(self) -> Any:
        return struct.unpack("<Q", self._ask(Kind.SAVE, b"", 0.0))[0], list(self._last)

    def restore(self, snapshot: Any) -> None:
        self._ask(Kind.RESTORE, struct.pack("<Q", snapshot[0]), 0.0)
        self._last = list(snapshot[1])

    def discard(self, snapshot: Any) -> None:
        self._ask(Kind.DISCARD, struct.pack("<Q", snapshot[0]), 0.0)

    def _ask(self, kind: Kind, payload: bytes = b"", t: float = 0.0, timeout: float | None = None) -> bytes:
        """The answer to a request. TimeoutError only with a `timeout` (s); whatever else goes wrong is a SlaveError."""
        self._sequence += 1
        patient = kind not in MESSAGES or self._preparing or not self._last
        usual = PREPARATION if patient else self._terms.timeout
        try:
            self._link.send(kind, self._sequence, payload, PREPARATION)
            while True:
                answer, sequence, content = self._link.receive(timeout or usual)
                if answer == Kind.CHALLENGE:
                    raise self._failed(t, WANTED.decode())
                if sequence > self._sequence or answer not in (Kind.OK, Kind.ERROR, Kind.END):
                    raise ProtocolError(f"{answer.name} with number {sequence} answers nothing")
                if sequence == self._sequence:  # an older one comes too late
                    break
            ended = float(array(content, 1)[0]) if answer == Kind.END else t
        except TimeoutError:
            if timeout is not None:
                raise
            raise self._failed(t, f"gave no answer to {kind.name} within {usual:g} s") from None
        except ProtocolError as error:
            raise self._failed(t, f"sent a malformed frame: {error}") from None
        except (EOFError, OSError) as error:
            raise self._failed(t, self._gone(error)) from None
        if answer == Kind.ERROR:
            raise self._failed(t, content.decode(errors="replace"))
        if answer == Kind.END:
            raise EndRequest(self.name, ended)
        return content

    def _malformed(self, what: str, how: str, t: float = 0.0) -> SlaveError:
        return self._failed(t, f"sent a malformed answer to {what}: {how}")

    def _gone(self, error: Exception) -> str:
        if self._child is None:
            return f"is gone: {getattr(error, 'strerror', None) or 'the connection was closed'}"
        try:
            return f"is gone: its process ended with code {self._child.wait(0.5)}"
        except subprocess.TimeoutExpired:
            return "is gone: its process closed the connection"

    def _failed(self, t: float, reason: str, h: float = 0.0) -> SlaveError:
        return SlaveError(self.name, t, h, f"the unit at {self._place} {reason}")

    def close(self) -> None:
        try:
            self._link.send(Kind.BYE, self._sequence + 1, timeout=0.2)
        except OSError:  # it is gone already, or takes nothing
            pass
        finally:
            self._link.close()
        if self._child is not None:
            child.end(self._child)


def _without_messages(d: SlaveDescription) -> SlaveDescription:
    """Without texts and clocks, which cannot be connected then."""
    texts = {s.name: s.type.capitalize() for s in (*d.text_inputs, *d.text_outputs)}
    clocks = dict.fromkeys((*d.clock_inputs, *d.clock_outputs), "Clock of a unit that tells of none in time")
    return replace(
        d, text_inputs=(), text_outputs=(), clock_inputs=(), clock_outputs=(), clocked={},
        excluded={**clocks, **d.excluded, **texts},
    )  # fmt: skip
