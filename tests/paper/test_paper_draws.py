"""How far each claim holds: draws from the open parameters, their rows, what is made of them."""

import os
import signal
import subprocess
import sys
import time
from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from gyro_cosim import figures, master
from gyro_cosim.master.side_by_side import SideBySide
from gyro_cosim.paper import cases, measures
from gyro_cosim.paper.sensitivity import figures as sensitivity_figures
from gyro_cosim.paper.sensitivity import pair_draws, statistics, vehicle_draws
from gyro_cosim.paper.sensitivity.draws import Bench, Study, Subject, carry_out
from gyro_cosim.paper.sensitivity.findings import all_findings, ranking, sentences
from gyro_cosim.paper.sensitivity.open_parameters import Open, coordinates, draws, middle
from gyro_cosim.paper.sensitivity.page import document, study_page
from gyro_cosim.paper.sensitivity.statistics import influences, wilson
from gyro_cosim.paper.sensitivity.study import studied
from gyro_cosim.sweeps.store import journal_of, load
from gyro_cosim.sweeps.table import Table
from gyro_cosim.trajectory import Trajectory

SHORT = cases.Extent(straight=1.0, behind_slow=5.0, behind_fast=5.0, starts=("0mm",))
PAIR, VEHICLE = pair_draws.subject(), vehicle_draws.subject(SHORT)
SUBJECTS: list[Subject] = [PAIR, VEHICLE]


@pytest.mark.parametrize("subject", SUBJECTS, ids=lambda subject: subject.name)
def test_every_open_parameter_is_drawn_and_can_be_set_on_the_fmus(subject: Subject) -> None:
    """What the tables mark as assumed, neither more nor less, takes any value of its range when a run begins."""
    plan = PAIR.system if subject is PAIR else VEHICLE.systems[cases.SLOW]
    with master.open_network(plan) as network:
        for parameter in subject.parameters:
            for member in plan.addressed(parameter.target.partition(".")[0]):
                slave = next(s for s in network.slaves if s.name == member)
                name = parameter.target.partition(".")[2]
                assert slave.description.settable[name].unit == parameter.unit
                for value in (parameter.low, parameter.high):
                    assert slave.description.start_values(slave.name, {name: value})[name] == value
    if subject is VEHICLE:
        names = {parameter.target for parameter in subject.parameters}
        assert names >= {"vehicle.conicity", "vehicle.friction", "gyro.spring_arm", "gyro.gimbal_stiffness"}
        assert not names & {"vehicle.body_mass", "vehicle.speed", "gyro.rotor_speed", "vehicle.wheel_spin_inertia"}


def test_the_kinds_of_wheels_differ_in_spin_inertia_alone() -> None:
    """Kalker's C11 is scaled with it, so that the wheel's stiffness in spin stays."""
    printed, light = VEHICLE.wheels.values()
    assert printed == {}
    assert set(light) == {"vehicle.wheel_spin_inertia", "vehicle.kalker_c11", "vehicle.flange_kalker_c11"}
    factor = light["vehicle.wheel_spin_inertia"] / VEHICLE.fixed["wheel_spin_inertia"]
    assert light["vehicle.kalker_c11"] == pytest.approx(factor * VEHICLE.fixed["kalker_c11"], rel=1e-9)


def test_draws_are_a_latin_hypercube_and_what_is_tied_moves_together() -> None:
    of = VEHICLE.parameters
    points = draws(of, 40, seed=3)
    assert points == draws(of, 40, seed=3) != draws(of, 40, seed=4)
    share = {p.target: np.array([(point[p.target] - p.low) / (p.high - p.low) for point in points]) for p in of}
    for target, x in share.items():
        assert sorted(np.floor(x * 40).astype(int)) == list(range(40)), target  # one in each fortieth of the range
    np.testing.assert_allclose(share["gyro.gimbal_stiffness"], share["gyro.gimbal_damping"], rtol=1e-9)
    n = [point["gyro.gimbal_stiffness"] / 86700.0 for point in points]
    np.testing.assert_allclose([point["gyro.gimbal_damping"] / 21000.0 for point in points], n, rtol=1e-9)  # n springs, n dampers
    assert len(coordinates(of)) == len(of) - 1
    assert middle(of)["vehicle.conicity"] == pytest.approx(0.25)


