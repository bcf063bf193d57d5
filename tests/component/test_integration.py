"""The macro step's definition: order and stability of the methods, error control, sample instants."""

import math

import casadi as ca
import numpy as np
import pytest
from fmu_models import autonomous, in_process, plain, random_steps, sampled, stiff
from hypothesis import given
from hypothesis import strategies as st
from scipy.integrate import solve_ivp

from gyro_cosim.component.do_step import macro_step
from gyro_cosim.component.integration import (
    METHODS,
    Progress,
    StepError,
    first_sample,
    input_at,
    pieces,
    step_function,
    substeps,
)

U = np.array([[0.3, 0.5, -0.8]])


def exact(method: str) -> np.ndarray:
    """The pendulum at t = 1 s with the input polynomial U, to 1e-13."""
    c = plain(method=method)
    p = c.start_parameters
    rhs = lambda t, x: np.array(c.rhs(x, input_at(U, t), p)).ravel()  # noqa: E731
    return solve_ivp(rhs, (0, 1), c.start_state, "DOP853", rtol=1e-13, atol=1e-14).y[:, -1]


@pytest.mark.parametrize("method", METHODS)
def test_observed_order_is_the_stated_order(method: str) -> None:
    """A nonlinear oscillator with an input of degree 2; the finest step keeps the error above rounding."""
    c, reference = plain(method=method), exact(method)
    h = 0.1 / 2.0 ** np.arange(4)
    error = [
        np.abs(macro_step(c, c.start_state, U, c.start_parameters, 0.0, 1.0, internal_step=h_i)[0] - reference).max() for h_i in h
    ]
    assert np.polyfit(np.log(h), np.log(error), 1)[0] == pytest.approx(METHODS[method].order, abs=0.2)


@pytest.mark.parametrize("method", ["rosenbrock", "radau"])
def test_stiff_methods_are_stable_far_beyond_the_fast_time_scale(method: str) -> None:
    """Internal step 1e-2 s, fast time constant 1e-5 s: the fast state follows cos(slow), as singular perturbation says."""
    c = stiff(method)
    x, _ = macro_step(c, c.start_state, np.zeros((1, 3)), c.start_parameters, 0.0, 1.0, internal_step=c.internal_step)
    assert x[1] == pytest.approx(math.cos(x[0]), abs=1e-4)
    slow = solve_ivp(lambda t, s: -s * np.cos(s), (0, 1), [1.0], rtol=1e-10, atol=1e-12).y[0, -1]
    assert x[0] == pytest.approx(slow, rel=1e-4)


@pytest.mark.parametrize("method", METHODS)
@pytest.mark.parametrize("tolerance", [1e-4, 1e-7])
def test_error_control_keeps_its_tolerance(method: str, tolerance: float) -> None:
    """It is relative to nominal + size (about 3) and holds for one internal step: 50 times it bounds the tens of them here."""
    c = plain(method=method, internal_step=0.5)
    x, _ = macro_step(c, c.start_state, U, c.start_parameters, 0.0, 1.0, internal_step=0.5, tolerance=tolerance)
    assert np.abs(x - exact(method)).max() < 50 * tolerance


def test_error_control_takes_long_steps_where_it_can() -> None:
    """The step grows to the whole macro step on a slow stretch, and shrinks on a fast one."""
    c = plain(internal_step=1e-4)
    progress = Progress()
    x = np.array([1e-9, 0.0])
    for i in range(8):
        x, progress = macro_step(
            c, x, U * 0, c.start_parameters, i * 0.01, 0.01, internal_step=1e-4, tolerance=1e-4, progress=progress
        )
    assert progress.step >= 0.01
    fast = np.array([9e8, 0.0])
    _, progress = macro_step(c, x, U, fast, 0.08, 0.01, internal_step=1e-4, tolerance=1e-4, progress=progress)
    assert progress.step < 0.001


@pytest.mark.parametrize(
    ("c", "options"),
    [
        (autonomous(), {"internal_step": 1e-2}), (autonomous(), {"internal_step": 1e-2, "tolerance": 1e-9}),
        (autonomous("radau"), {"internal_step": 3.0}),
    ],
    ids=["overflow", "tolerance", "Newton"],
)  # fmt: skip
def test_a_step_that_fails_says_so(c: object, options: dict) -> None:
    """x' = x^2 has no solution beyond t = 1."""
    with pytest.raises(StepError):
        macro_step(c, c.start_state, np.zeros((0, 3)), np.zeros(0), 0.0, 3.0, **options)


