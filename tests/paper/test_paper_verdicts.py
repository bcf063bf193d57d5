"""The verdicts on the paper's claims, from made-up runs whose outcome is known: each part comes out as it should."""

from dataclasses import replace

import numpy as np
import pytest

from gyro_cosim.paper import measures, pair_measures, vehicle
from gyro_cosim.paper.cases import FAST, SETS, SLOW, SPINS, STRAIGHT, Case
from gyro_cosim.paper.measures import decades, holds
from gyro_cosim.paper.pair_measures import ETA, PSI, TURNING, Observed, Y
from gyro_cosim.railway.assessment import assess
from gyro_cosim.trajectory import Trajectory

NAMES = tuple(
    f"vehicle.{n}"
    for n in ("body_distance", "curvature", "front_lateral_displacement", "front_yaw_angle", "front_left_lateral_force",
              "front_left_derailment_coefficient", "front_left_climb")
)  # fmt: skip
SIDE, SPEED = 1e-6, 5.0


def run(
    y: float = 0.0, psi: float = 0.0, force: float = 0.0, ratio: float = 0.0, climb: float = 0.0, *,
    rest: float = 0.0, until: float = 300.0, speed: float = SPEED,
) -> Trajectory:  # fmt: skip
    """A curve from 20 to 100 m, steady from 30 to 90 m: y swings by `y` to 110 m and by `rest` behind, the others are constant;
    it ends at `until`, with the climb `climb`."""
    s = np.arange(0.0, until, 0.01)
    curvature = np.interp(s, [20, 30, 90, 100], [0, 0.02, 0.02, 0])
    swing = np.where(s < 110.0, y, rest) * np.sin(2 * np.pi * s / 5.0)
    over = np.where(s < s[-1], -0.3, climb)
    columns = [s, curvature, swing, *(np.full_like(s, x) for x in (psi, force, ratio)), over]
    return Trajectory(s / speed, NAMES, ("1",) * len(NAMES), np.column_stack(columns))


def derails(at: float, **signals: float) -> Trajectory:
    return run(**signals, climb=1.01, until=at)


GOOD = {"y": 2e-3, "psi": 1e-3, "force": 1e4, "ratio": 0.4}
BAD = {"y": 8e-3, "psi": 5e-2, "force": 4e4, "ratio": 1.1}


def test_measures_of_a_curve_are_those_of_the_run() -> None:
    found = measures.curve(run(**GOOD, rest=5e-4))
    assert found["y"] == pytest.approx(2e-3, rel=1e-3)
    assert found["swing"] == pytest.approx(2e-3 / np.sqrt(2), rel=1e-2)  # of a sine; over the steady curve, not the whole run
    assert found["steady"] == pytest.approx(1e-3)
    assert found["after"] == pytest.approx(5e-4, rel=1e-3)
    assert (found["psi"], found["force"], found["climb"]) == (1e-3, 1e4, 0.0)
    assert found["filtered"] == pytest.approx(0.4, rel=1e-6)
    assert found["reach"] == pytest.approx(300.0, abs=0.02)


def test_the_steady_state_is_that_of_the_second_half_of_the_curve() -> None:
    """What swings in while the curve begins is a transient."""
    tr = run(**GOOD)
    entering = np.where(tr["vehicle.body_distance"] < 59.0, 10.0, 1.0)
    moved = np.isin(tr.names, (measures.Y, measures.PSI))
    values = tr.values * np.where(moved, entering[:, None], 1.0)
    wild, calm = measures.curve(Trajectory(tr.t, tr.names, tr.units, values)), measures.curve(tr)
    assert wild["y"] == pytest.approx(10 * calm["y"])
    assert (wild["swing"], wild["steady"]) == pytest.approx((calm["swing"], calm["steady"]))


@pytest.mark.parametrize(
    ("at", "through"), [(10.0, False), (25.0, False), (60.0, False), (95.0, True), (200.0, True)]
)  # before, in the transition, in the steady curve, in the exit, behind
def test_a_run_that_derails_before_the_end_of_the_steady_curve_has_no_steady_state(at: float, through: bool) -> None:
    found = measures.curve(derails(at, **GOOD))
    assert np.isfinite(found["swing"]) == np.isfinite(found["steady"]) == through
    assert found["after"] == np.inf


