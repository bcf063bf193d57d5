"""The master: time, energy, results, and runs that fail."""

import re
import subprocess
import sys
from dataclasses import replace
from pathlib import Path

import numpy as np
import oscillators
import pytest
from hypothesis import given
from hypothesis import strategies as st

from gyro_cosim import Algorithm, GaussSeidel, Jacobi, SlaveError, System, SystemComponent, simulate, system
from gyro_cosim.accuracy.monolith import Monolith
from gyro_cosim.master import macro_steps
from gyro_cosim.trajectory import read_csv

PAIR = system("wheel-pair")


@given(st.floats(1e-6, 10.0), st.floats(1.0, 1000.0))
def test_steps_fill_the_run_with_no_step_too_many(step: float, ratio: float) -> None:
    n = macro_steps(step, step * ratio)
    assert (n - 1) * step < step * ratio * (1 + 1e-12)
    assert n * step >= step * ratio * (1 - 1e-8)


@pytest.mark.parametrize(("step", "stop", "n"), [(1e-3, 1.0, 1000), (0.1, 0.3, 3), (0.3, 1.0, 4), (1.0, 1.0, 1), (0.1, 0.7, 7)])
def test_the_end_is_hit_exactly(step: float, stop: float, n: int) -> None:
    result = simulate(PAIR, step=step, stop=stop, in_process=True)
    assert result.steps == n
    assert result.trajectory.t[-1] == stop
    np.testing.assert_array_equal(result.trajectory.t[:-1], np.arange(n) * step)
    with_components = Monolith(PAIR).solve(result.trajectory.t)
    assert np.abs(result.trajectory.values - with_components.values).max() < 2.0  # the last, shorter step is no jump


def test_a_shorter_last_step_keeps_the_order() -> None:
    """0.5 s are no multiple of these steps; the state at the end must still be right to the algorithm's order."""
    reference = Monolith(oscillators.pair()).solve(np.array([0.0, 0.5])).values[-1]
    steps = np.array([0.012, 0.006, 0.003])
    for algorithm in (Jacobi(1), GaussSeidel(2)):
        ends = [
            simulate(oscillators.pair(), algorithm=algorithm, step=h, stop=0.5, in_process=True).trajectory.values[-1]
            for h in steps
        ]
        errors = [np.abs(end - reference).max() for end in ends]  # fmt: skip
        assert np.polyfit(np.log(steps), np.log(errors), 1)[0] > algorithm.order - 0.3


@pytest.mark.parametrize(
    ("step", "stop", "words"),
    [
        (0.0, 1.0, "`step` must be positive, got 0 s"),
        (-1e-3, 1.0, "`step` must be positive"),
        (float("nan"), 1.0, "`step` must be positive"),
        (2.0, 1.0, "`step` must be at most the run's length of 1 s, got 2 s"),
        (0.1, 0.0, "`stop` must be positive"),
        (0.1, float("inf"), "`stop` must be positive"),
    ],
)
def test_steps_that_make_no_sense_are_refused(step: float, stop: float, words: str) -> None:
    with pytest.raises(ValueError, match=words):
        simulate(PAIR, step=step, stop=stop, in_process=True)


@pytest.mark.parametrize("algorithm", [Jacobi(0), Jacobi(1), Jacobi(2), GaussSeidel(0), GaussSeidel(1)], ids=repr)
@pytest.mark.parametrize("variant", ["linear", "nonlinear"])
def test_energy_residual_is_what_the_coupling_added(algorithm: Algorithm, variant: str) -> None:
    """Against bookkeeping on both sides of the wall, which knows nothing of the inputs that the coupling chose.

    In yaw the wheel pair only has the energy I psi'^2 / 2 + K psi^2 / 2 and no loss: what it gained came through the bond.
    The gyro stores and dissipates what it took. What both together have too much, the coupling made.
    """
    plan = PAIR.with_source("gyro", variant)
    I, K = 0.006 + 1.3e-4, 2 * 14.42 * 0.025 * 0.049

    def deviation(h: float) -> float:
        run = simulate(plan, algorithm=algorithm, step=h, stop=4.0, in_process=True)
        tr, (bond,) = run.trajectory, run.energy
        total = I * tr["vehicle.yaw_rate"] ** 2 / 2 + K * tr["vehicle.yaw_angle"] ** 2 / 2 + tr["gyro.stored_energy"]
        made = total[-1] - total[0] + _integral(tr.t, tr["gyro.dissipated_power"])
        assert bond.share == abs(bond.residual) / bond.exchanged
        return abs(bond.residual - made) / abs(made)

    coarse, fine = deviation(8e-3), deviation(4e-3)
    assert fine < 0.2
    assert fine < 0.6 * coarse or fine < 1e-3  # asymptotically exact: the deviation falls at least with the step


def _integral(t: np.ndarray, y: np.ndarray) -> float:
    from scipy.interpolate import CubicSpline

    return float(CubicSpline(t, y).integrate(t[0], t[-1]))


def test_energy_residual_vanishes_with_the_step() -> None:
    def size(h: float, degree: int) -> float:
        return abs(simulate(PAIR, algorithm=Jacobi(degree), step=h, stop=2.0, in_process=True).energy_residual)

    assert size(1e-3, 0) < size(8e-3, 0) / 6
    assert size(1e-3, 1) < size(8e-3, 1) / 40


