"""Modes: named alike in any unit, crossings at the place that a formula gives, one command for both."""

import json
from pathlib import Path
from types import SimpleNamespace
from typing import Any, cast

import numpy as np
import pytest

from gyro_cosim.cli import main
from gyro_cosim.stability import AtRest
from gyro_cosim.stability.modes import crossings, modes_at


def of_matrix(matrix: Any, states: tuple[str, ...]) -> AtRest:
    """What `modes_at` and `crossings` use of a system at rest, for matrices written down here."""
    growth = lambda q: float(np.linalg.eigvals(matrix(q)).real.max())  # noqa: E731
    return cast(AtRest, SimpleNamespace(matrix=matrix, states=states, growth=growth))


def test_a_modes_name_does_not_depend_on_units() -> None:
    """Two coupled oscillators, the second an angle: in millimetres and milliradians, or hours, the shares are the same."""
    A = np.array([[0, 1, 0, 0], [-40.0, -0.5, 3.0, 0], [0, 0, 0, 1], [2.0, 0, -900.0, -1.0]])
    states = ("body.place", "body.velocity", "body.angle", "body.angle_rate")
    first = modes_at(of_matrix(lambda q: A, states), ())
    assert {(round(mode.frequency, 1), mode.moves) for mode in first} == {(1.0, "body.place"), (4.8, "body.angle")}
    for units in ([1e3, 1e3, 1.0, 1.0], [1.0, 3600.0, 1e-3, 3.6]):
        D = np.diag(units)
        B = D @ A @ np.linalg.inv(D)
        for mode, again in zip(first, modes_at(of_matrix(lambda q, B=B: B, states), ()), strict=True):
            assert again.root == pytest.approx(mode.root, rel=1e-9)
            assert again.participation == pytest.approx(mode.participation, abs=1e-9)
            assert again.moves == mode.moves


def test_crossings_are_where_the_damping_is_gone() -> None:
    """x'' = (v^2 - 7) x' - 25 x: stable below sqrt(7), by bisection and not by a line between grid points."""
    rest = of_matrix(lambda q: np.array([[0.0, 1.0], [-25.0, q[0] ** 2 - 7.0]]), ("mass.place", "mass.velocity"))
    [(value, mode)] = crossings(rest, np.array([1.0, 2.0, 4.0]))
    assert value == pytest.approx(np.sqrt(7.0), abs=1e-7)
    assert mode.frequency == pytest.approx(5.0 / (2 * np.pi), rel=1e-6)
    assert abs(mode.damping) < 1e-6


def test_the_command_maps_and_draws(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """A row of the map over two parameters is the series over one; figures are written; a figure of nothing is refused."""
    speed, spin = "vehicle.speed=2:20:3", "gyro.rotor_speed=0rpm:3000rpm:2"
    assert main(["modes", "wheel-pair", "--over", speed, "--plot", str(tmp_path / "locus.png"), "--json"]) == 0
    series = json.loads(capsys.readouterr().out)
    both = ["modes", "wheel-pair", "--over", speed, "--over", spin, "--plot", str(tmp_path / "map.png"), "--json"]
    assert main([*both, "--set", "gyro.rotor_speed=0rpm"]) == 0
    found = json.loads(capsys.readouterr().out)
    assert np.shape(found["growth"]) == (2, 3)
    assert main(["modes", "wheel-pair", "--over", speed, "--set", "gyro.rotor_speed=0rpm", "--json"]) == 0
    assert found["growth"][0] == pytest.approx(json.loads(capsys.readouterr().out)["growth"], rel=1e-9)
    assert found["parameters"] == ["vehicle.speed", "gyro.rotor_speed"]
    assert series["values"] == [2.0, 11.0, 20.0]
    assert all((tmp_path / name).stat().st_size > 5000 for name in ("locus.png", "map.png"))
    assert main([*both, "--set", "gyro.rotor_speed=0rpm", "--damping"]) == 0
    damping = json.loads(capsys.readouterr().out)["damping"]
    assert main(["modes", "wheel-pair", "--set", "vehicle.speed=11", "--set", "gyro.rotor_speed=3000rpm", "--json"]) == 0
    modes = json.loads(capsys.readouterr().out)["modes"]
    assert damping[1][1] == pytest.approx(min(m["damping"] for m in modes if m["frequency"] > 0 or m["growth"] > 0), rel=1e-6)
    assert main(["modes", "wheel-pair", "--over", speed, "--damping"]) == 2
    assert "--damping requires two --over, got 1" in capsys.readouterr().err
    assert main(["modes", "wheel-pair", "--plot", str(tmp_path / "no.png")]) == 2
    assert "--plot has no effect without --over" in capsys.readouterr().err


@pytest.mark.parametrize(
    ("over", "words"),
    [
        (("vehicle.speed=5:5:3",), "--over must lead from one value to another, got 'vehicle.speed=5:5:3'"),
        (("vehicle.speed=1:5:2", "vehicle.speed=1:9:3"), "--over must name two parameters, got vehicle.speed twice"),
        (("vehicle.speed=1:5:2",) * 3, "--over must be given once or twice, got 3 times"),
    ],
)
def test_ranges_that_make_no_figure_are_refused(over: tuple[str, ...], words: str, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["modes", "wheel-pair", *(word for text in over for word in ("--over", text))]) == 2
    assert words in capsys.readouterr().err
