"""FMUs for Model Exchange as slaves: CVODE integrates, events are where they belong, and each refusal is one line."""

from collections.abc import Callable
from pathlib import Path
from typing import Any

import exchange_fmus
import numpy as np
import pytest
import small_fmus
from test_events import G, flight

from gyro_cosim import Algorithm, Connection, Iterated, Jacobi, SlaveError, System, SystemComponent, simulate, ssp
from gyro_cosim.export import pack_fmu
from gyro_cosim.slaves import open_slave, restorable
from gyro_cosim.slaves.described import described_slave
from gyro_cosim.slaves.exchange.integrator import Integrator
from gyro_cosim.ssp.packing import pack
from gyro_cosim.systems import Conversion


def one(file: Path, **values: float) -> System:
    return System("s", (SystemComponent("a", str(file), values),), ())


@pytest.fixture(params=[2, 3], ids=["FMI 2.0", "FMI 3.0"])
def version(request: pytest.FixtureRequest) -> int:
    return int(request.param)


@pytest.mark.parametrize(("step", "isolate"), [(0.01, False), (0.37, False), (0.37, True)])
def test_every_impact_is_at_its_own_time_whatever_the_step(step: float, isolate: bool, version: int, tmp_path: Path) -> None:
    done = simulate(one(exchange_fmus.hopper(tmp_path, version)), step=step, stop=1.85, isolate=isolate)
    h, hits = flight(done.trajectory.t)
    np.testing.assert_allclose(done.trajectory["a.h"], h, rtol=0, atol=1e-7)
    np.testing.assert_array_equal(done.trajectory["a.impacts"], hits)
    assert done.events == {"a": hits[-1]} == {"a": 4}


def test_nominal_values_set_the_absolute_tolerance_also_when_they_change(version: int, tmp_path: Path) -> None:
    """The speck is 1e-6, then 1e-12, ...: an absolute tolerance that forgets it would see it as nothing."""
    done = simulate(one(exchange_fmus.hopper(tmp_path, version)), step=0.1, stop=1.9)
    t, hits = done.trajectory.t, done.trajectory["a.impacts"]
    assert hits[-1] == 4
    np.testing.assert_allclose(done.trajectory["a.speck"], 1e-6 ** (1 + hits) * np.exp(-t), rtol=1e-6)


@pytest.mark.parametrize("start", [0.0, 0.15])
@pytest.mark.parametrize("step", [0.07, 0.05])
def test_announced_times_are_hit_exactly(step: float, start: float, version: int, tmp_path: Path) -> None:
    """The hopper refuses a step past a tick, and takes none for one that comes a hair too early."""
    done = simulate(one(exchange_fmus.hopper(tmp_path, version), period=0.1), step=step, start=start, stop=0.44)
    np.testing.assert_array_equal(done.trajectory["a.ticks"], np.floor(done.trajectory.t / 0.1 + 1e-9))


def test_step_events_happen_where_the_fmu_asks_for_them(version: int, tmp_path: Path) -> None:
    done = simulate(one(exchange_fmus.hopper(tmp_path, version), every=10), step=0.05, stop=0.4)
    nudges = int(done.trajectory["a.nudges"][-1])
    assert nudges > 3
    assert done.events == {"a": nudges}
    deaf = simulate(one(exchange_fmus.hopper(tmp_path, version, hears=False), every=10), step=0.05, stop=0.4)
    assert deaf.events == {"a": 0}  # it has said that it need not hear of steps
    np.testing.assert_allclose(done.trajectory["a.h"], deaf.trajectory["a.h"], rtol=0, atol=1e-5)  # 200 restarts


