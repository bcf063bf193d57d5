"""Clocks of FMI 3.0: ticked at their own times, passed on from component to component, with what changes at a tick."""

import json
import re
import threading
import time
import zipfile
from dataclasses import replace
from pathlib import Path
from typing import Any

import clock_fmus
import numpy as np
import pytest

from gyro_cosim import Connection, GaussSeidel, Iterated, Jacobi, SlaveError, System, SystemComponent, WiringError, simulate
from gyro_cosim import system as read_system
from gyro_cosim.master import Options, open_network, run
from gyro_cosim.master.checkpoint import Checkpoint, Resume
from gyro_cosim.slaves import open_slave, tunable
from gyro_cosim.slaves.base import Clocked, Texting
from gyro_cosim.slaves.processes.listening import listen
from gyro_cosim.slaves.processes.messages import answered
from gyro_cosim.slaves.processes.protocol import Kind
from gyro_cosim.ssp.packing import pack
from gyro_cosim.systems import Port
from gyro_cosim.systems.scenario import Event, Scenario


def system(*parts: tuple[str, Path, dict[str, Any]], wires: tuple[str, ...] = ()) -> System:
    ends = [tuple(tuple(end.split(".")) for end in wire.split(" -> ")) for wire in wires]
    return System("s", tuple(SystemComponent(n, str(f), v) for n, f, v in parts), tuple(Connection(*pair) for pair in ends))


WHEN = {  # s, up to 1
    "constant": np.arange(0.0, 1.05, 0.1), "fixed": np.arange(0.05, 1.0, 0.1),
    "tunable": np.arange(0.0, 1.05, 0.1), "changing": 0.1 * np.array([0, 1, 3, 6, 10]),
    "countdown": 0.1 * np.array([1, 2, 4, 7]), "from parameters": np.arange(0.05, 1.0, 0.1),
}  # fmt: skip


@pytest.mark.parametrize("exchange", [False, True], ids=["co-simulation", "model exchange"])
@pytest.mark.parametrize("kind", clock_fmus.KINDS)
def test_a_clock_of_any_kind_ticks_at_its_own_times_whatever_the_macro_step(kind: str, exchange: bool, tmp_path: Path) -> None:
    """The FMU itself refuses a tick at any other time, and a step beyond one."""
    file = clock_fmus.clocks(tmp_path, kind, exchange=exchange)
    for step in (0.04, 1.0):
        done = simulate(system(("a", file, {"v": 3.0, "kind": clock_fmus.KINDS.index(kind)})), step=step, stop=1.0)
        t = done.trajectory.t
        ticks = np.array([np.sum(WHEN[kind] <= now + 1e-9) for now in t])
        np.testing.assert_array_equal(done.trajectory["a.ticks"], ticks)
        since = np.maximum(t - WHEN[kind][0], 0.0)
        np.testing.assert_allclose(done.trajectory["a.x"], 3.0 * since, rtol=0, atol=1e-9)


@pytest.mark.parametrize("isolate", [False, True], ids=["here", "isolated"])
@pytest.mark.parametrize("algorithm", [Jacobi(1), GaussSeidel(1), Iterated(1)], ids=["jacobi", "gauss-seidel", "iterated"])
@pytest.mark.parametrize("exchange", [False, True], ids=["co-simulation", "model exchange"])
def test_a_tick_arrives_at_its_own_time_with_what_changes_there(
    exchange: bool, algorithm: Any, isolate: bool, tmp_path: Path
) -> None:
    """a.out ticks at 0.1, 0.3, 0.5, ... with ticks = 1, 3, 5, ... there (before the update); b stands before a in the system."""
    file = clock_fmus.clocks(tmp_path, exchange=exchange)
    wires = ("a.out -> b.go", "a.last -> b.u", "b.answer -> c.letter", "b.out -> c.go", "b.goes -> c.u")
    plan = system(("c", file, {}), ("b", file, {"each": 0}), ("a", file, {}), wires=wires)
    done = simulate(plan, step=0.25, stop=1.0, algorithm=algorithm, isolate=isolate)
    of = done.trajectory
    np.testing.assert_array_equal(of["b.goes"], [0, 1, 3, 4, 5])
    # at 0.1, 0.3, ... a's last tick was at 0, 0.2, ...: the tick comes before the update
    np.testing.assert_allclose(of["b.sum"], np.cumsum([0, 0.0, 0.2 + 0.4, 0.6, 0.8]), atol=1e-12)
    np.testing.assert_array_equal(of["c.goes"], of["b.goes"])
    np.testing.assert_array_equal(of["c.sum"], np.cumsum([0, 0, 1 + 2, 3, 4]))


