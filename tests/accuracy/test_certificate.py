"""The certificate: its error estimate against true errors, its stability margin against runs, on FMUs and in process."""

import re
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import lorenz
import numpy as np
import oscillators
import pytest

from gyro_cosim import GaussSeidel, Iterated, Jacobi, SlaveError, System, system
from gyro_cosim.accuracy import certificate as certificate_module
from gyro_cosim.accuracy.certificate import Certificate, OutputError, Stability, certify, margin, spectral_radius
from gyro_cosim.accuracy.monolith import Monolith
from gyro_cosim.coupling import Algorithm, Nepce
from gyro_cosim.master import open_network, run
from gyro_cosim.network.linearised import linearise_network
from gyro_cosim.systems import StopWhen

PAIR = system("wheel-pair")
CASES = {
    "wheel pair": (PAIR, 8e-3, 2.0),
    "wheel pair, nonlinear gyro": (PAIR.with_source("gyro", "nonlinear"), 8e-3, 2.0),
    "two masses": (oscillators.pair(), 8e-3, 2.0),
    "two masses, nonlinear": (oscillators.pair(cubic=20.0), 8e-3, 2.0),
}


@pytest.mark.parametrize(
    "algorithm", [Jacobi(0), Jacobi(1), Jacobi(2), GaussSeidel(1), Iterated(1)], ids=lambda a: f"{a.name}-{a.degree}"
)
@pytest.mark.parametrize("name", CASES)
def test_estimated_errors_are_the_true_ones_within_a_factor_of_two(name: str, algorithm: Algorithm) -> None:
    plan, step, stop = CASES[name]
    with open_network(plan, in_process=True) as network:
        result = run(network, algorithm, step, stop)
        certificate = certify(network, result, stop)
    exact = Monolith(plan).solve(result.trajectory.t).values
    for k, error in enumerate(certificate.errors):
        true = float(np.abs(result.trajectory.values[:, k] - exact[:, k]).max())
        if true > 1e-9 * error.size:
            assert 0.5 < error.largest / true < 2.0, error
    assert certificate.observed_order == pytest.approx(algorithm.order, abs=0.3)
    assert certificate.no_estimate == ""
    assert certificate.worst is not None
    worst = max(e.largest / e.size for e in certificate.errors if e.size)
    assert certificate.worst.largest / certificate.worst.size == worst


@pytest.mark.parametrize("algorithm", [Jacobi(0), Jacobi(1), GaussSeidel(0), GaussSeidel(2), Nepce(0)], ids=repr)
def test_largest_stable_step_is_where_runs_begin_to_grow(algorithm: Algorithm) -> None:
    """A damped oscillator pair must die out: it does just below the margin's step and grows just above."""
    plan = oscillators.pair()
    with open_network(plan, in_process=True) as network:
        run(network, algorithm, 1e-3, 0.1)
        found = margin(network, algorithm, 1e-3)
        assert found is not None
        assert found.is_stable()
        limit = found.largest_step
        assert np.isfinite(limit)

        def grows(h: float) -> bool:
            size = np.abs(run(network, algorithm, h, 400 * h).trajectory.values).max(axis=1)
            return bool(size[-40:].max() > size[160:200].max())

        assert not grows(0.97 * limit)
        assert grows(1.03 * limit)


def test_radius_of_a_fine_step_is_that_of_the_solution() -> None:
    """As h -> 0 the map of a macro step tends to the exact one: radius e^(growth h), of the least damped root."""
    with open_network(PAIR, in_process=True) as network:
        network.initialize(0.0, 1.0)
        found = margin(network, Jacobi(1), 1e-3)
    assert found is not None
    assert found.radius == pytest.approx(found.exact, abs=1e-8)
    assert np.log(found.exact) / 1e-3 == pytest.approx(-0.10036595, rel=1e-5)  # the slow yaw root at 100 rpm


def test_fmus_give_the_same_linearisation_as_their_components() -> None:
    plan = PAIR.with_source("gyro", "nonlinear").with_value("gyro.gimbal_angle", 0.4)
    found = []
    for in_process in (True, False):
        with open_network(plan, in_process=in_process) as network:
            run(network, Jacobi(1), 1e-3, 0.5)
            linear = linearise_network(network)
            assert linear is not None
            found.append((linear.joined(), spectral_radius(linear, Jacobi(2), 0.01)))
    np.testing.assert_allclose(found[0][0], found[1][0], rtol=1e-11, atol=1e-12)
    assert found[0][1] == pytest.approx(found[1][1], rel=1e-12)


def test_joined_linearisations_are_the_monoliths_jacobian() -> None:
    plan = oscillators.pair(cubic=20.0)
    with open_network(plan, in_process=True) as network:
        network.initialize(0.0, 1.0)
        linear = linearise_network(network)
    assert linear is not None
    joined = Monolith(plan)
    np.testing.assert_allclose(linear.joined(), joined.matrix(x=joined.x0), rtol=1e-12)


def test_a_component_without_derivatives_has_no_margin_but_a_certificate() -> None:
    from gyro_cosim import SystemComponent

    plan = System("s", (SystemComponent("count", f"{oscillators.HERE}:counter"),), ())
    with open_network(plan, in_process=True) as network:
        result = run(network, Jacobi(1), 1e-2, 0.1)
        assert certify(network, result, 0.1).stability is None