def test_inputs_are_followed_as_polynomials_and_their_jumps_are_seen(version: int, tmp_path: Path) -> None:
    slave = open_slave("a", str(exchange_fmus.hopper(tmp_path, version)))
    slave.initialize({}, 0.0, 1.0)
    places = {s.name: k for k, s in enumerate(slave.inputs)}
    U = np.zeros((3, len(slave.inputs)))
    U[:, places["u"]] = 0.25, 0.5, 6.0  # u(s) = 0.25 + s / 2 + 3 s^2 crosses 0.5 at s = 0.2171 s
    slave.step(U, 0.0, 0.3)
    outputs = dict(zip([s.name for s in slave.outputs], slave.output(U[0], 0.3), strict=True))
    s = 0.3
    assert outputs["h"] == pytest.approx(1.0 - G * s**2 / 2 + 0.25 * s**2 / 2 + 0.5 * s**3 / 6 + 6.0 * s**4 / 24, abs=1e-7)
    assert (outputs["above"], slave.counts.events) == (1.0, 1)  # type: ignore[attr-defined]
    U[:] = 0.0
    slave.step(U, 0.3, 0.1)  # down with a jump: no root lies on the way, and yet it is an event
    assert slave.output(U[0], 0.4)[[s.name for s in slave.outputs].index("above")] == 0.0
    assert slave.counts.events == 2  # type: ignore[attr-defined]
    slave.close()


def test_a_discrete_input_changes_in_event_mode(version: int, tmp_path: Path) -> None:
    """Each impact of the first kicks the second, once; the hopper refuses it in any other mode."""
    file = str(exchange_fmus.hopper(tmp_path, version))
    plan = System(
        "s", (SystemComponent("a", file), SystemComponent("b", file, {"h": 50.0})), (Connection(("a", "impacts"), ("b", "kick")),)
    )
    done = simulate(plan, step=0.01, stop=1.5)
    assert done.events == {"a": 2, "b": 2}
    t = done.trajectory.t
    kicks = [t[k] for k in np.flatnonzero(np.diff(done.trajectory["a.impacts"]) > 0) + 1]
    np.testing.assert_allclose(done.trajectory["b.v"], -G * t + np.sum([t >= kick for kick in kicks], axis=0), rtol=0, atol=1e-6)


def test_an_event_and_a_completed_step_can_end_the_run(version: int, tmp_path: Path) -> None:
    file = exchange_fmus.hopper(tmp_path, version)
    third = np.sqrt(2.0 / G) * (1 + 2 * 0.7 + 2 * 0.7**2)
    done = simulate(one(file, last=3), step=0.1, stop=2.0)
    assert (done.status, done.trajectory.t[-1]) == ("ended", pytest.approx(1.5))
    assert f"component 'a' asks to end the run at t = {third:.5f}"[:-1] in done.ended_by
    done = simulate(one(file, fault=6), step=0.1, stop=2.0)
    assert (done.status, done.trajectory.t[-1]) == ("ended", pytest.approx(0.2))


@pytest.mark.parametrize(
    ("fault", "words"),
    [
        (1, r"failed at t = 0\.2\d* s.*Derivatives answered error; it says: the air is too thin \[logStatusError\]"),
        (2, r"failed at t = .*steps of the integrator must reach the end.*Derivatives answered discard at t = 0\.2"),
        (3, r"failed at t = .*steps of the integrator must reach the end.*'der\(v\)' must be finite, is nan at t = 0\.2"),
        (4, r"failed at t = 0\.45\d* s.*the discrete states must settle, they do not in 1000 updates"),
        (5, r"the FMU must get on, stays at t = 0\.45\d* s for 1000 events"),
    ],
)
def test_what_fails_is_told_in_one_line_with_the_fmus_own_words(fault: int, words: str, version: int, tmp_path: Path) -> None:
    with pytest.raises(SlaveError, match=words) as caught:
        simulate(one(exchange_fmus.hopper(tmp_path, version), fault=fault), step=0.1, stop=1.0)
    assert "\n" not in str(caught.value)


