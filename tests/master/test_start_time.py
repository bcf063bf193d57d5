"""Runs that begin at another time than 0: t = start + n h, and nothing else changes."""

import re
import shlex
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import oscillators
import pytest

from gyro_cosim import GaussSeidel, Jacobi, System, SystemComponent, simulate, system
from gyro_cosim.accuracy.certificate import certify
from gyro_cosim.accuracy.convergence import converge
from gyro_cosim.accuracy.monolith import Monolith
from gyro_cosim.coupling import Algorithm, Nepce, Newton
from gyro_cosim.kernel import driver
from gyro_cosim.master import Options, macro_steps, open_network, run
from gyro_cosim.master.adaptive import Adaptive
from gyro_cosim.master.checkpoint import Checkpoint, Resume
from gyro_cosim.master.recording import Recording
from gyro_cosim.ssp.packing import pack
from gyro_cosim.sweeps import Sweep

PAIR = system("wheel-pair")
LATE, STEP = 64.0, 2.0**-9  # times and their differences are then exact, and so must be every bit of the results


@pytest.mark.parametrize("algorithm", [Jacobi(0), Jacobi(2), GaussSeidel(1), Nepce(1), Newton(2)], ids=repr)
@pytest.mark.parametrize("in_process", [True, False], ids=["components", "fmus"])
def test_a_system_without_a_clock_does_the_same_at_any_time(algorithm: Algorithm, in_process: bool) -> None:
    """A stop that is no multiple of the step, so that the shorter last step is there too."""
    at_0, late = (
        simulate(oscillators.pair(), algorithm=algorithm, step=STEP, start=t, stop=t + 1.2500001, in_process=in_process)
        for t in (0.0, LATE)
    )
    np.testing.assert_array_equal(late.trajectory.values[:-1], at_0.trajectory.values[:-1])
    np.testing.assert_array_equal(late.trajectory.t[:-1], LATE + np.arange(641) * STEP)
    np.testing.assert_allclose(late.trajectory.values[-1], at_0.trajectory.values[-1], rtol=1e-12)
    assert (late.start, late.trajectory.t[-1], late.steps) == (LATE, LATE + 1.2500001, at_0.steps)
    assert late.energy[0].residual == pytest.approx(at_0.energy[0].residual, rel=1e-9)


def test_plain_path_and_both_inner_loops_agree_on_the_bits_at_a_crooked_start(monkeypatch: pytest.MonkeyPatch) -> None:
    found = []
    for fits, compiled in ((lambda *_: False, False), (driver.fits, False), (driver.fits, True)):
        with monkeypatch.context() as patch:
            patch.setattr(driver, "fits", fits)
            options = Options(compiled=compiled)
            found.append(simulate(PAIR, algorithm=Jacobi(2), step=1e-3, start=12.3456, stop=14.0, options=options).trajectory)
    for other in found[1:]:
        np.testing.assert_array_equal(other.t, found[0].t)
        np.testing.assert_array_equal(other.values, found[0].values)
    np.testing.assert_array_equal(found[0].t[:-1], 12.3456 + np.arange(1655) * 1e-3)


@pytest.mark.parametrize("start", [-3.0, 1e6, 1e9])
def test_far_from_zero_no_step_is_too_many_and_the_end_is_hit(start: float) -> None:
    assert macro_steps(1e-3, start + 0.7, start) == 700
    t = simulate(PAIR, step=1e-3, start=start, stop=start + 0.7, in_process=True).trajectory.t
    assert (len(t), t[0], t[-1]) == (701, start, start + 0.7)
    assert (np.diff(t) > 0.0).all()


@pytest.mark.parametrize("in_process", [True, False], ids=["component", "fmu"])
def test_a_sampled_part_keeps_to_the_clock(in_process: bool) -> None:
    """It ticks at whole multiples of its period, wherever the run begins: at 0.01, 0.02, ..., 0.09 s."""
    plan = System("s", (SystemComponent("s", f"{oscillators.HERE}:counter"),), ())
    end = simulate(plan, step=0.01, start=0.005, stop=0.1, in_process=in_process).trajectory.end()
    assert end["s.count"] == 9
    assert end["s.total"] == pytest.approx(0.01 * sum(range(1, 10)), rel=1e-9)


@pytest.mark.parametrize("estimate", ["doubling", "energy"])
def test_adaptive_steps_begin_and_end_where_told(estimate: str) -> None:
    options = Options(adaptive=Adaptive(1e-3, estimate))  # type: ignore[arg-type]
    at_0, late = (
        simulate(oscillators.pair(), step=1e-3, start=t, stop=t + 2.0, in_process=True, options=options) for t in (0.0, LATE)
    )
    assert (late.trajectory.t[0], late.trajectory.t[-1], late.steps) == (LATE, LATE + 2.0, at_0.steps)
    exact = Monolith(oscillators.pair()).solve(late.trajectory.t - LATE)
    size = np.abs(exact.values).max(axis=0)
    assert (np.abs(late.trajectory.values - exact.values) / size).max() < 0.03


