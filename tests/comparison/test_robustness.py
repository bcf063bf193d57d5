"""Verdicts that are asked again: what is changed, what is counted, and when nothing can be decided."""

import re
from collections.abc import Callable, Mapping
from dataclasses import replace
from typing import Any

import numpy as np
import oscillators
import pytest

from gyro_cosim.comparison.error_bars import error_bar
from gyro_cosim.comparison.robustness import Change, asked_again, changes, interval
from gyro_cosim.errors import RunError
from gyro_cosim.master import open_network
from gyro_cosim.railway.field import RAILWAY
from gyro_cosim.railway.forms import with_creep_law
from gyro_cosim.ssp import system
from gyro_cosim.systems import StopWhen, System, catalogue
from gyro_cosim.trajectory import Trajectory

WITHIN = {"left.position": "1mm", "right.v2": 0.02}


def made(plan: System, within: Mapping[str, str | float] = WITHIN, starts: int = 50, seed: int = 1) -> list[Change]:
    with open_network(plan, in_process=True) as network:
        return changes(network, 0.02, within=within, starts=starts, seed=seed, forms={"with a hard spring": oscillators.pair()})


def test_each_run_has_one_thing_changed() -> None:
    plan = oscillators.pair().with_value("left.internal_step", "0.8ms")
    macro, internal, form, *starts = made(plan)
    assert (macro.kind, macro.step, macro.system) == ("macro step", 0.01, plan)
    assert (internal.kind, internal.step) == ("internal step", 0.02)
    assert internal.system.components[0].values == {**plan.components[0].values, "internal_step": pytest.approx(0.4e-3)}
    assert internal.system.components[1].values["internal_step"] == pytest.approx(0.5e-3)  # its own is 1 ms
    assert (form.kind, form.words, form.step) == ("form", "with a hard spring", 0.02)
    assert {(s.kind, s.step) for s in starts} == {("start", 0.02)}
    assert all(s.system.components[0].values["internal_step"] == "0.8ms" for s in starts)


def test_starts_lie_within_the_tolerance_about_the_value_of_the_run_and_come_from_the_seed() -> None:
    plan = oscillators.pair().with_value("left.position", "2m")
    drawn = [[(c.values["position"], d.values["v2"]) for c, d in [x.system.components]] for x in made(plan) if x.kind == "start"]
    positions, speeds = zip(*(one for (one,) in drawn), strict=True)
    assert len(positions) == 50
    assert all(abs(p - 2.0) <= 1e-3 for p in positions)
    assert max(abs(p - 2.0) for p in positions) > 0.8e-3
    assert all(abs(v) <= 0.02 for v in speeds)
    assert max(abs(v) for v in speeds) > 0.016
    assert made(plan) == made(plan) != made(plan, seed=2)
    assert [c for c in made(plan, {}) if c.kind == "start"] == []


@pytest.mark.parametrize(
    ("within", "starts", "words"),
    [
        ({"left.positon": "1mm"}, 1, "unknown parameter of 'left': 'positon'; did you mean 'position'?"),
        ({"middle.position": "1mm"}, 1, "'middle'; known: left, right"),
        ({"left.position": "1s"}, 1, "left.position: unit 's' cannot be expressed in 'm'"),
        ({"left.position": "-1mm"}, 1, "left.position: tolerance must be positive and finite, got -1mm"),
        ({"left.internal_step": "2ms"}, 1, "left.internal_step: must be at least"),
        ({"left.position": "1mm"}, 0, "starts must be at least 1, got 0"),
    ],
)
def test_what_cannot_be_varied_is_refused(within: dict[str, str], starts: int, words: str) -> None:
    with pytest.raises(ValueError, match=re.escape(words)):
        made(oscillators.pair(), within, starts)