@pytest.mark.parametrize(("stop", "reason"), [
    (20.0, r"the results do not converge: halving the macro step changes an output by 1\.\d+ of its size, halving it again by 1"),
    (15.0, r"the macro step is too coarse: the observed order \d\.\d\d is not the algorithm's 2, and half the step still"),
])  # fmt: skip
def test_a_chaotic_run_has_no_estimate(stop: float, reason: str) -> None:
    """Lorenz's equations forget after some 10 s what the coupling has done to them: a true error is as large as the signal."""
    with open_network(lorenz.lorenz(), in_process=True) as network:
        certificate = certify(network, run(network, Jacobi(1), 1e-2, stop), stop)
        early = certify(network, run(network, Jacobi(1), 1e-2, 0.5), 0.5)
    assert re.match(reason, certificate.no_estimate)
    assert certificate.worst is None
    assert all(np.isnan(e.largest) and np.isnan(e.end) and e.size > 10.0 for e in certificate.errors)
    assert certificate.stability is not None
    assert early.no_estimate == ""  # before that there is one
    assert early.observed_order == pytest.approx(2.0, abs=0.1)


def test_a_shorter_step_that_ends_early_leaves_no_estimate() -> None:
    """A stop condition that the run in question has just not met."""
    plan = oscillators.pair()
    with open_network(plan, in_process=True) as network:
        highest = [run(network, Jacobi(1), h, 1.0).trajectory["left.velocity"].max() for h in (8e-3, 4e-3)]
    assert highest[0] < highest[1]
    condition = StopWhen(("left", "velocity"), sum(highest) / 2, "too fast")
    with open_network(replace(plan, stop_when=(condition,)), in_process=True) as network:
        certificate = certify(network, run(network, Jacobi(1), 8e-3, 1.0), 1.0)
    assert certificate.no_estimate.startswith("with a macro step of 0.004 s the run ends before its time: too fast at t = ")
    assert np.isnan(certificate.observed_order)
    assert certificate.worst is None


def test_differences_at_rounding_need_not_shrink() -> None:
    """Without a coupling the runs differ by rounding only: the estimate is that, and no order is observed."""
    whole = oscillators.pair()
    plan = replace(whole, components=whole.components[:1], connections=(), bonds=())
    with open_network(plan, in_process=True) as network:
        certificate = certify(network, run(network, Jacobi(1), 8e-3, 2.0), 2.0)
    assert certificate.no_estimate == ""
    assert np.isnan(certificate.observed_order)
    assert all(e.largest < 1e-9 * e.size for e in certificate.errors)
    for scale, seen in ((1e-12, False), (1e-6, True)):  # shares that grow: at rounding they say nothing
        assert np.isfinite(certificate_module._observed_order([3 * scale, 4 * scale])) == seen


def test_the_command_line_says_that_there_is_no_estimate(
    monkeypatch: pytest.MonkeyPatch, cosim: Callable[..., Any], cosim_json: Callable[..., Any]
) -> None:
    nan, command = float("nan"), ("run", "wheel-pair", "--in-process", "--stop", "0.1", "--certify")
    error = OutputError("vehicle.yaw_angle", "rad", nan, nan, 0.3)
    chaos = Certificate((error,), -4.8, Stability(0.9, 0.9, 1.0), "the results do not converge: and so on")
    monkeypatch.setattr(certificate_module, "certify", lambda *_, **__: chaos)
    told = cosim_json(*command)["certificate"]
    assert told["no_estimate"] == "the results do not converge: and so on"
    assert told["errors"] == {"vehicle.yaw_angle": {"largest": None, "end": None, "size": 0.3, "unit": "rad"}}
    assert told["observed_order"] == -4.8
    _, out, _ = cosim(*command)
    assert "no estimate of the coupling error: the results do not converge: and so on\n" in out
    assert "estimated coupling error" not in out
    assert "observed order" not in out
    assert "coupling stable: spectral radius 0.9 a step" in out


@pytest.mark.slow  # it runs the vehicle 84 000 steps
def test_a_vehicle_that_hunts_has_no_estimate(cosim_json: Callable[..., Any]) -> None:
    told = cosim_json("run", "lrt-curve", "--set", "vehicle.speed=8", "--gyro", "off", "--stop", "12", "--certify")
    assert told["certificate"]["no_estimate"].startswith("the results do not converge")
    assert {e["largest"] for e in told["certificate"]["errors"].values()} == {None}


def test_a_run_that_cannot_be_certified_is_kept(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path, cosim: Callable[..., Any]
) -> None:
    """An FMU with a fixed step of its own refuses the shorter steps of the estimate."""

    def refused(*_: Any, **__: Any) -> None:
        raise SlaveError("gyro", 0.0, 5e-4, "its own step is fixed to 0.001 s")

    monkeypatch.setattr(certificate_module, "certify", refused)
    code, out, err = cosim("run", "wheel-pair", "--in-process", "--stop", "0.1", "--certify", "--output", "kept.csv")
    assert (code, err.count("\n")) == (1, 1)
    assert "no certificate: over shorter steps component 'gyro' failed" in err
    assert "100 macro steps of 1 ms to t = 0.1 s" in out
    assert len((tmp_path / "kept.csv").read_text().splitlines()) == 102