def test_a_flange_that_is_lost_to_a_number_that_is_none_has_derailed() -> None:
    assert measures.climb(run(climb=float("nan"))) == np.inf


def settling(y: float, climb: float = 0.0) -> measures.Measures:
    """On straight track, the amplitude y at the end."""
    return measures.straight(run(8e-3, rest=y, climb=climb))


@pytest.mark.parametrize(
    ("off", "on", "parts"),
    [
        (settling(8e-3), settling(2e-7), (True, True)),
        (settling(2e-7), settling(8e-3), (False, False)),  # the other way round nothing is left of the claim
        (settling(2e-7), settling(2e-7), (False, True)),
        (settling(2e-7, climb=1.2), settling(2e-7, climb=1.2), (True, False)),  # who derails has not settled, however small y
    ],
)
def test_claim_6(off: measures.Measures, on: measures.Measures, parts: tuple[bool, bool]) -> None:
    assert tuple(holds(measures.claim_6(off, on)).values()) == parts


def test_claims_7_and_8_compare_off_with_on() -> None:
    off, on = [measures.curve(run(**BAD))], [measures.curve(run(**GOOD))]
    for claim in (measures.claim_7, measures.claim_8):
        margins = claim(off, on)
        assert all(holds(margins).values())
        assert not any(holds(claim(on, off)).values())
        assert claim(on, off) == pytest.approx({part: -margin for part, margin in margins.items()})
        assert not any(holds(claim(off, off)).values())  # equal is not better
    assert measures.claim_7(off, on) == pytest.approx(
        {"max y": np.log10(4), "max psi": np.log10(50), "swing in the curve": np.log10(4)}, rel=1e-3
    )
    assert measures.claim_8(off, on) == pytest.approx({"Y": np.log10(4), "Y/Q": np.log10(1.1 / 0.4)}, rel=1e-3)


def test_verdicts_are_medians_over_the_starts() -> None:
    bad, good = measures.curve(run(**BAD)), measures.curve(run(**GOOD))
    assert all(holds(measures.claim_7([bad, good, bad], [good, bad, good])).values())
    assert not any(holds(measures.claim_7([good, good, bad], [good, bad, bad])).values())


def test_both_derailed_before_the_curve_is_no_better_steady_state() -> None:
    both = [measures.curve(derails(25.0, **BAD))]
    assert measures.claim_7(both, both)["swing in the curve"] == 0.0
    assert not holds(measures.claim_7(both, both))["swing in the curve"]


def test_claim_9_asks_every_start_to_derail_and_the_earlier_the_clearer() -> None:
    passed, late, early = (measures.curve(t) for t in (run(**BAD), derails(200.0, **BAD), derails(40.0, **BAD)))
    assert holds(measures.claim_9([late, early]))["derails"]
    assert not holds(measures.claim_9([late, passed]))["derails"]
    margins = [measures.claim_9([found])["derails"] for found in (passed, late, early)]
    assert margins == sorted(margins)


@pytest.mark.parametrize(
    ("trajectory", "parts"),
    [
        (run(8e-3, 1e-3, rest=2e-4), (True, True, True)),
        (run(8e-3, 3e-3, rest=2e-4), (True, False, True)),
        (run(8e-3, 0.3e-3, rest=2e-4), (True, False, True)),
        (run(8e-3, 1e-3, rest=2e-3), (True, True, False)),
        (derails(250.0, y=8e-3, psi=1e-3, rest=2e-4), (False, True, False)),
        (derails(50.0, y=8e-3, psi=1e-3), (False, False, False)),
    ],
)
def test_claim_10(trajectory: Trajectory, parts: tuple[bool, ...]) -> None:
    assert tuple(holds(measures.claim_10([measures.curve(trajectory)])).values()) == parts


def test_claim_10_fails_where_one_start_derails() -> None:
    on = [measures.curve(t) for t in (run(8e-3, 1e-3), run(8e-3, 1e-3), derails(250.0, y=8e-3, psi=1e-3))]
    assert tuple(holds(measures.claim_10(on)).values()) == (False, True, True)


def test_decades_of_sizes() -> None:
    assert decades(100.0, 1.0) == 2.0
    assert decades(0.0, 0.0) == decades(np.inf, np.inf) == 0.0
    assert decades(1.0, np.inf) == decades(0.0, 1.0) == -np.inf