def test_the_share_counts_starts_only_and_every_change_can_turn() -> None:
    runs = made(oscillators.pair(), starts=20)

    def ask(change: Change) -> dict[str, str]:
        if change.kind == "macro step":
            raise RunError("component 'left' failed")
        turned = change.kind == "form" or change in runs[-3:]
        return {"falls": "yes" if turned else "no", "stands": "yes"}

    told: list[tuple[float, float]] = []
    falls, stands, rests = asked_again(
        {"falls": "no", "stands": "yes"}, ["falls", "stands", "rests"], runs, ask, lambda done, of: told.append((done, of))
    )
    assert (falls.same, falls.starts, falls.decidable) == (17, 20, False)
    assert falls.turned == (
        "no answer with half the macro step (10 ms) (component 'left' failed)",
        "yes with a hard spring",
        f"3 of 20 starts, such as yes {runs[-3].words}",
    )
    assert (stands.same, len(stands.turned), stands.decidable) == (20, 1, False)
    assert not rests.answer
    assert not rests.decidable
    assert told[-1] == (23, 23)
    assert asked_again({"q": "a"}, ["q"], runs, lambda _: {"q": "a"})[0].decidable


def test_the_interval_is_wilsons() -> None:
    """Of Newcombe, Two-sided confidence intervals for the single proportion (1998), table I: 81 of 263, 15 of 148, 0 of 20."""
    assert interval(81, 263) == pytest.approx((0.2553, 0.3662), abs=5e-5)
    assert interval(15, 148) == pytest.approx((0.0624, 0.1605), abs=5e-5)
    assert interval(0, 20) == pytest.approx((0.0, 0.1611), abs=5e-5)
    assert interval(0, 0) == (0.0, 1.0)


def test_the_railway_knows_which_vehicles_have_another_creep_law() -> None:
    forms = RAILWAY.forms(system("lrt-curve"))
    others = ["vehicle:lrt_shen_hedrick_elkins", "vehicle:lrt_fastsim", "vehicle:lrt_half_space"]
    assert [form.components[0].source for form in forms.values()] == others
    assert list(forms)[1] == "with FASTSIM (vehicle = vehicle:lrt_fastsim)"
    plan = system("lrt-curve")
    assert all(form.components[0].values == plan.components[0].values for form in forms.values())
    assert not RAILWAY.forms(system("lrt-straight-b").with_source("vehicle", "lrt_solid_axle"))
    assert not RAILWAY.forms(system("wheel-pair"))


def test_another_creep_law_keeps_the_numbers_of_the_vehicle() -> None:
    """Set B is a variant with Polach's law: with FASTSIM it has the same wheels, on the system's own track."""
    plan = system("lrt-curve-b").with_value("vehicle.friction", 0.3)
    _, fastsim, _ = RAILWAY.forms(plan).values()
    (vehicle, *_), own = fastsim.components, plan.components[0]
    rows = {v.name: v.start for v in catalogue.component(own.source).parameters}
    other = {v.name: v.start for v in catalogue.component(vehicle.source).parameters}
    assert vehicle.source == "vehicle:lrt_fastsim"
    assert {**rows, **own.bound, **own.values} == {**other, **vehicle.bound, **vehicle.values}
    assert (vehicle.bound["speed"], vehicle.values["friction"], vehicle.values["conicity"]) == (5.0, 0.3, 0.45)
    with pytest.raises(ValueError, match="creep law of 'vehicle:wheel_pair' must be one of none that is known, got 'FASTSIM'"):
        with_creep_law(system("wheel-pair"), "vehicle", "FASTSIM")


@pytest.fixture
def swinging(monkeypatch: pytest.MonkeyPatch) -> System:
    """The command line then runs the oscillator, which stops where its left mass is too fast: 3 m/s, which it is."""
    from gyro_cosim.cli import run as command

    plan = replace(
        oscillators.pair(), stop=2.0, step=1e-2, stop_when=(StopWhen(("left", "velocity"), 3.0, "too fast"),)
    )  # fmt: skip
    monkeypatch.setattr(command, "chosen_system", lambda *_, **__: plan)
    return plan


RUN = ("run", "oscillator", "--in-process", "--robust")


