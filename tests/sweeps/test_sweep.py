"""Sweeps: axes, rows, files, wrong use, a full disk, maps. test_sweep_workers.py: the processes that do them."""

import dataclasses
import errno
import os
import stat
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import oscillators
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from gyro_cosim import GaussSeidel, Jacobi, System, SystemComponent, simulate, system
from gyro_cosim.sweeps import Listed, Measure, Ranged, Sweep, load, parse, sweep
from gyro_cosim.sweeps.axes import points
from gyro_cosim.sweeps.store import journal_of
from gyro_cosim.sweeps.table import MARK, Table, write
from gyro_cosim.systems import StopWhen
from gyro_cosim.trajectory import Trajectory

SPIN = {"gyro.rotor_speed": "0rpm:300rpm:6"}
FAILS = System("alone", (SystemComponent("clock", f"{oscillators.HERE}:fails"),), ())


CASES = {
    "slow": {"vehicle.speed": "18km/h", "vehicle.lateral_displacement": 0.002},
    "fast": {"vehicle.speed": 20.0, "vehicle.lateral_displacement": "1mm"},
}


def swings(trajectory: Trajectory) -> dict[str, float]:
    """A measure: how often y goes through zero, and its mean. It refuses runs of less than 20 points."""
    y = trajectory["vehicle.lateral_displacement"]
    if y.size < 20:
        raise ValueError("too short to count")
    return {"mean": float(y.mean()), "swings": float(np.sum(y[1:] * y[:-1] < 0))}


def misnamed(trajectory: Trajectory) -> dict[str, float]:
    """A measure that returns something else than it says."""
    return {"end": float(trajectory.t[-1])}


COUNTED = Measure(swings, {"mean": "m", "swings": "1"})


def short(values: dict[str, str] | None = None, **options: Any) -> Sweep:
    """A sweep of runs of 50 ms."""
    return Sweep(system("wheel-pair"), SPIN if values is None else values, stop=0.05, **options)


@pytest.mark.parametrize(
    ("text", "axis"),
    [
        ("1:5:5", Listed("a", (1.0, 2.0, 3.0, 4.0, 5.0))),
        ("1:100:3:log", Listed("a", (1.0, 10.0, 100.0))),
        ("3, 1,2", Listed("a", (3.0, 1.0, 2.0))),
        ("7", Listed("a", (7.0,))),
        ("-1:1", Ranged("a", -1.0, 1.0)),
        ("1:9:log", Ranged("a", 1.0, 9.0, log=True)),
    ],
)
def test_an_axis_is_a_grid_a_list_or_a_range(text: str, axis: Listed | Ranged) -> None:
    got = parse("a", text, float)
    if isinstance(axis, Listed):
        assert isinstance(got, Listed)
        assert got.values == pytest.approx(axis.values, rel=1e-15)  # geomspace rounds
    else:
        assert got == axis


@settings(deadline=None)  # the first call imports scipy.stats
@given(st.integers(1, 50), st.integers(1, 4), st.integers(0, 9))
def test_a_latin_hypercube_has_one_sample_in_each_stratum(samples: int, dimensions: int, seed: int) -> None:
    axes = [Ranged(f"x{k}", 0.0, 1.0) for k in range(dimensions)]
    drawn = points(axes, samples, seed)
    cube = np.array([[float(point[axis.target]) for axis in axes] for point in drawn])
    strata = np.sort(np.floor(cube * samples).astype(int), axis=0)
    assert (strata == np.arange(samples)[:, None]).all()
    assert points(axes, samples, seed) == drawn
    assert samples == 1 or points(axes, samples, seed + 1) != drawn


def test_ranges_are_sampled_together_and_multiplied_with_lists() -> None:
    axes = [Listed("v", ("a", "b")), Ranged("x", 1.0, 100.0, log=True), Ranged("y", -1.0, 1.0)]
    runs = points(axes, samples=10, seed=1)
    assert len(runs) == 20
    assert [p["v"] for p in runs] == ["a"] * 10 + ["b"] * 10
    assert [(p["x"], p["y"]) for p in runs[:10]] == [(p["x"], p["y"]) for p in runs[10:]]
    assert sum(float(p["x"]) < 10.0 for p in runs[:10]) == 5  # half of a logarithmic range lies below its middle decade