@pytest.mark.parametrize(
    ("count", "judged", "low", "high"),
    [(81, 263, 0.2553, 0.3662), (15, 148, 0.0624, 0.1605), (0, 20, 0.0, 0.1611), (1, 29, 0.0061, 0.1718)],
)
def test_wilsons_interval_meets_the_literature(count: int, judged: int, low: float, high: float) -> None:
    """Newcombe, Two-sided confidence intervals for the single proportion, Statistics in Medicine 17 (1998), table I, method 3."""
    share = wilson(count, judged)
    assert (share.low, share.high) == pytest.approx((low, high), abs=5e-5)
    turned = wilson(judged - count, judged)
    assert (turned.low, turned.high) == pytest.approx((1 - high, 1 - low), abs=5e-5)


def test_a_share_of_nothing_says_nothing() -> None:
    assert (wilson(0, 0).low, wilson(0, 0).high) == (0.0, 1.0)
    with pytest.raises(ValueError, match=r"count must lie in 0\.\.3, got 4"):
        wilson(4, 3)


def test_rank_correlation_finds_what_decides_and_not_what_does_not() -> None:
    generator = np.random.default_rng(1)
    columns = {name: generator.random(200) for name in ("strong", "weak", "none")}
    margin = np.exp(5 * columns["strong"]) - 20 * columns["weak"]
    found = influences(columns, margin)
    assert [i.target for i in found] == ["strong", "weak", "none"]
    assert found[0].rho > 0.7
    assert -0.7 < found[1].rho < -0.2
    assert [i.counts for i in found] == [True, True, False]
    margin[:5] = np.nan  # draws that failed
    margin[5:10] = np.sign(margin[5:10]) * np.inf
    assert [i.counts for i in influences(columns, margin)] == [True, True, False]


def test_a_parameter_that_leans_on_another_does_not_count() -> None:
    """In a sample that ties them a little, a parameter without influence is correlated with what the other decides."""
    generator = np.random.default_rng(5)
    strong = generator.random(300)
    leaning = strong + 2 * generator.random(300)
    found = {i.target: i for i in influences({"strong": strong, "leaning": leaning}, strong + 0.1 * generator.random(300))}
    assert found["leaning"].rho > 0.3
    assert abs(found["leaning"].partial) < 0.2
    assert [found[name].counts for name in ("strong", "leaning")] == [True, False]


def test_rank_correlation_meets_a_worked_example() -> None:
    """Spearman's rho of IQ and hours of television, the example of the encyclopedias: -29 / 165."""
    iq = np.array([106, 100, 86, 101, 99, 103, 97, 113, 112, 110.0])
    hours = np.array([7, 27, 2, 50, 28, 29, 20, 12, 6, 17.0])
    (found,) = influences({"iq": iq}, hours)
    assert found.rho == pytest.approx(-29 / 165, rel=1e-12)
    assert found.p == pytest.approx(0.627188, abs=1e-6)
    assert not found.counts


def test_chance_counts_how_many_parameters_were_tried() -> None:
    """Of many meaningless parameters some look strong: in 50 studies hardly one may be reported."""
    generator = np.random.default_rng(2)
    told = 0
    for _ in range(50):
        columns = {str(k): generator.random(60) for k in range(25)}
        told += any(i.counts for i in influences(columns, generator.random(60)))
    assert told <= 7  # 2.5 expected; 8 or more has a probability of 0.4 %
    assert influences({"a": generator.random(9)}, np.ones(9)) == ()


@dataclass(frozen=True)
class Made:
    """A subject whose claim depends on its parameters in a known way; nothing has to be run."""

    name: str = "made"
    claims: Any = None
    measures: Any = None
    sources: tuple[str, ...] = ()
    parameters: tuple[Open, ...] = tuple(Open(f"m.{n}", 0.0, 1.0, "1", "made up") for n in ("alpha", "beta", "gamma"))
    wheels: Any = None
    named: Any = None

    def open(self, files: Mapping[str, str], lanes: SideBySide) -> Bench:
        raise NotImplementedError

    def described(self) -> dict[str, Any]:
        return {}


