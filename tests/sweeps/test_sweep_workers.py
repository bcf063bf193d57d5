"""Sweeps: processes that are stopped, killed, crashed by an FMU, or on a Dask cluster."""

import json
import multiprocessing
import os
import signal
import subprocess
import sys
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import small_fmus

from gyro_cosim import System, SystemComponent, system
from gyro_cosim.sweeps import Sweep, load, sweep
from gyro_cosim.sweeps.pool import Pool
from gyro_cosim.sweeps.store import journal_of

MANY = {"gyro.rotor_speed": "0rpm:300rpm:150"}


def own_folder(folder: Path) -> dict[str, str]:
    """An environment whose temporary files stay in `folder`: what is killed cannot clear up."""
    return {**os.environ, "TMPDIR": str(folder)}


@contextmanager
def running(file: Path, *options: str) -> Iterator[subprocess.Popen[str]]:
    """`cosim sweep` in a process of its own, yielded once some rows are kept."""
    axis = f"gyro.rotor_speed={MANY['gyro.rotor_speed']}"
    command = ["sweep", "wheel-pair", "--set", axis, "--stop", "10", "--output", str(file), "--workers", "1", *options]
    heeding = "import signal, sys; signal.signal(signal.SIGINT, signal.default_int_handler); "  # whoever runs the tests may not
    heeding += "from gyro_cosim.cli import main; sys.exit(main(sys.argv[1:]))"
    pipes: dict[str, Any] = {"stderr": subprocess.PIPE, "stdout": subprocess.PIPE, "text": True, "env": own_folder(file.parent)}
    with subprocess.Popen([sys.executable, "-c", heeding, *command], start_new_session=True, **pipes) as process:
        while process.poll() is None and not (journal_of(file).exists() and journal_of(file).read_bytes().count(b"\n") > 3):
            time.sleep(0.02)
        yield process
        if process.poll() is None:
            process.kill()


@pytest.mark.parametrize("how", [signal.SIGKILL, pytest.param(signal.SIGINT, marks=pytest.mark.slow)])
def test_a_sweep_that_is_stopped_goes_on_where_it_was(tmp_path: Path, how: signal.Signals, cosim: Callable[..., Any]) -> None:
    file = tmp_path / "a.npz"
    with running(file) as process:
        process.send_signal(how)
        out, _ = process.communicate(timeout=30)
    assert process.returncode == (1 if how == signal.SIGINT else -how)
    assert file.exists() == (how == signal.SIGINT)
    assert ("the same command goes on from here" in out) == (how == signal.SIGINT)
    if how == signal.SIGKILL:
        with journal_of(file).open("ab") as journal:
            journal.write(b'["spoilt", \0\0\0]\n["torn')  # as a crash of the machine may leave it
    kept = load(file)
    assert 3 <= len(kept) < 150
    what = Sweep(system("wheel-pair"), MANY, stop=10.0)
    outcome = sweep(what, file, workers=2)
    assert (outcome.before, outcome.done) == (len(kept), 150 - len(kept))
    table = load(file)
    assert not journal_of(file).exists()
    assert np.unique(table["gyro.rotor_speed"]).size == len(table) == 150
    assert (table["wall_s"][: len(kept)] == kept["wall_s"]).all()  # the rows of before, not new ones


def test_a_worker_that_is_killed_costs_only_its_runs(tmp_path: Path) -> None:
    killed: list[int] = []

    def kill_one(done: float, total: float) -> None:
        if not killed:
            victim = multiprocessing.active_children()[0].pid
            assert victim is not None
            killed.append(victim)
            os.kill(victim, signal.SIGKILL)

    what = Sweep(system("wheel-pair"), MANY, stop=1.0)
    outcome = sweep(what, tmp_path / "a.npz", workers=2, progress=kill_one)
    assert killed
    assert (outcome.done, outcome.failed) == (150, 0)
    assert len(load(tmp_path / "a.npz")) == 150
    assert multiprocessing.active_children() == []