def test_the_ledger_puts_each_run_in_its_place() -> None:
    """Set B is the paper's vehicle, set A does all it should not: the parts of the claims tell them apart."""
    cases = {}
    for name in SETS:
        for speed in (STRAIGHT, SLOW, FAST):
            for gyro in SPINS:
                damped = (gyro == "on") == (name == "B")
                tr = run(8e-3, rest=2e-7 if damped else 8e-3) if speed == STRAIGHT else run(**(GOOD if damped else BAD))
                if speed == FAST and not damped:
                    tr = derails(70.0, **BAD)
                (assessment,) = assess(tr)
                for start in range(1 if speed == STRAIGHT else 3):
                    cases[name, speed, gyro, start] = Case((name, speed, gyro, start), tr, assessment)
    claims = [vehicle.claim_6(cases), *vehicle.claims_7_and_8(cases), *vehicle.claims_9_and_10(cases)]
    assert [claim.id for claim in claims] == ["C6", "C7", "C8", "C9", "C10"]
    for claim in claims:
        assert {part: came_out for part, came_out in claim.parts.items() if part.startswith("B: ")} != {}
        assert all(came_out == part.startswith("B: ") for part, came_out in claim.parts.items()), claim
        assert claim.verdict.startswith("partly")
    assert "B: derails in 3 of 3 runs" in claims[3].measured
    assert "Y 40.0 -> 10.0 kN, Y/Q (EN 14363) 1.10 -> 0.40" in claims[2].measured


def observed(*, moving: int = 2, growth: float = -0.01, decay: float = 0.2, late: float = 0.0, faster: float = 1.0) -> Observed:
    """Six roots of which `moving` move, with the largest real part `growth`; runs that decay at `decay` (1/s), the gimbal's
    later by `late` (s) and `faster` times as fast; the run without spin only oscillates."""
    ways = np.linspace(0.0, 1.0, 5)[:, None] * (np.arange(6) < moving)
    over = -5.0 - np.arange(6) - ways + 0j
    over[:, 0] += growth - over.real.max()
    over[:, 0] = growth + 1j * (2.0 - ways[:, 0])
    t = np.arange(0.0, 60.0, 2e-3)

    def motion(decay: float) -> Trajectory:
        own = -decay * faster * np.maximum(t - late, 0.0)
        columns = [np.exp(rate) * np.cos(3 * t) for rate in (-decay * t, -decay * t, own)]
        return Trajectory(t, (Y, PSI, ETA), ("m", "rad", "rad"), np.column_stack(columns))

    return Observed(ways[:, 0], over, ways[:, 0], over, 0.0, motion(0.0), dict.fromkeys(TURNING, motion(decay)))


def test_claims_of_the_wheel_pair() -> None:
    assert all(holds(pair_measures.claim_1(observed(moving=2))).values())
    assert holds(pair_measures.claim_1(observed(moving=3))) == {"four stay": False, "none crosses the imaginary axis": True}
    assert not holds(pair_measures.claim_1(observed(growth=0.01)))["none crosses the imaginary axis"]
    assert all(holds(pair_measures.claim_2(observed(moving=4))).values())
    assert not holds(pair_measures.claim_2(observed(moving=5)))["two stay"]
    assert not holds(pair_measures.claim_2(observed(moving=3)))["two stay"]
    assert not holds(pair_measures.claim_2(observed(moving=4, growth=0.01)))["none crosses the imaginary axis"]


def test_claim_3_wants_neither_growth_nor_decay() -> None:
    seen = observed()
    assert all(holds(pair_measures.claim_3(seen)).values())
    for decay in (1e-3, -1e-3):
        other = observed(decay=decay)
        moved = replace(seen, undamped=1e-3, still=other.turning[100])
        assert not any(holds(pair_measures.claim_3(moved)).values())


def test_claim_4_wants_rest_and_the_gimbal_last() -> None:
    assert all(holds(pair_measures.claim_4(observed(late=2.0))).values())
    slow = holds(pair_measures.claim_4(observed(decay=0.01, late=2.0)))
    assert slow.pop("the gimbal not before yaw")  # both are still moving at the end: not before
    # All pass zero just before the end; that is no rest.
    assert not any(slow.values())
    assert not holds(pair_measures.claim_4(observed(faster=2.0)))["the gimbal not before yaw"]
