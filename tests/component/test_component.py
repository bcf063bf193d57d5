"""The contract: tables and functions agree, units convert, wrong tables are refused with one line."""

import doctest
import importlib
import math
from dataclasses import replace
from pkgutil import resolve_name

import casadi as ca
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from gyro_cosim.component import Component, build, input_, output, parameter, state
from gyro_cosim.component.units import BASE, compatible, convert, power_pair, quantity, unit
from gyro_cosim.systems import catalogue

COMPONENTS = [f"{package}:{variant}" for package, variants in catalogue.components().items() for variant in variants]
WHEEL_PAIR = resolve_name("gyro_cosim.vehicle.wheel_pair:small_wheel_pair")()


def made(**changes: object) -> Component:
    """A small valid component, or the refusal of one."""
    options = {
        "name": "c", "variant": "v", "description": "d", "equations": "", "internal_step": 1e-3,
        "variables": [state("x", "m", "place"), input_("u", "m/s", "rate"), output("y", "m", "place")],
        "model": lambda s: ({"x": s["u"]}, {"y": s["x"]}),
    } | changes  # fmt: skip
    return build(**options)  # type: ignore[arg-type]


@pytest.mark.parametrize("spec", [spec for spec in COMPONENTS if ":hil" not in spec])  # a rig clips and rounds
def test_step_of_a_component_has_the_order_of_its_method(spec: str) -> None:
    """One internal step of h against two of h/2: the difference falls as h^(order + 1)."""
    c = catalogue.component(spec)
    rng = np.random.default_rng(0)
    x = c.start_state + 1e-3 * rng.standard_normal(len(c.states))
    U = rng.standard_normal((len(c.inputs), 3)) * 1e-2
    p = c.start_parameters

    def defect(h: float) -> float:
        whole = np.array(c.step(x, U, p, 0.0, h))
        half = np.array(c.step(c.step(x, U, p, 0.0, h / 2), U, p, h / 2, h / 2))
        return float(np.abs(whole - half).max(initial=0.0))

    h = 4 * c.internal_step
    assert defect(h) < 1e-3  # a coarse step is near already
    assert defect(h / 4) < defect(h) / 4**2 or defect(h) < 1e-14


@pytest.mark.parametrize("spec", COMPONENTS)
def test_every_parameter_states_its_source_and_every_variable_its_meaning(spec: str) -> None:
    c = catalogue.component(spec)
    assert all(v.source for v in c.parameters)
    assert all(v.meaning for v in c.variables)
    assert all(unit(v.unit).factor == 1.0 for v in c.variables)


@pytest.mark.parametrize(
    ("changes", "words"),
    [
        (
            {"variables": [state("x", "m", "a"), parameter("x", 0.0, "m", "b", source="s")], "model": lambda s: ({"x": 0}, {})},
            "'x' twice",
        ),
        ({"model": lambda s: ({}, {"y": 0})}, "differs in x"),
        ({"model": lambda s: ({"x": 0}, {"y": 0, "z": 0})}, "differs in z"),
        ({"internal_step": 0.0}, "internal_step must be positive, got 0.0"),
        ({"model": lambda s: ({"x": 1 / (s["x"] * 0)}, {"y": 0})}, "rhs must be finite"),
        ({"model": lambda s: ({"x": 0}, {"y": ca.log(-1 - s["x"] ** 2)})}, "output 'y' must be finite"),
        ({"method": "euler"}, "method must be one of"),
    ],
)
def test_a_table_that_disagrees_with_its_functions_is_refused(changes: dict[str, object], words: str) -> None:
    with pytest.raises(ValueError, match=words):
        made(**changes)


def test_functions_of_the_wrong_shape_are_refused() -> None:
    c = made()
    with pytest.raises(ValueError, match="output must return one column of 2 outputs, got 1 rows"):
        replace(c, variables=(*c.variables, output("z", "m", "more")))