def test_a_binary_that_belongs_to_a_clock_arrives_with_its_tick(tmp_path: Path) -> None:
    """So messages travel on a bus: each as it was at the tick that says it is there, also three in one step."""
    file = clock_fmus.clocks(tmp_path)
    plan = system(
        ("a", file, {}), ("b", file, {"letter": b"abc", "each": 0}), ("c", file, {"each": 0}),
        wires=("a.out -> b.go", "b.out -> c.go", "b.answer -> c.letter"),
    )  # fmt: skip
    with open_network(plan) as network:
        run(network, Jacobi(0), 0.5, 0.5)
        c = network.slaves[2]
        assert isinstance(c, Texting)
        assert c.texts(0.5) == (b"2abc3",)  # b had ticked twice before it sent the last one


def test_clocks_in_a_circle_tick_at_the_next_communication_point_and_that_is_told(tmp_path: Path) -> None:
    file = clock_fmus.clocks(tmp_path)
    plan = system(("a", file, {"each": 3}), ("b", file, {"each": 0}), wires=("a.out -> b.go", "b.out -> a.go", "b.goes -> a.u"))
    done = simulate(plan, step=0.25, stop=0.5)
    # a ticks at 0.2 and 0.5 by itself, and again for each tick that comes back
    assert done.trajectory["b.goes"].tolist() == [0, 1, 3]
    assert done.trajectory["a.goes"].tolist() == [0, 0, 1]
    assert [note for note in done.notes if "circle" in note] == [
        "connection b.out -> a.go: clocks tick one another in a circle, these ticks come at the communication point that follows"
    ]


@pytest.mark.parametrize("exchange", [False, True], ids=["co-simulation", "model exchange"])
def test_a_run_that_is_resumed_remembers_its_ticks(exchange: bool, tmp_path: Path) -> None:
    """What has ticked and nobody has taken, what is expected, and when clocks tick next are a part of its state."""
    file = clock_fmus.clocks(tmp_path, "changing", exchange=exchange)
    given = {"kind": clock_fmus.KINDS.index("changing"), "interval": 0.03}
    wires = ("a.out -> b.go", "a.last -> b.u", "b.out -> a.go", "b.sum -> a.u")
    plan = system(("a", file, given), ("b", file, {**given, "each": 0}), wires=wires)

    def kill(k: int) -> None:
        if k == 14:
            raise KeyboardInterrupt

    whole = simulate(plan, step=0.05, stop=1.0)
    simulate(plan, step=0.05, stop=1.0, before_step=kill, options=Options(checkpoint=Checkpoint(tmp_path / "c.npz", 0.1)))
    again = simulate(plan, step=0.05, stop=1.0, options=Options(resume=Resume(tmp_path / "c.npz")))
    np.testing.assert_array_equal(again.trajectory.values, whole.trajectory.values)
    assert again.events == whole.events
    assert whole.trajectory["a.goes"][-1] > 3


def test_an_interval_that_is_tuned_counts_from_the_last_tick_on(tmp_path: Path) -> None:
    slave = open_slave("a", str(clock_fmus.clocks(tmp_path, "tunable")))
    able = tunable(slave)
    assert able is not None
    slave.initialize({"kind": float(clock_fmus.KINDS.index("tunable"))}, 0.0, 1.0)
    U = np.zeros((3, len(slave.inputs)))
    slave.step(U, 0.0, 0.25)
    able.tune({"interval": 0.3}, 0.25)  # the last tick was at 0.2
    slave.step(U, 0.25, 0.2)
    names = [s.name for s in slave.outputs]
    assert slave.output(U[0], 0.45)[names.index("ticks")] == 3
    slave.step(U, 0.45, 0.1)
    assert slave.output(U[0], 0.55)[[names.index("ticks"), names.index("last")]].tolist() == [4, 0.5]
    slave.close()


