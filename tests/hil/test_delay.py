"""How much delay a unit stands: two ways that agree, and what compensation gains."""

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from frames import sine

from gyro_cosim import Jacobi, simulate, system
from gyro_cosim.cli.delay import remedy
from gyro_cosim.comparison.verdict import five_percent
from gyro_cosim.hil.compensation import COMPENSATORS, Filter, Impulse, PassivityController, Polynomial, Uncompensated, delay_taps
from gyro_cosim.hil.delay_margin import (
    DelayStudy,
    by_eigenvalues,
    by_runs,
    delay_map,
    delayed_network,
    verdict_by_model,
    verdict_by_runs,
)
from gyro_cosim.hil.delayed_slave import DelayedSlave
from gyro_cosim.hil.sampled_model import linearise
from gyro_cosim.master import run
from gyro_cosim.slaves import linearisation, open_slave, serializable

PLAN = system("wheel-pair").with_value("gyro.rotor_speed", "200rpm").with_value("vehicle.yaw_angle", 0.05)
NONLINEAR = PLAN.with_source("gyro", "nonlinear")
SETTING = DelayStudy(PLAN, step=0.04, stop=20.0, longest=0.3)
LIMITS = five_percent(PLAN, "gyro")


@pytest.mark.parametrize("degree", [0, 1, 2])
@pytest.mark.parametrize("delay", [0.0, 0.02, 0.033])
def test_the_sampled_linear_model_is_the_run(degree: int, delay: float) -> None:
    """To the components' own integration error; from degree 1 on the cold start, which the model has not, shows at 20 ms."""
    setting = replace(SETTING, step=0.02, algorithm=Jacobi(degree), stop=4.0)
    with delayed_network(setting, delay) as network:
        values = run(network, setting.algorithm, setting.step, setting.stop).trajectory.values
    model = linearise(PLAN, "gyro").run(Uncompensated().taps(delay / setting.step), degree, setting.step, 200)
    moving = ("yaw_angle", "yaw_rate", "yaw_moment")
    rows = [i for i, n in enumerate(linearise(PLAN, "gyro").names) if n.rpartition(".")[2] in moving]
    size = np.abs(values[:, rows]).max(axis=0)
    assert (np.abs(model - values)[:, rows].max(axis=0) < (1e-7 if degree == 0 else 2e-2) * size).all()


@pytest.mark.parametrize("name", ["none", *(pytest.param(n, marks=pytest.mark.slow) for n in COMPENSATORS if n != "none")])
def test_eigenvalues_and_runs_agree_on_the_largest_stable_delay(name: str) -> None:
    setting = replace(SETTING, remedy=remedy(name))
    a, b = by_eigenvalues(setting), by_runs(setting)
    assert a.delay is not None
    assert b.delay is not None
    assert a.delay == pytest.approx(b.delay, rel=0.04)  # the resolution of both, and 20 s to see growth in


def test_course_and_runs_agree_on_the_largest_delay_within_tolerances() -> None:
    a, b = verdict_by_model(SETTING, LIMITS), verdict_by_runs(SETTING, LIMITS)
    assert a.delay is not None
    assert b.delay is not None
    assert 0.0 < a.delay < 0.05
    assert a.delay == pytest.approx(b.delay, rel=0.04)


@pytest.mark.parametrize(
    ("name", "stable", "kept"),
    [
        pytest.param("linear", 1.3, 2.5, marks=pytest.mark.slow),
        pytest.param("quadratic", 1.3, 2.5, marks=pytest.mark.slow),
        pytest.param("nepce", 1.3, 1.3, marks=pytest.mark.slow),
        ("model:linear", 4.0, 4.0),
        pytest.param("passivity", 4.0, 0.8, marks=pytest.mark.slow),
    ],
)
def test_compensation_enlarges_the_admissible_delay(name: str, stable: float, kept: float) -> None:
    """By these factors at least, on the nonlinear unit. Passivity buys stability, at a price in fidelity."""
    plain = replace(SETTING, system=NONLINEAR, step=0.02, stop=12.0, resolution=0.05)
    mended = replace(plain, remedy=remedy(name))
    for margin, factor in ((by_runs, stable), (lambda s: verdict_by_runs(s, LIMITS), kept)):
        before, after = margin(plain).delay, margin(mended).delay
        assert before is not None
        assert after is not None
        assert after > factor * before


