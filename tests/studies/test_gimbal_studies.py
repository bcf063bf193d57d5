"""The studies of the gimbal, each in its short form: what must hold whatever the digits."""

import json
import subprocess
import sys
from pathlib import Path
from typing import Any

import pytest

ROOT = Path(__file__).resolve().parents[2]


def short(study: str, folder: Path) -> dict[str, Any]:
    """The summary of a study run with --short in a folder of its own, and run again: the second finds all of it done."""
    for _ in range(2):
        command = [sys.executable, str(ROOT / "studies" / f"{study}.py"), "--short"]
        ran = subprocess.run(command, cwd=folder, capture_output=True, text=True, timeout=600, check=False)
        assert ran.returncode == 0, ran.stderr
    made = folder / "results/studies/short"
    assert (made / f"{study}.png").stat().st_size > 10_000
    return json.loads((made / f"{study}.json").read_text())


@pytest.mark.slow
def test_a_design_within_limits_is_no_worse_than_brute_force_and_keeps_its_lean(tmp_path: Path) -> None:
    found = short("gimbal_design", tmp_path)
    for name, result in found["fronts"].items():
        assert result["rest_error"] < 1e-6
        designs = result["1000 kg, 5 kW"]
        for design, grid in zip(designs, result["grid"], strict=True):
            assert design["lean"] <= design["largest_lean"] * (1 + 1e-5)
            assert design["power"] <= 5e3 * (1 + 1e-5)
            assert design["growth_at_50"] < grid + 0.1 * abs(grid)
        assert (designs[0]["growth_at_50"] < 0.0) == (name != "Table 2's wheels, steep tread")
    run = found["set B, straight at 50 m/s"]
    assert run["lean 0.3 rad"]["late"] < 0.1 * run["Table 2"]["late"]


@pytest.mark.slow
def test_only_a_spring_over_centre_holds_set_a_and_the_law_tells_the_needed_ratio(tmp_path: Path) -> None:
    found = short("lean_units", tmp_path)
    assert found["set A: no stable unit can, by the pair's law"] == {"8 m/s": True, "50 m/s": True}
    for unit in ("plain", "progressive", "centred", "scheduled"):
        assert found["units"][f"set A, {unit}"]["stable_at_50"] == 0
    assert found["units"]["set A, over-centre"]["stable_at_50"] > 10
    assert found["units"]["steep tread, over-centre"]["stable_at_50"] == 0
    assert found["units"]["steep tread, plain"]["stable_at_50"] > 0
    assert found["largest_factor"] < 2.0