def test_a_verdict_far_from_its_limit_holds(swinging: System, cosim: Callable[..., Any], cosim_json: Callable[..., Any]) -> None:
    document = cosim_json(*RUN, "--within", "left.position=1mm", "--starts", "5")
    (verdict,) = document["robust"]["verdicts"]
    assert (verdict["question"], verdict["answer"], verdict["decidable"]) == ("stops: too fast", "yes", True)
    assert (verdict["same"], verdict["of"], verdict["turned"]) == (5, 5, [])
    assert document["robust"]["starts"] == "5 starts, seed 1: left.position +- 1mm"
    assert document["robust"]["runs"] == 7
    code, out, err = cosim(*RUN)
    assert (code, err) == (0, "")
    assert "no other starts (--within)" in out
    assert "stops: too fast? yes, in all of them\n" in out


def test_a_verdict_that_starts_turn_is_not_decidable(swinging: System, cosim: Callable[..., Any]) -> None:
    code, out, _ = cosim(*RUN, "--within", "left.position=1m", "--starts", "8")
    assert code == 1
    said = " ".join(out.split())
    assert "stops: too fast? not decidable: yes in this run, " in said
    assert "of 8 starts, such as no from left.position = 0." in said


def test_a_system_without_a_verdict_is_refused_before_it_runs(cosim: Callable[..., Any], monkeypatch: pytest.MonkeyPatch) -> None:
    from gyro_cosim.cli import run as command

    monkeypatch.setattr(command, "run_network", lambda *_, **__: pytest.fail("it ran"))
    code, out, err = cosim("run", "wheel-pair", "--in-process", "--robust")
    assert (code, out, err.count("\n")) == (2, "", 1)
    assert err.startswith("cosim: --robust needs a verdict, system 'wheel-pair' has none: ")


@pytest.mark.parametrize(
    ("words", "says"),
    [
        (("--starts", "3"), "--starts has no effect without --robust"),
        (("--robust", "--adaptive", "1e-4"), "--robust needs an even macro step"),
        (("--robust", "--within", "left.position"), "--within must be COMPONENT.VARIABLE=TOL, got 'left.position'"),
    ],
)
def test_options_that_do_not_fit_are_one_line(
    words: tuple[str, ...], says: str, swinging: System, cosim: Callable[..., Any]
) -> None:
    code, out, err = cosim("run", "oscillator", "--in-process", *words)
    assert (code, out, err.count("\n")) == (2, "", 1)
    assert says in err


def test_a_start_that_nobody_has_seen_lies_in_the_bar_as_often_as_it_says() -> None:
    """Whatever the law: two humps with a long tail, and numbers of which many are equal; 3000 times, each with a fresh one."""
    random = np.random.default_rng(3)
    for starts, said in ((39, 0.95), (100, 1 - 4 / 101), (20, 19 / 21)):
        hits, ties = 0, 0
        for _ in range(3000):
            humps = np.where(
                random.random(starts + 1) < 0.3, random.normal(1.4, 0.01, starts + 1), random.lognormal(-0.5, 0.4, starts + 1)
            )
            bar = error_bar(humps[:-1])
            assert (bar.share, bar.starts) == (pytest.approx(said), starts)
            hits += bar.low <= humps[-1] <= bar.high
            steps = np.round(humps, 1)
            bar = error_bar(steps[:-1])
            ties += bar.low <= steps[-1] <= bar.high
        assert hits / 3000 == pytest.approx(said, abs=0.013)  # three standard errors
        assert ties >= hits


def test_a_start_without_a_figure_may_have_any() -> None:
    bar = error_bar([*np.linspace(0.0, 1.0, 38), float("nan")])
    assert (bar.low, bar.high) == (-np.inf, np.inf)
    assert error_bar([0.0, np.inf, 1.0]).high == np.inf
    with pytest.raises(ValueError, match="an error bar needs at least one value"):
        error_bar([])
    with pytest.raises(ValueError, match="share must lie between 0 and 1, got 1"):
        error_bar([1.0], 1.0)


class Swing:
    """A field that measures the end of the run."""

    key = "swings"

    def assess(self, trajectory: Trajectory) -> list[float]:
        return [float(trajectory["left.position"][-1])]

    def lines(self, finding: float) -> list[str]:
        return []

    def document(self, finding: float) -> dict[str, float]:
        return {"end": finding}

    def figure(self, finding: float, trajectory: Trajectory, title: str) -> None:
        return None

    def measures(self, finding: float) -> dict[str, tuple[float, str]]:
        return {"end": (finding, "m")}


