"""Real time: the pacer's arithmetic on a clock of its own, and on the real one that nothing comes early and no number changes."""

import gc
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from gyro_cosim import simulate, system
from gyro_cosim.cli.run import document as run_document
from gyro_cosim.hil import realtime
from gyro_cosim.hil.realtime import Pacer, RealTimeError

PLAN = system("wheel-pair").with_value("gyro.rotor_speed", "200rpm")
PLAIN = PLAN.with_source("gyro", "nonlinear")


class Clock:
    """Time that passes only by sleeping, by looking (1 us) and by work."""

    def __init__(self, monkeypatch: pytest.MonkeyPatch) -> None:
        self.now = 100.0
        monkeypatch.setattr(realtime.time, "perf_counter", self.look)
        monkeypatch.setattr(realtime.time, "sleep", self.sleep)
        self.slept = 0.0

    def look(self) -> float:
        self.now += 1e-6
        return self.now

    def sleep(self, seconds: float) -> None:
        self.now += seconds
        self.slept += seconds


@pytest.fixture
def clock(monkeypatch: pytest.MonkeyPatch) -> Clock:
    return Clock(monkeypatch)


def paced(clock: Clock, work: list[float], **options: Any) -> realtime.Report:
    """Steps of 1 ms whose work takes the times given."""
    pacer = Pacer(1e-3, steps=2, **options)
    with pacer:
        for k, seconds in enumerate(work, start=1):
            pacer(k)
            clock.now += seconds
    return pacer.report()


def test_steps_begin_when_they_are_due_and_never_earlier(clock: Clock) -> None:
    report = paced(clock, [0.2e-3] * 1000)
    assert (report.steps, report.overruns, report.lost) == (1000, 0, 0)
    assert (report.latency >= 0.0).all()
    assert report.latency.max() < 3e-6
    assert report.period.mean() == pytest.approx(1e-3, abs=1e-8)  # no drift
    assert clock.slept == pytest.approx(999 * (1 - 0.2 - 0.3) * 1e-3, rel=0.02)  # spins for the last 0.3 ms
    assert sum(report.histogram()[0]) == 999


def test_never_sleeping_is_spin_as_long_as_the_period(clock: Clock) -> None:
    paced(clock, [0.2e-3] * 10, spin=1e-3)
    assert clock.slept == 0.0


def test_count_keeps_the_time_table_and_catches_up(clock: Clock) -> None:
    report = paced(clock, [2.4e-3, 0.2e-3, 0.2e-3, 0.2e-3, 0.2e-3])
    assert (report.overruns, report.lost) == (2, 0)  # due at 1 and 2 ms, begun at 2.4 and 2.6; the one due at 3 waits
    np.testing.assert_allclose(report.latency, [0, 1.4e-3, 0.6e-3, 0, 0], atol=1e-5)
    assert report.slack.min() == pytest.approx(-1.4e-3, abs=1e-5)


def test_skip_gives_up_the_periods_that_have_begun(clock: Clock) -> None:
    report = paced(clock, [2.6e-3, 0.2e-3, 0.2e-3], overrun="skip")
    assert (report.overruns, report.lost) == (1, 2)
    np.testing.assert_allclose(report.period, [3e-3, 1e-3], atol=1e-5)


def test_a_grace_forgives_small_lateness(clock: Clock) -> None:
    assert paced(clock, [1.05e-3, 0.2e-3]).overruns == 1
    assert paced(clock, [1.05e-3, 0.2e-3], grace=0.1e-3).overruns == 0


def test_stop_ends_the_run_and_keeps_what_there_is() -> None:
    pacer = Pacer(1e-3, overrun="stop", grace=0.05)

    def late(k: int) -> None:
        pacer(k)
        if k == 5:
            time.sleep(0.1)

    with (
        pytest.raises(RealTimeError, match=r"real time: step 6 must begin at 0\.005000 s, its turn came \d+ us later") as caught,
        pacer,
    ):
        simulate(PLAIN, step=1e-3, stop=0.1, in_process=True, before_step=late)
    assert len(caught.value.partial.trajectory) == 6
    assert pacer.report().overruns == 1
    assert pacer.report().steps == 5


