"""Results first: whatever an FMU does to the process that it runs in, what was computed is on disk and the exit code is right.

All kinds of misbehaviour, in process and isolated: `make torture`. These are the ways in which a process can end.
"""

import json
import os
import signal
import subprocess
import sys
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

import hostile
import pytest

from gyro_cosim.ssp.packing import pack

pytestmark = pytest.mark.skipif(sys.platform == "win32", reason="processes are kept on Linux and macOS")
ROWS = hostile.AT  # before the step in which it happens


def cosim_run(folder: Path, kind: str, *options: str) -> tuple[int, str, str]:
    """`cosim run` of the FMU of a kind, as the shell calls it: exit code, standard output, standard error."""
    pack(hostile.system(folder, kind), folder / "system.ssp")
    command = [sys.executable, "-m", "gyro_cosim", "run", "system.ssp", "--output", "out.csv", *options]
    done = subprocess.run(command, cwd=folder, capture_output=True, text=True, timeout=60, check=False)
    return done.returncode, done.stdout, done.stderr


def rows(folder: Path) -> int:
    """Points in the file of results."""
    return len((folder / "out.csv").read_text().splitlines()) - 1


@pytest.mark.parametrize(
    ("kind", "says", "points"),
    [
        ("segv@step", r"component 'bad' crashed (SIGSEGV) at t = 0.49 s; --isolate", ROWS),
        pytest.param("stack@step", r"component 'bad' crashed (SIGSEGV) at t = 0.49 s; --isolate", ROWS, marks=pytest.mark.slow),
        ("exit0@step", "component 'bad' ended the process with code 0 at t = 0.49 s; --isolate", ROWS),
        pytest.param(
            "status-1@step",
            "component 'bad' failed at t = 0.49 s over a step of 0.01 s: fmi2DoStep answered status -1",
            ROWS,
            marks=pytest.mark.slow,
        ),
        ("segv@free", "a component crashed (SIGSEGV) after the run, whose results were written before; --isolate", 101),
        pytest.param("_exit0@terminate", "left with code 0 before its work was done; --isolate", 101, marks=pytest.mark.slow),
    ],
)
def test_a_process_that_an_fmu_ends_keeps_its_results(tmp_path: Path, kind: str, says: str, points: int) -> None:
    code, _, err = cosim_run(tmp_path, kind)
    assert code == 1
    line = err.splitlines()[-1]
    assert line.startswith("cosim: ")
    assert says in line
    assert err.count("cosim: ") == 1
    assert rows(tmp_path) == points


def test_an_fmu_that_leaves_without_a_word_is_no_success(tmp_path: Path) -> None:
    code, out, err = cosim_run(tmp_path, "_exit0@step")
    assert (code, out) == (1, "")
    assert err.startswith("cosim: the process of the command left with code 0 before its work was done; --isolate gives")
    assert err.count("\n") == 1


def test_what_an_fmu_prints_spoils_no_document(tmp_path: Path) -> None:
    code, out, err = cosim_run(tmp_path, "stdout-later@every", "--json")
    assert code == 0
    assert json.loads(out)["status"] == "done"
    assert "not flushed" in err


def test_an_fmu_changes_nothing_of_its_process_for_others(tmp_path: Path) -> None:
    code, _, err = cosim_run(tmp_path, "chdir@step")
    assert (code, err, rows(tmp_path)) == (0, "", 101)
    assert not Path("/out.csv").exists()


@pytest.mark.skipif(sys.platform != "linux", reason="orphans go to their keeper on Linux")
def test_no_process_that_an_fmu_has_started_is_left(tmp_path: Path) -> None:
    code, _, _ = cosim_run(tmp_path, "daemon@instantiate")
    assert code == 0
    assert not [p for p in Path("/proc").glob("[0-9]*") if _folder(p) == tmp_path]


def _folder(process: Path) -> Path | None:
    try:
        return (process / "cwd").readlink()
    except OSError:
        return None


@pytest.mark.slow
def test_ctrl_c_ends_a_run_that_hangs_and_keeps_its_results(tmp_path: Path) -> None:
    pack(hostile.system(tmp_path, "hang@step"), tmp_path / "system.ssp")
    script = "import sys; import gyro_cosim.cli.kept as k; k.PATIENCE = 0.3; from gyro_cosim.cli import main; sys.exit(main())"
    command = [sys.executable, "-c", script, "run", "system.ssp", "--output", "out.csv"]
    with subprocess.Popen(command, cwd=tmp_path, stderr=subprocess.PIPE, text=True, start_new_session=True) as process:
        time.sleep(4.0)
        os.killpg(process.pid, signal.SIGINT)
        _, err = process.communicate(timeout=30)
    assert process.returncode == 1
    assert err.splitlines()[-1].startswith("cosim: component 'bad' does not come back at t = 0.49 s; --isolate")
    assert rows(tmp_path) == ROWS


@pytest.mark.slow
def test_closing_may_not_take_for_ever(tmp_path: Path) -> None:
    pack(hostile.system(tmp_path, "busy@free"), tmp_path / "system.ssp")
    script = "import sys; import gyro_cosim.cli.kept as k; k.CLOSING = 0.3; from gyro_cosim.cli import main; sys.exit(main())"
    command = [sys.executable, "-c", script, "run", "system.ssp", "--output", "out.csv"]
    done = subprocess.run(command, cwd=tmp_path, capture_output=True, text=True, timeout=60, check=False)
    assert done.returncode == 1
    assert "an FMU does not close within 0.3 s; what results there are were written before" in done.stderr
    assert rows(tmp_path) == 101


def test_one_line_shows_what_an_fmu_says_and_obeys_none_of_it(tmp_path: Path, cosim: Callable[..., Any]) -> None:
    pack(hostile.system(tmp_path, "log-escape@step"), tmp_path / "system.ssp")
    code, _, err = cosim("run", "system.ssp")
    assert code == 1
    assert r"it says: \x1b[2J\x1b[31m" in err
    assert "\x1b" not in err
