"""What a run keeps: selection, thinning, streaming; adaptive steps; checkpoints that lose no bit."""

import os
import re
import sys
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import casadi as ca
import numpy as np
import oscillators
import pytest

from gyro_cosim import Connection, ConvergenceError, GaussSeidel, Iterated, Jacobi, Run, simulate, system
from gyro_cosim.accuracy.monolith import Monolith
from gyro_cosim.component import Component, build, input_, output, state
from gyro_cosim.coupling import Algorithm, Newton
from gyro_cosim.master import Options, open_network, run, ways
from gyro_cosim.master.adaptive import Adaptive
from gyro_cosim.master.checkpoint import Checkpoint, Resume
from gyro_cosim.master.recording import Recorder, Recording
from gyro_cosim.master.stepping import Stepper
from gyro_cosim.master.time_grid import TimeGrid
from gyro_cosim.systems import StopWhen, System, SystemComponent
from gyro_cosim.trajectory import Origin, Trajectory, matching, read_csv, read_results, read_with_origin
from gyro_cosim.trajectory.sameness import first_difference

PAIR = system("wheel-pair")


@pytest.mark.parametrize("in_process", [True, False])
def test_selection_and_thinning_keep_rows_and_the_end(in_process: bool, tmp_path: Path) -> None:
    whole = simulate(PAIR, step=1e-3, stop=6.0005, in_process=in_process).trajectory
    record = Recording(select=("vehicle.yaw_*", "gyro.yaw_moment"), every=7, stream=tmp_path / "s.csv")
    some = simulate(PAIR, step=1e-3, stop=6.0005, in_process=in_process, options=Options(record=record)).trajectory
    assert some.names == ("vehicle.yaw_angle", "vehicle.yaw_rate", "gyro.yaw_moment")
    chosen = [*range(0, 6001, 7), 6001]
    np.testing.assert_array_equal(some.t, whole.t[chosen])
    np.testing.assert_array_equal(some["vehicle.yaw_angle"], whole["vehicle.yaw_angle"][chosen])
    streamed = read_csv(tmp_path / "s.csv")
    np.testing.assert_array_equal(streamed.values, some.values)
    np.testing.assert_array_equal(streamed.t, some.t)


