"""Units elsewhere: the same numbers, late answers, and every way in which they can fail; and no orphan is left."""

import os
import signal
import socket
import subprocess
import sys
import threading
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from gyro_cosim import Jacobi, SlaveError, simulate, system
from gyro_cosim.slaves import open_slave
from gyro_cosim.slaves.base import Restorable, Slave
from gyro_cosim.slaves.processes.listening import listen
from gyro_cosim.slaves.processes.protocol import HEADER, MAGIC, Kind, Link, ProtocolError, array
from gyro_cosim.slaves.processes.remote import RemoteSlave, parse
from gyro_cosim.slaves.processes.serving import serve

PLAN = system("wheel-pair").with_value("gyro.rotor_speed", "200rpm")
PLAIN = PLAN.with_source("gyro", "nonlinear")


@contextmanager
def offered(slave: Slave) -> Iterator[int]:
    """The slave at a port of this machine, served by a thread, for one master; the port."""
    ports: list[int] = []
    there = threading.Event()

    def ready(port: int) -> None:
        ports.append(port)
        there.set()

    thread = threading.Thread(target=listen, args=(slave, ("127.0.0.1", 0)), kwargs={"once": True, "ready": ready})
    thread.start()
    there.wait()
    try:
        yield ports[0]
    finally:
        thread.join(10.0)
        slave.close()
        assert not thread.is_alive()


class Lagging(Restorable):
    """Passes everything on, but takes its time for the outputs of some points."""

    def __init__(self, slave: Slave, late: Callable[[float], float]) -> None:
        self._slave, self._late = slave, late
        self.name, self.description = slave.name, slave.description

    def begin(self, values: Any, t: float, stop: float) -> None:
        self._slave.begin(values, t, stop)

    def finish(self) -> None:
        self._slave.finish()

    def output(self, u: np.ndarray, t: float) -> np.ndarray:
        time.sleep(self._late(t))
        return self._slave.output(u, t)

    def step(self, U: np.ndarray, t: float, h: float) -> None:
        self._slave.step(U, t, h)

    def save(self) -> Any:
        return self._slave.save()

    def restore(self, snapshot: Any) -> None:
        self._slave.restore(snapshot)

    def discard(self, snapshot: Any) -> None:
        self._slave.discard(snapshot)

    def close(self) -> None:
        self._slave.close()


def unit() -> Slave:
    return open_slave("unit", "gyro_unit:nonlinear", in_process=True)


@pytest.mark.parametrize("degree", [0, 1])
def test_a_unit_in_a_child_process_gives_the_same_numbers(degree: int) -> None:
    remote = simulate(PLAN.with_source("gyro", "process:gyro_unit:nonlinear"), algorithm=Jacobi(degree), step=5e-3, stop=0.5,
                      in_process=True)  # fmt: skip
    here = simulate(PLAIN, algorithm=Jacobi(degree), step=5e-3, stop=0.5, in_process=True)
    np.testing.assert_array_equal(remote.trajectory.values, here.trajectory.values)
    assert not children()


def children() -> list[str]:
    """Processes of this one that serve units."""
    found = []
    for entry in Path("/proc").iterdir():
        if entry.name.isdigit():
            try:
                parent = (entry / "stat").read_text().rpartition(")")[2].split()[1]
                command = (entry / "cmdline").read_bytes()
            except OSError:
                continue
            if parent == str(os.getpid()) and b"gyro_cosim.slaves.processes.serving" in command:
                found.append(entry.name)
    return found


def test_a_unit_behind_a_port_gives_the_same_numbers_and_keeps_its_signals() -> None:
    with offered(unit()) as port:
        slave = RemoteSlave("gyro", f"tcp://127.0.0.1:{port}")
        other = unit()
        for kind in ("inputs", "outputs"):
            assert [(s.name, s.unit) for s in getattr(slave, kind)] == [(s.name, s.unit) for s in getattr(other, kind)]
        assert set(slave.description.settable) == set(other.description.settable)
        np.testing.assert_array_equal(slave.description.feedthrough, other.description.feedthrough)
        slave.close()
    with offered(unit()) as port:
        remote = simulate(PLAN.with_source("gyro", f"tcp://127.0.0.1:{port}"), step=5e-3, stop=0.5, in_process=True)
    here = simulate(PLAIN, step=5e-3, stop=0.5, in_process=True)
    np.testing.assert_array_equal(remote.trajectory.values, here.trajectory.values)


