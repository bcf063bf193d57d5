"""What depends on parameters alone is computed once: the same bits, whenever parameters change."""

from pathlib import Path

import casadi as ca
import numpy as np
import pytest
from fmu_opening import opened

from gyro_cosim import fmus
from gyro_cosim.component import Component, build, output, parameter, state
from gyro_cosim.component.integration import INPUT_DEGREE
from gyro_cosim.fmus.parametric import prepared
from gyro_cosim.systems import catalogue

SPECS = ["vehicle:lrt", "vehicle:lrt_fastsim", "vehicle:wheel_pair", "gyro_unit:nonlinear_full", "gyro_unit:multibody"]


@pytest.mark.parametrize("spec", SPECS)
def test_prepared_functions_give_the_bits_of_the_components(spec: str) -> None:
    c = catalogue.component(spec)
    functions, size = prepared(c).functions, prepared(c).size
    rng = np.random.default_rng(1)
    for _ in range(5):
        x = c.start_state + 1e-3 * rng.standard_normal(c.start_state.size)
        u = c.start_input + rng.standard_normal(c.start_input.size)
        p = c.start_parameters * (1.0 + 1e-3 * rng.random(c.start_parameters.size))
        P = np.concatenate([p, np.array(functions["prepare"](p)).ravel()]) if size else p
        assert (c.longest_step is None) == ("longest_step" not in functions)
        for name, whole in (("rhs", c.rhs), ("output", c.output), ("longest_step", c.longest_step)):
            if whole is None:
                continue
            assert np.array(functions[name](x, u, P)).tobytes() == np.array(ca.densify(whole(x, u, p))).tobytes()
        U = rng.standard_normal((u.size, INPUT_DEGREE + 1))
        if "step" in functions:
            assert np.array(functions["step"](x, U, P, 0.0, 1e-4)).tobytes() == np.array(c.step(x, U, p, 0.0, 1e-4)).tobytes()


def test_the_vehicle_prepares_much_and_computes_less() -> None:
    """FASTSIM's strips and cells depend on the ellipse, which a parameter set decides."""
    c = catalogue.component("vehicle:lrt_fastsim")
    assert prepared(c).functions["rhs"].n_instructions() < 0.7 * c.rhs.n_instructions()


def pendulum() -> Component:
    """x'' = -(g / l) sin x; g / l and the period come from parameters that may change between steps."""
    return build(
        name="pendulum", variant="plain", description="a pendulum", equations="", internal_step=1e-3,
        variables=(
            state("x", "rad", "angle", start=0.5), state("v", "rad/s", "rate"), output("period", "s", "of small swings"),
            parameter("g", 9.81, "m/s2", "gravity", source="test"), parameter("l", 0.7, "m", "length", source="test"),
        ),
        model=lambda s: (
            {"x": s["v"], "v": -(s["g"] / s["l"]) * ca.sin(s["x"])}, {"period": 2 * np.pi / ca.sqrt(s["g"] / s["l"])},
        ),
    )  # fmt: skip


@pytest.mark.parametrize("version", ["2", "3"])
def test_a_parameter_counts_from_when_it_changes_and_a_restored_state_brings_its_own(version: str, tmp_path: Path) -> None:
    c = pendulum()
    assert prepared(c).size > 0
    (path,) = fmus.export(c, tmp_path, fmi=(version,))

    def period(length: float) -> float:
        return float(c.output([0.5, 0.0], [], [9.81, length]))

    save, restore = ("getFMUstate", "setFMUstate") if version == "2" else ("getFMUState", "setFMUState")
    with opened(path, tmp_path / "unpacked") as it:
        it.initialize(l=1.4)
        assert it.get("period") == period(1.4)
        it.step(0.0, 0.1)
        short = getattr(it.fmu, save)()
        it.set(l=2.8)
        assert it.get("period") == period(2.8)
        it.step(0.1, 0.1)
        slow = it.get("x", "v")
        getattr(it.fmu, restore)(short)
        assert it.get("period") == period(1.4)
        it.step(0.1, 0.1)
        fast = it.get("x", "v")
        assert not np.array_equal(fast, slow)
    with opened(path, tmp_path / "unpacked") as it:  # one whose length never changes
        it.initialize(l=1.4)
        it.step(0.0, 0.1)
        it.step(0.1, 0.1)
        assert it.get("x", "v").tobytes() == fast.tobytes()
