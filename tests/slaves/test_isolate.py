"""An FMU in a process of its own: the same numbers, and whatever it does ends as one line here, with nothing left behind."""

import contextlib
import os
import subprocess
import sys
import tempfile
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import small_fmus
from small_fmus import FAULTS

from gyro_cosim import Connection, SlaveError, System, SystemComponent, simulate, system
from gyro_cosim.slaves import open_slave, scratch
from gyro_cosim.slaves.processes.isolated import IsolatedSlave
from gyro_cosim.ssp.packing import pack


@pytest.fixture(autouse=True)
def nothing_left(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> object:
    """No child process and no temporary file after a test."""
    scratch = tmp_path / "scratch"
    scratch.mkdir()
    monkeypatch.setattr(tempfile, "tempdir", str(scratch))
    yield
    assert list(scratch.iterdir()) == []
    children = Path(f"/proc/{os.getpid()}/task/{os.getpid()}/children")
    mine = children.read_text().split() if children.is_file() else []
    commands = [Path(f"/proc/{pid}/cmdline").read_bytes() for pid in mine if Path(f"/proc/{pid}/cmdline").exists()]
    assert not [c for c in commands if b"gyro_cosim.slaves.processes.fmu_process" in c]


def broken(folder: Path, fault: str) -> System:
    """A mixed FMU that breaks at the first step that reaches t = 0.05 s, and one beside it."""
    file = small_fmus.mixed(folder)
    parts = (SystemComponent("bad", str(file), {"fault": FAULTS[fault], "text": "oh no"}), SystemComponent("good", str(file)))
    return System("s", parts, (Connection(("good", "count"), ("bad", "add")),), step=0.01, stop=0.1)


def test_the_numbers_are_the_same_to_the_last_bit() -> None:
    here, there = (simulate(system("wheel-pair"), step=2e-3, stop=0.2, isolate=isolate) for isolate in (False, True))
    np.testing.assert_array_equal(here.trajectory.values, there.trajectory.values)


@pytest.mark.parametrize(
    ("fault", "words"),
    [
        ("crash", r"its process was ended by signal 11 \(SIGSEGV\) in step"),
        ("exit", "its process exited with code 3 in step"),
        ("error", "fmi2DoStep answered error"),
        ("fatal", "fmi2DoStep answered fatal"),
        ("discard", r"fmi2DoStep answered discard, having reached t = 0\.0425 s"),
    ],
)
def test_a_failing_fmu_ends_as_one_line_with_its_own_words(tmp_path: Path, fault: str, words: str) -> None:
    with pytest.raises(SlaveError, match=rf"^component 'bad' failed at t = 0\.04 s over a step of 0\.01 s: {words}") as caught:
        simulate(broken(tmp_path, fault), isolate=True)
    assert "it broke at 0.04 s: oh no" in str(caught.value)
    assert "\n" not in str(caught.value)
    assert caught.value.partial.trajectory.t[-1] == pytest.approx(0.04)
    assert caught.value.partial.trajectory["good.count"][-1] == 4


def test_a_hanging_fmu_is_given_up_after_the_patience(tmp_path: Path) -> None:
    slave = IsolatedSlave("slow", str(small_fmus.mixed(tmp_path)), patience=1.0)
    try:
        slave.initialize({"fault": float(FAULTS["hang"])}, 0.0, 1.0)
        with pytest.raises(SlaveError, match=r"over a step of 0\.1 s: step does not end, given up after 1 s"):
            slave.step(np.zeros((3, len(slave.inputs))), 0.0, 0.1)
    finally:
        slave.close()


def test_states_and_derivatives_cross_the_wall() -> None:
    """Save, restore, serialize and dy/du of an isolated FMU are those of the FMU in this process."""
    slaves = [open_slave("s", "gyro_unit:nonlinear", isolate=isolate) for isolate in (False, True)]
    try:
        found = []
        for slave in slaves:
            slave.initialize({"gimbal_angle": 0.2}, 0.0, 1.0)
            U = np.full((3, len(slave.inputs)), 0.5)
            slave.step(U, 0.0, 0.01)
            snapshot, data = slave.save(), slave.serialize()
            rows = []
            for go_back in (lambda: None, lambda: slave.restore(snapshot), lambda: slave.deserialize(data)):  # noqa: B023
                go_back()
                slave.step(U, 0.01, 0.01)
                rows.append(slave.output(U[0], 0.02))
            slave.discard(snapshot)
            np.testing.assert_array_equal(rows[0], rows[1])
            np.testing.assert_array_equal(rows[0], rows[2])
            found.append((rows[0], slave.state_space().D, data))
        np.testing.assert_array_equal(found[0][0], found[1][0])
        np.testing.assert_array_equal(found[0][1], found[1][1])
        assert found[0][2] == found[1][2]
    finally:
        for slave in slaves:
            slave.close()


def test_an_fmu_that_cannot_be_opened_is_wrong_use_as_ever(tmp_path: Path) -> None:
    with pytest.raises(ValueError, match=r"none\.fmu' must exist"):
        open_slave("s", str(tmp_path / "none.fmu"), isolate=True)


def test_the_command_line_survives_a_crash_and_keeps_the_results(tmp_path: Path, cosim: Callable[..., Any]) -> None:
    pack(broken(tmp_path, "crash"), tmp_path / "bad.ssp")
    code, _, err = cosim("run", "bad.ssp", "--isolate", "--output", "kept.csv")
    assert code == 1
    assert "component 'bad' failed at t = 0.04 s over a step of 0.01 s: its process was ended by signal 11" in err
    assert "it broke at 0.04 s: oh no" in err
    assert len((tmp_path / "kept.csv").read_text().splitlines()) == 1 + 5  # header, t = 0 to 0.04 s


def test_what_a_killed_process_leaves_is_removed_by_the_next(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Two processes open an FMU; one is killed. Its folder goes when the next one opens an FMU, the living one's stays."""
    code = "import sys, time; from gyro_cosim.slaves import open_slave; s = open_slave('s', sys.argv[1]); print(1, flush=True)"
    code += "; time.sleep(60)"
    place, file = tmp_path / "place", str(small_fmus.mixed(tmp_path))
    place.mkdir()
    stranger, early = place / "cosim-stranger", place / f"{scratch.PREFIX}x"
    stranger.mkdir()  # not called as ours are
    early.mkdir()  # its process was killed before it had locked it
    folders = []
    with contextlib.ExitStack() as stack:
        for _ in range(2):
            process = stack.enter_context(
                subprocess.Popen(
                    [sys.executable, "-c", code, file], stdout=subprocess.PIPE, env={**os.environ, "TMPDIR": str(place)}
                )
            )
            stack.callback(process.kill)
            assert process.stdout is not None
            assert process.stdout.readline()
            folders.append(next(p for p in place.glob("cosim-*") if p not in (*folders, stranger)))
            assert not early.exists()
            if len(folders) == 1:
                process.kill()
                process.wait()
                assert folders[0].is_dir()
        assert not folders[0].exists()
        monkeypatch.setattr(tempfile, "tempdir", str(place))
        slave = open_slave("s", file)
        assert folders[1].is_dir()
        slave.close()
        assert sorted(place.iterdir()) == sorted([folders[1], stranger])