@pytest.mark.parametrize("exchange", [False, True], ids=["co-simulation", "model exchange"])
@pytest.mark.parametrize(("kind", "first"), [("fixed", 0.05), ("tunable", 0.0)])
def test_the_interval_of_a_clock_can_be_given_by_whoever_runs_the_fmu(
    kind: str, first: float, exchange: bool, tmp_path: Path
) -> None:
    """Where the description states one (FMI 3.0.2, 2.2.9.3); the shift is the description's."""
    file = clock_fmus.clocks(tmp_path, kind, exchange=exchange)
    given = {"kind": clock_fmus.KINDS.index(kind), "every": "250 ms", "v": 3.0}
    done = simulate(system(("a", file, given)), step=0.04, stop=1.0).trajectory
    np.testing.assert_array_equal(done["a.ticks"], np.floor((done.t - first) / 0.25 + 1e-6) + 1)


@pytest.mark.parametrize("isolate", [False, True], ids=["here", "isolated"])
@pytest.mark.parametrize("exchange", [False, True], ids=["co-simulation", "model exchange"])
def test_a_scenario_gives_a_tunable_clock_another_interval(exchange: bool, isolate: bool, tmp_path: Path) -> None:
    """Ticks at 0, 0.1, 0.2, 0.3; from 0.35 on 0.2 after the last one: 0.5, 0.7, 0.9."""
    file = clock_fmus.clocks(tmp_path, "tunable", exchange=exchange)
    plan = system(("a", file, {"kind": clock_fmus.KINDS.index("tunable")}))
    events = Scenario((Event(0.35, "set", "a.every", value=0.2),))
    done = simulate(replace(plan, scenario=events), step=0.05, stop=1.0, isolate=isolate).trajectory
    ticks = np.array([0, 0.1, 0.2, 0.3, 0.5, 0.7, 0.9])
    np.testing.assert_array_equal(done["a.ticks"], [np.sum(ticks <= t + 1e-9) for t in done.t])


@pytest.mark.parametrize(
    ("kind", "value", "words"),
    [
        ("fixed", "0 s", "a.every: must be at least 1e-12 s, got 0 s"),
        ("fixed", "3 m", "a.every: unit 'm' cannot be expressed in 's'"),
        ("constant", "1 s", "a.every must be something that takes a value, is a Clock with an interval of its own"),
        ("from parameters", "1 s", "a.every must be something that takes a value, is a Clock with an interval of its own"),
    ],
)
def test_an_interval_that_cannot_be_given_is_refused(kind: str, value: str, words: str, tmp_path: Path) -> None:
    file = clock_fmus.clocks(tmp_path, kind)
    with pytest.raises(ValueError, match=re.escape(words)):
        simulate(system(("a", file, {"kind": clock_fmus.KINDS.index(kind), "every": value})), step=0.1, stop=0.1)


@pytest.mark.parametrize(
    ("wire", "words"),
    [
        ("a.out -> b.every", "connection a.out -> b.every: b.every is a Clock with an interval of its own, which takes no part"),
        ("a.goes -> b.go", "connection a.goes -> b.go: b.go is a clock, a.goes must be an output clock and is none"),
        ("a.out -> b.u", "types must fit: a.out is a clock, the other end is none"),
    ],
)
def test_clocks_that_cannot_be_joined_are_refused(wire: str, words: str, tmp_path: Path) -> None:
    file = clock_fmus.clocks(tmp_path)
    with pytest.raises(WiringError, match=re.escape(words)):
        simulate(system(("a", file, {}), ("b", file, {}), wires=(wire,)), step=0.1, stop=0.1)


def test_an_fmu_whose_steps_must_not_vary_can_have_ticks_at_their_ends_only(tmp_path: Path) -> None:
    file = clock_fmus.clocks(tmp_path, variable=False)
    assert simulate(system(("a", file, {})), step=0.05, stop=1.0).trajectory["a.ticks"][-1] == 11
    with pytest.raises(SlaveError, match=r"a clock ticks at t = 0\.1 s"):
        simulate(system(("a", file, {})), step=0.04, stop=1.0)


