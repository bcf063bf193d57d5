"""Files are whole or as they were, one run at a time writes them, a damaged checkpoint is refused, a finished run goes on."""

import os
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import oscillators
import pytest

from gyro_cosim import Jacobi, Options, Recording, simulate
from gyro_cosim.component.whole_files import whole_file
from gyro_cosim.master import Run
from gyro_cosim.master.checkpoint import Checkpoint, Resume
from gyro_cosim.master.locking import in_use
from gyro_cosim.master.recording import growing
from gyro_cosim.trajectory import Origin
from gyro_cosim.trajectory.origin import beside

RUN = ("run", "wheel-pair", "--in-process", "--stop", "0.2")


def run(stop: float, **how: Any) -> Run:
    return simulate(oscillators.pair(), algorithm=Jacobi(1), step=0.01, stop=stop, in_process=True, options=Options(**how))


# ---- whole or not at all ----------------------------------------------------------------------------------------------


def test_a_file_is_replaced_as_a_whole_or_stays(tmp_path: Path) -> None:
    file = tmp_path / "a.csv"
    file.write_text("old")
    file.chmod(0o640)

    def fail() -> None:
        with whole_file(file) as beside:
            beside.write_text("half")
            assert beside.suffix == ".csv"
            raise ZeroDivisionError

    with pytest.raises(ZeroDivisionError):
        fail()
    assert file.read_text() == "old"
    (tmp_path / "link.csv").symlink_to(file)
    with whole_file(tmp_path / "link.csv") as beside:
        beside.write_text("new")
    assert file.read_text() == "new"
    assert file.stat().st_mode & 0o777 == 0o640
    assert (tmp_path / "link.csv").is_symlink()
    assert sorted(p.name for p in tmp_path.iterdir()) == ["a.csv", "link.csv"]
    with whole_file(Path(os.devnull)) as beside:
        assert beside == Path(os.devnull)
    with pytest.raises(OSError, match=r"b\.csv"), whole_file(tmp_path / "gone" / "b.csv"):
        pass


@pytest.mark.skipif(sys.platform == "win32", reason="no locks there")
def test_what_a_killed_process_was_writing_goes_with_the_next(tmp_path: Path) -> None:
    """Not so what a living one still writes, nor anything else that is called alike."""
    file, others = tmp_path / "a.csv", {".a.cosim-12345678.mat", ".a.cosim-1234.csv", "a.cosim-12345678.csv", ".a.12345678.csv"}
    for name in (*others, ".a.cosim-12345678.csv"):
        (tmp_path / name).write_text("half")
    with whole_file(file) as living, whole_file(file) as beside:
        assert living.is_file()
        beside.write_text("new")
    assert {p.name for p in tmp_path.iterdir()} == {"a.csv", *others}