MADE = Made(
    claims={"C1": ("high", "low"), "C2": ("all",)},
    measures={"5 m/s off: climb": "1", "5 m/s on: climb": "1"},
    wheels={"round": {}},
    named={"best": ("round", {"m.alpha": 0.9, "m.beta": 0.1, "m.gamma": 0.5})},
)


def made(count: int = 200) -> tuple[Study, Table]:
    """C1 holds where alpha is over a half (part "high") and beta under 0.8 ("low"); C2 everywhere but in draw 7, which failed.

    Off derails where alpha is over a quarter, on where it is over 0.75.
    """
    study = Study(MADE, count, 2)
    rows = []
    for k, point in enumerate(study.points()):
        a, b = float(point["m.alpha"]), float(point["m.beta"])
        failed = point["draw"] == 7.0
        climbs = [float(a > 0.25) + 0.5, float(a > 0.75) + 0.5]
        parts = [x for margin in (10 * (a - 0.5), 0.8 - b, 1.0) for x in (float(margin > 0), margin)]
        values = [float("nan")] * 8 if failed else climbs + parts
        rows.append([str(k), *point.values(), "failed" if failed else "done", "burst" if failed else "", 0.0, *values])
    text = ["run", "kind", "wheels", "status", "error"]
    return study, Table.of_rows({"columns": list(study.columns), "text": text, "definition": {}}, rows)


def test_what_is_found_is_what_was_put_in() -> None:
    study, table = made()
    found = {(f.claim, f.part): f for f in all_findings(study, table)}
    assert found["C1", "high"].share.judged == 199
    assert found["C1", "high"].share.count == pytest.approx(100, abs=1)  # a Latin hypercube: half of the range, half of the draws
    assert found["C1", ""].share.count == pytest.approx(80, abs=12)
    assert found["C2", ""].share == statistics.wilson(199, 199)
    assert [shown.target for shown in found["C1", "high"].deciding] == ["m.alpha"]
    assert found["C1", "high"].deciding[0].rho == pytest.approx(np.sqrt(3) / 2, abs=0.01)  # of a half with its ranks
    assert found["C1", "low"].deciding[0].rho == pytest.approx(-np.sqrt(3 * 0.2 * 0.8), abs=0.02)  # of a fifth
    few = {(f.claim, f.part): f for f in all_findings(*made(15))}[
        "C1", "high"
    ]  # too few on either side: the margin is alpha itself
    assert [(i.target, i.rho) for i in few.deciding] == [("m.alpha", pytest.approx(1.0))]
    assert "; its margin moves with alpha (+1.00)" in few.text
    assert [i.target for i in found["C1", ""].deciding] == ["m.alpha", "m.beta"]
    assert found["C1", ""].middle is False  # alpha is not OVER a half there
    assert found["C1", "low"].middle is True
    assert found["C2", ""].influences == ()
    told = sentences(list(found.values()), ("round",))
    count, low, high = (getattr(found["C1", ""].share, n) for n in ("count", "low", "high"))
    assert told["C1"].startswith(f"holds in {count} of 199 draws ({100 * low:.0f}..{100 * high:.0f} %); decided by alpha (+0.")
    assert told["C1"].endswith("at the middle of all ranges it does not")
    assert told["C2"] == "holds in 199 of 199 draws (98..100 %); at the middle of all ranges it holds"


def test_ranking_counts_parts_and_the_page_says_it_all() -> None:
    study, table = made()
    ranked = ranking(study, table)
    assert (ranked[0].parts, ranked[0].claims) == (3, 2)
    assert (ranked[-1].parts, ranked[-1].claims, ranked[-1].draw) == (0, 0, 7)  # what failed comes last
    assert [r.parts for r in ranked] == sorted((r.parts for r in ranked), reverse=True)
    best = sum(r.parts == 3 and r.kind == "draw" for r in ranked)
    text = study_page(study, table)
    assert f"| best | round | 3 | 2 | 0 of 200 | {best} |" in text
    equal = sum((r.parts, r.claims) == (2, 1) and r.kind == "draw" for r in ranked)
    assert f"| middle of all ranges | round | 2 | 1 | {best} of 200 | {equal} |" in text
    assert "1 of them failed" in text
    assert "| 5 m/s | round | 150 (" in text  # off
    assert "| 100 | 0 | 199 |" in text  # off derails where on passes, and never the other way
    data = document(study, table)
    assert data["ranking"][0]["values"]["m.alpha"] > 0.5
    assert (data["draws"], data["failed"], len(data["findings"])) == (200, 1, 5)