@pytest.mark.parametrize("version", ["1.0", "2.0"])
def test_a_system_with_clocks_is_packed_and_runs_from_its_package(version: str, tmp_path: Path) -> None:
    """SSP 2.0 has a type for clocks; SSP 1.0 has none, and says none of them."""
    file = clock_fmus.clocks(tmp_path)
    plan = system(("a", file, {}), ("b", file, {"each": 0}), wires=("a.out -> b.go", "a.last -> b.u"))
    package = pack(plan, tmp_path / "clocks.ssp", version=version)
    written = zipfile.ZipFile(package).read("SystemStructure.ssd").decode()
    assert written.count('<ssc:Clock intervalVariability="triggered"/>') == (2 if version == "2.0" else 0)
    of = simulate(read_system(str(package)), step=0.25, stop=1.0).trajectory
    np.testing.assert_array_equal(of["b.goes"], [0, 1, 3, 4, 5])
    assert of["b.sum"][-1] == pytest.approx(2.0)


@pytest.mark.parametrize(
    ("clock", "words"),
    [
        ("og", "unknown clock of connector b.u: 'og'; known: every, go, out"),
        ("every", "must have the clocks go, the system file says"),
    ],
)
def test_a_clock_that_a_connector_does_not_have_is_refused(clock: str, words: str, tmp_path: Path) -> None:
    file = clock_fmus.clocks(tmp_path)
    ports = {"u": Port("input", clocks=(clock,))}
    plan = System("s", (SystemComponent("b", str(file), ports=ports),), ())
    with pytest.raises(ValueError, match=re.escape(words)):
        simulate(plan, step=0.1, stop=0.1)


def test_a_clock_with_an_interval_of_its_own_ticks_those_of_others(tmp_path: Path) -> None:
    """As the clock of a bus does, whose message is there when its countdown is over: 0.1, 0.2, 0.4, 0.7."""
    file = clock_fmus.clocks(tmp_path, "countdown")
    given = {"kind": clock_fmus.KINDS.index("countdown"), "letter": b"x"}
    plan = system(
        ("b", clock_fmus.clocks(tmp_path), {"each": 0}), ("a", file, given),
        wires=("a.every -> b.go", "a.answer -> b.letter", "a.ticks -> b.u"),
    )  # fmt: skip
    done = simulate(plan, step=0.25, stop=1.0)
    assert done.trajectory["b.goes"].tolist() == [0, 2, 3, 4, 4]
    assert done.trajectory["b.sum"].tolist() == [0, 0 + 1, 1 + 2, 3 + 3, 6]


def test_clocks_and_texts_of_a_unit_elsewhere_arrive_like_those_of_one_that_is_here(tmp_path: Path) -> None:
    file = clock_fmus.clocks(tmp_path)
    wires = ("a.out -> b.go", "a.last -> b.u", "b.out -> c.go", "b.answer -> c.letter", "b.goes -> c.u")
    values = [("a", {}), ("b", {"letter": b"abc", "each": 0}), ("c", {"each": 0})]
    here = simulate(system(*((n, file, v) for n, v in values), wires=wires), step=0.25, stop=1.0)
    there = simulate(system(*((n, f"process:{file}", v) for n, v in values), wires=wires), step=0.25, stop=1.0)  # type: ignore[misc]
    np.testing.assert_array_equal(there.trajectory.values, here.trajectory.values)
    assert there.trajectory["c.goes"][-1] > 3


def test_a_unit_elsewhere_changes_its_parameters_on_the_way(tmp_path: Path) -> None:
    """In event mode, as here."""
    file = clock_fmus.clocks(tmp_path, "tunable")
    given, events = {"kind": clock_fmus.KINDS.index("tunable")}, Scenario((Event(0.35, "set", "a.interval", value=0.2),))
    runs = [
        simulate(replace(system(("a", source, given)), scenario=events), step=0.05, stop=1.0)  # type: ignore[arg-type]
        for source in (file, f"process:{file}")
    ]
    np.testing.assert_array_equal(runs[1].trajectory.values, runs[0].trajectory.values)
    assert runs[0].trajectory["a.ticks"][-1] == 7