def test_results_never_lie_beside_the_origin_of_others(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Whatever is cut off between the two files: the older origin goes first, and only once the new results are whole."""
    file, done = tmp_path / "a.csv", run(0.1)
    done.trajectory.save(file, Origin(("run", "x")))
    assert beside(file).is_file()
    place, seen = Path.replace, []

    def replaced(self: Path, target: Path) -> Path:
        seen.append((self.stat().st_size > 0, beside(file).exists()))
        return place(self, target)

    monkeypatch.setattr(Path, "replace", replaced)
    done.trajectory.save(file, Origin(("run", "y")))
    simulate(oscillators.pair(), step=0.01, stop=0.1, in_process=True, options=Options(record=Recording(stream=file)))
    assert seen == [(True, False)] * 3


@pytest.mark.skipif(not Path("/dev/full").exists(), reason="needs a device that is full")
@pytest.mark.parametrize("ending", [".csv", ".mat", ".png"])
def test_a_full_disk_keeps_the_old_file_and_is_named(ending: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Whatever writes: the place beside the file is made a device without room."""
    from gyro_cosim import figures

    done, file = run(0.1), tmp_path / f"old{ending}"
    file.write_bytes(b"old")
    rename = Path.chmod

    def full(self: Path, mode: int) -> None:
        rename(self, mode)
        if self.parent == tmp_path:
            self.unlink()
            self.symlink_to("/dev/full")

    monkeypatch.setattr(Path, "chmod", full)
    drawn = figures.time_histories(done.trajectory, ["left.position"])
    with pytest.raises(OSError, match="No space left on device") as raised:
        figures.save(drawn, file) if ending == ".png" else done.trajectory.save(file)
    assert raised.value.filename == str(file)
    assert file.read_bytes() == b"old"
    assert [p.name for p in tmp_path.iterdir()] == [file.name]


def test_streamed_rows_stand_beside_until_the_run_is_over(tmp_path: Path) -> None:
    file = tmp_path / "r.csv"
    file.write_text("old")

    def stop(k: int) -> None:
        if k == 50:
            assert file.read_text() == "old"
            assert growing(file).is_file()

    simulate(
        oscillators.pair(), step=0.01, stop=1.0, in_process=True, options=Options(record=Recording(stream=file)), before_step=stop
    )
    assert len(file.read_text().splitlines()) == 102
    assert not growing(file).exists()


# ---- one run at a time --------------------------------------------------------------------------------------------------


def test_a_second_run_into_a_file_is_refused(tmp_path: Path, cosim: Callable[..., Any]) -> None:
    """It names the process that has the file; the lock goes with that process, however it ends."""
    file = tmp_path / "r.csv"
    code = (
        "import sys, time; from pathlib import Path; from gyro_cosim.master.locking import in_use\n"
        "with in_use([Path(sys.argv[1])]): print('held', flush=True); time.sleep(60)"
    )
    with subprocess.Popen([sys.executable, "-c", code, str(file)], stdout=subprocess.PIPE) as other:
        assert other.stdout is not None
        assert other.stdout.readline() == b"held\n"
        status, _, err = cosim(*RUN, "--output", str(file))
        other.kill()
    assert status == 2
    assert f"file {str(file)!r} must not be in use, process {other.pid} (-c {file}) writes to it" in err
    assert not file.exists()
    assert cosim(*RUN, "--output", str(file))[0] == 0
    assert sorted(p.name for p in tmp_path.iterdir()) == ["r.csv", "r.csv.origin.json"]
    with in_use([file, file]), in_use([tmp_path / "other.csv"]):  # the same twice is one; others are free
        pass


# ---- checkpoints --------------------------------------------------------------------------------------------------------


def test_a_damaged_checkpoint_is_refused_in_one_line(tmp_path: Path) -> None:
    file = tmp_path / "c.npz"
    run(0.5, checkpoint=Checkpoint(file, every=0.2))
    whole = file.read_bytes()
    rng = np.random.default_rng(0)
    for k in rng.integers(0, 8 * len(whole), 30):
        torn = bytearray(whole)
        torn[k // 8] ^= 1 << (k % 8)
        file.write_bytes(torn)
        with pytest.raises(ValueError, match="must agree with its checksum"):
            run(1.0, resume=Resume(file))
    for cut in (0, len(whole) // 2, len(whole) - 1):
        file.write_bytes(whole[:cut])
        with pytest.raises(ValueError, match="must agree with its checksum"):
            run(1.0, resume=Resume(file))


@pytest.mark.parametrize("streamed", [False, True])
def test_a_finished_run_goes_on(streamed: bool, tmp_path: Path) -> None:
    """As if it had been meant to be that long, bit by bit, and its file is replaced at the end only."""

    def record(name: str) -> Recording:
        return Recording(stream=tmp_path / name if streamed else None)

    run(0.4, record=record("r.csv"), checkpoint=Checkpoint(tmp_path / "c.npz", every=0.2))
    longer = run(1.0, record=record("r.csv"), resume=Resume(tmp_path / "c.npz"))
    at_once = run(1.0, record=record("s.csv"))
    assert np.array_equal(longer.trajectory.values, at_once.trajectory.values)
    if streamed:
        assert (tmp_path / "r.csv").read_bytes() == (tmp_path / "s.csv").read_bytes()


def test_a_run_does_not_go_on_into_the_rows_of_another(tmp_path: Path) -> None:
    """A run that was killed has left rows of its own in the place of those that the checkpoint relies on."""
    file, checkpoint = tmp_path / "r.csv", tmp_path / "c.npz"
    run(0.4, record=Recording(stream=file), checkpoint=Checkpoint(checkpoint, every=0.2))
    whole = file.read_bytes()
    growing(file).write_bytes(whole.replace(b"0", b"1") * 2)
    run(1.0, record=Recording(stream=file), resume=Resume(checkpoint))  # the rows are in the file itself, still
    run(1.0, record=Recording(stream=tmp_path / "s.csv"))
    assert file.read_bytes() == (tmp_path / "s.csv").read_bytes()
    file.write_bytes(whole.replace(b"0", b"1"))
    with pytest.raises(ValueError, match="must hold what was streamed before, it has been lost, cut off or exchanged"):
        run(1.0, record=Recording(stream=file), resume=Resume(checkpoint))


def test_a_checkpoint_beyond_the_end_or_between_two_points_is_refused(tmp_path: Path) -> None:
    file = tmp_path / "c.npz"
    run(0.405, checkpoint=Checkpoint(file, every=0.405))  # its last step is half as long
    for stop in (0.3, 1.0):
        with pytest.raises(ValueError, match=r"of t = 0\.405 s, must be of a communication point of this run, which ends at"):
            run(stop, resume=Resume(file))
