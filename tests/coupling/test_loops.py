"""Algebraic loops: where their solution begins, steps that are too long, loops without a solution."""

import casadi as ca
import numpy as np
import pytest

from gyro_cosim import Connection, ConvergenceError, System, SystemComponent, simulate
from gyro_cosim.component import Component, build, input_, output, parameter, state


def sums() -> Component:
    """a + b + c = 0 and 2 a - 3 b + 2 c = 9, solved for a and b; hence b = -1.8."""
    return build(
        name="test", variant="sums", description="two equations of three", equations="", internal_step=1e-2,
        variables=[input_("c", "m", "c", start=1.0), state("z", "m", "no part of it"), output("a", "m", "a"),
                   output("b", "m", "b")],
        model=lambda s: ({"z": -s["z"]}, {"a": 1.8 - s["c"], "b": -1.8 + 0 * s["c"]}),
    )  # fmt: skip


def sphere() -> Component:
    """a^2 + b^2 + c^2 = 5, solved for c > 0, which is not defined where a^2 + b^2 > 5."""
    return build(
        name="test", variant="sphere", description="the third equation", equations="", internal_step=1e-2,
        variables=[input_("a", "m", "a", start=0.8), input_("b", "m", "b", start=-1.8), state("z", "m", "no part of it"),
                   output("c", "m", "c")],
        model=lambda s: ({"z": -s["z"]}, {"c": ca.sqrt(5 - s["a"] ** 2 - s["b"] ** 2)}),
    )  # fmt: skip


def bend() -> Component:
    """y = x - g(x) with g = atan(2 (x - middle)): Newton's whole steps for g(x) = 0 swing out ever further from |x| > 0.7 on.

    `gap` above 0 raises it so that there is no solution: y = x + gap + |atan|.
    """
    return build(
        name="test", variant="bend", description="a bend", equations="", internal_step=1e-2,
        variables=[input_("x", "1", "in", start=0.0), output("y", "1", "out"),
                   parameter("middle", 3.0, "1", "where the solution is", source="test"),
                   parameter("gap", 0.0, "1", "keeps it from one", source="test")],
        model=lambda s: ({}, {"y": ca.if_else(s["gap"] > 0, s["x"] + s["gap"] + (s["x"] - s["middle"]) ** 2,
                                              s["x"] - ca.atan(2 * (s["x"] - s["middle"])))}),
    )  # fmt: skip


def three_equations(**start: float) -> System:
    """The case of OMSimulator's issue 808."""
    plan = System(
        "808",
        (SystemComponent("A", f"{__file__}:sums"), SystemComponent("B", f"{__file__}:sphere")),
        (Connection(("A", "a"), ("B", "a")), Connection(("A", "b"), ("B", "b")), Connection(("B", "c"), ("A", "c"))),
    )
    for name, value in start.items():
        plan = plan.with_value(name.replace("_", "."), value)
    return plan


def ring(**values: float) -> System:
    """A bend that feeds itself."""
    return System("ring", (SystemComponent("p", f"{__file__}:bend", values),), (Connection(("p", "y"), ("p", "x")),))


@pytest.mark.parametrize("how", ["in process", "as FMUs", "isolated"])
def test_a_nonlinear_loop_is_solved_from_its_declared_start_values(how: str) -> None:
    """c = 0.9 + sqrt(0.07) is the solution near c = 1; from zero the root is that of a negative number."""
    run = simulate(three_equations(), step=0.1, stop=0.3, in_process=how == "in process", isolate=how == "isolated")
    c = 0.9 + np.sqrt(0.07)
    for name, value in (("A.a", 1.8 - c), ("A.b", -1.8), ("B.c", c)):
        np.testing.assert_allclose(run.trajectory[name], np.full(4, value), rtol=0, atol=1e-12)


def test_a_start_value_chooses_among_solutions() -> None:
    run = simulate(three_equations(A_c=0.5), step=0.1, stop=0.3, in_process=True)
    np.testing.assert_allclose(run.trajectory["B.c"], np.full(4, 0.9 - np.sqrt(0.07)), rtol=0, atol=1e-12)


@pytest.mark.parametrize("in_process", [True, False])
def test_steps_into_the_undefined_are_shortened(in_process: bool) -> None:
    """From c = 0.87, where the slope is nearly level, Newton's whole step ends where a^2 + b^2 > 5."""
    run = simulate(three_equations(A_c=0.87, B_a=0.93), step=0.1, stop=0.3, in_process=in_process)
    c = run.trajectory["B.c"]
    np.testing.assert_allclose(np.abs(c - 0.9), np.full(4, np.sqrt(0.07)), rtol=0, atol=1e-12)


@pytest.mark.parametrize("middle", [0.2, 3.0, -20.0])
def test_a_loop_on_which_whole_steps_diverge_is_solved(middle: float) -> None:
    run = simulate(ring(middle=middle), step=0.1, stop=0.2, in_process=True)
    np.testing.assert_allclose(run.trajectory["p.y"], np.full(3, middle), rtol=0, atol=1e-11)


def test_a_loop_without_a_solution_is_told_with_the_nearest_values() -> None:
    words = (
        r"the algebraic loop of p\.y must have a solution at t = 0 s, none found in 50 iterations; "
        r"nearest is p\.y = (3|[23]\.[09]\d*), "
        r"where p\.y becomes 3\.[45]\d* \(an input's start value says where to begin\)"
    )
    with pytest.raises(ConvergenceError, match=words):
        simulate(ring(gap=0.5), step=0.1, stop=0.2, in_process=True)


def test_a_loop_that_is_undefined_where_it_begins_is_told() -> None:
    words = (
        r"the algebraic loop of A\.a, B\.c must be defined where its solution begins, at A\.a = .*, B\.c = 9: "
        r"component 'B' failed at t = 0 s: output 'c' must be finite, got nan"
    )
    with pytest.raises(ConvergenceError, match=words):
        simulate(three_equations(A_c=9.0, B_a=4.0), step=0.1, stop=0.2, in_process=True)
