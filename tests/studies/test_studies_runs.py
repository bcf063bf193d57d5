"""The studies that run the coupled vehicle, each in its short form: against stored norms where a run is not chaotic, and physics.

The norms in norms are what the scripts wrote, with the command that made them. "chaotic" stands there in place of what
comes of runs that hunt in the flanges: no figure of those is repeated by another compiler.
"""

import importlib.util
import json
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from gyro_cosim.railway.comfort import W_B, W_D, mean_comfort
from gyro_cosim.trajectory import Trajectory

ROOT = Path(__file__).resolve().parents[2]
# Runs with the gyro do not hunt: what another compiler's last digits make of them stays far below this.
SAME = 1e-3


@pytest.fixture(scope="module")
def short(tmp_path_factory: pytest.TempPathFactory) -> Callable[[str], dict[str, Any]]:
    """study -> its summary, run once with --short in a folder of its own."""
    folder, done = tmp_path_factory.mktemp("studies"), dict[str, dict[str, Any]]()

    def run(study: str) -> dict[str, Any]:
        if study not in done:
            command = [sys.executable, str(ROOT / "studies" / f"{study}.py"), "--short"]
            ran = subprocess.run(command, cwd=folder, capture_output=True, text=True, timeout=300, check=False)
            assert ran.returncode == 0, ran.stderr
            done[study] = json.loads((folder / "results/studies/short" / f"{study}.json").read_text())
            assert (folder / "results/studies/short" / f"{study}.png").stat().st_size > 10_000
        return done[study]

    return run


def same(found: Any, norm: Any) -> None:
    """Numbers to SAME, everything else exactly; where the norm says "chaotic", anything."""
    if isinstance(norm, dict):
        assert found.keys() == norm.keys()
        for key in norm:
            same(found[key], norm[key])
    elif isinstance(norm, list):
        assert len(found) == len(norm)
        for one, other in zip(found, norm, strict=True):
            same(one, other)
    elif isinstance(norm, float) and not isinstance(found, str | None):
        assert found == pytest.approx(norm, rel=SAME, abs=1e-9)
    elif norm != "chaotic":
        assert found == norm


@pytest.mark.parametrize("study", [
    pytest.param("derailment_map", marks=pytest.mark.slow), "safe_speed",
    pytest.param("gyro_cost", marks=pytest.mark.slow), "stability_law",
    pytest.param("comfort", marks=pytest.mark.slow),  # it builds the FMU with 192 harmonics first
])  # fmt: skip
def test_the_short_study_meets_its_norms(short: Callable[[str], dict[str, Any]], study: str) -> None:
    norm = json.loads((Path(__file__).parent / "norms" / f"{study}.json").read_text())
    assert norm.pop("command") == f"python studies/{study}.py --short"
    same(short(study), norm)


@pytest.mark.slow
def test_the_map_at_0_rpm_is_the_gyro_off(short: Callable[[str], dict[str, Any]]) -> None:
    found = short("derailment_map")["B"]
    spin, radius = found["spin"], found["radius-off"]
    assert spin["gyro.rotor_speed"][0] == 0.0
    assert radius["vehicle.curve_radius"][0] == 50.0
    for what in ("share_derailed", "ratio"):  # chaotic or not: the same runs, reached over two maps
        assert spin[what][0] == radius[what][0]


def test_the_gyro_is_worth_its_cost_in_the_curve(short: Callable[[str], dict[str, Any]]) -> None:
    """Claims C8 and C10 in the form of a study: less Y/Q and less wear at 5 m/s, and through at 8 m/s."""
    off, on = short("gyro_cost")["B"]["0 rpm"], short("gyro_cost")["B"]["2000 rpm"]
    for what in ("ratio", "wear"):  # without the gyro the run hunts: by another compiler's digits it may derail instead
        assert off["5 m/s: share_derailed"] == 1.0 or on[f"5 m/s: {what}"] < 0.5 * off[f"5 m/s: {what}"]
    assert on["5 m/s: share_derailed"] == 0.0
    assert on["8 m/s: share_derailed"] == 0.0