def test_figures_are_drawn(tmp_path: Path) -> None:
    found = all_findings(*made(30))
    assert figures.save(sensitivity_figures.shares(found), tmp_path / "a.png").stat().st_size > 5000
    assert figures.save(sensitivity_figures.correlations(found), tmp_path / "b.png").stat().st_size > 5000


@pytest.mark.slow
def test_a_study_that_is_stopped_goes_on_and_repeats_nothing(tmp_path: Path) -> None:
    study, file = Study(PAIR, 3, 1), tmp_path / "a.csv"

    def stop(done: float, total: float) -> None:
        if done >= 2:
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        carry_out(study, file, workers=1, progress=stop)
    kept = load(file)
    assert 2 <= len(kept) < 5
    heard: list[tuple[float, float]] = []
    table = carry_out(study, file, workers=2, progress=lambda done, total: heard.append((done, total)))
    assert len(table) == 5  # three draws, the middle, the defaults
    assert heard[0][0] > len(kept)
    assert heard[-1] == (5, 5)
    before = dict(zip(kept["run"].tolist(), kept["wall_s"].tolist(), strict=True))
    after = dict(zip(table["run"].tolist(), table["wall_s"].tolist(), strict=True))
    assert {key: after[key] for key in before} == before
    assert table["kind"].tolist() == ["defaults", "middle", *["draw"] * 3]
    again = carry_out(study, file, progress=lambda done, total: pytest.fail("nothing is left to do"))
    assert (again["wall_s"] == table["wall_s"]).all()
    other = carry_out(study, tmp_path / "b.csv", workers=1)  # the same rows, to the last bit
    for name in set(table.values) - {"wall_s"}:
        assert np.array_equal(table[name], other[name], equal_nan=table[name].dtype.kind == "f"), name
    assert not np.array_equal(carry_out(Study(PAIR, 3, 2), tmp_path / "c.csv")["gyro.spring_arm"], table["gyro.spring_arm"])


def test_a_study_that_is_killed_goes_on(tmp_path: Path) -> None:
    command = [
        sys.executable,
        "-m",
        "gyro_cosim",
        "paper",
        "--only-wheel-pair",
        "--draws",
        "30",
        "--seed",
        "3",
        "-o",
        str(tmp_path),
    ]
    file = tmp_path / "draws_wheel-pair_30_3.csv"
    with subprocess.Popen(command, start_new_session=True, stderr=subprocess.DEVNULL, env={**os.environ, "TMPDIR": str(tmp_path)}
                          ) as process:  # fmt: skip
        while process.poll() is None and not (journal_of(file).exists() and journal_of(file).read_bytes().count(b"\n") > 3):
            time.sleep(0.02)
        os.killpg(process.pid, signal.SIGKILL)
    kept = load(file)
    assert 0 < len(kept) < 32
    assert not file.exists()
    table = carry_out(Study(PAIR, 30, 3), file)
    assert len(table) == np.unique(table["run"]).size == 32
    assert set(kept["wall_s"].tolist()) <= set(table["wall_s"].tolist())


def test_a_file_of_another_study_is_refused_and_kept(cosim: Callable[..., Any]) -> None:
    options = ("paper", "--only-wheel-pair", "--draws", "1", "-o", ".")
    carry_out(Study(PAIR, 2, 1), Path("draws_wheel-pair_1_1.csv"))
    before = Path("draws_wheel-pair_1_1.csv").read_bytes()
    code, _, err = cosim(*options)
    assert code == 2
    assert "'draws_wheel-pair_1_1.csv' holds another sweep, which differs in samples; give another folder" in err
    assert err.count("\n") == 1
    assert Path("draws_wheel-pair_1_1.csv").read_bytes() == before
    code, _, err = cosim("paper", "--draws", "-1")
    assert (code, err) == (2, "cosim: --draws must not be negative, got -1\n")