def test_memory_stays_bounded_when_results_go_to_disk(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    from gyro_cosim.master import recording

    monkeypatch.setattr(recording, "IN_MEMORY", 1000)
    run = simulate(PAIR, step=1e-3, stop=5.0, options=Options(record=Recording(stream=tmp_path / "s.csv")))
    assert run.trajectory.values.size <= 1100
    assert len(read_csv(tmp_path / "s.csv")) == 5001
    assert run.trajectory.end() == read_csv(tmp_path / "s.csv").end()


def test_wrong_recordings_are_refused() -> None:
    with pytest.raises(ValueError, match=r"unknown signal to record: 'vehicle\.yaw_angel'; did you mean 'vehicle\.yaw_angle'"):
        simulate(PAIR, stop=0.1, in_process=True, options=Options(record=Recording(select=("vehicle.yaw_angel",))))
    with pytest.raises(ValueError, match="`every` must be a whole number of at least 1, got 0"):
        Recording(every=0)
    with pytest.raises(ValueError, match=r"streamed to a \.csv file only"):
        Recording(stream=Path("a.mat"))


@pytest.mark.parametrize("estimate", ["doubling", "energy"])
@pytest.mark.parametrize("algorithm", [Jacobi(0), Jacobi(2), GaussSeidel(1), Iterated(1)], ids=lambda a: f"{a.name}-{a.degree}")
def test_adaptive_steps_keep_to_the_tolerance(algorithm: Algorithm, estimate: str) -> None:
    """A tighter tolerance gives more steps and a smaller error; the end is hit exactly."""
    plan = oscillators.pair()
    if estimate == "energy" and isinstance(algorithm, Iterated):
        with pytest.raises(ValueError, match="the energy estimate sees no error of 'iterated'"):
            simulate(plan, algorithm=algorithm, in_process=True, options=Options(adaptive=Adaptive(1e-3, estimate)))
        return

    def done(tolerance: float) -> tuple[int, float]:
        options = Options(adaptive=Adaptive(tolerance, estimate))  # type: ignore[arg-type]
        run = simulate(plan, algorithm=algorithm, step=1e-3, stop=2.0, in_process=True, options=options)
        assert run.trajectory.t[-1] == 2.0
        assert (np.diff(run.trajectory.t) > 0.0).all()
        exact = Monolith(plan).solve(run.trajectory.t)
        size = np.abs(exact.values).max(axis=0)
        return run.steps, float((np.abs(run.trajectory.values - exact.values) / size).max())

    (few, coarse), (many, fine) = done(1e-2), done(1e-3)
    assert many > few
    assert fine < coarse / 2


def test_a_step_that_is_too_long_is_taken_back() -> None:
    run = simulate(oscillators.pair(), step=0.5, stop=1.0, in_process=True, options=Options(adaptive=Adaptive(1e-5)))
    assert run.rejections > 0
    with pytest.raises(ConvergenceError, match=r"must reach the tolerance 1e-12 before its smallest size of 0\.01 s"):
        simulate(
            oscillators.pair(), step=0.5, stop=1.0, in_process=True, options=Options(adaptive=Adaptive(1e-12, smallest=0.01))
        )


@pytest.mark.parametrize("in_process", [True, False])
@pytest.mark.parametrize("algorithm", [Jacobi(2), GaussSeidel(1), Newton(1)], ids=lambda a: a.name)
def test_a_run_that_is_killed_and_resumed_gives_the_same_bytes(algorithm: Algorithm, in_process: bool, tmp_path: Path) -> None:
    """Killed after its last checkpoint at 0.8 s: what stands in the file after it is dropped, the rest follows."""
    plan = PAIR.with_source("gyro", "nonlinear")

    def run(name: str, before_step: Callable[[int], None] | None = None, **more: Any) -> Run:
        options = Options(record=Recording(stream=tmp_path / name), **more)
        return simulate(
            plan, algorithm=algorithm, step=2e-3, stop=2.0, in_process=in_process, options=options, before_step=before_step
        )

    def kill(k: int) -> None:
        if k == 551:
            raise KeyboardInterrupt

    whole = run("whole.csv")
    assert run("part.csv", kill, checkpoint=Checkpoint(tmp_path / "c.npz", every=0.4)).steps == 550
    again = run("part.csv", resume=Resume(tmp_path / "c.npz"))
    assert (tmp_path / "part.csv").read_bytes() == (tmp_path / "whole.csv").read_bytes()
    np.testing.assert_array_equal(again.trajectory.values, whole.trajectory.values)
    assert again.energy_residual == whole.energy_residual


@pytest.mark.parametrize(("before", "after"), [(True, False), (False, True)], ids=["from a file", "into a file"])
def test_a_resumed_run_may_keep_its_rows_elsewhere(before: bool, after: bool, tmp_path: Path) -> None:
    """What fits into memory can go on there, and what was in memory goes into the file first."""

    def record(streams: bool) -> Recording:
        return Recording(stream=tmp_path / "s.csv" if streams else None)

    def kill(k: int) -> None:
        if k == 300:
            raise KeyboardInterrupt

    options = Options(record=record(before), checkpoint=Checkpoint(tmp_path / "c.npz", every=0.2))
    simulate(PAIR, step=1e-3, stop=0.5, options=options, before_step=kill)
    again = simulate(PAIR, step=1e-3, stop=0.5, options=Options(record=record(after), resume=Resume(tmp_path / "c.npz")))
    whole = simulate(PAIR, step=1e-3, stop=0.5)
    np.testing.assert_array_equal(again.trajectory.values, whole.trajectory.values)
    if after:
        np.testing.assert_array_equal(read_csv(tmp_path / "s.csv").values, whole.trajectory.values)


def test_a_resume_that_is_refused_leaves_the_results_as_they_are(tmp_path: Path) -> None:
    record = Recording(stream=tmp_path / "s.csv")
    simulate(PAIR, step=1e-3, stop=0.5, options=Options(record=record, checkpoint=Checkpoint(tmp_path / "c.npz", every=0.2)))
    written = (tmp_path / "s.csv").read_bytes()
    resume = Options(record=record, resume=Resume(tmp_path / "c.npz"))
    with pytest.raises(ValueError, match="must be of this run"):
        simulate(PAIR.with_value("gyro.rotor_speed", "200rpm"), step=1e-3, stop=1.0, options=resume)
    assert (tmp_path / "s.csv").read_bytes() == written
    (tmp_path / "s.csv").write_bytes(written[:100])
    with pytest.raises(
        ValueError, match=r"results file '.*s\.csv' must hold what was streamed before, it has been lost, cut off or exchanged"
    ):
        simulate(PAIR, step=1e-3, stop=1.0, options=resume)
    assert (tmp_path / "s.csv").read_bytes() == written[:100]


def bent() -> Component:
    """y = 3 u + cos(u) / 2 + x with x' = 1: two in a ring are an algebraic loop whose slope changes all the time."""
    return build(
        name="test", variant="bent", description="a bent gain", equations="", internal_step=1e-3,
        variables=[input_("u", "1", "in"), output("y", "1", "out"), state("x", "1", "what is added")],
        model=lambda s: ({"x": 1}, {"y": 3 * s["u"] + ca.cos(s["u"]) / 2 + s["x"]}),
    )  # fmt: skip


def test_an_algebraic_loop_is_solved_alike_after_a_resume_and_in_another_run(tmp_path: Path) -> None:
    """What its solver keeps from point to point decides on the last bits."""
    wires = (Connection(("a", "y"), ("b", "u")), Connection(("b", "y"), ("a", "u")))
    ring = System("ring", tuple(SystemComponent(name, f"{__file__}:bent") for name in "ab"), wires)

    def kill(k: int) -> None:
        if k == 60:
            raise KeyboardInterrupt

    with open_network(ring, in_process=True) as network:
        whole = run(network, Jacobi(1), 0.01, 1.0)
        again = run(network, Jacobi(1), 0.01, 1.0)
    np.testing.assert_array_equal(again.trajectory.values, whole.trajectory.values)
    options = Options(checkpoint=Checkpoint(tmp_path / "c.npz", every=0.4))
    simulate(ring, step=0.01, stop=1.0, in_process=True, before_step=kill, options=options)
    options = Options(resume=Resume(tmp_path / "c.npz"))
    again = simulate(ring, step=0.01, stop=1.0, in_process=True, options=options)
    np.testing.assert_array_equal(again.trajectory.values, whole.trajectory.values)


def test_a_checkpoint_of_another_run_is_refused(tmp_path: Path) -> None:
    file = tmp_path / "c.npz"
    simulate(PAIR, step=1e-3, stop=0.5, options=Options(checkpoint=Checkpoint(file, every=0.2)))
    for changed, step in ((PAIR.with_value("gyro.rotor_speed", "200rpm"), 1e-3), (PAIR, 2e-3)):
        with pytest.raises(ValueError, match=r"must be of this run: same system, values, algorithm, start, step and signals"):
            simulate(changed, step=step, stop=1.0, options=Options(resume=Resume(file)))
    file.write_bytes(b"nonsense")
    with pytest.raises(ValueError, match="must agree with its checksum"):
        simulate(PAIR, step=1e-3, stop=1.0, options=Options(resume=Resume(file)))
    with pytest.raises(ValueError, match="must exist"):
        simulate(PAIR, step=1e-3, stop=1.0, options=Options(resume=Resume(tmp_path / "gone.npz")))
    with pytest.raises(ValueError, match="time between checkpoints must be positive"):
        Checkpoint(file, every=0.0)


def test_trajectories_become_frames_and_datasets() -> None:
    """Where pandas and xarray are installed."""
    trajectory = simulate(PAIR, step=0.01, stop=0.1, in_process=True).trajectory
    frame = pytest.importorskip("pandas") and trajectory.to_pandas()
    assert list(frame.columns) == list(trajectory.names)
    assert frame.index.name == "time"
    assert frame.attrs["units"]["vehicle.yaw_angle"] == "rad"
    np.testing.assert_array_equal(frame["vehicle.yaw_angle"].to_numpy(), trajectory["vehicle.yaw_angle"])
    pytest.importorskip("xarray")
    dataset = trajectory.to_xarray()
    assert dataset["vehicle.yaw_rate"].attrs["units"] == "rad/s"
    np.testing.assert_array_equal(dataset["vehicle.yaw_rate"].sel(time=0.0), trajectory["vehicle.yaw_rate"][0])


@pytest.mark.parametrize("in_process", [True, False])
def test_a_stop_condition_ends_the_run_at_the_step_where_it_holds(in_process: bool) -> None:
    """Some steps later the component could not even go on: what it did there is dropped, and no error."""
    clock = System(
        "s", (SystemComponent("clock", f"{oscillators.HERE}:fails"),), (),
        stop_when=(StopWhen(("clock", "reading"), 0.51, "half a second has passed"),),
    )  # fmt: skip
    run = simulate(clock, step=0.02, stop=1.0, in_process=in_process)
    assert run.status == "ended"
    assert run.ended_by == "half a second has passed at t = 0.52 s"
    assert run.trajectory.t[-1] == pytest.approx(0.52)
    assert run.trajectory["clock.reading"][-1] == pytest.approx(0.52)


def test_a_streamed_file_has_the_bytes_of_a_saved_one_whatever_the_names(tmp_path: Path) -> None:
    names = ("a.y[1,2]", 'a."quoted"', "b.größe", "c.two\nlines")
    t, values = np.array([0.0, 0.1, 1 / 3]), np.array([[1.0, -0.0, 5e-324, 0.1], [1e300, 2.0, np.pi, 7.0], [3.0, 4.0, 5.0, 6.0]])
    whole = Trajectory(t, names, ("1",) * 4, values)
    whole.save(tmp_path / "saved.csv")
    network: Any = SimpleNamespace(names=names, units=whole.units)
    recorder = Recorder(Recording(stream=tmp_path / "streamed.csv"), network, 2)
    recorder.begin()
    recorder.add(0, t[:2], values[:2])
    recorder.add(2, t[2:], values[2:])
    recorder.finish()
    assert (tmp_path / "streamed.csv").read_bytes() == (tmp_path / "saved.csv").read_bytes()
    assert b"\r" not in (tmp_path / "saved.csv").read_bytes()
    back = read_csv(tmp_path / "streamed.csv")
    assert back.names == names
    assert back.values.tobytes() == values.tobytes()


def test_the_state_of_a_run_can_be_compared_and_written() -> None:
    with open_network(system("wheel-pair")) as network:
        first, second = (Stepper(network, Newton(1), TimeGrid.over(1e-2, stop), Options()) for stop in (0.05, 0.05))
        second.go(None, None)
        assert first.state != second.state
        assert second.state.done == 5
        assert first.state.from_arrays(second.state.arrays()) == second.state
        third = Stepper(network, Newton(1), TimeGrid.over(1e-2, 0.05), Options())
        third.go(None, None)
        assert third.state == second.state


NAMES = ("M.y1", "M.y[1]", "M.y*", "M.x", "N.y?")


@pytest.mark.parametrize(
    ("pattern", "meant"),
    [
        ("M.y[1]", ["M.y[1]"]),  # brackets are part of a name
        ("M.y*", ["M.y*"]),  # a signal that is called so
        ("M.*", ["M.y1", "M.y[1]", "M.y*", "M.x"]),
        ("?.y?", ["M.y1", "M.y*", "N.y?"]),
        ("M.y.", []),
        ("m.x", []),
    ],
)
def test_an_exact_name_always_means_that_signal_and_only_star_and_question_mark_are_wild(pattern: str, meant: list[str]) -> None:
    assert matching(pattern, NAMES) == meant
    network: Any = SimpleNamespace(names=NAMES, units=("1",) * len(NAMES))
    if meant:
        assert list(Recorder(Recording(select=(pattern,)), network, 2).names) == meant
    else:
        with pytest.raises(ValueError, match="unknown signal to record:"):
            Recorder(Recording(select=(pattern,)), network, 2)


@pytest.mark.parametrize("options", [Options(adaptive=Adaptive(1e-6)), Options(compiled=False), Options(compiled=True)])
def test_results_do_not_depend_on_how_many_points_are_held(options: Options, monkeypatch: pytest.MonkeyPatch) -> None:
    plan = system("wheel-pair")
    whole = simulate(plan, step=1e-3, stop=0.15, options=options)
    assert whole.steps > 100
    monkeypatch.setattr(ways, "CHUNK_NUMBERS", 1)  # 16 points at once
    pieces = simulate(plan, step=1e-3, stop=0.15, options=options)
    assert pieces.trajectory.t.tobytes() == whole.trajectory.t.tobytes()
    assert pieces.trajectory.values.tobytes() == whole.trajectory.values.tobytes()
    assert pieces.energy == whole.energy


@pytest.mark.parametrize("ending", ["csv", "mat", "parquet", "mf4"])
def test_results_with_names_of_any_script_come_back_from_every_format(ending: str, tmp_path: Path) -> None:
    names = ("ψ.角度", "a.y[1,2]", 'a."quoted, too"', "b.größe", "c.time [s]")
    t, values = np.array([0.0, 0.1, 1 / 3]), np.arange(15.0).reshape(3, 5) / 7
    values[1, 2], values[2, 0] = np.nan, -0.0
    file = tmp_path / f"r.{ending}"
    origin = Origin(("run", "größe.ssp"), "..", {"gyro-cosim": "1"}, {"größe.ssp": "00"})
    Trajectory(t, names, ("rad", "1", "", "°C", "[m]"), values).save(file, origin)
    back, told = read_with_origin(file)
    assert (back.names, back.units) == (names, ("rad", "1", "", "°C", "[m]"))
    assert (back.t.tobytes(), np.ascontiguousarray(back.values).tobytes()) == (t.tobytes(), values.tobytes())
    assert told is not None
    assert replace(told, units={}) == origin
    Trajectory(t[:0], names, ("",) * 5, values[:0]).save(file)
    back, told = read_with_origin(file)
    assert (back.names, back.values.shape, told) == (names, (0, 5), None)
    file.write_bytes(b"time\x00\xff")
    with pytest.raises(ValueError, match=f"'.*r.{ending}' must be a .{ending} that holds results over time: "):
        read_results(file)


def test_a_mat_file_of_a_modelica_tool_is_read_with_aliases_and_constants(tmp_path: Path) -> None:
    """Its second matrix holds series, its first constants; a negative place is an alias with the sign turned."""
    from scipy.io import savemat

    def text(*lines: str) -> np.ndarray:
        return np.array([list(line.ljust(16)) for line in lines])

    data = {
        "Aclass": text("Atrajectory", "1.1", "", "binNormal"), "name": text("time", "x", "minus_x", "mass"),
        "description": text("time in [s]", "position [m]", "", "mass [kg]"),
        "dataInfo": np.array([[0, 1, 0, -1], [2, 2, 0, -1], [2, -2, 0, -1], [1, 2, 0, -1]], dtype=np.int32),
        "data_1": np.array([[0.0, 5.0], [1.0, 5.0]]), "data_2": np.array([[0.0, 1.0], [0.5, 2.0], [1.0, 4.0]]),
    }  # fmt: skip
    savemat(tmp_path / "m.mat", data, format="4")
    back = read_results(tmp_path / "m.mat")
    assert (back.names, back.units) == (("x", "minus_x", "mass"), ("m", "", "kg"))
    np.testing.assert_array_equal(back.values, [[1, -1, 5], [2, -2, 5], [4, -4, 5]])


def test_a_file_that_cannot_be_written_whole_leaves_the_old_one(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    whole = Trajectory(np.arange(3.0), ("a",), ("",), np.arange(3.0)[:, None])
    for file in (tmp_path / "r.csv", tmp_path / "r.mf4"):
        whole.save(file)
        monkeypatch.setattr(os, "fsync", lambda descriptor: (_ for _ in ()).throw(OSError(28, "No space left on device")))
        with pytest.raises(OSError, match="No space left") as failure:
            Trajectory(np.arange(2.0), ("b",), ("",), np.arange(2.0)[:, None]).save(file)
        assert Path(failure.value.filename) == file
        monkeypatch.undo()
        assert read_results(file).names == ("a",)
    assert sorted(p.name for p in tmp_path.iterdir()) == ["r.csv", "r.mf4"]


def test_the_first_difference_of_two_results_is_named() -> None:
    t, values = np.arange(4.0), np.arange(8.0).reshape(4, 2)
    values[3, 1] = np.nan
    one = Trajectory(t, ("a", "b"), ("m", ""), values)
    assert first_difference(one, Trajectory(t.copy(), ("a", "b"), ("m", ""), values.copy())) is None
    other = values.copy()
    other[1, 1], other[2, 0], other[0, 0] = 3.0 + 5e-16, 9.0, -0.0
    told = first_difference(one, replace(one, values=other))
    assert str(told) == "value of a at t = 0 s was 0.0, is -0.0 (and at 2 points more)"
    other[0, 0] = 0.0
    assert str(first_difference(one, replace(one, values=other))).startswith(
        "value of b at t = 1 s was 3.0, is 3.0000000000000004"
    )
    late = np.array([0.0, 1.0, 2.0, 3.0 + 1e-15])
    assert str(first_difference(one, replace(one, t=late))).startswith("time at t = 3 s was 3.0, is 3.000000000000001")
    short = Trajectory(t[:3], one.names, one.units, values[:3])
    assert str(first_difference(one, short)) == "length at t = 3 s was 4 points, is 3 points"
    assert str(first_difference(one, replace(one, names=("a", "c")))) == "signals of b was there, is lost"
    assert str(first_difference(one, replace(one, units=("m", "s")))) == "units of b was '', is 's'"


@pytest.mark.skipif(sys.platform == "win32", reason="signals end no process there")
def test_a_reader_of_mf4_that_crashes_or_fails_is_one_line(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """asammdf ends its process at some damaged files."""
    file, package = tmp_path / "run.mf4", tmp_path / "asammdf"
    file.write_bytes(b"MDF     4.10    damaged")
    package.mkdir()
    monkeypatch.setenv("PYTHONPATH", str(tmp_path))
    for code, says in (
        ("import os; os.kill(os.getpid(), 11)", "asammdf, which reads it, ended with signal 11"),
        ("import os; os._exit(3)", "asammdf, which reads it, ended with exit code 3"),
        ("def MDF(file):\n    print('noise')\n    raise KeyError('one\\ntwo')", "KeyError: 'one"),
    ):
        (package / "__init__.py").write_text(code)
        with pytest.raises(
            ValueError, match=re.escape(f"{str(file)!r} must be a .mf4 that holds results over time: {says}")
        ) as error:
            read_results(file)
        assert "\n" not in str(error.value)