@pytest.mark.parametrize(("speed", "known"), [(5, 462.0), (8, 739.0)])
def test_in_the_curve_the_gyro_pitches_its_frame_with_h_v_over_r(
    short: Callable[[str], dict[str, Any]], speed: int, known: float
) -> None:
    found = short("gyro_cost")
    assert found["pitch_moment_H_v_over_R_N_m"][f"{speed}"][1] == pytest.approx(known, abs=1.0)  # PHYSICS gives whole N m
    moment = -found["B"]["2000 rpm"][f"{speed} m/s: steady_pitch"]
    # The lean takes H cos(eta), 0.2 % at 3.6 degrees; the front pair runs 0.1 % faster than the body.
    assert moment == pytest.approx(known, rel=4e-3)
    lean = -found["B"]["2000 rpm"][f"{speed} m/s: steady_lean"]
    # The spring k_g d_g^2 of set B bears it; the gimbal's last creep onto its lean leaves the damper a thousandth.
    assert lean == pytest.approx(moment / (130050.0 * 0.3**2), rel=1.5e-3)
    # Both gyros' pitch moments lift one axle and load the other, over 6 m; the hunting vehicle without them does not.
    shift = -found["B"]["2000 rpm"][f"{speed} m/s: front_load"]
    assert shift == pytest.approx(2 * moment / 6.0, rel=0.05)  # the axles' other moments are a few N m


def test_without_gimbal_springs_the_gyro_stabilises_table_2s_wheels(short: Callable[[str], dict[str, Any]]) -> None:
    """Over waves of 10 mm at 50 m/s, far above what the paper's ratio allows; the law is a good guide to the full vehicle."""
    found = short("stability_law")
    assert found["without springs, 0 rpm"]["derailed"]
    assert not found["without springs, 3000 rpm"]["derailed"]
    assert found["without springs, 3000 rpm"]["largest_y_in_the_last_2_s_m"] < 1e-3
    steep = found["Table 2's wheels, steep tread"]
    for law, full in zip(steep["needed_ratio_by_law_s"], steep["needed_ratio_full_vehicle_s"], strict=True):
        assert found["ratio_of_the_paper_s"] < law / 4
        assert law / 2 < full < law * 2
    assert found["law_allows_the_papers_ratio_within_the_ranges"]["up_to_m_s"] < 8.0  # C10's speed
    assert found["least_lean_of_a_stable_gimbal_at_8_m_s"]["rad"] > 1.0  # the price in C10's curve


def test_a_rotor_at_rest_gives_no_moment(short: Callable[[str], dict[str, Any]]) -> None:
    off = short("gyro_cost")["B"]["0 rpm"]
    passed = [v for v in (5, 8) if off[f"{v} m/s: share_derailed"] == 0.0]  # as long as one of the chaotic runs passes
    assert all(abs(off[f"{v} m/s: steady_pitch"]) < 1.0 for v in passed)  # the gimbal's inertia, against 462 N m at 2000 rpm
    assert all(off[f"{v} m/s: yaw"] < 1.0 for v in passed)


def test_energy_and_momentum_of_a_rotor(short: Callable[[str], dict[str, Any]]) -> None:
    found, omega = short("gyro_cost"), 2000 * np.pi / 30
    assert found["momentum_N_m_s"][1] == pytest.approx(22.04 * omega)
    assert found["energy_of_a_rotor_J"][1] == pytest.approx(22.04 * omega**2 / 2)


RATE = 2 * np.pi * 1.4  # 1/s