def test_the_margin_falls_with_the_spin() -> None:
    found = delay_map(SETTING, "gyro.rotor_speed", np.array([20.0, 30.0, 40.0]), np.array([0.02, 0.01]), "rad/s")
    assert (np.diff(found.delay, axis=1) < 0).all()
    assert np.abs(found.delay[0] / found.delay[1] - 1).max() < 0.2  # the macro step itself costs little here


def test_an_interface_without_delay_changes_nothing() -> None:
    plain = simulate(NONLINEAR, algorithm=Jacobi(1), step=0.01, stop=2.0, in_process=True).trajectory
    with delayed_network(replace(SETTING, system=NONLINEAR, step=0.01), 0.0) as network:
        np.testing.assert_array_equal(run(network, Jacobi(1), 0.01, 2.0).trajectory.values, plain.values)


def test_fmus_stand_behind_an_interface_too() -> None:
    setting = replace(SETTING, step=0.02, stop=1.0)
    results = []
    for here in (True, False):
        with delayed_network(replace(setting, in_process=here), 0.05) as network:
            results.append(run(network, Jacobi(1), 0.02, 1.0).trajectory.values)
    np.testing.assert_allclose(*results, rtol=1e-10, atol=1e-12)


# ---- filters ----------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("d", [0.0, 1.0, 2.25, 7.9])
def test_a_delay_is_one_whole_and_fractional(d: float) -> None:
    """A line goes through unchanged but for the delay."""
    f = Filter(Uncompensated().taps(d), np.zeros(1))
    rows = []
    for n in range(30):
        rows.append(f.value(np.array([float(n)]))[0])
        f.push(np.array([float(n)]))
    np.testing.assert_allclose(rows[10:], np.arange(10, 30) - d, atol=1e-12)


@pytest.mark.parametrize(("compensator", "degree"), [(Polynomial(1), 1), (Polynomial(2), 2), (Polynomial(2, 1.5), 2)])
def test_predictors_are_exact_for_their_polynomials(compensator: Polynomial, degree: int) -> None:
    for d in (1.0, 4.0, 3.0):
        f = Filter(compensator.taps(d), np.zeros(1))
        for n in range(60):
            wanted = 1.0 + 0.3 * n + (0.01 * n**2 if degree == 2 else 0.0)
            got = f.value(np.array([wanted]))[0]
            f.push(np.array([wanted]))
        assert got == pytest.approx(wanted, rel=1e-9)


def test_the_impulse_arrives_in_the_end() -> None:
    """A ramp that stops: what arrives comes to rest at it, and its sum lacks less than the delay's, by 1 + g."""
    v = np.concatenate([np.arange(20.0), np.full(400, 20.0)])

    def missing(taps: Any) -> float:
        f, w = Filter(taps, np.zeros(1)), []
        for value in v:
            w.append(f.value(np.array([value]))[0])
            f.push(np.array([value]))
        assert w[-1] == pytest.approx(20.0, rel=1e-6)
        return float((v - w).sum())

    plain, mended = missing(Uncompensated().taps(8.0)), missing(Impulse(0.5).taps(8.0))
    assert plain == pytest.approx(160.0)
    assert mended == pytest.approx(160.0 / 1.5, rel=1e-6)


def test_the_passivity_controller_takes_back_what_was_made() -> None:
    """An effort that always pushes: it is turned until the balance is level again, within its bound."""
    controller, h, total = PassivityController(), 0.01, 0.0
    for n in range(200):
        u = np.array([np.sin(0.1 * n)])
        w, controller = controller.corrected(u, 0.5 * u, h)
        total -= h * float(w @ u)
    assert total == pytest.approx(0.0, abs=0.5 * h)
    assert controller.absorbed == pytest.approx(total)