@pytest.mark.parametrize("in_process", [True, False], ids=["components", "fmus"])
def test_a_late_run_that_is_killed_and_resumed_gives_the_same_bytes(in_process: bool, tmp_path: Path) -> None:
    def late(name: str, before_step: Callable[[int], None] | None = None, **more: Any) -> Any:
        options = Options(record=Recording(stream=tmp_path / name), **more)
        return simulate(PAIR, step=2e-3, start=5.3, stop=7.0, in_process=in_process, options=options, before_step=before_step)

    def kill(k: int) -> None:
        if k == 551:
            raise KeyboardInterrupt

    late("whole.csv")
    assert late("part.csv", before_step=kill, checkpoint=Checkpoint(tmp_path / "c.npz", every=0.4)).steps == 550
    late("part.csv", resume=Resume(tmp_path / "c.npz"))
    assert (tmp_path / "part.csv").read_bytes() == (tmp_path / "whole.csv").read_bytes()


def test_a_checkpoint_of_another_start_is_refused(tmp_path: Path) -> None:
    file = tmp_path / "c.npz"
    simulate(PAIR, start=1.0, stop=1.5, options=Options(checkpoint=Checkpoint(file, every=0.2)))
    with pytest.raises(ValueError, match="same system, values, algorithm, start, step and signals"):
        simulate(PAIR, start=0.9, stop=1.5, options=Options(resume=Resume(file)))


def test_certificate_and_ladder_are_those_of_a_run_from_zero() -> None:
    plan = oscillators.pair()
    errors = []
    for start in (0.0, LATE):
        with open_network(plan, in_process=True) as network:
            result = run(network, Jacobi(1), STEP, start + 1.0, start=start)
            errors.append([e.largest for e in certify(network, result, start + 1.0).errors])
    assert errors[0] == errors[1]
    ladders = [
        converge(replace(plan, start=t, stop=t + 1.0), [Jacobi(1)], step=4 * STEP, rungs=3, stop=t + 1.0, in_process=True)
        for t in (0.0, LATE)
    ]
    assert ladders[0].ladders[0].errors == ladders[1].ladders[0].errors
    assert ladders[1].ladders[0].observed_order == pytest.approx(2.0, abs=0.1)
    with pytest.raises(
        ValueError, match=r"`stop` must be a multiple of the coarsest step 0\.3 s after the start at 64 s, got 65 s"
    ):
        converge(replace(plan, start=LATE), [Jacobi(1)], step=0.3, rungs=2, stop=LATE + 1.0, in_process=True)


def test_a_system_file_says_when_its_runs_begin(tmp_path: Path, cosim_json: Callable[..., dict[str, Any]]) -> None:
    pack(replace(PAIR, start=2.5, stop=3.0), tmp_path / "late.ssp")
    assert (system(str(tmp_path / "late.ssp")).start, system(str(tmp_path / "late.ssp")).stop) == (2.5, 3.0)
    told = cosim_json("run", "late.ssp")
    assert (told["start"], told["stop"], told["steps"]) == (2.5, 3.0, 500)
    told = cosim_json("run", "late.ssp", "--start", "-500ms", "--stop", "0", "--output", "r.csv")
    assert (told["start"], told["stop"], told["steps"]) == (-0.5, 0.0, 500)
    assert (tmp_path / "r.csv").read_text().splitlines()[1].startswith("-0.5,")
    assert cosim_json("info", "late.ssp")["start"] == 2.5


def test_a_sweep_begins_where_its_system_does() -> None:
    """And a run from another start is another run."""
    values = {"gyro.rotor_speed": "10rpm:300rpm:3"}
    at_0, late = (Sweep(replace(PAIR, start=t), values, stop=2.0).plan() for t in (0.0, 1.5))
    assert late.context.system.start == 1.5
    assert not set(at_0.runs) & set(late.runs)
    with pytest.raises(ValueError, match="`stop` must be after `start` at 3 s, got 2 s"):
        Sweep(replace(PAIR, start=3.0), values, stop=2.0).plan()


@pytest.mark.parametrize(
    ("options", "words"),
    [
        (("--start", "70"), "`stop` must be after `start` at 70 s, got 60 s"),
        (("--start", "59", "--step", "2"), "`step` must be at most the run's length of 1 s, got 2 s"),
        (("--start", "inf"), "`start` must be finite, got inf s"),
        (("--start", "1e14", "--stop", "2e14"), "`step` must be told apart from rounding at `start` = 1e+14 s, got 0.001 s"),
        (("--start", "soon"), "--start must be a number"),
    ],
)
def test_starts_that_make_no_sense_are_refused(options: tuple[str, ...], words: str, cosim: Callable[..., Any]) -> None:
    code, out, err = cosim("run", "wheel-pair", "--in-process", *options)
    assert (code, out, err.count("\n")) == (2, "", 1)
    assert words in err


def test_the_page_about_running_fmus_works_as_written(cosim: Callable[..., Any]) -> None:
    page = Path(__file__).parents[2] / "docs" / "master.md"
    text = page.read_text(encoding="utf-8")
    commands = [line for block in re.findall(r"```sh\n(.*?)```", text, flags=re.DOTALL) for line in block.splitlines()]
    assert commands
    for command in commands:
        code, out, err = cosim(*shlex.split(command)[1:])
        assert (code, err) == (0, "")
        assert out
    for link in re.findall(r"\]\(((?!http)[^)#]+)\)", text):
        assert (page.parent / link).exists()