def test_where_answers_may_be_missing_no_clock_can_be_joined(tmp_path: Path) -> None:
    file = clock_fmus.clocks(tmp_path)
    plan = system(("a", file, {}), ("b", f"process:{file}?late=hold", {}), wires=("a.out -> b.go",))  # type: ignore[arg-type]
    with pytest.raises(WiringError, match=re.escape("b.go is a Clock of a unit that tells of none in time")):
        simulate(plan, step=0.25, stop=1.0)


@pytest.mark.parametrize(
    ("kind", "content", "words"),
    [
        (Kind.TUNE, {"values": {"each": 3.0}, "t": 0.0}, "'each' must be a parameter that may change on the way"),
        (Kind.TUNE, {"values": {"every": -1.0}, "t": 0.0}, "every: must be at least 1e-12 s, got -1.0"),
        (Kind.GIVE_TEXTS, {"values": {"letter": "abc"}, "t": 0.0}, "'letter' must be a text input, and bytes its value"),
        (Kind.EXPECT, {"ticks": [[0.1, ["out"], [], [], {}]]}, "'out' must be an input clock"),
        (Kind.EXPECT, {"ticks": [[0.1, ["go"], [], [[9, 1.0]], {}]]}, "a tick must tell of inputs 0 to 2"),
        (Kind.EXPECT, {"ticks": [["inf", ["go"], [], [], {}]]}, "a tick must have finite numbers"),
        (Kind.EXPECT, {"ticks": 3}, "ticks must be a list of at most 100000"),
        (Kind.EXPECT, {"ticks": [3]}, "no tick: "),
    ],
)
def test_a_unit_believes_no_message(kind: Kind, content: dict[str, Any], words: str, tmp_path: Path) -> None:
    slave = open_slave("a", str(clock_fmus.clocks(tmp_path, "tunable")))
    slave.initialize({"kind": float(clock_fmus.KINDS.index("tunable"))}, 0.0, 1.0)
    with pytest.raises(ValueError, match=re.escape(words)):
        answered(slave, kind, json.dumps(content).encode())
    slave.close()


class Slow(Clocked):
    """Passes everything on, but takes its time to tell what has ticked in its second step."""

    def __init__(self, slave: Any) -> None:
        self._slave, self.name, self.description, self._steps = slave, slave.name, slave.description, 0

    def begin(self, values: Any, t: float, stop: float) -> None:
        self._slave.begin(values, t, stop)

    def finish(self) -> None:
        self._slave.finish()

    def output(self, u: np.ndarray, t: float) -> Any:
        return self._slave.output(u, t)

    def step(self, U: np.ndarray, t: float, h: float) -> None:
        self._steps += 1
        self._slave.step(U, t, h)

    def expect(self, ticks: Any) -> None:
        self._slave.expect(ticks)

    def take_ticks(self) -> Any:
        time.sleep(0.5 if self._steps == 2 else 0.0)
        return self._slave.take_ticks()

    def close(self) -> None:
        self._slave.close()


def test_a_unit_that_does_not_tell_its_ticks_in_time_stops_the_run(tmp_path: Path) -> None:
    file, ports = clock_fmus.clocks(tmp_path), []
    slave = Slow(open_slave("unit", str(file)))
    thread = threading.Thread(target=listen, args=(slave, ("127.0.0.1", 0)), kwargs={"once": True, "ready": ports.append})
    thread.start()
    while not ports:
        time.sleep(1e-3)
    there = f"tcp://127.0.0.1:{ports[0]}?timeout=100ms"
    plan = system(("a", there, {}), ("b", file, {"each": 0}), wires=("a.out -> b.go",))  # type: ignore[arg-type]
    with pytest.raises(SlaveError, match=r"gave no answer to TAKE_TICKS within 0\.1 s"):
        simulate(plan, step=0.25, stop=1.0)
    thread.join(10.0)
    slave.close()


def test_an_interval_is_refused_where_no_clock_ticks(tmp_path: Path) -> None:
    """Event mode can turn out to be refused after the interval has been given."""
    slave = open_slave("a", str(clock_fmus.clocks(tmp_path, "tunable")))
    slave._adopt(replace(slave.description, counts_events=False))  # type: ignore[attr-defined]
    with pytest.raises(SlaveError, match="clock 'every' ticks in event mode only, in which the FMU cannot be run"):
        slave.begin({"every": 0.2}, 0.0, 1.0)
    slave.close()
