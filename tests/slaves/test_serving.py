"""A unit at a port among strangers: every message is checked, none ends the unit for others, and who may speak is asked."""

import json
import math
import socket
import struct
import subprocess
import sys
import threading
import time
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from gyro_cosim.errors import RunError
from gyro_cosim.slaves import open_slave
from gyro_cosim.slaves.processes.admission import Admission, read_secret
from gyro_cosim.slaves.processes.listening import listen
from gyro_cosim.slaves.processes.protocol import HEADER, MAGIC, Kind, Link, numbers
from gyro_cosim.slaves.processes.remote import RemoteSlave
from gyro_cosim.slaves.processes.serving import Limits

START = {"values": {}, "t": 0.0, "stop": 1.0}
SECRET = b"a secret of sixteen bytes or more"


class Port:
    """A unit at a port, served by a thread for as long as the test."""

    def __init__(self, limits: Limits | None = None, admission: Admission | None = None) -> None:
        there = threading.Event()
        self.slave = open_slave("unit", "gyro_unit:nonlinear", in_process=True)

        def ready(port: int) -> None:
            self.port = port
            there.set()

        keywords: dict[str, Any] = {"ready": ready, "limits": limits, "admission": admission}
        threading.Thread(target=listen, args=(self.slave, ("127.0.0.1", 0)), kwargs=keywords, daemon=True).start()
        there.wait()

    def link(self) -> Link:
        """A stream to it."""
        return Link(socket.create_connection(("127.0.0.1", self.port), timeout=10.0))

    def works(self) -> None:
        """A master finds the unit as ever."""
        slave = RemoteSlave("gyro", f"tcp://127.0.0.1:{self.port}")
        slave.initialize({}, 0.0, 1.0)
        slave.step(np.zeros((3, len(slave.inputs))), 0.0, 0.01)
        assert np.isfinite(slave.output(np.zeros(len(slave.inputs)), 0.01)).all()
        slave.close()


@pytest.fixture(scope="module")
def port() -> Iterator[Port]:
    return Port(Limits(rate=1000))


def start(**changes: Any) -> bytes:
    return json.dumps({**START, **changes}).encode()


def steps(t: float, h: float) -> bytes:
    return numbers(t, h, np.zeros(9))


STRANGE = [
    (Kind.START, start(t=[]), "t must be a finite number, got []"),
    (Kind.START, start(values=None), "values must be an object, got None"),
    (Kind.START, b'{"values": {}, "t": ' + b"9" * 400 + b', "stop": 1}', "a whole number must have at most 20 digits"),
    (Kind.START, start(stop=math.inf), "stop must be a finite number, got inf"),
    (Kind.START, start(stop=-1.0), "stop must be behind t"),
    (Kind.START, start(values={"none": 1.0}), "unknown parameter of 'unit': 'none'"),
    (Kind.START, start(values={"gimbal_angle": [[1]]}), "value 'gimbal_angle' must be a finite number"),
    (Kind.START, b"[" * 100_000, "no JSON"),
    (Kind.BEGIN, b"\xff" * 100, "no JSON"),
    (Kind.OUTPUT, numbers(0.0, 0.0, 0.0, 0.0), "OUTPUT must come after START, or BEGIN"),
    (Kind.SAVE, b"", "SAVE must come after START, or BEGIN"),
    (Kind.FINISH, b"", "FINISH must come after START, or BEGIN"),
    (Kind.SERIALIZE, b"", "SERIALIZE is no request to this unit"),
    (Kind.OK, b"", "OK is no request to this unit"),
]


@pytest.mark.parametrize(("kind", "payload", "rule"), STRANGE, ids=[f"{k.name}-{r[:20]}" for k, _, r in STRANGE])
def test_a_message_that_breaks_a_rule_is_answered_with_the_rule(port: Port, kind: Kind, payload: bytes, rule: str) -> None:
    link = port.link()
    link.send(kind, 7, payload)
    answer, sequence, content = link.receive(10.0)
    assert (answer, sequence) == (Kind.ERROR, 7)
    assert rule in content.decode()
    link.close()
    port.works()


