"""Events of FMI 3.0 FMUs with event mode: at their own time, counted, and the FMU's calls in the standard's order."""

from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import small_fmus

from gyro_cosim import Algorithm, Connection, GaussSeidel, Iterated, Jacobi, SlaveError, System, SystemComponent, simulate
from gyro_cosim.coupling import Newton
from gyro_cosim.master import Options, open_network, run
from gyro_cosim.master.adaptive import Adaptive
from gyro_cosim.master.checkpoint import Checkpoint, Resume
from gyro_cosim.slaves import open_slave
from gyro_cosim.ssp.packing import pack

G = 9.81


def flight(t: np.ndarray, e: float = 0.7) -> tuple[np.ndarray, np.ndarray]:
    """Height of a ball dropped from 1 m, and how often it has hit the ground, by the formula of free fall."""
    impact, v = np.sqrt(2.0 / G), np.sqrt(2.0 * G)  # the first impact, and the speed before it
    h, hits = 1.0 - G * t**2 / 2, np.zeros(t.shape)
    for _ in range(30):
        after = t >= impact
        v *= e
        h[after], hits[after] = (v * (t - impact) - G * (t - impact) ** 2 / 2)[after], hits[after] + 1
        impact += 2 * v / G
    return h, hits


def one(file: Path, **values: float) -> System:
    return System("s", (SystemComponent("ball", str(file), values),), ())


@pytest.mark.parametrize("isolate", [False, True])
@pytest.mark.parametrize("step", [0.01, 0.37, 2.0])
def test_every_bounce_is_at_its_own_time_whatever_the_macro_step(step: float, isolate: bool, tmp_path: Path) -> None:
    """In a step of 2 s there are four impacts; the FMU returns early at each."""
    done = simulate(one(small_fmus.ball(tmp_path)), step=step, stop=2.0, isolate=isolate)
    h, hits = flight(done.trajectory.t)
    np.testing.assert_allclose(done.trajectory["ball.h"], h, rtol=0, atol=1e-12)
    np.testing.assert_array_equal(done.trajectory["ball.impacts"], hits)
    assert done.events == {"ball": hits[-1]}
    assert hits[-1] == 4


def test_an_fmu_that_deals_with_its_events_itself_gives_the_same_and_tells_of_none(tmp_path: Path) -> None:
    own, told = (
        simulate(one(small_fmus.ball(tmp_path, events=events), period=0.113), step=0.05, stop=2.0) for events in (False, True)
    )
    np.testing.assert_allclose(own.trajectory.values, told.trajectory.values, rtol=0, atol=1e-12)
    assert own.events == {}
    assert told.events == {"ball": 4 + 17}


@pytest.mark.parametrize("start", [0.0, 0.15])
@pytest.mark.parametrize("step", [0.07, 0.05])
def test_announced_times_are_met(step: float, start: float, tmp_path: Path) -> None:
    """Ticks at 0.1, 0.2, ... s: the FMU lets no step pass one, and one at a step's end counts there.

    The first of a later start is overdue and comes at once.
    """
    done = simulate(one(small_fmus.ball(tmp_path), period=0.1), step=step, start=start, stop=0.44)
    np.testing.assert_array_equal(done.trajectory["ball.ticks"], np.floor(done.trajectory.t / 0.1 + 1e-9))


def test_a_discrete_input_changes_in_event_mode(tmp_path: Path) -> None:
    """Each impact of the first ball kicks the second, once: what changes between two steps is an event of its own."""
    file = str(small_fmus.ball(tmp_path))
    plan = System(
        "s", (SystemComponent("a", file), SystemComponent("b", file, {"h": 50.0})), (Connection(("a", "impacts"), ("b", "kick")),)
    )
    done = simulate(plan, step=0.01, stop=2.0)
    assert done.events == {"a": 4, "b": 4}
    t = done.trajectory.t
    kicks = [t[k] for k in np.flatnonzero(np.diff(done.trajectory["a.impacts"]) > 0) + 1]
    v = -G * t + np.sum([t >= kick for kick in kicks], axis=0)
    np.testing.assert_allclose(done.trajectory["b.v"], v, rtol=0, atol=1e-10)


@pytest.mark.parametrize("how", ["here", "isolated", "remote"])
def test_an_event_can_end_the_run(how: str, tmp_path: Path) -> None:
    """The third impact is the last: in the midst of a step, which then is not there, or at its end."""
    file, isolate = small_fmus.ball(tmp_path), how == "isolated"
    plan = System("s", (SystemComponent("ball", f"process:{file}" if how == "remote" else str(file), {"last": 3}),), ())
    third = np.sqrt(2.0 / G) * (1 + 2 * 0.7 + 2 * 0.7**2)
    half = third / 2 * (1 + 1e-10)  # a hair more, so that rounding does not put it into the next step
    done = simulate(plan, step=0.1, stop=2.0, isolate=isolate)
    assert (done.status, done.trajectory.t[-1]) == ("ended", pytest.approx(1.5))
    assert done.ended_by == f"component 'ball' asks to end the run at t = {third:.9g} s"
    done = simulate(plan, step=half, stop=2.0, isolate=isolate)
    assert (done.status, done.steps) == ("ended", 2)
    assert done.events == ({} if how == "remote" else {"ball": 3})
    assert done.trajectory["ball.impacts"][-1] == 3
    assert simulate(plan, step=half, stop=2 * half, isolate=isolate).status == "done"