def test_a_run_whose_coupling_makes_energy_says_so() -> None:
    """With dampers six times as hard as any assumed the vehicle seems to derail in steps of 1 ms, in steps of 0.2 ms not."""
    plan = system("lrt-curve-b").with_value("gyro.gimbal_damping", 5e5).with_value("gyro.rotor_speed", "2000rpm")
    plan = plan.with_value("vehicle.speed", 8.0).with_value("vehicle.curve_start", 2.0)
    calm, wild = (simulate(plan, step=step, stop=1.0) for step in (2e-4, 1e-3))
    assert (calm.status, calm.coupling_warning) == ("done", "")
    assert wild.status == "ended"
    assert re.match(r"the coupling itself made or lost \S+ of the energy on vehicle\.\w+ x gyro_\w+\.\w+:", wild.coupling_warning)


def test_a_failing_component_is_named_and_the_results_so_far_are_kept() -> None:
    broken = System("s", (SystemComponent("clock", f"{oscillators.HERE}:fails"),), ())
    with pytest.raises(SlaveError, match=r"component 'clock' failed at t = 0\.6.*output 'reading' must be finite") as caught:
        simulate(broken, step=0.1, stop=1.0, in_process=True)
    partial = caught.value.partial
    assert partial.status == "failed"
    assert partial.steps == 5
    np.testing.assert_allclose(partial.trajectory["clock.reading"], partial.trajectory.t, atol=1e-11)


def test_an_interrupt_keeps_what_was_computed() -> None:
    def stop_at_once(done: float, total: float) -> None:
        raise KeyboardInterrupt

    result = simulate(PAIR, step=1e-4, stop=60.0, in_process=True, progress=stop_at_once)
    assert result.status == "interrupted"
    assert 0 < result.steps < 600000
    assert len(result.trajectory) == result.steps + 1


@pytest.mark.parametrize("name", ["run.csv", "run.mat"])
def test_results_come_back_from_files(tmp_path: Path, name: str) -> None:
    trajectory = simulate(PAIR, step=0.01, stop=0.3, in_process=True).trajectory
    trajectory.save(tmp_path / name)
    if name.endswith(".csv"):
        again = read_csv(tmp_path / name)
        np.testing.assert_array_equal(again.values, trajectory.values)  # repr keeps every bit
        assert again.names == trajectory.names
        assert (tmp_path / name).read_text().startswith("time,vehicle.lateral_displacement,")
    else:
        from scipy.io import loadmat

        data = loadmat(tmp_path / name, chars_as_strings=False)
        names = ["".join(column).rstrip() for column in data["name"].T]
        assert names == ["time", *trajectory.names]
        assert "".join(data["Aclass"][3]).rstrip() == "binTrans"
        np.testing.assert_array_equal(data["data_2"][1:].T, trajectory.values)
        np.testing.assert_array_equal(np.abs(data["dataInfo"][1]), np.arange(len(names)) + 1)


def test_a_run_of_built_fmus_loads_no_model_and_no_figure_library() -> None:
    """Start-up is part of every command: what a short run of built FMUs does not need must not be imported."""
    from gyro_cosim.systems import catalogue

    for spec in ("vehicle:wheel_pair", "gyro_unit:linear"):
        catalogue.fmu(spec)
    code = """if True:
        import sys
        from gyro_cosim.cli import main
        main(["run", "wheel-pair", "--stop", "0.1", "--json"])
        print([m for m in ("casadi", "matplotlib", "scipy", "fmpy", "numba", "pandas") if m in sys.modules], file=sys.stderr)
    """
    assert subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True).stderr.strip() == "[]"


def test_a_run_shows_itself_in_five_lines_and_as_a_table_with_a_plot() -> None:
    run = simulate(system("wheel-pair"), step=1e-2, stop=0.5)
    first, *_, last = lines = repr(run).splitlines()
    assert len(lines) == 5
    assert first == "Run of 'wheel-pair': done at t = 0.5 s"
    assert "50 macro steps of 0.01 s" in lines[1]
    assert last.startswith("  coupling energy: ")
    page = run._repr_html_()
    assert page.count("<tr>") == 1 + 8
    assert "vehicle.yaw_angle" in page
    assert "src='data:image/png;base64,iVBOR" in page


def test_what_a_run_shows_executes_nothing_from_a_name() -> None:
    plan = system("wheel-pair")
    run = simulate(replace(plan, name="<script>alert(1)</script>"), step=1e-2, stop=0.02)
    assert "<script" not in run._repr_html_()


def test_a_package_that_is_missing_is_one_line(monkeypatch: pytest.MonkeyPatch) -> None:
    run = simulate(system("wheel-pair"), step=1e-2, stop=0.02)
    for package, what in (("pandas", run.trajectory.to_pandas), ("xarray", run.trajectory.to_xarray)):
        monkeypatch.setitem(sys.modules, package, None)
        with pytest.raises(ModuleNotFoundError, match=rf"needs the package {package}: python -m pip install {package}$"):
            what()
    with pytest.raises(ValueError, match=r"unknown signal 'gyro\.nonsense'"):
        run.trajectory.unit("gyro.nonsense")