def test_a_draw_that_fails_is_a_row_with_its_error(tmp_path: Path) -> None:
    bad = replace(PAIR, parameters=(Open("vehicle.wheel_load", -3.0, 4.0, "N", "partly impossible"),), named={})
    table = carry_out(Study(bad, 2, 1), tmp_path / "a.csv", workers=1)
    impossible = table["vehicle.wheel_load"] < 0.0
    assert impossible.sum() == 1
    assert (table["status"] == np.where(impossible, "failed", "done")).all()
    (error,) = table["error"][impossible]
    assert "vehicle.wheel_load: must be at least 0" in error
    assert np.isnan(table["C1: four stay"][impossible]).all()
    assert np.isfinite(table["C1: four stay"][~impossible]).all()
    assert all_findings(Study(bad, 2, 1), table)[0].share.judged == 1


def test_a_draw_of_the_vehicle_is_what_the_ledgers_code_gives(tmp_path: Path) -> None:
    """Set B as a row of the study against the same case run on its own, as the ledger does."""
    short = {"vehicle.transition_length": (5.0, 6.0), "vehicle.curve_length": (20.0, 21.0)}
    ranges = tuple(replace(p, low=short[p.target][0], high=short[p.target][1]) if p.target in short else p
                   for p in VEHICLE.parameters)  # fmt: skip
    subject = replace(VEHICLE, parameters=ranges, named={"set B": VEHICLE.named["set B"]})
    table = carry_out(Study(subject, 1, 1), tmp_path / "a.csv")
    assert table["kind"].tolist() == ["set B", "middle", "middle", "draw", "draw"]
    assert table["wheels"].tolist() == [cases.SETS["B"], *[*cases.SETS.values()] * 2]
    assert set(table["status"].tolist()) == {"done"}
    plan = cases.with_case(cases.base("B", cases.SLOW), cases.SLOW, "on", "0mm")
    vehicle = {"curve_start": 20.0, "transition_length": 40.0, "curve_length": 60.0}
    stop = cases.seconds(cases.SLOW, vehicle, SHORT)
    assert stop == (20 + 2 * 40 + 60 + 5) / 5
    tr = master.simulate(plan, algorithm=cases.ALGORITHM, stop=stop, options=master.Options(record=cases.RECORD)).trajectory
    for key, value in measures.curve(tr).items():
        assert table[f"5 m/s on: {key}"][0] == pytest.approx(value, rel=1e-9), key
    assert table["C9: derails"][0] == 1.0  # 8 m/s off derails with set B (figure 9) ...
    assert table["C10: passes"][0] == 1.0  # ... and on passes
    drawn = table.where(table["kind"] == "draw")
    for parameter in VEHICLE.parameters:  # both kinds of wheels have the same draw
        assert drawn[parameter.target][0] == drawn[parameter.target][1]
    assert drawn["50 m/s off: y"][0] != drawn["50 m/s off: y"][1]


@pytest.mark.parametrize(
    ("early", "late", "left"), [(8e-3, 8e-3, True), (8e-3, 3e-3, False), (8e-3, 5e-4, False), (1e-9, 1e-4, False)]
)
def test_a_straight_run_is_left_only_where_it_hunts_steadily(early: float, late: float, left: bool) -> None:
    """One that still shrinks, is small, or grows from nothing is run to its end."""
    t = np.arange(0.0, 60.0, 0.01)
    y = np.interp(t, [30.0, 55.0], [early, late]) * np.sin(20 * t)
    assert vehicle_draws.hunts(Trajectory(t, (measures.Y,), ("m",), y[:, None])) == left


def test_the_ledger_tells_the_sensitivity(tmp_path: Path) -> None:
    texts, files = studied(tmp_path, 4, 1, [PAIR])
    assert set(texts) == {"C1", "C2", "C3", "C4", "C5"}
    assert texts["C3"].startswith("holds in 4 of 4 draws (51..100 %)")
    assert {file.name for file in files} >= {
        "draws_wheel-pair_4_1.csv",
        "sensitivity.md",
        "sensitivity.json",
        "claims_shares.png",
    }
    assert all(file.exists() for file in files)