def test_figures_get_error_bars_from_the_starts(
    swinging: System, monkeypatch: pytest.MonkeyPatch, cosim: Callable[..., Any], cosim_json: Callable[..., Any]
) -> None:
    """The linear oscillator ends where it began times a factor: the bar is as wide as the tolerance times that factor."""
    from gyro_cosim.cli import assessments, robust

    for module in (assessments, robust):
        monkeypatch.setattr(module, "fields", lambda: [Swing()])
    document = cosim_json(*RUN, "--within", "left.position=1mm", "--stop", "0.4")
    (bar,) = document["robust"]["error_bars"]
    assert (bar["of"], bar["unit"], bar["starts"]) == ("end", "m", 39)
    assert bar["share"] == pytest.approx(0.95)
    assert bar["low"] < bar["value"] == document["swings"][0]["end"] < bar["high"]
    wider = cosim_json(*RUN, "--within", "left.position=2mm", "--stop", "0.4")["robust"]["error_bars"][0]
    assert wider["high"] - wider["low"] == pytest.approx(2 * (bar["high"] - bar["low"]), rel=1e-6)
    _, out, _ = cosim(*RUN, "--within", "left.position=1mm", "--starts", "5")
    assert re.search(r"^end \S+ m; a further start lies in \S+\.\.\S+ m with 67 %$", out, flags=re.MULTILINE)


COMPARED = ("compare", "wheel-pair", "--gyro", "nonlinear", "--gyro", "linear", "--in-process", "--stop", "1", "--robust")


def test_variants_that_are_alike_stay_alike_whatever_is_changed(
    cosim_json: Callable[..., Any], monkeypatch: pytest.MonkeyPatch
) -> None:
    """Small angles: the cosine matters nowhere. Each variant gets half of its own internal step."""
    from gyro_cosim.cli import compare_robust

    seen: list[list[str]] = []

    def watched(plan: System, texts: list[str], **settings: Any) -> Any:
        seen.append(list(texts))
        return compare_robust_compare(plan, texts, **settings)

    compare_robust_compare = compare_robust.compare
    monkeypatch.setattr(compare_robust, "compare", watched)
    small = ("--set", "vehicle.yaw_angle=0.01", "--within", "vehicle.yaw_angle=1mrad", "--starts", "3")
    asked = cosim_json(*COMPARED, *small)["robust"]
    (verdict,) = asked["verdicts"]
    assert verdict["question"] == "linear keeps the tolerances against nonlinear"
    assert (verdict["answer"], verdict["decidable"], verdict["same"], verdict["of"]) == ("yes", True, 3, 3)
    assert asked["starts"] == "3 starts, seed 1: vehicle.yaw_angle +- 1mrad"
    assert seen[1] == ["nonlinear,internal_step=0.0005", "linear,internal_step=0.0005"]
    assert [texts for k, texts in enumerate(seen) if k != 1] == [["nonlinear", "linear"]] * 4


def test_a_comparison_that_a_start_turns_is_not_decidable(cosim: Callable[..., Any]) -> None:
    """5 % are reached at some 0.2 rad; the starts lie about the value that is set, not about the system's own."""
    big = ("--set", "vehicle.yaw_angle=0.25", "--within", "vehicle.yaw_angle=0.2", "--starts", "8")
    code, out, _ = cosim(*COMPARED, *big)
    assert code == 1
    said = " ".join(out.split())
    assert re.search(
        r"linear keeps the tolerances against nonlinear\? not decidable: (yes|no) in this run, [1-7] of 8 starts, ", said
    )
    code, _, err = cosim("compare", "wheel-pair", "--gyro", "linear", "--gyro", "off", "--starts", "3")
    assert (code, err) == (2, "cosim: --starts has no effect without --robust, got 3\n")
    code, _, err = cosim("compare", "wheel-pair", "--gyro", "linear", "--gyro", "other.ssp", "--robust")
    assert code == 2
    assert "--robust needs variants of a component" in err