@pytest.mark.parametrize("suffix", [".npz", ".csv", ".parquet"])
def test_rows_are_what_single_runs_give(tmp_path: Path, suffix: str) -> None:
    file = tmp_path / f"a{suffix}"
    what = short({"gyro.rotor_speed": "100rpm,200rpm"}, variants={"gyro": ("linear", "nonlinear")},
                 algorithms=("jacobi", "gauss-seidel"), steps=(1e-3, 2e-3))  # fmt: skip
    outcome = sweep(what, file, workers=1)
    assert (outcome.runs, outcome.done, outcome.failed, outcome.before) == (16, 16, 0, 0)
    table = load(file)
    assert len(table) == 16
    assert table.unit("vehicle.yaw_angle.rms") == "rad"
    assert set(table["status"].tolist()) == {"done"}
    for i in (0, 5, 15):
        plan = (
            system("wheel-pair")
            .with_source("gyro", str(table["gyro"][i]))
            .with_value("gyro.rotor_speed", table["gyro.rotor_speed"][i])
        )
        algorithm = Jacobi(1) if table["algorithm"][i] == "jacobi" else GaussSeidel(1)
        run = simulate(plan, algorithm=algorithm, step=float(table["step"][i]), stop=0.05)
        y = run.trajectory["vehicle.yaw_angle"]
        assert table["vehicle.yaw_angle.end"][i] == y[-1]  # the compiled loop and the plain one agree to the last bit
        assert table["vehicle.yaw_angle.max"][i] == np.abs(y).max()
        assert table["vehicle.yaw_angle.rms"][i] == pytest.approx(np.sqrt(np.mean(y**2)), rel=1e-14)
        assert table["energy_residual"][i] == pytest.approx(run.energy_residual, rel=1e-12)
        assert table["steps"][i] == run.steps


def test_rows_do_not_depend_on_the_number_of_workers(tmp_path: Path) -> None:
    for n in (1, 2):
        assert sweep(short(), tmp_path / f"{n}.npz", workers=n).done == 6
    one, two = load(tmp_path / "1.npz"), load(tmp_path / "2.npz")
    order = [two["run"].tolist().index(key) for key in one["run"]]
    for name in set(one.values) - {"wall_s"}:
        assert (one[name] == two[name][order]).all(), name


def test_a_file_of_format_1_is_drawn_but_not_gone_on_with(tmp_path: Path) -> None:
    """Its samples were drawn otherwise: a sweep that went on would hold two hypercubes."""
    file = tmp_path / "old.npz"
    what = short({"gyro.rotor_speed": "0rpm:300rpm"}, samples=3)
    sweep(what, file, workers=1)
    table = load(file)
    write(Table({**table.head, MARK: 1}, table.values), file)
    before = file.read_bytes()
    for extend in (False, True):
        with pytest.raises(
            ValueError, match=r"old.npz' must be a sweep of format 2 to go on, has format 1, which can only be drawn"
        ):
            sweep(what, file, workers=1, extend=extend)
    assert file.read_bytes() == before
    assert not journal_of(file).exists()
    assert len(load(file)) == 3


def test_a_failed_run_is_a_row_with_its_error_and_what_came_before(tmp_path: Path) -> None:
    outcome = sweep(Sweep(FAILS, {"clock.breaks_at": "0.35,5"}, steps=(0.1,), stop=1.0), tmp_path / "a.npz", workers=1)
    assert (outcome.done, outcome.failed) == (2, 1)
    table = load(tmp_path / "a.npz")
    bad, good = np.argsort(table["clock.breaks_at"])
    assert table["status"][[bad, good]].tolist() == ["failed", "done"]
    assert "component 'clock' failed at t = 0.4" in table["error"][bad]
    assert table["t_end"][[bad, good]] == pytest.approx([0.3, 1.0])
    assert table["clock.reading.end"][bad] == pytest.approx(0.3)


def test_a_run_that_a_stop_condition_ends_says_so(tmp_path: Path) -> None:
    stop = StopWhen(("vehicle", "lateral_displacement"), 0.002, "out of the gauge")
    plan = dataclasses.replace(system("wheel-pair"), stop_when=(stop,))
    sweep(Sweep(plan, {"vehicle.lateral_displacement": "0.0015,-1"}, stop=0.05), tmp_path / "a.npz", workers=1)
    table = load(tmp_path / "a.npz")
    assert table["status"].tolist() == ["ended", "done"]
    assert table["ended_by"][0].startswith("out of the gauge at t = ")
    assert table["t_end"][0] < 0.05 == table["t_end"][1]