@pytest.mark.parametrize("name", ["gyro_unit:nonlinear", "sampled", "gain"])
@pytest.mark.parametrize("isolate", [False, True], ids=["here", "isolated"])
def test_model_exchange_and_co_simulation_agree(name: str, isolate: bool, built: Callable, version: int) -> None:
    """The same FMU by both interfaces: with states, with samples that are time events, with neither."""
    component, file, _ = built(name, str(version))
    start = {v.name: 0.3 for v in component.inputs}
    plan = System("s", (SystemComponent("a", str(file), start),), ())
    exact = simulate(plan, step=0.0099, stop=0.5)  # at no point but the first is there a sample
    got = simulate(plan.with_implementation("a", "ModelExchange"), step=0.0099, stop=0.5, isolate=isolate)
    for signal in exact.trajectory.names:
        a, b = got.trajectory[signal][1:], exact.trajectory[signal][1:]
        np.testing.assert_allclose(a, b, rtol=0, atol=1e-6 * np.abs(b).max() + 1e-12, err_msg=signal)
    assert got.events == {"a": 71 if name == "sampled" else 0}


@pytest.mark.parametrize(
    "algorithm", [Jacobi(0), Jacobi(2), pytest.param(Iterated(1), marks=pytest.mark.slow)], ids=lambda a: f"{a.name} {a.degree}"
)
def test_algorithms_keep_their_order(algorithm: Algorithm, built: Callable) -> None:
    """Two pendulums that drive one another, against the same by Co-Simulation over small steps."""
    _, file, _ = built("plain", "2")
    drive = (Conversion(suppress=True, factor=4.0),)
    wires = tuple(Connection((a, "phi"), (b, "u"), drive) for a, b in (("a", "b"), ("b", "a")))
    parts = tuple(SystemComponent(name, str(file), {"phi": phi}) for name, phi in (("a", 0.5), ("b", -0.2)))
    plan = System("s", parts, wires)
    exact = simulate(plan, algorithm=Jacobi(2), step=1e-3, stop=1.0).trajectory.values[-1]
    for name in "ab":
        plan = plan.with_implementation(name, "ModelExchange")
    h = 0.1 / 2.0 ** np.arange(4)
    error = [np.abs(simulate(plan, algorithm=algorithm, step=h_i, stop=1.0).trajectory.values[-1] - exact).max() for h_i in h]
    assert np.polyfit(np.log(h), np.log(error), 1)[0] == pytest.approx(algorithm.order, abs=0.15)


@pytest.mark.parametrize("attributes", [(), ("canGetAndSetFMUstate", "canSerializeFMUstate")], ids=["its state", "its numbers"])
def test_an_fmu_is_saved_written_and_brought_back(attributes: tuple[str, ...], built: Callable, tmp_path: Path) -> None:
    """By its own state, or by time and continuous states where it remembers nothing else."""
    _, file, _ = built("plain", "2")
    slave: Any = open_slave("a", str(exchange_fmus.without(file, tmp_path / "plain.fmu", *attributes)))
    slave.initialize({}, 0.0, 1.0)
    U = np.array([[0.5], [1.0], [0.0]])
    slave.step(U, 0.0, 0.3)
    saved, written = slave.save(), slave.serialize()
    slave.step(U, 0.3, 0.2)
    expected = slave.output(U[0], 0.5)
    slave.restore(saved)
    slave.step(U, 0.3, 0.2)
    np.testing.assert_array_equal(slave.output(U[0], 0.5), expected)
    slave.discard(saved)
    slave.initialize({}, 0.0, 1.0)
    slave.deserialize(written)
    slave.step(U, 0.3, 0.2)
    np.testing.assert_array_equal(slave.output(U[0], 0.5), expected)
    slave.close()


def test_an_fmu_that_cannot_save_its_state_says_so(version: int, tmp_path: Path) -> None:
    """It counts, so that time and continuous states would not bring it back."""
    slave = open_slave("a", str(exchange_fmus.hopper(tmp_path, version, restores=False)))
    assert restorable(slave) is None
    slave.close()