@pytest.mark.parametrize(
    ("make", "words"),
    [
        (lambda: parameter("a b", 0.0, "m", "x", source="s"), "must be a C identifier"),
        (lambda: parameter("a", 0.0, "", "x", source="s"), "must have a unit"),
        (lambda: parameter("a", 0.0, "furlong", "x", source="s"), "unknown unit 'furlong'"),
        (lambda: parameter("a", 0.0, "mm", "x", source="s"), "must be in an SI unit, got 'mm'"),
        (lambda: parameter("a", math.nan, "m", "x", source="s"), "start must be finite, got nan"),
        (lambda: parameter("a", 0.0, "m", "x", source="s", min=1.0), "start must be at least min"),
        (lambda: parameter("a", 0.0, "m", "x", source="s", min=2.0, max=1.0), "must be at"),
        (lambda: parameter("a", 5.0, "m", "x", source="s", assumed=(0.0, 1.0)), "must lie in its assumed range"),
        (lambda: parameter("a", 0.0, "m", "x", source="s", display_unit="kg"), "does not fit"),
        (lambda: parameter("a", 0.0, "m", "", source="s"), "must have a meaning"),
    ],
)
def test_a_row_that_no_fmu_could_carry_is_refused(make: object, words: str) -> None:
    with pytest.raises(ValueError, match=words):
        make()  # type: ignore[operator]


@pytest.mark.parametrize(
    ("text", "target", "value"),
    [
        ("200rpm", "rad/s", 200 * 2 * math.pi / 60),
        ("36 kmh", "m/s", 10.0),
        ("36 km/h", "m/s", 10.0),
        ("1ms", "s", 1e-3),
        ("0.3", "N.m", 0.3),
        ("3 mN.m", "N.m", 3e-3),
        ("-1e3 mm", "m", -1.0),
        ("20 degC", "K", 293.15),
    ],
)
def test_quantities_are_read_with_their_units(text: str, target: str, value: float) -> None:
    assert quantity(text, target) == pytest.approx(value, rel=1e-15)


@pytest.mark.parametrize(("text", "target"), [("3kg", "rad/s"), ("abc", "m"), ("1 bogus", "m"), ("2/3/4", "m"), ("1 m/s/s", "m")])
def test_quantities_that_do_not_fit_are_refused(text: str, target: str) -> None:
    with pytest.raises(ValueError, match=r"unit|number"):
        quantity(text, target)


@given(st.sampled_from(["rpm", "rad/s", "deg/s", "rev/min"]), st.sampled_from(["rpm", "rad/s", "rev/s"]), st.floats(-1e6, 1e6))
def test_conversion_there_and_back_is_the_identity(a: str, b: str, value: float) -> None:
    assert convert(convert(value, a, b), b, a) == pytest.approx(value, rel=1e-14, abs=1e-300)


def test_units_of_power_pairs_and_dimensions() -> None:
    assert power_pair("rad/s", "N.m")
    assert power_pair("m/s", "N")
    assert not power_pair("rad", "N.m")
    assert not compatible("rad/s", "1/s")  # angles are kept apart, as FMI does
    assert dict(zip(BASE, unit("N.m.s/rad").dimension, strict=True)) == {
        "kg": 1, "m": 2, "s": -1, "A": 0, "K": 0, "mol": 0, "cd": 0, "rad": -1,
    }  # fmt: skip


def test_feedthrough_is_found_from_the_functions() -> None:
    gyro = catalogue.component("gyro_unit:nonlinear")
    found = {
        (gyro.outputs[i].name, gyro.inputs[j].name) for i, j in zip(*np.nonzero(gyro.feedthrough), strict=True)
    }  # the gimbal's damper sees the pitch rate at once
    assert found == {("pitch_moment", "pitch_rate"), ("dissipated_power", "pitch_rate")}
    assert not WHEEL_PAIR.feedthrough.any()


@pytest.mark.parametrize("module", ["building", "units"])
def test_examples_in_docstrings_hold(module: str) -> None:
    failed, tried = doctest.testmod(importlib.import_module(f"gyro_cosim.component.{module}"))
    assert tried > 0
    assert failed == 0