def test_an_interface_repeats_its_step_after_a_restore() -> None:
    unit = DelayedSlave(open_slave("gyro", "gyro_unit:nonlinear", in_process=True), [(0, 0)], step=0.01, delay=0.033,
                     compensator=Polynomial(1), passive=True)  # fmt: skip
    rate = sine(0.5, 6.0)
    unit.initialize({}, 0.0, 1.0)

    def go(first: int, last: int) -> np.ndarray:
        for k in range(first, last):
            U = np.zeros((3, 3))
            U[:, 0] = rate(0.01 * k)
            unit.output(U[0], 0.01 * k)
            unit.step(U, 0.01 * k, 0.01)
        return unit.output(U[0], 0.01 * last)

    go(0, 20)
    snapshot = unit.save()
    first = go(20, 40)
    unit.restore(snapshot)
    np.testing.assert_array_equal(go(20, 40), first)
    assert linearisation(unit) is None
    assert serializable(unit) is None


# ---- the command and wrong use ----------------------------------------------------------------------------------------

DELAY = ("delay", "wheel-pair", "--set", "gyro.rotor_speed=300rpm", "--step", "20ms", "--stop", "4")


def test_the_command_tells_and_draws(cosim: Callable[..., Any], cosim_json: Callable[..., Any]) -> None:
    code, out, err = cosim(
        *DELAY, "--compensate", "none,linear+passivity", "--map", "gyro.rotor_speed=200rpm:600rpm:3", "--plot", "m.png"
    )
    assert (code, err) == (0, "")
    for words in ("stable, eigenvalues", "none", "linear+passivity", "wrote m.png"):
        assert words in out
    assert Path("m.png").stat().st_size > 5000
    document = cosim_json(*DELAY)
    (margin,) = document["margins"]
    assert margin["stable"]["model_s"] == pytest.approx(margin["stable"]["runs_s"], rel=0.2)  # 4 s are short


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (("--compensate", "magic"), "compensation must be one of none, linear, quadratic, nepce"),
        (("--compensate", "model:lineal"), "did you mean 'linear'?"),
        (("--longest", "1ms"), "the longest delay must be at least the macro step of 0.02 s, got 0.001 s"),
        (("--map", "gyro.rotor_speed=1:2:3"), "--map and --plot go together"),
        (("--map", "gyro.rotor_speed=1:2", "--plot", "m.png"), "--map must be COMPONENT.PARAMETER=LOW:HIGH:N"),
        (("--map", "gyro.rotor_sped=1:2:3", "--plot", "m.png"), "did you mean 'rotor_speed'?"),
        (("--gyro", "hil"), "component 'gyro' must have no sampled part, gyro_unit:hil has one"),
        (("--component", "vehicle"), "system 'wheel-pair' must have power bonds with 'vehicle'"),
    ],
)
def test_wrong_use_is_one_line(arguments: tuple[str, ...], words: str, cosim: Callable[..., Any]) -> None:
    code, out, err = cosim(*DELAY, *arguments)
    assert (code, out, err.count("\n")) == (2, "", 1)
    assert words in err


@pytest.mark.parametrize(
    ("make", "words"),
    [
        (lambda: delay_taps(-0.5), "a delay must not be negative, got -0.5"),
        (lambda: delay_taps(np.nan), "a delay must not be negative, got nan"),
        (lambda: Polynomial(3), "degree of the predictor must be 1 or 2, got 3"),
        (lambda: Polynomial(1, 0.0), "spacing must be positive"),
        (lambda: Impulse(1.0), "gain must be at least 0 and below 1, got 1"),
        (lambda: by_eigenvalues(replace(SETTING, remedy=remedy("passivity"))), "eigenvalues need the algorithm jacobi"),
    ],
)
def test_numbers_that_mean_nothing_are_refused(make: Callable[[], Any], words: str) -> None:
    with pytest.raises(ValueError, match=words):
        make()