def test_starting_again_repeats_nothing_and_extending_adds(tmp_path: Path) -> None:
    file = tmp_path / "a.csv"
    sweep(short(), file, workers=1)
    before = file.read_text()
    again = sweep(short(), file, workers=1)
    assert (again.before, again.done) == (6, 0)
    assert file.read_text() == before
    wider = short({"gyro.rotor_speed": "0rpm:600rpm:11"})
    with pytest.raises(ValueError, match=r"another sweep, which differs in axes; give another file; --extend adds"):
        sweep(wider, file, workers=1)
    assert file.read_text() == before
    more = sweep(wider, file, workers=1, extend=True)
    assert (more.before, more.done) == (6, 5)
    assert len(load(file)) == 11


def test_a_full_disk_is_one_line_and_costs_no_row(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, cosim: Callable[..., Any]
) -> None:
    file, write, room = tmp_path / "a.npz", os.write, [6000]

    def on_a_small_disk(descriptor: int, data: Any) -> int:
        """Takes what there is room for, then refuses, as a file system does; pipes have room."""
        if not stat.S_ISREG(os.fstat(descriptor).st_mode):
            return write(descriptor, data)
        if room[0] == 0:
            raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))
        done = write(descriptor, data[: room[0]])
        room[0] -= done
        return done

    options = (
        "sweep",
        "wheel-pair",
        "--set",
        "gyro.rotor_speed=0rpm:300rpm:30",
        "--stop",
        "0.05",
        "--lanes",
        "1",
        "--workers",
        "1",
        "--output",
        str(file),
    )
    monkeypatch.setattr("gyro_cosim.sweeps.store.os.write", on_a_small_disk)
    code, out, err = cosim(*options)
    assert (code, out) == (1, "")
    assert err == f"cosim: {journal_of(file)}: No space left on device\n"
    monkeypatch.undo()
    kept = len(load(file))
    assert journal_of(file).read_bytes().endswith(b"]\n")  # nothing torn
    code, out, err = cosim(*options)
    assert (code, err) == (0, "")
    assert f"30 runs of wheel-pair: {kept} were in the file, {30 - kept} done now" in out
    assert len(load(file)) == 30


SWEEP = ("sweep", "wheel-pair", "--stop", "0.05", "--output", "new.npz")


def test_a_case_sets_several_values_at_once(tmp_path: Path) -> None:
    file = tmp_path / "a.npz"
    sweep(short({"gyro.rotor_speed": "0rpm,100rpm"}, cases=CASES), file, workers=1)
    table = load(file)
    assert sorted(zip(table["case"].tolist(), table["gyro.rotor_speed"].round(2).tolist(), strict=True)) == [
        ("fast", 0.0), ("fast", 10.47), ("slow", 0.0), ("slow", 10.47)
    ]  # fmt: skip
    for i in range(4):
        plan = system("wheel-pair").with_value("gyro.rotor_speed", table["gyro.rotor_speed"][i])
        for target, value in CASES[str(table["case"][i])].items():
            plan = plan.with_value(target, value)
        assert table["vehicle.yaw_angle.end"][i] == simulate(plan, stop=0.05).trajectory["vehicle.yaw_angle"][-1]
    more = short({"gyro.rotor_speed": "0rpm,100rpm"}, cases={"faster": {"vehicle.speed": 30.0}})
    assert sweep(more, file, workers=1, extend=True).done == 2
    other = short({"gyro.rotor_speed": "0rpm,100rpm"}, cases={"faster": {"vehicle.speed": 31.0}})
    with pytest.raises(ValueError, match="holds another sweep, which differs in cases; give another file"):
        sweep(other, file, workers=1, extend=True)


def test_the_same_values_under_another_name_are_the_same_run(tmp_path: Path) -> None:
    file = tmp_path / "a.npz"
    sweep(short({}, cases=CASES), file, workers=1)
    again = sweep(short({}, cases={"renamed": CASES["slow"]}), file, workers=1, extend=True)
    assert (again.before, again.done) == (1, 0)


def test_ones_own_measure_is_a_column(tmp_path: Path) -> None:
    sweep(short(signals=("vehicle.yaw_angle",), measure=COUNTED), tmp_path / "a.csv", workers=2)
    table = load(tmp_path / "a.csv")
    assert list(table.values)[-4:] == ["vehicle.yaw_angle.max", "vehicle.yaw_angle.rms", "mean", "swings"]
    assert (table.unit("mean"), table.unit("swings")) == ("m", "1")
    plan = system("wheel-pair").with_value("gyro.rotor_speed", table["gyro.rotor_speed"][3])
    assert table["mean"][3] == swings(simulate(plan, stop=0.05).trajectory)["mean"]  # of the same numbers, to the last bit


