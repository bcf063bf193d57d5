"""What an FMU changes of its process is put back: floating-point mode, signal handlers, timers, folder, mask, limits."""

import os
import signal
import sys
from pathlib import Path

import hostile
import numpy as np
import pytest

from gyro_cosim import simulate
from gyro_cosim.slaves.fmi.surroundings import floating_point_kept, kept, mind_floating_point

pytestmark = pytest.mark.skipif(sys.platform == "win32", reason="the behaviours are those of POSIX")


@pytest.mark.parametrize("hook", ["load", "instantiate", "initialize", "step", "free"])
@pytest.mark.parametrize("compiled", [True, False])
def test_the_floating_point_mode_is_put_back(tmp_path: Path, hook: str, compiled: bool) -> None:
    from gyro_cosim import Options

    plan = hostile.system(tmp_path, f"rounding@{hook}")
    run = simulate(plan, options=Options(compiled=compiled))
    assert floating_point_kept()
    good = simulate(hostile.system(tmp_path, "good@nowhere"), options=Options(compiled=compiled))
    np.testing.assert_array_equal(run.trajectory.values, good.trajectory.values)


@pytest.mark.parametrize("kind", ["flush@initialize", "traps@load"])
def test_other_modes_are_put_back(tmp_path: Path, kind: str) -> None:
    simulate(hostile.system(tmp_path, kind))
    assert floating_point_kept()
    assert np.float64(1.0) / 3.0 * 3.0 == 1.0  # inexact: a trap would end the process


@pytest.mark.parametrize("behaviour", ["handlers", "ignore", "timer", "chdir", "umask", "locale"])
def test_handlers_timers_folder_mask_and_limits_are_put_back(tmp_path: Path, behaviour: str) -> None:
    before = Path.cwd(), _mask(), signal.getitimer(signal.ITIMER_REAL)[0]
    heard: list[int] = []
    usual = signal.signal(signal.SIGTERM, lambda number, frame: heard.append(number))
    try:
        simulate(hostile.system(tmp_path, f"{behaviour}@instantiate"))
        os.kill(os.getpid(), signal.SIGTERM)
        assert heard == [signal.SIGTERM]
        assert (Path.cwd(), _mask(), signal.getitimer(signal.ITIMER_REAL)[0]) == before
    finally:
        signal.signal(signal.SIGTERM, usual)


def _mask() -> int:
    mask = os.umask(0)
    os.umask(mask)
    return mask


def test_nothing_is_put_back_that_was_not_changed(caplog: pytest.LogCaptureFixture) -> None:
    caplog.set_level("INFO", "gyro_cosim")
    with kept("nobody"):
        pass
    mind_floating_point("nobody")
    assert not caplog.records


def test_a_library_whose_threads_run_stays_loaded(tmp_path: Path, caplog: pytest.LogCaptureFixture) -> None:
    if not Path("/proc/self/task").exists():
        pytest.skip("threads cannot be counted")
    caplog.set_level("INFO", "gyro_cosim")
    run = simulate(hostile.system(tmp_path, "threads@instantiate"))
    assert len(run.trajectory) == hostile.STEPS + 1
    assert "has left threads running, so its library stays loaded" in caplog.text