@pytest.mark.parametrize(
    ("fault", "words"),
    [
        ("restless", r"failed at t = 0 s: the discrete states must settle, they do not in 1000 updates"),
        ("stubborn", r"failed at t = 0\.4 s over a step of 0\.1 s: the FMU must get on, stays at t = 0\.451523641 s"),
    ],
)
def test_an_fmu_that_never_leaves_an_event_is_given_up(fault: str, words: str, tmp_path: Path) -> None:
    with pytest.raises(SlaveError, match=words):
        simulate(one(small_fmus.ball(tmp_path), **{fault: 1}), step=0.1, stop=1.0)


@pytest.mark.parametrize("algorithm", [GaussSeidel(1), Iterated(1), Newton(1)], ids=lambda a: a.name)
def test_events_of_steps_that_are_taken_back_do_not_count(algorithm: Algorithm, tmp_path: Path) -> None:
    file = str(small_fmus.ball(tmp_path))
    plan = System(
        "s", (SystemComponent("a", file, {"period": 0.03}), SystemComponent("b", file)), (Connection(("a", "h"), ("b", "e")),)
    )
    plan = System("s", plan.components, (Connection(("a", "ticks"), ("b", "kick")),))
    plain = simulate(plan, algorithm=Jacobi(0), step=0.01, stop=1.0)
    again = simulate(plan, algorithm=algorithm, step=0.01, stop=1.0)
    assert again.events["a"] == plain.events["a"] == 1 + 33
    np.testing.assert_array_equal(again.trajectory["a.h"], plain.trajectory["a.h"])


def test_adaptive_steps_and_events_go_together(tmp_path: Path) -> None:
    file = str(small_fmus.ball(tmp_path))
    plan = System(
        "s", (SystemComponent("a", file), SystemComponent("b", file, {"h": 50.0})), (Connection(("a", "impacts"), ("b", "kick")),)
    )
    done = simulate(plan, step=0.01, stop=0.4, options=Options(adaptive=Adaptive(1e-3)))
    np.testing.assert_allclose(done.trajectory["a.h"], flight(done.trajectory.t)[0], rtol=0, atol=1e-12)
    assert done.events == {"a": 0, "b": 0}


def test_a_run_that_is_resumed_remembers_its_events(tmp_path: Path) -> None:
    file = str(small_fmus.ball(tmp_path))
    parts = SystemComponent("a", file, {"period": 0.07}), SystemComponent("b", file, {"h": 50.0})
    plan = System("s", parts, (Connection(("a", "ticks"), ("b", "kick")),))

    def kill(k: int) -> None:
        if k == 131:
            raise KeyboardInterrupt

    whole = simulate(plan, step=0.01, stop=2.0)
    simulate(plan, step=0.01, stop=2.0, before_step=kill, options=Options(checkpoint=Checkpoint(tmp_path / "c.npz", 0.5)))
    again = simulate(plan, step=0.01, stop=2.0, options=Options(resume=Resume(tmp_path / "c.npz")))
    np.testing.assert_array_equal(again.trajectory.values, whole.trajectory.values)
    assert again.events == whole.events == {"a": 4 + 28, "b": 28}


def test_runs_begin_anew_on_an_open_network(tmp_path: Path) -> None:
    with open_network(one(small_fmus.ball(tmp_path), last=6)) as network:
        first, second = (run(network, Jacobi(1), 0.01, 3.0) for _ in range(2))
    np.testing.assert_array_equal(first.trajectory.values, second.trajectory.values)
    assert first.events == second.events == {"ball": 6}
    assert first.status == second.status == "ended"


def test_an_fmu_with_a_clock_that_nobody_ticks_runs_with_its_events(tmp_path: Path) -> None:
    slave = open_slave("s", str(small_fmus.ball(tmp_path, clock=True)))
    assert slave.description.clock_inputs == ("clock",)
    slave.close()
    assert simulate(one(small_fmus.ball(tmp_path, clock=True)), step=0.1, stop=1.0).events == {"ball": 1}


def test_the_command_line_tells_of_events(tmp_path: Path, cosim: Callable[..., Any], cosim_json: Callable[..., Any]) -> None:
    pack(one(small_fmus.ball(tmp_path)), tmp_path / "ball.ssp")
    told = cosim_json("run", "ball.ssp", "--stop", "2", "--step", "10ms")
    assert told["events"] == {"total": 4, "components": {"ball": 4}}
    assert "events: 4 (ball 4)" in cosim("run", "ball.ssp", "--stop", "2", "--step", "10ms")[1]
    assert cosim_json("run", "wheel-pair", "--stop", "0.1")["events"] == {"total": 0, "components": {}}
    pack(one(small_fmus.ball(tmp_path), last=2), tmp_path / "twice.ssp")
    code, out, err = cosim("run", "twice.ssp", "--stop", "2", "--step", "10ms", "--certify")
    assert (code, err) == (0, "cosim: no certificate: the run has ended before its time\n")
    assert out.startswith("component 'ball' asks to end the run at t = 1.08")
