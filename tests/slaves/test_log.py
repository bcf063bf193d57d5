"""What an FMU says: in Python's log, counted per component, in the summary and in JSON."""

import json
import logging
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest
import small_fmus

from gyro_cosim import System, SystemComponent, simulate
from gyro_cosim.cli.log import Plain
from gyro_cosim.ssp.packing import pack

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


def test_the_summary_and_json_say_how_often_an_fmu_warned(tmp_path: Path, cosim: Callable[..., Any]) -> None:
    file = tmp_path / "worn.ssp"
    pack(worn(tmp_path), file)
    code, out, err = cosim("run", str(file), "--step", "0.1", "--stop", "1")
    assert (code, err) == (0, "")
    assert "m gave 8 warnings, the first: worn at 0.2 s [logStatusWarning]" in out
    code, out, err = cosim("run", str(file), "--step", "0.1", "--stop", "1", "--json")
    assert json.loads(out)["warnings"] == {"m": {"count": 8, "first": "worn at 0.2 s [logStatusWarning]"}}


@pytest.mark.parametrize("place", [0, 1, 2])
def test_the_log_is_quiet_but_for_v(tmp_path: Path, cosim: Callable[..., Any], place: int) -> None:
    file = tmp_path / "worn.ssp"
    pack(worn(tmp_path), file)
    command = ["run", str(file), "--step", "0.1", "--stop", "1"]
    assert cosim(*command)[2] == ""
    code, _, err = cosim(*command[:place], "-v", *command[place:])
    assert code == 0
    assert err.count("WARNING gyro_cosim.fmu.m: m: worn at") == 8
    assert "INFO gyro_cosim.master.simulation: opened m" in err
    assert cosim(*command)[2] == ""  # it goes with the command


def test_what_an_fmu_writes_into_the_log_is_shown_and_not_obeyed() -> None:
    record = logging.LogRecord("gyro_cosim.fmu.m", logging.WARNING, "", 0, "m: \x1b[31mred\x1b[0m\nnext", (), None)
    assert Plain("%(message)s").format(record) == "m: \\x1b[31mred\\x1b[0m next"