@pytest.mark.parametrize("late", ["hold", "extrapolate"])
def test_a_late_answer_is_held_or_extrapolated(late: str) -> None:
    """Points 10 and 20 answer late: their moments are those before, or lie on the line through the two before."""
    slow = Lagging(unit(), lambda t: 0.12 if round(t / 0.01) in (10, 20) else 0.0)
    with offered(slow) as port:
        plan = PLAN.with_source("gyro", f"tcp://127.0.0.1:{port}?timeout=60ms&late={late}")
        run = simulate(plan, algorithm=Jacobi(0), step=0.01, stop=0.5, in_process=True)
    M = run.trajectory["gyro.yaw_moment"]
    for k in (10, 20):
        expected = M[k - 1] if late == "hold" else 2 * M[k - 1] - M[k - 2]
        assert M[k] == pytest.approx(expected, rel=1e-12)
    assert M[12] != M[11]


def partial(plan: Any) -> tuple[str, Any]:
    """The message of a run that must fail, and what was kept of it."""
    with pytest.raises(SlaveError) as caught:
        simulate(plan, algorithm=Jacobi(0), step=0.01, stop=0.5, in_process=True)
    return str(caught.value), caught.value.partial


@pytest.mark.parametrize(("late", "point"), [("stop", 10), ("hold", 13)])
def test_a_unit_that_hangs_stops_the_run_at_once_or_when_patience_ends(late: str, point: int) -> None:
    hanging = Lagging(unit(), lambda t: 0.5 if round(t / 0.01) == 10 else 0.0)
    with offered(hanging) as port:
        message, run = partial(PLAN.with_source("gyro", f"tcp://127.0.0.1:{port}?timeout=20ms&late={late}&patience=3"))
    assert f"component 'gyro' failed at t = {point / 100:g} s" in message
    assert "gave no answer within 0.02 s" in message
    assert len(run.trajectory) == point


def test_a_unit_that_dies_stops_the_run_and_leaves_nothing_behind() -> None:
    slaves: list[str] = []

    def kill(k: int) -> None:
        if k == 20:
            slaves.extend(children())
            os.kill(int(slaves[0]), signal.SIGKILL)

    with pytest.raises(
        SlaveError, match=r"the unit at process:gyro_unit:nonlinear is gone: its process ended with code -9"
    ) as caught:
        simulate(PLAN.with_source("gyro", "process:gyro_unit:nonlinear"), step=0.01, stop=0.5, in_process=True, before_step=kill)
    assert 18 <= len(caught.value.partial.trajectory) <= 21
    assert slaves
    assert not children()


def test_a_child_that_hangs_is_ended() -> None:
    slave = open_slave("gyro", "process:gyro_unit:nonlinear")
    (pid,) = children()
    os.kill(int(pid), signal.SIGSTOP)
    slave.close()
    assert not children()


def test_a_child_leaves_with_a_master_that_is_killed() -> None:
    """No orphan, even if the master has no chance to say good-bye."""
    code = (
        "import time; from gyro_cosim.slaves import open_slave; s = open_slave('g', 'process:gyro_unit:nonlinear');"
        "print(s._child.pid, flush=True); time.sleep(60)"
    )
    with subprocess.Popen([sys.executable, "-c", code], stdout=subprocess.PIPE, text=True) as master:
        assert master.stdout is not None
        pid = int(master.stdout.readline())
        os.kill(pid, signal.SIGSTOP)  # not even the closed stream can tell it
        master.kill()
    for _ in range(100):
        if not Path(f"/proc/{pid}").exists() or "Z" in Path(f"/proc/{pid}/stat").read_text().rpartition(")")[2].split()[0]:
            return
        time.sleep(0.05)
    pytest.fail(f"process {pid} is still there")


def talker(say: Callable[[Link], None]) -> tuple[threading.Thread, int]:
    """Something at a port that answers one master in its own way."""
    server = socket.create_server(("127.0.0.1", 0))

    def run() -> None:
        with server:
            stream, _ = server.accept()
            link = Link(stream)
            try:
                say(link)
            finally:
                link.close()

    thread = threading.Thread(target=run)
    thread.start()
    return thread, server.getsockname()[1]


def introduce(link: Link) -> None:
    """Answer HELLO with no JSON."""
    _, sequence, _ = link.receive(5.0)
    link.send(Kind.OK, sequence, b"good morning")


def misnumber(link: Link) -> None:
    """Answer a question that was not asked."""
    _, sequence, _ = link.receive(5.0)
    link.send(Kind.OK, sequence + 7)


