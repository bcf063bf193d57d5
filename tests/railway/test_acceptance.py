"""The table by EN 14363 from signals whose answer is known by hand, and what a verdict may say."""

import json
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from gyro_cosim.railway.acceptance import Acceptance, judge
from gyro_cosim.railway.assessment import Assessment, assess
from gyro_cosim.railway.limits import Limits, read
from gyro_cosim.railway.record import Row
from gyro_cosim.railway.track_sections import sections
from gyro_cosim.trajectory import Trajectory
from gyro_cosim.trajectory.csv_files import write_csv

V, R = 20.0, 400.0  # m/s, m
KNOTS, BENDS = [0.0, 200.0, 240.0, 440.0, 480.0, 2000.0], [0.0, 0.0, 1 / R, 1 / R, 0.0, 0.0]  # m, 1/m
WHEELS = ("front_left", "front_right")


def ridden(stop: float = 40.0, rate: float = 250.0, **other: Callable[[np.ndarray], np.ndarray]) -> Trajectory:
    """A vehicle that runs through a curve to the left: its loads shift by a fifth there, a pair sways by 2 Hz."""
    t = np.linspace(0.0, stop, round(stop * rate) + 1)
    s = V * t
    bend = np.interp(s, KNOTS, BENDS)
    sway = np.sin(2 * np.pi * 2.0 * t)
    still = np.zeros_like(t)
    signals = {"body_distance": s, "curvature": bend, "cant_angle": -0.05 * R * bend, "body_roll_angle": still,
               "body_lateral_velocity": 0.1 * sway, "body_vertical_velocity": still, "front_guiding_force": 10e3 * sway,
               "front_lateral_displacement": 1e-3 * sway, "front_yaw_angle": still}  # fmt: skip
    for wheel, side in zip(WHEELS, (-1.0, 1.0), strict=True):
        load, wear = 50e3 * (1 + 0.2 * side * R * bend), 100.0 + 50 * R * bend
        own = {"climb": still, "derailment_coefficient": still + 0.5, "lateral_force": still + 3e3, "vertical_force": load,
               "wear_number": wear, "wheel_lift": still}  # fmt: skip
        signals |= {f"{wheel}_{name}": signal for name, signal in own.items()}
    signals |= {name: change(t) for name, change in other.items()}
    names = tuple(f"v.{name}" for name in signals)
    return Trajectory(t, names, ("",) * len(names), np.column_stack(list(signals.values())))


def judged(trajectory: Trajectory, limits: Limits | None = None) -> tuple[Assessment, Acceptance]:
    (found,) = assess(trajectory)
    return found, judge(trajectory, found, limits)


def row(table: Acceptance, quantity: str, kind: str = "curve", statistic: str = "") -> Row:
    rows = [r for r in table.rows if r.quantity == quantity and statistic in r.statistic and r.section and r.section.kind == kind]
    return rows[0]


def test_a_run_is_cut_into_straight_track_transitions_and_curves() -> None:
    s = np.arange(0.0, 600.0, 0.1)
    found = sections(s, np.interp(s, KNOTS, BENDS))
    assert [part.kind for part in found] == ["straight", "transition", "curve", "transition", "straight"]
    assert [round(part.begin) for part in found] == [0, 200, 240, 440, 480]
    assert all(part.whole for part in found)
    assert found[2].words == "curve of R = 400 m"
    cut = sections(s[s < 300.0], np.interp(s[s < 300.0], KNOTS, BENDS))
    assert [part.whole for part in cut] == [True, True, False]


def test_the_table_holds_what_can_be_worked_out_by_hand() -> None:
    found, table = judged(ridden())
    assert found.verdict.text == "passed: every wheel stayed on its rail, through the curve of R = 400 m"
    shortened = np.sinc(2.0 * 2.0 / V)  # a wave of 10 m under a mean of 2 m
    assert row(table, "sum Y").value == pytest.approx(10e3 * shortened, rel=5e-3)
    passed = 1 / (1 + (np.sqrt(2) - 1) / 2**4)  # of 2 Hz by a filter that loses 3 dB at 4 Hz
    assert row(table, "sum Y").limit == pytest.approx(10e3 + 100e3 / 3.0)
    assert row(table, "stability", "straight").value == pytest.approx(10e3 / np.sqrt(2) * passed, rel=2e-3)
    assert "2 +- 2 Hz" in row(table, "stability", "straight").filter
    assert (row(table, "Q_qst").value, row(table, "Q_qst").place) == (pytest.approx(60e3), "front_right")
    assert (row(table, "unloading").value, row(table, "unloading").place) == (pytest.approx(0.2, rel=1e-3), "front_left")
    assert row(table, "Q").limit == pytest.approx(140e3)
    assert row(table, "Y_qst").value == pytest.approx(3e3)
    assert row(table, "y''_qst").value == pytest.approx(abs(V**2 / R - 9.81 * np.sin(0.05)), rel=0.05)
    swaying = 0.1 * 2 * np.pi * 2.0
    assert row(table, "y''", statistic="r.m.s.").value == pytest.approx(swaying / np.sqrt(2), rel=0.02)
    assert row(table, "T gamma").value == pytest.approx(150.0, rel=1e-3)
    assert row(table, "T gamma").verdict == ""
    mean = next(r for r in table.rows if r.quantity == "N_MV")
    assert (mean.verdict, mean.reason) == ("not decidable", "7 of 60 windows")