@given(h=st.lists(st.floats(1e-3, 0.5), min_size=1, max_size=12), period=st.floats(1e-2, 0.3), start=st.floats(0.0, 2.0))
def test_every_sample_is_taken_once_at_its_instant(h: list[float], period: float, start: float) -> None:
    """Over uneven macro steps: pieces cover each step, samples stand at k * period, none at the end of a step, none is lost."""
    t, k = start, first_sample(period, start)
    first = k
    for length in h:
        end = 0.0
        for offset, piece, due in pieces(t, length, period, k):
            assert offset == end
            assert piece > 0.0
            for _ in range(due):
                assert k * period - t == pytest.approx(offset, abs=2e-9 * period)
                assert offset < length
                k += 1
            end = offset + piece
        assert end == pytest.approx(length, rel=1e-12)
        t += length
        assert k * period >= t - 2e-9 * period
    assert k >= first


def test_sampled_part_sees_the_inputs_of_its_instant() -> None:
    """The controller at 7 ms uses u(7 ms) of the macro step's polynomial, and holds until 14 ms."""
    c = sampled()
    ramp = np.array([[0.0, 100.0, 0.0]])
    x, progress = macro_step(c, c.start_state, ramp, c.start_parameters, 0.0, 0.01, internal_step=1e-3, progress=Progress())
    names = [v.name for v in c.states]
    assert progress.samples == 2
    assert x[names.index("valve")] == pytest.approx(0.8 * 0.7)


def test_splitting_a_macro_step_between_samples_changes_nothing_but_rounding() -> None:
    c = sampled()
    whole = in_process(c, [(0.0, 0.02, np.array([[1.0, 0, 0]]))], internal_step=1e-3)
    halves = in_process(c, [(0.0, 0.01, np.array([[1.0, 0, 0]])), (0.01, 0.01, np.array([[1.0, 0, 0]]))], internal_step=1e-3)
    assert halves[-1] == pytest.approx(whole[-1], rel=1e-9)


@given(st.floats(1e-6, 10.0), st.integers(1, 1000))
def test_whole_multiples_give_whole_numbers_of_substeps(step: float, n: int) -> None:
    """Rounding of n * step never adds a substep."""
    assert substeps(n * step, step) == n
    assert substeps(n * step * 1.01, step) >= n


def test_a_large_model_is_stepped_by_calls_with_the_same_result() -> None:
    """Above SMALL_MODEL the step calls rhs instead of repeating it; the bits are those of the straight version."""
    from gyro_cosim.component import integration

    c = plain()
    straight = integration.step_function(c.rhs, "rk4")
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(integration, "SMALL_MODEL", 0)
        called = integration.step_function(c.rhs, "rk4")
    assert (straight.is_a("SXFunction"), called.is_a("MXFunction")) == (True, True)
    for _, h, polynomial in random_steps(c, 0.01, 5):
        a, b = (np.array(f(c.start_state, polynomial, c.start_parameters, 0.1, h)) for f in (straight, called))
        assert a == pytest.approx(b, rel=1e-15)
    assert isinstance(straight, ca.Function)


@pytest.mark.parametrize("method", METHODS)
def test_a_state_at_rest_is_zero(method: str) -> None:
    """Below 1e-100, so that no subnormal number arises; larger ones and NaN are left alone."""
    x, u, p = (ca.SX.sym(name, n) for name, n in (("x", 4), ("u", 0), ("p", 0)))
    step = step_function(ca.Function("rhs", [x, u, p], [0 * x]), method)
    ends = np.array(step([1e-101, -1e-310, -1e-99, np.nan], np.zeros((0, 3)), [], 0.0, 1e-3)).ravel()
    assert list(ends[:3]) == [0.0, 0.0, -1e-99]
    assert np.isnan(ends[3]) or method == "radau"  # whose Newton iteration fails instead


def test_a_system_that_decays_reaches_rest() -> None:
    """x' = -x: after 1000 s, where x would be 1e-435, it is 0, and on the way no state was ever subnormal."""
    x, u, p = (ca.SX.sym(name, n) for name, n in (("x", 1), ("u", 0), ("p", 0)))
    step = step_function(ca.Function("rhs", [x, u, p], [-x]), "rk4")
    states = [1.0]
    for _ in range(10_000):
        states.append(float(step(states[-1], np.zeros((0, 3)), [], 0.0, 0.1)))
    assert states[-1] == 0.0
    assert min(abs(s) for s in states if s) >= 1e-100
