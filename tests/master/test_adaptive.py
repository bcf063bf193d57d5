"""Adaptive macro steps: what their controller does, what their tolerance holds, and what the error over the whole run is."""

from collections.abc import Callable
from dataclasses import replace
from typing import Any

import numpy as np
import oscillators
import pytest

from gyro_cosim import GaussSeidel, Iterated, Jacobi, Options, System, certify, open_network
from gyro_cosim.accuracy import GlobalError, Monolith, global_error
from gyro_cosim.cli.info import system_document
from gyro_cosim.coupling import Algorithm
from gyro_cosim.errors import ConvergenceError
from gyro_cosim.master import Run, run
from gyro_cosim.master.adaptive import Adaptive, Controller
from gyro_cosim.master.step_control import LEAST, MOST, SAFETY, StepControl
from gyro_cosim.network.redundancy import redundant_states

STOP = 2.0


def adapted(
    plan: System, algorithm: Algorithm, how: Adaptive, stop: float = STOP, *, after: Callable[..., Any] = global_error
) -> tuple[Run, Any, np.ndarray]:
    """A run, what `after` says of it, and the true errors of its outputs as shares of their sizes."""
    with open_network(plan, in_process=True) as network:
        done = run(network, algorithm, 1e-3, stop, options=Options(adaptive=how))
        told = after(network, done, stop)
    exact = Monolith(plan).solve(done.trajectory.t).values
    return done, told, np.abs(done.trajectory.values - exact).max(axis=0) / np.abs(exact).max(axis=0)


# ---- the controller ---------------------------------------------------------------------------------------------------


def test_the_controller_looks_at_the_trend_and_keeps_its_bounds() -> None:
    control = StepControl(order=1)
    factor, after = control.accepted(0.25)
    assert factor == pytest.approx(SAFETY * 0.25 ** (-1 / 2))  # no trend yet: the elementary controller
    growing, _ = after.accepted(0.5)
    steady, _ = after.accepted(0.25)
    assert growing == pytest.approx(SAFETY * 0.5 ** (-0.7 / 2) * 0.25 ** (0.4 / 2))
    assert growing < steady
    assert after.accepted(0.0)[0] == MOST
    shorter, refused = after.rejected(4.0)
    assert shorter == pytest.approx(SAFETY * 4.0 ** (-1 / 2))
    assert refused.accepted(0.01)[0] == 1.0  # it does not grow just after it was taken back
    assert after.rejected(float("nan"))[0] == after.rejected(1e9)[0] == LEAST


@pytest.mark.parametrize("algorithm", [Jacobi(1), Iterated(1)], ids=lambda a: a.name)
def test_fewer_steps_are_taken_back_and_the_work_for_an_accuracy_is_less(algorithm: Algorithm) -> None:
    """Against the elementary controller. Work: three steps for two; the error falls with the square of the steps."""
    plan, cost, rejections = oscillators.pair(cubic=30.0), [], []
    for how in (Adaptive(1e-4, integral=1.0, proportional=0.0), Adaptive(1e-4)):
        done, _, true = adapted(plan, algorithm, how)
        rejections.append(done.rejections)
        cost.append(3 * (done.steps / 2 + done.rejections) * np.sqrt(true.max()))
    assert rejections[0] >= 8
    assert rejections[1] <= rejections[0] / 2
    assert cost[1] < 1.02 * cost[0]


def test_it_gives_up_after_many_rejections(monkeypatch: pytest.MonkeyPatch) -> None:
    """Where the estimate does not fall with the step, as at a jump."""
    estimate = Controller._doubled
    monkeypatch.setattr(Controller, "_doubled", lambda self, *arguments: (estimate(self, *arguments)[0], 2.0))
    with pytest.raises(ConvergenceError, match="shortened 20 times, estimate"):
        adapted(oscillators.pair(), Jacobi(1), Adaptive(1e-3))


def test_no_step_is_shorter_than_rounding() -> None:
    with (
        pytest.raises(ConvergenceError, match="before its smallest size of"),
        open_network(oscillators.pair(), in_process=True) as n,
    ):
        run(n, Jacobi(1), 1e-3, 101.0, start=100.0, options=Options(adaptive=Adaptive(1e-30, smallest=1e-100)))


# ---- what the tolerance holds, and the error over the whole run ----------------------------------------------------------


@pytest.mark.parametrize("algorithm", [Jacobi(1), Jacobi(2), GaussSeidel(1), Iterated(1)], ids=lambda a: f"{a.name}-{a.degree}")
def test_the_error_over_the_whole_run_is_estimated(algorithm: Algorithm) -> None:
    """Within a factor of 3 of the true one for every output, while the tolerance itself is no such bound."""
    for tolerance in (1e-2, 1e-3):
        _, told, true = adapted(oscillators.pair(), algorithm, Adaptive(tolerance))
        estimated = np.array([e.largest / e.size for e in told.errors])
        assert (estimated < 3 * true).all(), tolerance
        assert (estimated > true / 3).all(), tolerance
        assert true.max() > 2 * tolerance