def test_a_paced_run_gives_the_numbers_of_any_run_and_leaves_the_process_as_it_was() -> None:
    pacer = Pacer(1e-3, steps=10)
    assert gc.isenabled()
    began = time.perf_counter()
    with pacer:
        assert not gc.isenabled()
        a = simulate(PLAIN, step=1e-3, stop=0.1, in_process=True, before_step=pacer)
    assert time.perf_counter() - began >= 0.099  # never early
    assert gc.isenabled()
    b = simulate(PLAIN, step=1e-3, stop=0.1, in_process=True)
    np.testing.assert_array_equal(a.trajectory.values, b.trajectory.values)
    report = pacer.report()
    assert report.steps == 100
    assert set(report.percentiles(report.period)) == {"p50", "p90", "p99", "p99.9", "max"}
    assert "100 steps" in report.words()
    assert report.document()["overruns"] == report.overruns
    assert run_document(a)["steps"] == 100


@pytest.mark.parametrize(
    ("options", "words"),
    [
        ({"period": 0.0}, "`period` must be at least 0.1 ms, got 0 s"),
        ({"period": 1e-3, "overrun": "panic"}, "`overrun` must be one of count, skip, stop, got 'panic'"),
        ({"period": 1e-3, "spin": -1.0}, "`spin` must not be negative"),
        ({"period": 1e-3, "priority": 100}, "`priority` must be 0 to 99, got 100"),
    ],
)
def test_pacers_that_cannot_be_are_refused(options: dict[str, Any], words: str) -> None:
    with pytest.raises(ValueError, match=words):
        Pacer(**options)


def test_run_can_be_paced(cosim: Callable[..., Any], cosim_json: Callable[..., Any]) -> None:
    paced = cosim_json("run", "wheel-pair", "--in-process", "--stop", "0.1", "--realtime", "--overrun", "skip")
    plain = cosim_json("run", "wheel-pair", "--in-process", "--stop", "0.1")
    assert paced["end"] == plain["end"]
    told = paced["realtime"]
    assert (told["steps"], told["period_s"], told["policy"]) == (100, 1e-3, "skip")
    assert sum(told["histogram"]["counts"]) == 99
    code, out, _ = cosim("run", "wheel-pair", "--in-process", "--stop", "0.05", "--realtime")
    assert code == 0
    assert "real time at 1 ms: 50 steps" in out
    for wrong, words in (
        (("--overrun", "panic"), "--overrun must be one of count, skip, stop"),
        (("--adaptive", "1e-3"), "even macro step"),
    ):
        code, out, err = cosim("run", "wheel-pair", "--in-process", "--stop", "0.1", "--realtime", *wrong)
        assert (code, out, err.count("\n")) == (2, "", 1)
        assert words in err


def test_a_paced_run_that_stops_keeps_its_results(cosim: Callable[..., Any], monkeypatch: pytest.MonkeyPatch) -> None:
    """Every wait ends 5 ms late: the second step is late already."""
    monkeypatch.setattr(realtime.time, "sleep", lambda s: None)
    clock = time.perf_counter
    shift = [0.0]

    def jumping() -> float:
        shift[0] += 1e-3
        return clock() + shift[0]

    monkeypatch.setattr(realtime, "time", type("T", (), {"perf_counter": staticmethod(jumping), "sleep": lambda s: None}))
    code, _, err = cosim(
        "run", "wheel-pair", "--in-process", "--stop", "0.1", "--realtime", "--overrun", "stop", "--output", "r.csv"
    )
    assert code == 1
    assert "kept the results" in err
    assert "real time: step 2 must begin" in err
    assert Path("r.csv").is_file()
