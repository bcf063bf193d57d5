"""Coupling algorithms keep the order they state, from a cold start, and tend to the monolith."""

from dataclasses import replace

import numpy as np
import oscillators
import pytest

from cosim import Connection, GaussSeidel, Jacobi, Part, System, simulate, system
from cosim.convergence import converge
from cosim.coupling import Algorithm, History, projected
from cosim.master import open_network, run
from cosim.monolith import Monolith

ALGORITHMS = [method(degree) for method in (Jacobi, GaussSeidel) for degree in range(3)]
SYSTEMS = {
    "wheel pair, linear gyro": (system("wheel-pair"), 0.016, 4.0),
    "wheel pair, nonlinear gyro": (system("wheel-pair").with_source("gyro", "nonlinear"), 0.016, 4.0),
    "two masses with feedthrough": (oscillators.pair(), 0.008, 2.0),
    "two masses, nonlinear": (oscillators.pair(cubic=30.0), 0.008, 2.0),
}


@pytest.mark.parametrize("name", SYSTEMS)
@pytest.mark.parametrize("algorithm", ALGORITHMS, ids=lambda a: f"{a.name}-{a.degree}")
def test_observed_order_is_the_stated_order(algorithm: Algorithm, name: str) -> None:
    plan, step, stop = SYSTEMS[name]
    result = converge(plan, [algorithm], step=step, rungs=4, stop=stop, in_process=True)
    assert all(result.ladders[0].used)
    assert result.ladders[0].observed_order == pytest.approx(algorithm.order, abs=0.15)


@pytest.mark.parametrize("algorithm", [Jacobi(2), GaussSeidel(2)], ids=lambda a: a.name)
@pytest.mark.parametrize(("variant", "reference"), [("linear", "matrix exponential"), ("nonlinear", "monolith, DOP853")])
def test_the_run_tends_to_the_reference(algorithm: Algorithm, variant: str, reference: str) -> None:
    plan = system("wheel-pair").with_source("gyro", variant)
    result = converge(plan, [algorithm], step=4e-3, rungs=3, stop=2.0, in_process=True)
    assert result.reference == reference
    assert result.ladders[0].errors[-1] < 5e-7  # 1 ms, third order, time constants of 0.1 s
    assert result.ladders[0].errors[-1] < result.ladders[0].errors[0] / 40


def test_the_two_references_agree_on_the_linear_case() -> None:
    """Matrix exponential against the Runge-Kutta solution of the same functions."""
    joined = Monolith(system("wheel-pair"))
    t = np.linspace(0.0, 5.0, 26)
    np.testing.assert_allclose(joined._integrated(t), joined._exponential(t), rtol=0, atol=1e-10)


def test_gauss_seidel_is_exact_where_the_chain_has_no_loop() -> None:
    """Gyro driven by the vehicle but not fed back, vehicle first: its input then is the interpolated truth."""
    chain = replace(system("wheel-pair"), connections=system("wheel-pair").connections[:1], bonds=())
    t = np.arange(0, 1001) * 2e-3
    reference = Monolith(chain).solve(t)

    def error(algorithm: Algorithm) -> float:
        got = simulate(chain, algorithm=algorithm, step=2e-3, stop=2.0, in_process=True).trajectory
        return float(np.abs(got["gyro.gimbal_angle"] - reference["gyro.gimbal_angle"]).max())

    assert error(GaussSeidel(2, ("vehicle", "gyro"))) < error(Jacobi(2)) / 2  # interpolation beats extrapolation
    assert error(GaussSeidel(1, ("vehicle", "gyro"))) < error(Jacobi(1)) / 2


def test_the_sequence_of_gauss_seidel_matters_and_is_kept() -> None:
    runs = [
        simulate(system("wheel-pair"), algorithm=GaussSeidel(0, order), step=0.01, stop=1.0, in_process=True).trajectory.values
        for order in (("vehicle", "gyro"), ("gyro", "vehicle"), ())
    ]
    assert np.abs(runs[0] - runs[1]).max() > 1e-6
    np.testing.assert_array_equal(runs[0], runs[2])  # chosen by itself: the gyro's outputs can depend on rates, so it is second


@pytest.mark.parametrize("degree", [0, 1])
def test_projection_on_a_lower_degree_is_the_least_squares_one(degree: int) -> None:
    U, h = np.array([[1.0, -2.0], [3.0, 0.5], [-40.0, 7.0]]), 0.2
    s = np.linspace(0.0, h, 4001)
    values = U[0] + np.outer(s, U[1]) + np.outer(s**2 / 2, U[2])
    fitted = np.polynomial.polynomial.polyfit(s, values, degree)
    np.testing.assert_allclose(projected(U, h, degree)[: degree + 1], fitted, rtol=2e-3)
    assert not projected(U, h, degree)[degree + 1 :].any()


def test_projection_keeps_an_order_that_cutting_off_would_lose() -> None:
    """A slave that takes constant inputs only, fed with degree 1: order 2 by the mean over the step."""
    with open_network(oscillators.pair(), in_process=True) as network:
        for slave in network.slaves:
            slave.input_degree = 0
        reference = Monolith(oscillators.pair())
        errors = []
        for h in (8e-3, 4e-3, 2e-3):
            got = run(network, Jacobi(1), h, 2.0).trajectory
            errors.append(np.abs(got.values - reference.solve(got.t).values).max())
    assert np.polyfit(np.log([8e-3, 4e-3, 2e-3]), np.log(errors), 1)[0] == pytest.approx(2.0, abs=0.15)


def test_history_polynomials_reproduce_polynomials() -> None:
    """Through values of t^2 the polynomial of degree 2 is t^2: value, slope 2 t and curvature 2 at the newest point."""
    history = History(0.0, np.array([0.0]), 0.1)
    for k in range(1, 5):
        history.push(0.1 * k, np.array([(0.1 * k) ** 2]))
    np.testing.assert_allclose(history.polynomial(2)[:, 0], [0.16, 0.8, 2.0], rtol=1e-12)
    np.testing.assert_allclose(history.through(0.05, np.array([0.45**2]), 2)[:, 0], [0.16, 0.8, 2.0], rtol=1e-12)


def test_wrong_degree_and_sequence_are_refused() -> None:
    with pytest.raises(ValueError, match="degree must be 0, 1 or 2, got 3"):
        Jacobi(3)
    with pytest.raises(ValueError, match="unknown component in the sequence: 'wheel'"):
        simulate(system("wheel-pair"), algorithm=GaussSeidel(1, ("wheel", "gyro")), stop=0.1, in_process=True)
    with pytest.raises(ValueError, match="sequence must name every component once"):
        simulate(system("wheel-pair"), algorithm=GaussSeidel(1, ("gyro",)), stop=0.1, in_process=True)


def test_uncoupled_slaves_need_no_algorithm() -> None:
    """Without connections every algorithm gives the same bits."""
    alone = System("s", (Part("left", f"{oscillators.HERE}:left"),), ())
    runs = [simulate(alone, algorithm=a, step=0.01, stop=0.5, in_process=True).trajectory.values for a in ALGORITHMS]
    for other in runs[1:]:
        np.testing.assert_array_equal(runs[0], other)


def test_connection_is_a_value() -> None:
    assert Connection(("a", "y"), ("b", "u")) == Connection(("a", "y"), ("b", "u"))
