"""The scripts of the linear studies, run short: stored norms, and what must agree within each."""

import json
import runpy
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

ROOT = Path(__file__).parents[2]


@pytest.fixture(scope="module")
def short(tmp_path_factory: pytest.TempPathFactory) -> Callable[[str], dict[str, Any]]:
    """short(name): the summary that `python studies/name.py --short` writes; each is run once."""
    folder = tmp_path_factory.mktemp("studies")
    done: dict[str, dict[str, Any]] = {}

    def run(name: str) -> dict[str, Any]:
        if name not in done:
            with pytest.MonkeyPatch.context() as patch:
                patch.chdir(folder)
                patch.setattr(sys, "argv", [str(ROOT / "studies" / f"{name}.py"), "--short"])
                runpy.run_path(sys.argv[0], run_name="__main__")
            assert (folder / "results" / "studies" / "short" / f"{name}.png").stat().st_size > 10_000
            done[name] = json.loads((folder / "results" / "studies" / "short" / f"{name}.json").read_text())
        return done[name]

    return run


NOT_COMPARED = (
    "furthest_from_rest",  # rounding; checked above
    "evaluations",  # what the optimiser does on its way may differ in the last bit
    "criteria",  # the cost is compared
)


def compare(found: Any, stored: Any, where: str) -> None:
    """The same structure; numbers to 1e-4, what a flat optimum makes of rounding, or 1e-8 where they are tiny."""
    if isinstance(stored, dict):
        assert set(found) == set(stored), where
        for key in set(stored) - set(NOT_COMPARED):
            compare(found[key], stored[key], f"{where}.{key}")
    elif isinstance(stored, list):
        assert len(found) == len(stored), where
        for i, (a, b) in enumerate(zip(found, stored, strict=True)):
            compare(a, b, f"{where}[{i}]")
    elif isinstance(stored, float):
        assert found == pytest.approx(stored, rel=1e-4, abs=1e-8), where
    else:
        assert found == stored, where


@pytest.mark.parametrize(
    "name",
    [
        *(pytest.param(n, marks=pytest.mark.slow) for n in ("root_locus", "critical_speed")),
        "stability_map",
        "solid_axle",
        "optimum",
    ],
)
def test_study_meets_its_norms(name: str, short: Callable[[str], dict[str, Any]]) -> None:
    stored = json.loads((Path(__file__).parent / "norms" / f"{name}.json").read_text())
    assert stored.pop("command") == f"python studies/{name}.py --short"
    found = short(name)
    compare({key: value for key, value in found.items() if key != "command"}, stored, name)


def test_runs_in_time_decay_and_grow_as_the_eigenvalue_says(short: Callable[[str], dict[str, Any]]) -> None:
    """Without spin to rounding; with it the coupling at 1 ms moves the root by 3e-6 / s."""
    checks = short("critical_speed")["sprung wheelset"]["in_time"]
    assert [np.sign(c["growth"]) for c in checks] == [-1.0, 1.0, -1.0, 1.0]
    for c in checks:
        assert c["measured"] == pytest.approx(c["growth"], abs=1e-5 if c["rpm"] else 1e-9)
        assert c["measured_frequency"] == pytest.approx(c["frequency"], abs=1e-4 if c["rpm"] else 1e-8)


def test_a_soft_gimbal_helps_solid_axles_and_the_spin_axis_does_not_matter(short: Callable[[str], dict[str, Any]]) -> None:
    """The condition for a weak unit holds in every cell of the coarse map; what it says of strong ones the eigenvalues and the
    runs in time show."""
    found = short("solid_axle")
    assert found["map"]["weak_unit_as_the_condition_says"] == found["map"]["cells"] == 36
    rest, paper, soft = (found[name] for name in ("at rest", "as in Table 2", "a tenth of the damper, 4.1 kN/m"))
    assert [r["a_weak_one_helps"] for r in (paper, soft)] == [False, True]
    assert paper["critical_speed_m_s"] < rest["critical_speed_m_s"] < soft["critical_speed_m_s"] / 2
    assert soft["largest_y_at_the_end_mm"] < 1.0 < paper["largest_y_at_the_end_mm"]  # begun with 1 mm, growing or falling
    along, across = (
        found[f"vehicle, {name}"]["stable_up_to_m_s"] for name in ("1 kN/m, 0.43 kN s/m", "the same, lateral spin axis")
    )
    assert across == pytest.approx(along, rel=1e-3)


def test_cost_by_co_simulation_is_the_cost_by_the_monolith(short: Callable[[str], dict[str, Any]]) -> None:
    """Wheel pair: 1e-6, the error of the coupling at 1 ms with inputs of degree 2. Vehicle: 2e-5, since its rest state is exact
    to 6e-12 m of motions of 1e-5 m, and these are not quite linear."""
    for name, tolerance in (("wheel pair", 1e-6), ("set B", 2e-5)):
        for design in ("default", "optimum"):
            entry = short("optimum")[name][design]
            assert entry["cost_of_run"] == pytest.approx(entry["cost_by_monolith"], rel=tolerance)


def test_optimum_is_better_than_default_and_than_every_point_of_the_grid(short: Callable[[str], dict[str, Any]]) -> None:
    found = short("optimum")
    for name in ("wheel pair", "set B"):
        assert found[name]["optimum"]["cost"] < found[name]["default"]["cost"] / 2
    assert found["wheel pair"]["optimum"]["cost"] < found["wheel pair"]["brute_force"]["cost"]
    assert found["set A"]["optimum"]["growth"] > 0.0  # nothing within the bounds stabilises it
