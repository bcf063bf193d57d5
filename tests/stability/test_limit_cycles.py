"""Limit cycles: a normal form in closed form, Cooperrider's bogie on both sides of its fold, the command."""

import json
from pathlib import Path

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from validation_cases.cooperrider import bogie_cycles

from gyro_cosim.cli import main
from gyro_cosim.stability.limit_cycles import Branch, branch


class Subcritical:
    """r' = r (v + r^2 - r^4), phi' = 2: cycles at v = r^4 - r^2, which turn back at v = -1/4."""

    def rates(self, z: np.ndarray, v: float) -> np.ndarray:
        x, y = z.T
        g = v + x * x + y * y - (x * x + y * y) ** 2
        return np.column_stack([g * x - 2 * y, g * y + 2 * x])

    def slopes(self, z: np.ndarray, v: float) -> np.ndarray:
        x, y = z.T
        r2 = x * x + y * y
        g, d = v + r2 - r2**2, 2 - 4 * r2
        return np.array([[g + d * x * x, d * x * y - 2], [d * x * y + 2, g + d * y * y]]).transpose(2, 0, 1)

    def by_parameter(self, z: np.ndarray, v: float) -> np.ndarray:
        return z.copy()


def found(intervals: int = 20, **options: float) -> Branch:
    given = {"scale": 0.5, "longest": 0.1} | options
    return branch(Subcritical(), (0.0, 2j, np.array([1.0, -1j])), (-1.0, 1.0), intervals=intervals, **given)  # type: ignore[arg-type]


def test_a_normal_form_has_its_cycles_and_multipliers() -> None:
    cycles = found().cycles
    r = np.array([cycle.amplitudes()[0] for cycle in cycles])
    assert r[0] < 0.15
    assert r[-1] > 1.2
    assert [cycle.v for cycle in cycles] == pytest.approx(r**4 - r**2, abs=1e-5)
    assert np.array([cycle.frequency for cycle in cycles]) == pytest.approx(1 / np.pi, rel=1e-6)
    assert [cycle.multiplier for cycle in cycles] == pytest.approx(np.exp((2 * r**2 - 4 * r**4) * np.pi), rel=1e-4, abs=1e-6)
    assert [cycle.is_stable for cycle in cycles] == list(r > 0.5**0.5)


def test_the_fold_is_where_it_turns() -> None:
    (fold,) = found().folds
    assert fold.v == pytest.approx(-0.25, abs=1e-6)
    assert fold.amplitudes()[0] == pytest.approx(0.5**0.5, abs=1e-4)


def test_more_intervals_are_nearer_by_their_order() -> None:
    """At an equal amplitude; the equations at the places are of order 5, at the begins of intervals of more."""
    errors = []
    for intervals in (5, 10):
        at = [(c.v, *(np.hypot(*c.z[:, 2].T))) for c in found(intervals).cycles if c.v > 0.5]
        v, r = at[0][0], np.array(at[0][1:])
        errors.append(np.abs(v - r**4 + r**2).max())
    assert errors[1] < errors[0] / 2**4


def test_too_few_intervals_are_refused() -> None:
    with pytest.raises(ValueError, match="intervals of a cycle must be 4 or more, got 3"):
        found(3)


def test_a_branch_begins_at_an_oscillation_within_the_range() -> None:
    for start, message in (
        ((0.0, 0j, np.ones(2)), "begins at a pair of roots"),
        ((2.0, 2j, np.ones(2)), "must lie from -1 to 1"),
    ):
        with pytest.raises(ValueError, match=message):
            branch(Subcritical(), start, (-1.0, 1.0))


def test_cycles_of_a_bogie_reach_back_to_a_fold_below_where_its_rest_becomes_unstable() -> None:
    _, cycles = bogie_cycles()
    (fold,) = cycles.folds
    assert fold.v == pytest.approx(66.65, abs=0.02)
    assert cycles.cycles[0].v == pytest.approx(68.644, abs=0.01)
    r = [cycle.amplitudes()[0] for cycle in cycles.cycles]
    assert [cycle.is_unstable for cycle in cycles.cycles if cycle.amplitudes()[0] > 1e-3] == [a < 9.2e-3 for a in r if a > 1e-3]


@pytest.mark.slow
def test_a_bogie_hunts_above_the_fold_only_and_from_large_disturbances() -> None:
    """Runs in time: the unstable cycle is the border between rest and hunting; below the fold all dies out."""
    bogie, cycles = bogie_cycles()
    (fold,) = cycles.folds

    def late(v: float, start: np.ndarray) -> float:
        """Largest lateral displacement in the last of 20 s, mm."""
        run = solve_ivp(lambda _, z: bogie.rates(z[None], v)[0], (0.0, 20.0), start, "LSODA", rtol=1e-7, atol=1e-10)
        return 1e3 * float(np.abs(run.y[0, run.t > 18.0]).max())

    border = min((c for c in cycles.cycles if c.is_unstable), key=lambda c: abs(c.v - 67.6))
    assert border.amplitudes()[0] == pytest.approx(6.7e-3, abs=0.2e-3)
    assert late(border.v, 0.9 * border.z[0, 2]) < 3.0
    assert late(border.v, 1.1 * border.z[0, 2]) == pytest.approx(9.66, abs=0.05)
    assert late(fold.v - 0.5, 1.1 * fold.z[0, 2]) < 0.5
    assert late(fold.v + 0.5, 1.1 * fold.z[0, 2]) == pytest.approx(9.53, abs=0.05)


def test_the_command_lists_and_draws_the_cycles_of_a_wheelset(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    image = tmp_path / "cycles.png"
    options = ["--over", "vehicle.speed=20:30:3", "--intervals", "30", "--plot", str(image), "--json"]
    assert main(["limit-cycles", "vehicle:wheelset", *options]) == 0
    (one,) = json.loads(capsys.readouterr().out)["branches"]
    assert one["begins"] == pytest.approx(23.0845, abs=1e-3)
    assert one["amplitude_of"] == "vehicle.lateral_displacement"
    assert one["values"][-1] > 28.0
    assert one["stable"][-1]
    assert 7e-3 < one["amplitudes"][-1] < 7.6e-3
    assert image.stat().st_size > 1000
    assert main(["limit-cycles", "vehicle:wheelset", "--over", "vehicle.speed=24:30:3"]) == 0
    assert "no branch of limit cycles begins there" in capsys.readouterr().out


@pytest.mark.parametrize(
    ("options", "message"),
    [
        (["--over", "vehicle.speed=20:30:3", "--intervals", "3"], "--intervals must be 4 or more, got 3"),
        (["--over", "vehicle.speed=20:30:3", "--most", "0"], "--most must be 1 or more, got 0"),
        (["--over", "vehicle.speed=20:30"], "--over must be COMPONENT.PARAMETER=FROM:TO:N"),
        (["--over", "vehicle.speed=20:30:3", "--of", "vehicle.yaw_rate"], "--of: state that is a length or an angle"),
        (["--over", "vehicle.speed=20:30:3", "--of", "vehicle.distance"], "may be shifted without change"),
    ],
)
def test_bad_input_is_one_line(options: list[str], message: str, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["limit-cycles", "vehicle:wheelset", *options]) == 2
    (line,) = capsys.readouterr().err.splitlines()
    assert message in line