@pytest.mark.parametrize(
    ("kind", "payload", "rule"),
    [
        (Kind.STEP, steps(0.0, 1e308), "the length of a step must be above 0 s and at most 10 s, got 1e+308 s"),
        (Kind.STEP, steps(0.0, 1e9), "at most 10 s, got 1e+09 s"),
        (Kind.STEP, steps(0.0, -1.0), "above 0 s"),
        (Kind.STEP, steps(math.nan, 1.0), "all numbers of STEP must be finite"),
        (Kind.STEP, steps(1e300, 1.0), "must lead on"),
        (Kind.STEP, b"123", "3 bytes are not 11 numbers"),
        (Kind.OUTPUT, numbers(0.0, math.inf, 0.0, 0.0), "all numbers of OUTPUT must be finite"),
        (Kind.RESTORE, struct.pack("<Q", 99), "RESTORE must name a state that is held"),
        (Kind.DISCARD, b"x", "DISCARD must name a state that is held"),
    ],
)
def test_in_a_run_too(kind: Kind, payload: bytes, rule: str) -> None:
    port = Port()
    link = port.link()
    link.send(Kind.START, 1, start())
    assert link.receive(10.0)[0] == Kind.OK
    link.send(kind, 2, payload)
    if kind == Kind.STEP:  # its failure is the answer to what is asked next
        link.send(Kind.OUTPUT, 2, numbers(0.0, 0.0, 0.0, 0.0))
    answer, _, content = link.receive(10.0)
    assert answer == Kind.ERROR
    assert rule in content.decode()
    link.send(Kind.START, 3, start())  # the same master may begin anew
    assert link.receive(10.0)[0] == Kind.OK
    link.close()
    port.works()


def test_steps_before_a_start_do_nothing() -> None:
    fresh = Port()
    link = fresh.link()
    link.send(Kind.STEP, 1, steps(0.0, 0.01))
    link.send(Kind.HELLO, 2)
    assert b"STEP must come after START" in link.receive(10.0)[2]
    link.close()
    fresh.works()


def test_a_silent_master_a_half_message_and_a_huge_one_are_dropped() -> None:
    port = Port(Limits(idle=0.2))
    for said in (b"", HEADER.pack(MAGIC, 1, Kind.START, 0, 100, 1) + b"half", HEADER.pack(MAGIC, 1, Kind.START, 0, 1 << 31, 1)):
        link = port.link()
        link.stream.sendall(said)
        link.stream.settimeout(10.0)
        assert link.stream.recv(1) == b""
        link.close()
    port.works()


def test_others_are_told_that_the_unit_is_taken() -> None:
    port = Port()
    first = RemoteSlave("gyro", f"tcp://127.0.0.1:{port.port}")
    with pytest.raises(RunError, match="serves another master; one at a time"):
        RemoteSlave("gyro", f"tcp://127.0.0.1:{port.port}")
    first.close()
    port.works()


def test_saved_states_are_counted() -> None:
    port = Port(Limits(snapshots=2))
    link = port.link()
    link.send(Kind.START, 1, start())
    answers = [link.receive(10.0)]
    for k in range(3):
        link.send(Kind.SAVE, k + 2)
        answers.append(link.receive(10.0))
    assert [kind for kind, _, _ in answers] == [Kind.OK, Kind.OK, Kind.OK, Kind.ERROR]
    assert b"at most 2 states may be held" in answers[-1][2]
    link.close()


def test_only_who_knows_the_secret_is_served(tmp_path: Path) -> None:
    (tmp_path / "right").write_bytes(SECRET)
    (tmp_path / "wrong").write_bytes(SECRET[::-1])
    port = Port(admission=Admission(read_secret(tmp_path / "right")))
    place = f"tcp://127.0.0.1:{port.port}"
    with pytest.raises(RunError, match="must be asked with the secret that it knows"):
        RemoteSlave("gyro", place)
    time.sleep(0.3)
    with pytest.raises(RunError, match="lets nobody in: it does not know the secret"):
        RemoteSlave("gyro", f"{place}?secret={tmp_path / 'wrong'}")
    time.sleep(0.3)
    slave = RemoteSlave("gyro", f"{place}?secret={tmp_path / 'right'}")
    slave.close()


def test_a_secret_is_long_enough(tmp_path: Path) -> None:
    (tmp_path / "short").write_bytes(b"1234")
    with pytest.raises(ValueError, match="must have at least 16 bytes, has 4"):
        read_secret(tmp_path / "short")
    with pytest.raises(ValueError, match="must be a file that can be read"):
        read_secret(tmp_path / "none")


def test_serve_tells_its_place_as_a_document() -> None:
    command = [sys.executable, "-m", "gyro_cosim", "serve", "gyro_unit:nonlinear", "--once", "--json"]
    with subprocess.Popen(command, stdout=subprocess.PIPE, text=True) as server:
        assert server.stdout is not None
        text = ""
        while not text.endswith("}\n"):
            text += server.stdout.readline()
        RemoteSlave("gyro", json.loads(text)["source"]).close()
        assert server.wait(10) == 0