def test_an_estimate_needs_every_point() -> None:
    def thinned(network: Any, done: Run, stop: float) -> GlobalError:
        return global_error(network, replace(done, steps=done.steps + 1), stop)

    _, told, _ = adapted(oscillators.pair(), Jacobi(1), Adaptive(1e-2), after=thinned)
    assert told.worst is None
    assert "every communication point" in told.how


def test_a_run_with_adaptive_steps_is_certified() -> None:
    done, certificate, true = adapted(oscillators.pair(), Jacobi(1), Adaptive(1e-4), after=certify)
    assert certificate.observed_order == pytest.approx(2.0, abs=0.15)
    estimated = np.array([e.largest / e.size for e in certificate.errors])
    assert estimated == pytest.approx(true, rel=0.1)
    assert certificate.stability is not None
    assert certificate.stability.is_stable()
    assert certificate.stability.largest_step > np.diff(done.trajectory.t).max()


def test_given_points_are_kept_and_checked() -> None:
    points = np.array([0.0, 0.1, 0.15, 0.3])
    with open_network(oscillators.pair(), in_process=True) as network:
        done = run(network, Jacobi(1), 0.1, 0.3, options=Options(points=points))
        assert np.array_equal(done.trajectory.t, points)
        for wrong in (points[:-1], points[1:], points[[0, 2, 1, 3]], points[:1]):
            with pytest.raises(ValueError, match=r"`points` must rise from the start 0 s to the stop time 0\.3 s"):
                run(network, Jacobi(1), 0.1, 0.3, options=Options(points=wrong))
    with pytest.raises(ValueError, match="cannot be combined with `adaptive`"):
        Options(points=points, adaptive=Adaptive())


# ---- states that are held twice ---------------------------------------------------------------------------------------


def test_a_rate_integrated_on_both_sides_is_told() -> None:
    """Kyllingstad's case: each step holds 1e-3, the run ends two orders away from that, and both are said."""
    plan = oscillators.held_twice()
    done, told, true = adapted(plan, Jacobi(1), Adaptive(1e-3), 20.0)
    assert done.adaptive is not None
    assert "so it is no bound on that of the result" in done.adaptive.meaning
    assert true.max() > 0.01
    worst = told.worst
    assert worst is not None
    assert true.max() / 3 < worst.largest / worst.size < 3 * true.max()
    with open_network(plan, in_process=True) as network:
        (twice,) = system_document(network)["redundant_states"]
    assert twice.startswith("spring and mass both integrate mass.velocity: ")


def test_states_held_once_are_not_told() -> None:
    with open_network(oscillators.pair(), in_process=True) as network:
        network.initialize(0.0, 1.0)
        assert redundant_states(network) == ()


# ---- an FMU's own steps -----------------------------------------------------------------------------------------------


def restricted(**how: Any) -> Callable[..., Run]:
    """A run of the pair whose right component says this of its steps."""

    def done(tolerance: float, estimate: Any = "doubling") -> Run:
        with open_network(oscillators.pair(), in_process=True) as network:
            slave = network.slaves[1]
            slave.description = replace(slave.description, **how)
            return run(network, Jacobi(1), 0.1, 1.013, options=Options(adaptive=Adaptive(tolerance, estimate)))

    return done


@pytest.mark.parametrize("estimate", ["doubling", "energy"])
def test_macro_steps_are_whole_numbers_of_a_fixed_step_inside(estimate: str) -> None:
    steps = np.diff(restricted(fixed_step=0.01)(3e-2, estimate).trajectory.t) / 0.01
    last = 2 if estimate == "doubling" else 1
    assert steps[:-last] == pytest.approx(np.round(steps[:-last]), abs=1e-6)
    assert len(set(np.round(steps[:-last]))) > 1
    with pytest.raises(ConvergenceError, match=r"before the fixed internal step of 'right', 0\.01 s, forbids it, estimate"):
        restricted(fixed_step=0.01)(1e-7, estimate)


def test_a_component_with_steps_of_one_length_is_refused() -> None:
    with pytest.raises(ValueError, match="'right' says canHandleVariableCommunicationStepSize = false"):
        restricted(variable_steps=False)(1e-3)


# ---- the command line -------------------------------------------------------------------------------------------------


def test_the_command_line_says_what_the_tolerance_holds(cosim: Callable[..., Any], cosim_json: Callable[..., Any]) -> None:
    case = ("run", "wheel-pair", "--stop", "0.5", "--in-process", "--adaptive", "1e-3")
    told = cosim_json(*case)["adaptive"]
    assert told["meaning"].startswith("tolerance 0.001: of each macro step, its own estimated error")
    assert 0.0 < told["shortest_step"] < told["longest_step"]
    assert told["global_error"]["errors"]["vehicle.yaw_rate"]["largest"] > 0.0
    _, out, _ = cosim(*case)
    assert "estimated error over the whole run: at most" in out
    assert cosim_json(*case, "--certify")["certificate"]["observed_order"] == pytest.approx(2.0, abs=0.3)