@pytest.mark.parametrize(("signal", "axis", "felt"), [
    ("lateral_velocity", "y", RATE), ("vertical_velocity", "z", RATE), ("speed_deviation", "x", RATE),
    ("yaw_rate", "y", RATE * 3.0), ("pitch_rate", "z", RATE * 3.0),  # over the pivots
    ("roll_rate", "y", RATE * (3550.0 / 3000.0 - 0.35)),  # under the centre of body (2 t, 1.5 m) and bogies (1 t, 0.55 m)
    ("roll_angle", "y", 9.81),
])  # fmt: skip
def test_what_is_felt_on_the_floor(monkeypatch: pytest.MonkeyPatch, signal: str, axis: str, felt: float) -> None:
    """A body that moves as a sine in one freedom: the study's windows hold what the standard makes of that sine."""
    monkeypatch.setattr(sys, "argv", ["comfort.py", "--short"])
    place = importlib.util.spec_from_file_location("comfort_study", ROOT / "studies" / "comfort.py")
    assert place is not None
    assert place.loader is not None
    study = importlib.util.module_from_spec(place)
    place.loader.exec_module(study)
    t = np.arange(0.0, study.STOP + 5e-4, 1e-3)
    body = [f"vehicle.body_{name}" for name in study.MOTION]
    rest = [f"vehicle.{wheel}_wear_number" for wheel in study.WHEELS] + ["vehicle.derailed", "vehicle.front_lateral_displacement"]
    moving = np.where(np.array(body)[:, None] == f"vehicle.body_{signal}", 0.05 * np.sin(RATE * t), 0.0)
    values = np.vstack([moving, np.zeros((len(rest), t.size))]).T
    windows = study.ride(Trajectory(t, (*body, *rest), ("1",) * values.shape[1], values))
    rms = {a: np.array([windows[f"front_{a}_{k}"] for k in range(study.WINDOWS)]) for a in "xyz"}
    weight = abs((W_B if axis == "z" else W_D).response(np.array(RATE / (2 * np.pi))))
    expected = 0.05 * felt / np.sqrt(2) * weight
    assert rms[axis] == pytest.approx(expected, rel=2e-3)  # the filter's start and the difference quotient
    if signal != "pitch_rate":  # which moves the floor along x too, below the centre
        assert mean_comfort(rms["x"], rms["y"], rms["z"]) == pytest.approx(6 * expected, rel=2e-3)


@pytest.mark.slow
def test_a_yaw_damper_does_what_an_inerter_does_not(short: Callable[[str], dict[str, Any]]) -> None:
    """Of what is not chaotic: growth on straight track, and runs through the curve that do not hunt."""
    found = short("rivals")
    damper = "yaw damper, 30 kN m s"
    for wheels in ("set A", "steep tread", "set B"):
        rates = {name: row["growth_at_8_and_20_m_s"][0] for name, row in found[wheels].items()}
        for inerter in ("inerter like the gyro", "inerter of its mass"):
            assert 0.0 < rates[inerter] < rates["no unit"]
        assert rates[damper] < rates["gyro as in Table 2"] < rates["no unit"]
    assert found["steep tread"][damper]["growth_at_8_and_20_m_s"][0] < 0.0
    assert found["solid axles"]["inerter like the gyro"]["growth_at_8_and_20_m_s"][0] > 0.0
    needed = found["needed_damper_by_the_law_N_m_s"]
    assert needed["set A"]["8 m/s"] is None  # infinite
    assert needed["set B"]["8 m/s"] < needed["steep tread"]["8 m/s"] < 3e4
    for wheels in ("set A", "set B"):
        for name in (damper, "gyro as in Table 2"):
            run = found[wheels][name]["curve, polach, 8 m/s"]
            assert (run["runs"], run["derail"]) == (2, 0), (wheels, name)


@pytest.mark.slow
def test_the_decision_counts_starts_of_a_vehicle_that_somebody_would_build(short: Callable[[str], dict[str, Any]]) -> None:
    """What is not chaotic: set B comes through both curves with the unit spinning and with a yaw damper, and settles there."""
    found = short("decision")
    assert found["starts"] == 4
    assert len(found["cells"]) == 4
    for cell in found["cells"].values():
        assert [cell[unit]["starts"] for unit in ("no unit", "at rest", "spinning", "yaw damper")] == [4] * 4
        for unit in ("spinning", "yaw damper"):
            assert cell[unit]["derailed"] == 0
            assert cell[unit]["share"] == pytest.approx([0.0, 0.4899], abs=1e-4)  # Wilson, 0 of 4
            assert cell[unit]["late_mm"] < 0.1
    tight = found["cells"]["B, Polach, R = 50 m, 5 m/s"]
    assert tight["spinning"]["ratio"] == pytest.approx([0.736] * 4, abs=2e-3)
    assert tight["no unit"]["derailed"] > 0  # of a run that hunts: some of the starts, whatever the compiler's digits
    assert found["derailments"]["in_the_last_50_m"] == 0