@pytest.mark.parametrize("times", [1, 99])
def test_a_worker_that_is_killed_while_it_starts_is_replaced(times: int, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """It has held no run yet; but where no worker comes to life the sweep says so instead of trying for ever."""
    plain, killed = Pool._start, []

    def start(pool: Pool) -> Any:
        worker = plain(pool)
        if len(killed) < times:
            killed.append(worker.process.pid)
            worker.process.kill()
        return worker

    monkeypatch.setattr(Pool, "_start", start)
    what = Sweep(system("wheel-pair"), {"gyro.rotor_speed": "0rpm:300rpm:3"}, stop=0.1)
    if times == 1:
        outcome = sweep(what, tmp_path / "a.npz", workers=1)
        assert (outcome.done, outcome.failed) == (3, 0)
    else:
        with pytest.raises(RuntimeError, match="a worker process must start, it ended with signal SIGKILL"):
            sweep(what, tmp_path / "a.npz", workers=1)
        assert len(killed) == 3
    assert multiprocessing.active_children() == []


def test_a_run_that_takes_its_process_with_it_is_a_row(tmp_path: Path) -> None:
    plan = System("small", (SystemComponent("m", str(small_fmus.mixed(tmp_path))),), ())
    crash, leave = small_fmus.FAULTS["crash"], small_fmus.FAULTS["exit"]
    what = Sweep(plan, {"m.fault": f"0,{crash},{leave}", "m.gain": "1,2,3,4"}, steps=(0.01,), stop=0.1)
    outcome = sweep(what, tmp_path / "a.npz", workers=2)
    assert (outcome.done, outcome.failed) == (12, 8)
    table = load(tmp_path / "a.npz")
    assert set(table["status"][table["m.fault"] == 0].tolist()) == {"done"}
    assert set(table["error"][table["m.fault"] == crash].tolist()) == {"the process that ran it ended with signal SIGSEGV, twice"}
    assert all("the process that ran it ended with exit code" in error for error in table["error"][table["m.fault"] == leave])


def test_two_sweeps_do_not_share_a_file(tmp_path: Path, cosim: Callable[..., Any]) -> None:
    file = tmp_path / "a.npz"
    with running(file):
        code, _, err = cosim(
            "sweep", "wheel-pair", "--set", f"gyro.rotor_speed={MANY['gyro.rotor_speed']}", "--stop", "10", "--output", str(file)
        )
    assert code == 2
    assert "must not be in use, another sweep is writing to it" in err


@contextmanager
def cluster(folder: Path, workers: int) -> Iterator[tuple[str, list[subprocess.Popen[bytes]]]]:
    """A real Dask scheduler and workers, each a process of its own, on this machine."""
    pytest.importorskip("distributed")
    address = folder / "scheduler.json"
    processes: list[subprocess.Popen[bytes]] = []

    def start(program: str, *options: str) -> None:
        command = [
            sys.executable,
            "-m",
            f"distributed.cli.{program}",
            "--scheduler-file",
            str(address),
            "--no-dashboard",
            *options,
        ]
        processes.append(
            subprocess.Popen(command, cwd=folder, env=own_folder(folder), stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
        )

    try:
        start("dask_scheduler", "--host", "127.0.0.1", "--port", "0")
        for _ in range(workers):
            start("dask_worker", "--host", "127.0.0.1", "--nthreads", "1", "--no-nanny", "--local-directory", str(folder))
        while not (address.exists() and address.read_text().endswith("}")):
            time.sleep(0.05)
        yield json.loads(address.read_text())["address"], processes[1:]
    finally:
        for process in processes:
            process.kill()
            process.wait()


def test_a_dask_cluster_gives_the_same_rows_though_a_worker_is_lost(tmp_path: Path) -> None:
    what = Sweep(system("wheel-pair"), MANY, stop=0.05)
    sweep(what, tmp_path / "here.npz", workers=1)
    (tmp_path / "dask").mkdir()
    held: list[int] = []
    with cluster(tmp_path / "dask", 2) as (address, workers):

        def lose_one(done: float, total: float) -> None:
            if not held:
                held.append(len(list((tmp_path / "dask").rglob("*.fmu"))))
                workers[0].kill()

        outcome = sweep(what, tmp_path / "there.npz", scheduler=address, progress=lose_one)
        assert (outcome.done, outcome.failed) == (150, 0)
    assert held[0] in (2, 4)  # both FMUs once on each worker; the second worker may have joined late
    here, there = load(tmp_path / "here.npz"), load(tmp_path / "there.npz")
    order = [there["run"].tolist().index(key) for key in here["run"]]
    for name in set(here.values) - {"wall_s"}:
        assert (here[name] == there[name][order]).all(), name
