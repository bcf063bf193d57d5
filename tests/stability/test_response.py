"""Frequency response to a wavy track: limits that symmetry and slow waves give exactly, and a run in time."""

import json
from pathlib import Path

import numpy as np
import pytest

from gyro_cosim import simulate
from gyro_cosim.cli import main
from gyro_cosim.stability.response import Wave, wave_response
from gyro_cosim.systems import System, SystemComponent

SPEED, SPACING, B = 10.0, 6.69, 0.7475
PLAN = System("lrt", (SystemComponent("vehicle", "vehicle:lrt"),), ()).with_value("vehicle.speed", SPEED)


def response(channel: str, *frequencies: float) -> dict[str, np.ndarray]:
    keys = [f"vehicle.{key}" for key in (f"stretch_{channel}", "stretch_wavelength", "stretch_start", "stretch_cycles", "speed")]
    found = wave_response(PLAN, Wave(*keys), frequencies, ("vehicle.*distance",))
    assert found.speed == SPEED
    return {state.removeprefix("vehicle."): values for state, values in found.states.items()}


def test_a_long_wave_lifts_and_rolls_the_vehicle_as_it_is() -> None:
    """1 km long: the body stands 1.000 of it higher, and 1 / (2 b) of a cross level turned, within what its wheels wander."""
    found = response("vertical", 0.01)
    assert found["body_vertical_displacement"][0] == pytest.approx(1.0, abs=2e-3)
    assert found["front_vertical_displacement"][0] == pytest.approx(np.exp(1j * np.pi * SPACING / 1000), abs=2e-3)
    found = response("cross_level", 0.01)
    assert found["front_roll_angle"][0] == pytest.approx(np.exp(1j * np.pi * SPACING / 1000) / (2 * B), rel=0.01)


def test_axles_half_a_wave_apart_do_not_lift_the_body_but_pitch_it() -> None:
    """And a whole wave apart they do not pitch it: the vehicle is alike fore and aft."""
    found = response("vertical", SPEED / (2 * SPACING), SPEED / SPACING)
    lift, pitch = (np.abs(found[name]) for name in ("body_vertical_displacement", "body_pitch_angle"))
    assert lift[0] < 1e-6 < 0.1 < lift[1]
    assert pitch[1] < 1e-2 * pitch[0]


@pytest.mark.slow
def test_a_run_in_time_settles_to_it() -> None:
    """2 Hz, 0.05 mm: the amplitude of the fundamental after 12 s. Sideways the vehicle is unstable, and settles to nothing."""
    channel, state = "vertical", "body_vertical_velocity"
    plan = PLAN.with_value("vehicle.stretch_wavelength", SPEED / 2.0).with_value("vehicle.stretch_cycles", 1e4)
    run = simulate(plan.with_value(f"vehicle.stretch_{channel}", 5e-5), stop=20.0, step=1e-3)
    t, y = run.trajectory.t, run.trajectory[f"vehicle.{state}"]
    late = t > 12.0 - 1e-9
    wave = np.exp(-2j * np.pi * 2.0 * t[late])
    amplitude = 2 * np.mean((y[late] * wave)[: 8000 // 500 * 500])
    assert abs(amplitude) / 5e-5 == pytest.approx(abs(response(channel, 2.0)[state][0]), rel=0.02)


def test_the_command_lists_and_draws(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    picture = tmp_path / "response.svg"
    assert (
        main(
            [
                "response",
                "lrt-straight",
                "--set",
                "vehicle.speed=10",
                "--frequencies",
                "0.5:5:5",
                "--plot",
                str(picture),
                "--json",
            ]
        )
        == 0
    )
    found = json.loads(capsys.readouterr().out)
    assert found["speed"] == SPEED
    assert found["frequencies"][0] == 0.5
    assert set(found["gain"]) == {f"vehicle.{body}_vertical_velocity" for body in ("body", "front", "rear")}
    assert "response to vertical irregularity" in picture.read_text(encoding="utf-8")
    assert main(["response", "lrt-straight", "--set", "vehicle.speed=10", "--frequencies", "0.5:5:5", "--rate", "--json"]) == 0
    rates = json.loads(capsys.readouterr().out)
    key = "vehicle.body_vertical_velocity"
    assert rates["gain"][key] == pytest.approx(2 * np.pi * np.array(found["frequencies"]) * found["gain"][key])
    assert rates["units"][key] == "m/s2 per m"


@pytest.mark.parametrize(
    ("words", "message"),
    [
        (("lrt-straight", "--track", "vertcal"), "did you mean 'vertical'?"),
        (("lrt-straight", "--frequencies", "5:1:10"), "--frequencies must rise from above 0 Hz"),
        (("lrt-straight", "--frequencies", "5:1"), "--frequencies must be FROM:TO:N"),
        (("lrt-straight", "--of", "vehicle.body_vertical_velocit"), "did you mean 'vehicle.body_vertical_velocity'?"),
        (("gyro_unit:linear",), "response requires a component with parameters stretch_vertical and speed"),
    ],
)
def test_wrong_use_is_one_line(words: tuple[str, ...], message: str, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["response", *words]) == 2
    told = capsys.readouterr().err
    assert message in told
    assert told.count("\n") == 1
