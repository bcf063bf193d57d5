"""The other end: answers a master's frames with a slave, until that one leaves. See protocol.py for the frames.

Nothing that a master sends is believed: a message that breaks a rule is answered with the rule, and ends that run only.
"""

import json
import math
import socket
import struct
import sys
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from types import MappingProxyType
from typing import Any

import numpy as np

from ...errors import EndRequest
from ..base import Slave, restorable
from ..opening import open_slave
from ..signal import Value
from . import child
from .messages import MESSAGES, answered
from .protocol import Kind, Link, ProtocolError, array, document, numbers
from .telling import introduction, number, read_values

__all__ = ["Limits", "serve"]


@dataclass(frozen=True)
class Limits:
    """What a master may ask for.

    Parameters
    ----------
    idle : float
        Seconds that it may be silent.
    slow : float
        Seconds that it may take to receive an answer.
    longest : float
        Seconds of simulated time that one step may have: what it costs nobody can stop.
    snapshots : int
        Saved states that it may hold.
    rate : int
        Connections that are looked at in 10 s; more are closed at once.
    """

    idle: float = 600.0
    slow: float = 10.0
    longest: float = 10.0
    snapshots: int = 10_000
    rate: int = 20

    def __post_init__(self) -> None:
        for name in ("idle", "slow", "longest", "snapshots", "rate"):
            if not 0 < getattr(self, name) < math.inf:
                raise ValueError(f"{name} must be positive, got {getattr(self, name)}")


class _Session:
    """What a master has come to with a slave."""

    def __init__(self, slave: Slave, limits: Limits, values: Mapping[str, Value]) -> None:
        self._slave, self._limits, self._values = slave, limits, values
        self._states = restorable(slave)
        self._snapshots: dict[int, Any] = {}
        self._count = 0
        self._stage = "new"  # then "begun", then "ready" for steps
        self.failed, self.ended = "", b""

    def answer(self, kind: Kind, payload: bytes) -> bytes:
        """What a request is answered with; ValueError says which rule it breaks."""
        slave = self._slave
        n_u = len(slave.inputs)
        if kind == Kind.HELLO:
            return json.dumps(introduction(slave, self._values) | {"messages": True}).encode()
        if kind in (Kind.START, Kind.BEGIN):
            self._begin(kind, document(payload))
        elif self.failed or self.ended:
            pass
        elif kind == Kind.FINISH:
            self._must("begun", kind)
            slave.finish()
            self._stage = "ready"
        elif kind == Kind.OUTPUT:
            self._must("begun ready", kind)
            whole = _finite(array(payload, 1 + n_u), "OUTPUT")
            return numbers(slave.output(whole[1:], float(whole[0])))
        elif kind == Kind.STEP:
            self._must("ready", kind)
            whole = _finite(array(payload, 2 + 3 * n_u), "STEP")
            t, h = float(whole[0]), float(whole[1])
            if not 0.0 < h <= self._limits.longest:
                raise ValueError(f"the length of a step must be above 0 s and at most {self._limits.longest:g} s, got {h:g} s")
            if not t + h > t:
                raise ValueError(f"a step of {h:g} s must lead on from t = {t:g} s")
            slave.step(whole[2:].reshape(3, -1), t, h)
        elif kind in (Kind.SAVE, Kind.RESTORE, Kind.DISCARD):
            self._must("begun ready", kind)
            return self._state(kind, payload)
        elif kind in MESSAGES:
            self._must("begun ready", kind)
            return answered(slave, kind, payload)
        else:
            raise ValueError(f"{kind.name} is no request to this unit")
        return b""

    def _begin(self, kind: Kind, given: dict[str, Any]) -> None:
        t, stop, values = number(given, "t"), number(given, "stop"), {**self._values, **read_values(given.get("values"))}
        if not stop > t:
            raise ValueError(f"stop must be behind t, got t = {t:g} s and stop = {stop:g} s")
        self._slave.description.start_values(self._slave.name, values)  # names and bounds
        self.discard_all()
        self.failed, self.ended, self._stage = "", b"", "new"
        (self._slave.initialize if kind == Kind.START else self._slave.begin)(values, t, stop)
        self._stage = "ready" if kind == Kind.START else "begun"

    def _must(self, stages: str, kind: Kind) -> None:
        if self._stage not in stages.split():
            raise ValueError(f"{kind.name} must come after {'START, or BEGIN' if 'begun' in stages else 'START, or FINISH'}")

    def _state(self, kind: Kind, payload: bytes) -> bytes:
        if self._states is None:
            raise ValueError(f"component {self._slave.name!r} cannot restore its state")
        if kind == Kind.SAVE:
            if len(self._snapshots) >= self._limits.snapshots:
                raise ValueError(f"at most {self._limits.snapshots} states may be held, discard some")
            self._count += 1
            self._snapshots[self._count] = self._states.save()
            return struct.pack("<Q", self._count)
        if len(payload) != 8 or (name := int.from_bytes(payload, "little")) not in self._snapshots:
            raise ValueError(f"{kind.name} must name a state that is held, got {payload[:8].hex() or 'nothing'}")
        if kind == Kind.RESTORE:
            self._states.restore(self._snapshots[name])
        else:
            self._states.discard(self._snapshots.pop(name))
        return b""

    def discard_all(self) -> None:
        """Free what a master has left."""
        while self._snapshots and self._states is not None:
            self._states.discard(self._snapshots.popitem()[1])


def serve(slave: Slave, link: Link, limits: Limits | None = None, values: Mapping[str, Value] = MappingProxyType({})) -> None:
    """Answer a master until it says BYE, is gone, or sends what is no frame. The slave stays open.

    limits : where a stranger may be the master, who is then dropped where he is silent for too long.
    values : that it starts with where the master gives none.
    """
    rules = limits or Limits(longest=sys.float_info.max)
    session = _Session(slave, rules, values)
    while True:
        try:
            kind, sequence, payload = link.receive(None if limits is None else rules.idle)
        except (EOFError, OSError, ProtocolError):
            break
        if kind == Kind.BYE:
            break
        answer = b""
        try:
            answer = session.answer(kind, payload)
        except EndRequest as request:
            session.ended = numbers(request.t)
        except Exception as error:  # whatever one master does, the next one finds a unit
            session.failed = str(error) or type(error).__name__
        if kind == Kind.STEP:
            continue
        told = (Kind.OK, answer)
        if session.failed or session.ended:
            told = (Kind.ERROR, session.failed.encode()) if session.failed else (Kind.END, session.ended)
        try:
            link.send(told[0], sequence, told[1], rules.slow)
        except OSError:
            break
    session.discard_all()


def _finite(whole: np.ndarray, what: str) -> np.ndarray:
    if not np.isfinite(whole).all():
        raise ValueError(f"all numbers of {what} must be finite, got {whole[~np.isfinite(whole)][0]}")
    return whole


def main(source: str, descriptor: int) -> None:
    """The child of gyro_cosim.slaves.processes.remote: serves on an inherited socket."""
    link = Link(socket.socket(fileno=descriptor))
    try:
        slave = open_slave("unit", source, in_process=True)
    except Exception as error:  # whatever is wrong with the unit, the master shall hear of it
        _, sequence, _ = link.receive()
        link.send(Kind.ERROR, sequence, str(error).encode())
        return
    try:
        serve(slave, link)
    finally:
        slave.close()


if __name__ == "__main__":
    sys.path.append(str(Path.cwd()))  # a package of the user's that stands there, after all others: it takes no name from them
    if child.belongs():
        main(sys.argv[1], int(sys.argv[2]))
