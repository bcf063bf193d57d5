"""Coupling algorithms keep the order they state, from a cold start, and tend to the monolith."""

from dataclasses import replace

import casadi as ca
import numpy as np
import oscillators
import pytest

from gyro_cosim import Connection, ConvergenceError, GaussSeidel, Jacobi, System, SystemComponent, simulate, system
from gyro_cosim.accuracy.convergence import converge, ladder, own_error
from gyro_cosim.accuracy.monolith import Monolith
from gyro_cosim.component import Component, build, input_, output, state
from gyro_cosim.coupling import Algorithm, History, Iterated, Nepce, Newton
from gyro_cosim.coupling.base import save_all
from gyro_cosim.master import open_network, run
from gyro_cosim.network import projected
from gyro_cosim.systems import StopWhen

ALGORITHMS = [
    *(method(degree) for method in (Jacobi, GaussSeidel) for degree in range(3)),
    *(algorithm(degree) for algorithm in (Iterated, Newton) for degree in (0, 1, 2)),
    *(Nepce(degree) for degree in range(3)),
]
SYSTEMS = {
    "wheel pair, linear gyro": (system("wheel-pair"), 0.016, 2.4),
    "wheel pair, nonlinear gyro": (system("wheel-pair").with_source("gyro", "nonlinear"), 0.016, 2.4),
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


def test_a_step_too_coarse_to_get_through_is_a_rung_that_fails() -> None:
    """At 0.4 s Jacobi with degree 0 blows up and the run ends early; the ladder says so and goes on with finer steps."""
    watched = replace(oscillators.pair(), stop_when=(StopWhen(("left", "position"), 10.0, "blown up"),))
    result = converge(watched, [Jacobi(0)], step=0.4, rungs=8, stop=20.0, in_process=True)
    errors = result.ladders[0].errors
    assert errors[0] == np.inf
    assert not result.ladders[0].used[0]
    assert errors[-1] < 0.2


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
            slave.description = replace(slave.description, input_degree=0)
        reference = Monolith(oscillators.pair())
        errors = []
        for h in (8e-3, 4e-3, 2e-3):
            got = run(network, Jacobi(1), h, 2.0).trajectory
            errors.append(np.abs(got.values - reference.solve(got.t).values).max())
    assert np.polyfit(np.log([8e-3, 4e-3, 2e-3]), np.log(errors), 1)[0] == pytest.approx(2.0, abs=0.15)


def test_history_polynomials_reproduce_polynomials() -> None:
    """Through values of t^2 the polynomial of degree 2 is t^2: value, slope 2 t and curvature 2 at the newest point."""
    history = History((0.0,), (np.array([0.0]),), np.array([], dtype=int))
    for k in range(1, 5):
        history = history.push(0.1 * k, np.array([(0.1 * k) ** 2]))
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
    alone = System("s", (SystemComponent("left", f"{oscillators.HERE}:left"),), ())
    runs = [simulate(alone, algorithm=a, step=0.01, stop=0.5, in_process=True).trajectory.values for a in ALGORITHMS]
    for other in runs[1:]:
        np.testing.assert_array_equal(runs[0], other)


def test_algebraic_loops_are_solved_at_every_communication_point() -> None:
    """Two gains in a ring with a bias: y_a = 2 y_b + 1, y_b = y_a / 4 + 3, so y_a = 14 and y_b = 6.5."""
    gain = f"{oscillators.HERE}:crossed"
    parts = (SystemComponent("a", gain, {"gain": 2.0, "bias": 1.0}), SystemComponent("b", gain, {"gain": 0.25, "bias": 3.0}))
    ring = System("ring", parts, (Connection(("a", "y"), ("b", "u")), Connection(("b", "y"), ("a", "u"))))
    for algorithm in (Jacobi(0), GaussSeidel(1), Iterated(1)):
        values = simulate(ring, algorithm=algorithm, step=0.1, stop=0.3, in_process=True).trajectory.values
        np.testing.assert_allclose(values, [[14.0, 6.5]] * 4, rtol=1e-10)
    with pytest.raises(ConvergenceError, match=r"algebraic loop of a\.y, b\.y must have a solution at t = 0 s"):
        simulate(ring.with_value("b.gain", 0.5), step=0.1, stop=0.3, in_process=True)
    with pytest.raises(ValueError, match=r"must have no algebraic loop, has (a\.y -> b\.y -> a\.y|b\.y -> a\.y -> b\.y)"):
        simulate(ring, step=0.1, stop=0.3, in_process=True, loops="refuse")


def bent() -> Component:
    """y = 3 u + cos(u) / 2 + x with x' = 1, and z = 2 u, which does not go round."""
    return build(
        name="test", variant="bent", description="a bent gain", equations="", internal_step=1e-3,
        variables=[input_("u", "1", "in"), input_("v", "1", "another"), output("y", "1", "out"), output("z", "1", "beside"),
                   state("x", "1", "what is added")],
        model=lambda s: ({"x": 1}, {"y": 3 * s["u"] + ca.cos(s["u"]) / 2 + s["x"], "z": 2 * s["v"]}),
    )  # fmt: skip


@pytest.mark.parametrize("n", [2, 3, 6])
def test_a_loop_of_any_gain_leaves_no_more_than_rounding(n: int) -> None:
    """A ring of n bent gains of about 3: passing values round once more would multiply every error by 3^n.

    Beside the loop a chain of the second outputs runs the other way round the same slaves, and begins at the loop.
    """
    parts = tuple(SystemComponent(f"p{k}", f"{__file__}:bent") for k in range(n))
    ring = [Connection((f"p{k}", "y"), (f"p{(k + 1) % n}", "u")) for k in range(n)]
    chain = [Connection((f"p{k + 1}", "z"), (f"p{k}", "v")) for k in range(n - 1)]
    plan = System("ring", parts, (*ring, *chain, Connection(("p0", "y"), (f"p{n - 1}", "v"))))
    trajectory = simulate(plan, step=0.01, stop=1.0, in_process=True).trajectory
    for k in range(n):
        u, y = trajectory[f"p{k}.y"], trajectory[f"p{(k + 1) % n}.y"]
        np.testing.assert_allclose(y, 3 * u + np.cos(u) / 2 + trajectory.t, rtol=0, atol=1e-12)
        np.testing.assert_allclose(trajectory[f"p{k}.z"], 2.0 ** (n - k) * trajectory["p0.y"], rtol=1e-12)


def test_iterated_coupling_is_stable_where_one_pass_is_not() -> None:
    """A step so large that Jacobi with degree 0 blows up; iterated to agreement the oscillators stay bounded."""
    stiff = oscillators.pair().with_value("left.stiffness", 4.0)
    one = simulate(stiff, algorithm=Jacobi(0), step=0.25, stop=20.0, in_process=True).trajectory.values
    many = simulate(stiff, algorithm=Newton(1), step=0.25, stop=20.0, in_process=True)
    assert np.abs(one).max() > 1e3
    assert np.abs(many.trajectory.values).max() < 40.0
    assert many.iterations > many.steps


def test_iteration_that_does_not_converge_says_where() -> None:
    with pytest.raises(ConvergenceError, match=r"macro step at t = 0 s over 0\.02 s must converge within 1 iterations; "):
        simulate(oscillators.pair(), algorithm=Iterated(1, max_iterations=1), step=0.02, stop=0.1, in_process=True)


def test_sub_steps_of_one_component_take_the_inputs_along() -> None:
    """A slave that holds its inputs, stepped five times a macro step: its inputs then follow the line in five stairs."""

    chain = replace(oscillators.pair(), connections=oscillators.pair().connections[:2], bonds=())
    reference = Monolith(chain)

    def error(parts: int) -> float:
        with open_network(chain, in_process=True, substeps={"right": parts}) as network:
            network.slaves[1].description = replace(network.slaves[1].description, input_degree=0)
            got = run(network, GaussSeidel(2), 0.04, 2.0).trajectory
        return float(np.abs(got["right.force"] - reference.solve(got.t)["right.force"]).max())

    with open_network(oscillators.pair(), in_process=True) as network:
        smooth = run(network, Jacobi(1), 0.02, 2.0).trajectory.values
    with open_network(oscillators.pair(), in_process=True, substeps={"right": 5, "left": 2}) as network:
        np.testing.assert_allclose(run(network, Jacobi(1), 0.02, 2.0).trajectory.values, smooth, rtol=1e-9, atol=1e-12)
    assert error(5) < error(1) / 4
    for given, words in (({"rihgt": 2}, "unknown component with sub-steps"), ({"right": 0}, "whole number of at least 1, got 0")):
        with pytest.raises(ValueError, match=words):
            open_network(oscillators.pair(), in_process=True, substeps=given)


def test_held_signals_are_never_extrapolated() -> None:
    """A counter's output, marked as not smooth, reaches its reader as a stair and not as a slope."""
    from dataclasses import replace

    plan = System(
        "s", (SystemComponent("count", f"{oscillators.HERE}:counter"), SystemComponent("reader", f"{oscillators.HERE}:crossed")),
        (Connection(("count", "count"), ("reader", "u")),),
    )  # fmt: skip
    with open_network(plan, in_process=True) as network:
        known = network.slaves[0].description
        outputs = tuple(replace(y, smooth=y.name != "count") for y in known.outputs)
        network.slaves[0].description = replace(known, outputs=outputs)
        again = type(network)(plan, network.slaves)
        assert again.held.tolist() == [0]
        history = History((0.0,), (np.array([1.0, 0.0, 1.0]),), again.held)
        history = history.push(0.1, np.array([2.0, 1.0, 2.0]))
        np.testing.assert_array_equal(history.polynomial(1), [[2, 1, 2], [0, 10, 10], [0, 0, 0]])


@pytest.mark.parametrize("algorithm", [Iterated, Newton])
def test_a_number_of_iterations_that_is_none_is_refused(algorithm: type[Iterated | Newton]) -> None:
    for number in (0, -1, 2.5):
        with pytest.raises(ValueError, match=f"max_iterations must be a whole number of at least 1, got {number}"):
            algorithm(1, max_iterations=number)  # type: ignore[arg-type]


def test_an_algorithm_writes_to_nobody() -> None:
    """The same step from the same history and memory, twice: the same outcome, and neither of them changed."""
    for algorithm in (Jacobi(2), GaussSeidel(1), Nepce(1), Iterated(2), Newton(2)):
        with open_network(oscillators.pair(cubic=3.0), in_process=True) as network:
            Y = network.initialize(0.0, 1.0)
            history, memory = History((0.0,), (Y.copy(),), network.held), {}
            for k in range(3):
                step = algorithm.advance(network, history, 0.01, memory)
                history, memory = history.push(0.01 * (k + 1), step.Y), step.memory
            kept = [Y.copy() for Y in history.Y], {name: value.copy() for name, value in memory.items()}
            with save_all(network) as before:
                once = algorithm.advance(network, history, 0.01, memory)
                before.go_back()
                again = algorithm.advance(network, history, 0.01, memory)
            assert once.Y.tobytes() == again.Y.tobytes()
            assert all(a.tobytes() == b.tobytes() for a, b in zip(history.Y, kept[0], strict=True))
            assert memory.keys() == kept[1].keys()
            assert all(memory[name].tobytes() == kept[1][name].tobytes() for name in memory)


def test_connection_is_a_value() -> None:
    assert Connection(("a", "y"), ("b", "u")) == Connection(("a", "y"), ("b", "u"))


def test_a_ladder_leaves_out_what_the_components_own_error_spoils() -> None:
    """e = h^order + 4e-4: where the fourth order comes to a stand shows what is common; the second can be seen still."""
    steps = [0.16, 0.08, 0.04, 0.02]
    errors = [[h**order + 4e-4 for h in steps] for order in (2, 4)]
    floor = own_error(errors)
    assert floor == pytest.approx(4e-4, rel=1e-3)
    second, fourth = (ladder(Jacobi(degree), steps, e, floor) for degree, e in zip((1, 2), errors, strict=True))
    assert second.used == (True, True, True, False)
    assert second.observed_order == pytest.approx(2.0, abs=0.2)
    assert fourth.used == (True, False, False, False)
    assert np.isnan(fourth.observed_order)
    assert own_error([[h**order for h in steps] for order in (1, 2, 3)]) == 0.0
    assert own_error([[float("inf"), float("inf"), 0.5, 0.49]]) == 0.0  # not there yet