def test_a_limit_is_kept_only_where_the_place_was_passed() -> None:
    within, cut = judged(ridden())[1], judged(ridden(stop=18.0))
    assert row(within, "Y/Q").verdict == "kept"
    assert (row(cut[1], "Y/Q").verdict, row(cut[1], "Y/Q").reason) == ("not decidable", "the run ends or begins in it")
    assert row(cut[1], "Y/Q", "straight").verdict == "kept"
    assert cut[0].verdict.text == "not decidable: every wheel stayed on its rail, but the run ends in the curve of R = 400 m"
    assert row(judged(ridden(stop=18.0), Limits(ratio=0.4))[1], "Y/Q").verdict == "exceeded"  # once is enough


def test_behind_a_derailment_nothing_counts() -> None:
    def wild(t: np.ndarray) -> np.ndarray:
        return np.where(t > 15.0, 1e3, 0.5)

    found, table = judged(
        ridden(front_left_climb=lambda t: np.where(t > 15.0, 2.0, 0.0), front_right_derailment_coefficient=wild)
    )
    assert found.verdict.derailed
    assert found.verdict.distance == pytest.approx(300.0, abs=0.1)
    assert row(table, "Y/Q").value == pytest.approx(0.5, rel=1e-6)
    assert row(table, "Y/Q").verdict == "not decidable"


@pytest.mark.parametrize(
    ("loads", "says"),
    [
        ({}, "flange climb at Y/Q up to 0.5"),
        ({"front_left_vertical_force": lambda t: np.where(t > 14.8, 1e3, 50e3)}, "wheel unloading"),
        ({"front_right_vertical_force": lambda t: np.where(t > 14.6, 1e2, 50e3)}, "body roll-over"),
    ],
)
def test_a_derailment_is_named_by_its_cause(loads: dict[str, Any], says: str) -> None:
    (found,) = assess(ridden(front_left_climb=lambda t: np.where(t > 15.0, 2.0, 0.0), **loads))
    assert found.verdict.text.endswith(f"t = 15.004 s, {says}")


def test_a_vehicle_that_hangs_over_one_rail_has_derailed() -> None:
    (found,) = assess(ridden(front_right_wheel_lift=lambda t: np.where(t > 16.0, 0.2, 0.0)))
    assert (found.verdict.derailed, found.verdict.cause) == (True, "body roll-over")


def test_a_coarse_record_decides_nothing() -> None:
    (only,) = judged(ridden(rate=30.0))[1].rows
    assert (only.verdict, only.reason) == ("not decidable", "1201 points, 30 a second, are too few for a low pass of 20 Hz")
    comfort = [r for r in judged(ridden(rate=100.0))[1].rows if r.quantity.startswith(("N_MV", "C_"))]
    assert {r.reason for r in comfort} == {"recorded at 100 Hz, its filters need 200"}


def test_what_is_no_number_keeps_no_limit() -> None:
    table = judged(ridden(front_guiding_force=lambda t: np.where(np.abs(t - 17.0) < 0.01, np.nan, 0.0)))[1]
    assert row(table, "sum Y").verdict == "not decidable"


def test_recorded_runs_are_assessed_from_the_prompt(cosim: Callable[..., Any], tmp_path: Path) -> None:
    good, bad = tmp_path / "good.csv", tmp_path / "bad.csv"
    write_csv(ridden(body_lateral_velocity=np.zeros_like), good)
    write_csv(ridden(front_left_derailment_coefficient=lambda t: 0.9 + 0 * t), bad)
    code, out, _ = cosim("assess", str(good), "-o", str(tmp_path / "rows.csv"))
    assert code == 0
    assert "limits kept, 0 exceeded" in out
    assert (tmp_path / "rows.csv").read_text().count("curve 400 m") > 5
    code, out, _ = cosim("assess", str(good), str(bad), "--json")
    assert code == 1
    first, second = json.loads(out)["assessments"]
    assert {r["verdict"] for r in first["rows"] if r["quantity"] == "Y/Q"} == {"kept"}
    assert {r["verdict"] for r in second["rows"] if r["quantity"] == "Y/Q"} == {"exceeded"}


@pytest.mark.parametrize(
    ("text", "says"),
    [
        ("raito = 0.8", "raito: a limit must be one of ratio, "),
        ("ratio = -1", "ratio: a limit must be a positive number in SI units, got -1"),
        ("ratio = '0.8'", "ratio: a limit must be a positive number in SI units, got '0.8'"),
        ("ratio = 1" + "0" * 400, "ratio: a limit must be a positive number in SI units, got 1000"),
        ("xyz = 1", "xyz: a limit must be one of ratio, "),
        ("ratio = ", "a file of limits must be TOML: "),
        ("ratio = " + "[" * 5000, "a file of limits must be TOML that is nested less deeply"),
    ],
)
def test_a_file_of_limits_that_is_wrong_is_one_line(text: str, says: str, tmp_path: Path) -> None:
    file = tmp_path / "limits.toml"
    file.write_text(text)
    with pytest.raises(ValueError, match=r"limits\.toml: ") as error:
        read(file)
    assert says in str(error.value)


def test_a_file_of_limits_changes_those_that_it_names(tmp_path: Path) -> None:
    (tmp_path / "freight.toml").write_text("guiding_factor = 0.85\n")
    assert read(tmp_path / "freight.toml") == Limits(guiding_factor=0.85)
