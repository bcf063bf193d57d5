"""The paper's second part, figures 6 to 10, in full and cut short, and what the command line tells of it."""

from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

from gyro_cosim import paper
from gyro_cosim.paper import vehicle
from gyro_cosim.paper.cases import Extent

FIGURES = ["figure_6.png", "figure_7.png", "figure_8.png", "figure_9.png", "figure_10.png"]
CUT = Extent(straight=2.0, behind_slow=2.0, behind_fast=5.0, starts=("0mm",))


def test_the_second_part_cut_short_draws_its_figures_and_judges_its_claims(tmp_path: Path) -> None:
    """One start, little straight track: what happens in the curve is all there."""
    heard: list[tuple[float, float]] = []
    claims, files = vehicle.reproduce(tmp_path, extent=CUT, progress=lambda done, total: heard.append((done, total)))
    assert heard[-1] == (12, 12)  # two sets, off and on, on straight track and in the curve at two speeds
    assert [file.name for file in files] == FIGURES
    assert all(file.read_bytes().startswith(b"\x89PNG") and file.stat().st_size > 20_000 for file in files)
    parts = {claim.id: claim.parts for claim in claims}
    assert list(parts) == ["C5", "C6", "C7", "C8", "C9", "C10"]
    assert parts["C5"] == {"28 degrees of freedom": True}
    assert parts["C6"] == {"A: off does not settle": True, "A: on settles": False, "B: off does not settle": True,
                           "B: on settles": False}  # nothing settles in two seconds  # fmt: skip
    assert all(parts["C7"][f"B: {part}"] for part in ("max y", "max psi", "swing in the curve"))
    assert parts["C8"] == {"A: Y": True, "A: Y/Q": True, "B: Y": True, "B: Y/Q": True}
    assert parts["C9"]["B: derails"]  # in the exit of the curve
    assert parts["C10"]["B: passes"]
    assert parts["C10"]["B: yaw about 0.001 rad"]
    assert all(claim.measured and claim.verdict for claim in claims)


@pytest.mark.slow
def test_the_whole_paper(cosim_json: Callable[..., Any], cosim: Callable[..., Any]) -> None:
    """Set B is the paper's vehicle in every part; with Table 2's wheels nothing settles at 50 m/s, nor behind the curve."""
    document = cosim_json("paper", "-o", "out", "--draws", "2")
    claims = {claim["id"]: claim for claim in document["claims"]}
    assert list(claims) == [f"C{k}" for k in range(1, 11)]
    for claim in claims.values():
        assert all(came_out for part, came_out in claim["parts"].items() if not part.startswith("A: ")), claim
        assert claim["sensitivity"].startswith(("holds in", "Table 2's wheels: holds in"))
    assert not claims["C6"]["parts"]["A: on settles"]
    assert not claims["C10"]["parts"]["A: y back to 0"]
    assert claims["C6"]["verdict"] == "partly: all but A: on settles"
    assert {Path(file).name for file in document["files"]} >= {*FIGURES, "draws_vehicle_2_1.csv", "draws_wheel-pair_2_1.csv"}


def test_the_sensitivity_stands_in_the_ledger_in_all_its_forms(cosim_json: Callable[..., Any]) -> None:
    told = cosim_json("paper", "-o", "out", "--only-wheel-pair", "--draws", "4", "--seed", "7")
    c4 = next(claim for claim in told["claims"] if claim["id"] == "C4")
    assert c4["sensitivity"].startswith("holds in ")
    assert " of 4 draws (" in c4["sensitivity"]
    assert c4["sensitivity"] in (Path("out") / "ledger.md").read_text()
    assert (Path("out") / "draws_wheel-pair_4_7.csv").exists()
    told = cosim_json("paper", "-o", "none", "--only-wheel-pair", "--draws", "0")
    assert {claim["sensitivity"] for claim in told["claims"]} == {"not studied (--draws 0)"}
    assert not list(Path("none").glob("draws*"))


def test_who_asks_for_no_draws_of_a_study_is_told(tmp_path: Path) -> None:
    with pytest.raises(ValueError, match="the number of draws must be at least 1, got 0"):
        paper.studied(tmp_path, 0, 1, [])
