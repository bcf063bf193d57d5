"""Claims asked again: what holds, what fails, what nothing decides; and the runs themselves."""

from pathlib import Path

import pytest

from gyro_cosim.paper import ledger, robust
from gyro_cosim.paper.cases import FAST, SLOW, STRAIGHT, Extent
from gyro_cosim.paper.measures import Measures
from gyro_cosim.paper.robust import WAYS, Part

RUN = {"y": 1e-2, "psi": 5e-2, "force": 3e4, "filtered": 1.5, "swing": 3e-3, "steady": 5e-2, "after": 1e-2, "climb": 0.2,
       "reach": 300.0}  # fmt: skip
CALM = {"y": 1e-3, "psi": 1e-3, "force": 1e4, "filtered": 0.5, "swing": 1e-4, "steady": 1e-3, "after": 1e-4, "climb": -0.1,
        "reach": 300.0}  # fmt: skip
LOST = RUN | {"climb": 1.1, "reach": 60.0}
N = 20


def rows(lost: dict[str, int]) -> dict[robust.Run, list[Measures]]:
    """The gyro calms every run; without it so many of the starts at 8 m/s derail with each way."""
    made: dict[robust.Run, list[Measures]] = {}
    for way in WAYS:
        for speed in (STRAIGHT, SLOW, FAST):
            calm = CALM | {"y": 1e-7} if speed == STRAIGHT else CALM
            made[way, speed, "on", "B"] = [calm] * N
            made[way, speed, "off", "B"] = [RUN] * N
        made[way, FAST, "off", "B"] = [LOST if k < lost.get(way, N) else RUN for k in range(N)]
    return made


def test_a_part_that_every_law_step_and_start_agrees_on_holds_or_fails() -> None:
    found = {(part.claim, part.part): part for part in robust.parts(rows({}))}
    assert found["C9", "B: derails"].held == dict.fromkeys(WAYS, N)
    assert {part.verdict for part in found.values()} == {"holds"}
    found = {(part.claim, part.part): part for part in robust.parts(rows(dict.fromkeys(WAYS, 0)))}
    assert found["C9", "B: derails"].verdict == "fails"
    assert found["C9", "B: derails"].words == f"{', '.join(f'{way} 0' for way in WAYS)} of 20"


@pytest.mark.parametrize(
    ("lost", "verdict"),
    [({"FASTSIM": 0}, "not decidable"), ({"FASTSIM": 19}, "holds"), ({"Polach": 18}, "not decidable"),
     (dict.fromkeys(WAYS, 10), "not decidable"), (dict.fromkeys(WAYS, 1), "fails")],
)  # fmt: skip
def test_one_law_and_one_start_in_twenty_decide(lost: dict[str, int], verdict: str) -> None:
    (part,) = (part for part in robust.parts(rows(lost)) if part.claim == "C9")
    assert part.verdict == verdict


def test_starts_are_compared_one_by_one() -> None:
    """Off and on of the same start: medians of both would hide that half of the starts go the other way."""
    turned = rows({})
    for way in WAYS:
        off, on = turned[way, SLOW, "off", "B"], turned[way, SLOW, "on", "B"]
        turned[way, SLOW, "off", "B"], turned[way, SLOW, "on", "B"] = [*off[:10], *on[10:]], [*on[:10], *off[10:]]
    found = [part for part in robust.parts(turned) if part.claim in ("C7", "C8")]
    assert len(found) == 5
    assert all(part.held == dict.fromkeys(WAYS, 10) for part in found)


CLAIM = ledger.Claim("C9", "fig. 9", "derails", "derails", "3 of 3", {"A: derails": True, "B: derails": True})


def asked(**counts: int) -> list[Part]:
    return [Part("C9", f"{name}: derails", {"Polach": N, "FASTSIM": count}, N) for name, count in counts.items()]


@pytest.mark.parametrize(
    ("found", "verdict"),
    [
        (asked(A=20, B=20), "reproduced"),
        (asked(A=20, B=0), "reproduced; not decidable: B: derails (Polach 20, FASTSIM 0 of 20)"),
        (asked(A=3, B=0), "not decidable: A: derails (Polach 20, FASTSIM 3 of 20); B: derails (Polach 20, FASTSIM 0 of 20)"),
        ([Part("C9", "A: derails", {"Polach": 0, "FASTSIM": 0}, N), *asked(B=20)], "partly: all but A: derails"),
        ([Part("C10", "A: passes", {"Polach": 0}, N)], "reproduced"),
    ],
)
def test_the_verdict_of_the_ledger_goes_by_what_was_asked_again(found: list[Part], verdict: str) -> None:
    claim = robust.judged(CLAIM, found)
    assert claim.verdict == verdict
    assert (claim.survives == "") == (found[0].claim != "C9")
    assert claim.survives in ledger.markdown([claim], "t")


def test_the_page_has_a_row_for_each_part_with_its_intervals() -> None:
    lines = robust.page(asked(A=20, B=0)).splitlines()
    assert lines[-1] == "| C9 | B: derails | not decidable | 20 (84..100 %) | 0 (0..16 %) |"
    assert len(lines) == 6


def test_a_number_of_starts_that_is_none_is_refused(tmp_path: Path) -> None:
    with pytest.raises(ValueError, match="starts must be at least 1, got 0"):
        robust.survived(tmp_path, 0)


@pytest.mark.slow
def test_the_runs_are_those_of_the_claims_and_go_on_where_they_were(tmp_path: Path) -> None:
    """Set A derails on straight track and in the curve whatever the law; asked for more starts, only those are run."""
    extent = Extent(straight=4.0, behind_slow=10.0, behind_fast=10.0)
    one = robust.survived(tmp_path, 1, extent)
    assert [part.claim for part in one] == ["C6"] * 4 + ["C7"] * 6 + ["C8"] * 4 + ["C9"] * 2 + ["C10"] * 6
    found = {(part.claim, part.part): part for part in one}
    assert found["C9", "A: derails"].held == dict.fromkeys(WAYS, 1)
    before = {file: file.stat().st_mtime_ns for file in tmp_path.glob("*.npz")}
    assert len(before) == 8
    assert robust.survived(tmp_path, 1, extent) == one
    assert {file: file.stat().st_mtime_ns for file in tmp_path.glob("*.npz")} == before
    with pytest.raises(ValueError, match="holds another sweep, which differs in stop"):
        robust.survived(tmp_path, 1, Extent(straight=5.0, behind_slow=10.0, behind_fast=10.0))