@pytest.mark.parametrize(
    ("say", "words"),
    [
        (
            lambda link: link.stream.sendall(b"HTTP/1.1 400 Bad Request\r\n\r\n"),
            "sent a malformed frame: b'HTTP/1.1 400 Bad Req' is no header",
        ),
        (lambda link: link.stream.sendall(HEADER.pack(MAGIC, 1, 100, 0, 1 << 30, 1)), "is no header"),
        (introduce, "sent a malformed frame: no JSON"),
        (misnumber, "sent a malformed frame: OK with number 8 answers nothing"),
        (lambda link: link.receive(5.0) and link.send(Kind.OK, 1, b"{}"), "it does not introduce itself: inputs must be there"),
        (lambda link: None, "is gone"),
    ],
)
def test_what_is_no_unit_is_recognised(say: Callable[[Link], None], words: str, cosim: Callable[..., Any]) -> None:
    thread, port = talker(say)
    code, out, err = cosim("run", "wheel-pair", "--in-process", "--stop", "0.1", "--gyro", f"tcp://127.0.0.1:{port}")
    thread.join(10.0)
    assert (code, out, err.count("\n")) == (1, "", 1)
    assert words in err


def test_a_malformed_frame_in_the_middle_stops_the_run_and_keeps_its_results() -> None:
    class Babbling(Lagging):
        def output(self, u: np.ndarray, t: float) -> np.ndarray:
            y = super().output(u, t)
            return y[:3] if t > 0.1 else y

    with offered(Babbling(unit(), lambda t: 0.0)) as port:
        message, run = partial(PLAN.with_source("gyro", f"tcp://127.0.0.1:{port}"))
    assert "sent a malformed frame: 24 bytes are not 6 numbers" in message
    assert len(run.trajectory) > 10


def test_a_failure_of_the_unit_itself_comes_through() -> None:
    class Broken(Lagging):
        def step(self, U: np.ndarray, t: float, h: float) -> None:
            if t > 0.1:
                raise SlaveError("unit", t, h, "the gimbal has come off")

    with offered(Broken(unit(), lambda t: 0.0)) as port:
        message, run = partial(PLAN.with_source("gyro", f"tcp://127.0.0.1:{port}"))
    assert "the gimbal has come off" in message
    assert len(run.trajectory) > 10


@pytest.mark.parametrize(
    ("source", "code", "words"),
    [
        ("tcp://127.0.0.1:1", 1, "the unit at tcp://127.0.0.1:1 does not answer: Connection refused"),
        ("tcp://127.0.0.1", 2, "must be tcp://HOST:PORT"),
        ("tcp://127.0.0.1:99999", 2, "must be tcp://HOST:PORT"),
        ("tcp://127.0.0.1:1?late=maybe", 2, "late must be hold, extrapolate or stop, got 'maybe'"),
        ("tcp://127.0.0.1:1?timeout=-1ms", 2, "timeout must be positive, got -0.001 s"),
        ("tcp://127.0.0.1:1?timeout=soon", 2, "must be a number"),
        ("tcp://127.0.0.1:1?patient=3", 2, "unknown option 'patient'; did you mean 'patience'?"),
        ("process:gyro_unit:nonlineer", 1, "did you mean 'nonlinear'?"),
    ],
)
def test_units_that_are_not_there_are_one_line(source: str, code: int, words: str, cosim: Callable[..., Any]) -> None:
    got, out, err = cosim("run", "wheel-pair", "--in-process", "--stop", "0.1", "--gyro", source)
    assert (got, out, err.count("\n")) == (code, "", 1)
    assert words in err
    assert not children()


def test_terms_come_with_units() -> None:
    place, terms = parse("tcp://rig:5000?timeout=0.5ms&late=extrapolate&patience=20")
    assert (place, terms.timeout, terms.late, terms.patience) == ("tcp://rig:5000", 5e-4, "extrapolate", 20)


def test_a_server_sends_nonsense_away_and_goes_on() -> None:
    here, there = socket.socketpair()
    slave = unit()
    thread = threading.Thread(target=serve, args=(slave, Link(there)))
    thread.start()
    here.sendall(b"\0" * 100)
    thread.join(10.0)
    assert not thread.is_alive()
    here.close()
    there.close()
    slave.close()
    with pytest.raises(ProtocolError, match="3 bytes are not 1 numbers"):
        array(b"123", 1)


def test_serve_is_a_command(cosim: Callable[..., Any]) -> None:
    with subprocess.Popen(
        [sys.executable, "-m", "gyro_cosim", "serve", "gyro_unit:nonlinear", "--once"], stderr=subprocess.PIPE, text=True
    ) as server:
        assert server.stderr is not None
        place = server.stderr.readline().split()[-1]
        code, _, err = cosim("run", "wheel-pair", "--in-process", "--stop", "0.1", "--gyro", place)
        assert (code, err) == (0, "")
        assert server.wait(10) == 0