@pytest.mark.parametrize(
    ("measure", "stop", "words"),
    [
        (COUNTED, 0.01, "measuring the run: ValueError: too short to count"),
        (Measure(misnamed, {"last": "s"}), 0.05, "a measure must return last, got end"),
    ],
)
def test_a_measure_that_fails_is_a_row_with_its_error(tmp_path: Path, measure: Measure, stop: float, words: str) -> None:
    what = dataclasses.replace(short(measure=measure), stop=stop)
    assert sweep(what, tmp_path / "a.npz", workers=1).failed == 6
    table = load(tmp_path / "a.npz")
    assert all(words in error for error in table["error"])
    assert np.isnan(table[next(iter(measure.columns))]).all()
    assert np.isfinite(table["vehicle.yaw_angle.end"]).all()  # the run itself is kept


def test_another_measure_makes_another_sweep(tmp_path: Path) -> None:
    sweep(short(measure=COUNTED), tmp_path / "a.npz", workers=1)
    with pytest.raises(ValueError, match="holds another sweep, which differs in measure"):
        sweep(short(measure=Measure(misnamed, COUNTED.columns)), tmp_path / "a.npz", workers=1)


def test_wrong_cases_and_measures_are_refused() -> None:
    with pytest.raises(ValueError, match=r"'gyro.rotor_speed' must be an axis or be set by case 'a', got both"):
        short(cases={"a": {"gyro.rotor_speed": 5.0}}).plan()
    with pytest.raises(ValueError, match="unknown parameter of 'vehicle': 'sped'; did you mean 'speed'"):
        short(cases={"a": {"vehicle.sped": 5.0}}).plan()
    with pytest.raises(ValueError, match="a measure must be a function at the top of a module"):
        Measure(lambda trajectory: {"a": 0.0}, {"a": "1"})
    with pytest.raises(ValueError, match="a measure must name at least one column"):
        Measure(swings, {})


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (("--set", "gyro.rotorspeed=1:2:3"), "unknown parameter of 'gyro': 'rotorspeed'; did you mean 'rotor_speed'"),
        (("--set", "giro.rotor_speed=1:2:3"), "'giro'"),
        (("--set", "giro=linear,nonlinear"), "'giro'"),
        (("--gyro", "linear,liner"), "unknown variant of gyro_unit 'liner'"),
        (("--set", "gyro.rotor_speed=2:2:3"), "axis 'gyro.rotor_speed': the range must not be empty, got 2 to 2"),
        (("--set", "gyro.rotor_speed=2:1"), "axis 'gyro.rotor_speed': the range must not be empty, got 2 to 1"),
        (("--set", "gyro.rotor_speed=1:2:1"), "N in LOW:HIGH:N must be a whole number of at least 2, got '1'"),
        (("--set", "gyro.rotor_speed=1:2:3:4"), "must be LOW:HIGH:N, LOW:HIGH"),
        (("--set", "gyro.rotor_speed=-1:2:3:log"), "a logarithmic range must begin above 0, got -1"),
        (("--set", "gyro.rotor_speed=1,1"), "values must differ, got 1.0 twice"),
        (("--set", "gyro.rotor_speed=1kg:2kg:3"), "gyro.rotor_speed: unit 'kg' cannot be expressed in 'rad/s'"),
        (("--set", "vehicle.speed=0:5:3"), "vehicle.speed: must be at least 0.1 m/s, got 0"),
        (("--set", "gyro.rotor_speed=1:2"), "is a range: say how many values (LOW:HIGH:N), or how many samples (--lhs N)"),
        (("--set", "gyro.rotor_speed=1:2:3", "--lhs", "5"), "a Latin hypercube must have a range LOW:HIGH to sample"),
        (("--set", "gyro.rotor_speed=1:2", "--lhs", "0"), "the number of samples must be at least 1, got 0"),
        (("--set", "gyro.rotor_speed=1:2:3", "--set", "gyro.rotor_speed=1:2:3"), "axis 'gyro.rotor_speed' must be given once"),
        (("--set", "gyro.rotor_speed=5"), "a sweep must have an axis, has none"),
        (("--set", "gyro.rotor_speed"), "--set must be COMPONENT.PARAMETER=VALUE or COMPONENT=VARIANT, got"),
        (("--set", "gyro.rotor_speed=1:2:3", "--step", "1"), "`step` must be at most the run's length of 0.05 s, got 1 s"),
        (("--algorithm", "jacobi,magic"), "algorithm must be one of jacobi"),
        (("--order", "0,x"), "--degree must be degrees such as 0,1,2, got '0,x'"),
        (("--order", "0,1", "--signals", "gyro.eta"), "unknown signal 'gyro.eta'"),
        (("--order", "0,1", "--workers", "0"), "the number of workers must be at least 1, got 0"),
        (("--order", "0,1", "--output", "a.xls"), "sweep file must end in .npz, .csv, .parquet, got 'a.xls'"),
        (("--order", "0,1", "--output", "no/a.npz"), "the folder of 'no/a.npz' must exist"),
        (("--order", "0,1", "--scheduler", "tcp://127.0.0.1:1"), "a Dask scheduler must answer at 'tcp://127.0.0.1:1'"),
    ],
)
def test_wrong_use_is_one_line_and_leaves_nothing(
    cosim: Callable[..., Any], arguments: tuple[str, ...], words: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("gyro_cosim.sweeps.cluster.ANSWERS_WITHIN", 0.5)
    code, out, err = cosim(*SWEEP, *arguments)
    assert code == 2, err
    assert out == ""
    assert words in err
    assert err.count("\n") == 1
    assert list(Path().iterdir()) == []


@pytest.mark.parametrize("content", ["", "time,a\n0,1\n", '# {"cosim sweep": 1}\nrun\n'], ids=["empty", "a run", "damaged"])
def test_a_file_that_is_no_sweep_is_left_alone(cosim: Callable[..., Any], content: str) -> None:
    for name in ("a.csv", "b.npz.journal"):
        Path(name).write_text(content or "\n")
        code, _, err = cosim("sweep", "wheel-pair", "--order", "0,1", "--stop", "0.05", "--output", name.removesuffix(".journal"))
        assert code == 2
        assert "holds something else" in err
        assert Path(name).read_text() == (content or "\n")
    assert sorted(p.name for p in Path().iterdir()) == ["a.csv", "b.npz.journal"]


def test_plot_draws_maps_curves_and_runs(cosim: Callable[..., Any]) -> None:
    grid = ("--set", "gyro.rotor_speed=1:9:4", "--set", "vehicle.speed=1:20:3:log", "--gyro", "linear,nonlinear")
    assert cosim("sweep", "wheel-pair", "--stop", "0.05", *grid, "--output", "grid.npz")[0] == 0
    cube = ("--set", "gyro.rotor_speed=1:9", "--set", "vehicle.speed=1:20:log", "--lhs", "12")
    assert cosim("sweep", "wheel-pair", "--stop", "0.05", *cube, "--output", "cube.csv")[0] == 0
    assert cosim("run", "wheel-pair", "--stop", "0.05", "--output", "run.csv")[0] == 0
    measure = "vehicle.yaw_angle.rms"
    for arguments in (
        ("grid.npz", "gyro.rotor_speed", "vehicle.speed", measure),
        ("grid.npz", "gyro.rotor_speed", measure, "--where", "vehicle.speed=20"),
        ("cube.csv", "gyro.rotor_speed", "vehicle.speed", measure),
        ("cube.csv", "gyro.rotor_speed", measure),
        ("run.csv", "vehicle.yaw_angle", "gyro.gimbal_angle"),
    ):
        code, out, err = cosim("plot", *arguments, "-o", "a.png")
        assert (code, err, out) == (0, "", "wrote a.png\n")
        assert Path("a.png").read_bytes().startswith(b"\x89PNG")
        Path("a.png").unlink()
    for arguments, words in (
        (("gone.npz", "a"), "file 'gone.npz' must exist"),
        (
            ("grid.npz", "gyro.rotor_sped", "vehicle.speed", measure),
            "unknown column of the sweep: 'gyro.rotor_sped'; did you mean",
        ),
        (("grid.npz", "gyro", "vehicle.speed", measure), "column 'gyro' must hold numbers to be drawn, holds text"),
        (("grid.npz", measure), "a sweep is drawn over X Y MEASURE, or X MEASURE, got 1 name(s)"),
        (("grid.npz", "gyro.rotor_speed", measure, "--where", "vehicle.speed=3"), "must have a value of the sweep"),
        (("cube.csv", "gyro.rotor_speed", measure, "--where", "gyro"), "--where must be NAME=VALUE, got 'gyro'"),
        (("run.csv", "vehicle.yaw"), "unknown signal 'vehicle.yaw'"),
        (("run.csv", "vehicle.yaw_angle", "--where", "a=1"), "--where is for the file of a sweep"),
    ):
        code, out, err = cosim("plot", *arguments)
        assert (code, out) == (2, "")
        assert words in err
    assert not list(Path().glob("*.png"))
