"""The program in an isolated FMU's process: it opens the FMU and does what isolated.py asks, in frames of protocol.py."""

import json
import socket
import struct
import sys
from typing import Any

import numpy as np

from ...errors import EndRequest, OutputError, SlaveError
from ..fmi.log import shown
from ..opening import open_fmu
from ..usage import Usage, promise
from . import child
from .messages import MESSAGES, answered
from .protocol import Kind, Link, array, document, numbers
from .sandbox import confine
from .telling import introduction, number, read_values

MOST_LINES = 200  # of the log with one answer; what is beyond is counted only


class Program:
    """One FMU and what is asked of it. Everything here may end at any time: the FMU is a stranger."""

    def __init__(self, link: Link) -> None:
        self._link = link
        self._slave: Any = None
        self._snapshots: dict[int, Any] = {}
        self._count = self._dropped = 0
        self._lines: list[tuple[int, str, str]] = []

    def run(self) -> None:
        """Do what is asked until the parent says BYE or is gone."""
        while True:
            try:
                kind, sequence, payload = self._link.receive()
            except (EOFError, OSError):
                break
            if kind == Kind.BYE:
                break
            answer, content = Kind.OK, b""
            try:
                content = self._done(kind, payload)
            except SlaveError as error:
                told = {"t": error.t, "h": error.h, "reason": error.reason, "log": error.log}
                of = "output" if isinstance(error, OutputError) else "slave"
                answer, content = Kind.ERROR, json.dumps({"kind": of, **told}).encode()
            except EndRequest as request:
                answer, content = Kind.END, numbers(request.t)
            except ValueError as error:
                answer, content = Kind.ERROR, json.dumps({"kind": "value", "reason": str(error)}).encode()
            except Exception as error:  # whatever it is, the parent needs one line
                reason = f"{type(error).__name__}: {error}"
                answer, content = Kind.ERROR, json.dumps({"kind": "other", "reason": reason}).encode()
            self._tell(sequence)
            self._link.send(answer, sequence, content)
        if self._slave is not None:
            self._slave.close()

    def _heard(self, status: int, category: str, text: str) -> None:
        """What the FMU says goes to the parent with the next answer, and into the file, should there be none."""
        if len(self._lines) < MOST_LINES:
            self._lines.append((status, category[:200], text[:2000]))
            print(shown(self._lines[-1]), flush=True)
        else:
            self._dropped += 1

    def _tell(self, sequence: int) -> None:
        if self._lines or self._dropped:
            told = {"lines": self._lines, "dropped": self._dropped}
            self._link.send(Kind.LOG, sequence, json.dumps(told).encode())
            self._lines, self._dropped = [], 0

    def _done(self, kind: Kind, payload: bytes) -> bytes:
        """The answer to one request."""
        if kind == Kind.OPEN:
            given = document(payload)
            self._slave = open_fmu(
                given["name"], given["location"], implementation=given["implementation"], values=given["sizes"]
            )
            self._slave.log.listen(self._heard)
            return json.dumps(introduction(self._slave)).encode()
        slave = self._slave
        n_u = len(slave.inputs)
        if kind in MESSAGES:
            return answered(slave, kind, payload)
        if kind == Kind.PROMISE:
            given = document(payload)
            notes = promise(
                slave, Usage(**given["usage"]), read_values(given["values"]), number(given, "t"), number(given, "stop")
            )
            return json.dumps(introduction(slave) | {"notes": list(notes)}).encode()
        if kind == Kind.BEGIN:
            given = document(payload)
            slave.begin(read_values(given["values"]), number(given, "t"), number(given, "stop"))
        elif kind == Kind.FINISH:
            slave.finish()
        elif kind == Kind.OUTPUT:
            whole = array(payload, 1 + n_u)
            return numbers(self._events(), slave.output(whole[1:], float(whole[0])))
        elif kind == Kind.STEP:
            whole = array(payload, 2 + 3 * n_u)
            slave.step(whole[2:].reshape(3, -1), float(whole[0]), float(whole[1]))
        elif kind == Kind.SAVE:
            self._count += 1
            self._snapshots[self._count] = slave.save()
            return struct.pack("<Q", self._count)
        elif kind == Kind.RESTORE:
            slave.restore(self._snapshots[struct.unpack("<Q", payload)[0]])
        elif kind == Kind.DISCARD:
            slave.discard(self._snapshots.pop(struct.unpack("<Q", payload)[0]))
        elif kind == Kind.SERIALIZE:
            return bytes(slave.serialize())
        elif kind == Kind.DESERIALIZE:
            slave.deserialize(payload)
        elif kind == Kind.LINEARISE:
            space = slave.state_space()
            return b"" if space is None else numbers(len(space.A), n_u, len(space.C), space.A, space.B, space.C, space.D)
        return b""

    def _events(self) -> float:
        """How many events there have been; NaN where the FMU does not tell."""
        events = self._slave.counts.events
        return np.nan if events is None else float(events)


def main() -> None:
    """Arguments: the number of the socket, the parent's process id."""
    if child.belongs():
        confine()
        Program(Link(socket.socket(fileno=int(sys.argv[1])))).run()


if __name__ == "__main__":
    main()
