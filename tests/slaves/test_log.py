"""What an FMU says: in Python's log, counted per component, in the summary and in JSON."""

import logging
from pathlib import Path

import pytest
import small_fmus

from gyro_cosim import System, SystemComponent, simulate

WARNS = 10  # the kind of fault at which the FMU warns in every step


def worn(folder: Path) -> System:
    values = {"fault": WARNS, "fault_at": 0.25}
    return System("s", (SystemComponent("m", str(small_fmus.mixed(folder)), values),), ())


@pytest.mark.parametrize("isolate", [False, True])
def test_warnings_are_counted_and_logged(tmp_path: Path, caplog: pytest.LogCaptureFixture, isolate: bool) -> None:
    with caplog.at_level(logging.WARNING, "gyro_cosim"):
        run = simulate(worn(tmp_path), step=0.1, stop=1.0, isolate=isolate)
    assert run.status == "done"
    assert run.warnings == {"m": (8, "worn at 0.2 s [logStatusWarning]")}
    told = [record for record in caplog.records if record.name == "gyro_cosim.fmu.m"]
    assert len(told) == 8
    assert {record.levelname for record in told} == {"WARNING"}
    assert told[-1].getMessage() == "m: worn at 0.9 s [logStatusWarning]"


def test_a_second_run_counts_anew(tmp_path: Path) -> None:
    plan = worn(tmp_path)
    simulate(plan, step=0.1, stop=1.0)
    assert simulate(plan, step=0.1, stop=0.5).warnings == {"m": (3, "worn at 0.2 s [logStatusWarning]")}
    assert simulate(plan, step=0.1, stop=0.1).warnings == {}