def test_a_restored_state_repeats_the_step_bit_for_bit(version: int, tmp_path: Path) -> None:
    slave: Any = open_slave("a", str(exchange_fmus.hopper(tmp_path, version)))
    slave.initialize({"period": 0.07}, 0.0, 1.0)
    U = np.zeros((3, len(slave.inputs)))
    slave.step(U, 0.0, 0.3)
    saved = slave.save()
    before = slave.counts.events
    ways = []
    for _ in range(2):
        slave.step(U, 0.3, 0.25)
        ways.append((slave.output(U[0], 0.55), slave.counts.events))
        slave.restore(saved)
        assert slave.counts.events == before
    slave.discard(saved)
    slave.close()
    np.testing.assert_array_equal(ways[0][0], ways[1][0])
    assert ways[0][1] == ways[1][1] > before


def test_a_far_jump_of_an_input_begins_anew_and_small_ones_do_not(version: int, tmp_path: Path, monkeypatch: Any) -> None:
    begun = []
    restart = Integrator.restart
    monkeypatch.setattr(Integrator, "restart", lambda self, t, *how: (begun.append(t), restart(self, t, *how))[1])
    slave: Any = open_slave("a", str(exchange_fmus.hopper(tmp_path, version)))
    slave.initialize({"h": 10.0}, 0.0, 1.0)
    u = np.zeros((3, len(slave.inputs)))
    place = [s.name for s in slave.inputs].index("u")
    v = 0.0
    for k, size in enumerate([0.1, 0.1 + 1e-9, 0.1, 3.1, 3.1]):
        u[0, place] = size
        slave.step(u, 0.1 * k, 0.1)
        v += 0.1 * (size - G)
    assert begun == pytest.approx([0.0, 0.3])
    assert dict(zip([s.name for s in slave.outputs], slave.output(u[0], 0.5), strict=True))["v"] == pytest.approx(v, abs=1e-7)
    slave.close()


def test_a_system_file_says_which_interface_and_pack_keeps_it(tmp_path: Path, built: Callable) -> None:
    _, file, _ = built("plain", "2")
    plan = System("s", (SystemComponent("a", str(file)),), ()).with_implementation("a", "ModelExchange")
    again = ssp.read(pack(plan, tmp_path / "s.ssp"))
    assert [c.implementation for c in again.components] == ["ModelExchange"]
    assert simulate(again, step=0.1, stop=0.2).events == {"a": 0}
    assert again.with_source("a", "plain.fmu").components[0].implementation == ""  # it was said of the other FMU


def test_what_cannot_run_by_model_exchange_is_refused_in_one_line(tmp_path: Path, built: Callable) -> None:
    _, file, _ = built("plain", "2")
    plan = System("s", (SystemComponent("a", str(file)),), ()).with_implementation("a", "ModelExchange")
    with pytest.raises(ValueError, match=r"must run by Co-Simulation, for the whole holds no integrator, 'a' runs by Model"):
        pack_fmu(plan, tmp_path)
    with pytest.raises(ValueError, match="must run as an FMU to be run by Model Exchange, 'gyro_unit:linear' runs in this"):
        open_slave("g", "gyro_unit:linear", in_process=True, implementation="ModelExchange")
    alone = str(small_fmus.mixed(tmp_path))
    with pytest.raises(ValueError, match=r"must offer Model Exchange, offers Co-Simulation only"):
        open_slave("m", alone, implementation="ModelExchange")
    with pytest.raises(ValueError, match=r"must offer Co-Simulation, offers Model Exchange only"):
        open_slave("m", str(exchange_fmus.hopper(tmp_path, 2)), implementation="CoSimulation")
    with pytest.raises(ValueError, match="implementation must be CoSimulation or ModelExchange, got 'ME'"):
        plan.with_implementation("a", "ME")


def test_what_it_is_able_to_do_is_known_without_its_library(version: int, tmp_path: Path) -> None:
    file = str(exchange_fmus.hopper(tmp_path, version, restores=False))
    told, slave = described_slave("a", file).description, open_slave("a", file)
    try:
        for name in ("input_degree", "counts_events", "can_restore", "can_serialize"):
            assert getattr(told, name) == getattr(slave.description, name)
        assert told.input_degree == 2
    finally:
        slave.close()
