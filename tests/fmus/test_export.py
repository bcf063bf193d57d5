"""The exporter: FMUs of every kind of component agree with the component, bit for bit where both do the same."""

import zipfile
from collections.abc import Callable
from pathlib import Path

import fmpy
import numpy as np
import pytest
from fmpy.validation import validate_fmu
from fmu_models import COMPONENTS, in_process, random_steps
from fmu_opening import opened

from gyro_cosim import fmus
from gyro_cosim.systems import catalogue


@pytest.mark.parametrize("version", ["2", "3"])
@pytest.mark.parametrize(
    "name",
    [n if n in ("gyro_unit:nonlinear", "sampled", "gain") else pytest.param(n, marks=pytest.mark.slow) for n in COMPONENTS],
)
def test_validators_find_nothing(built: Callable, name: str, version: str) -> None:
    """FMPy's validation holds the schema, names, units, structure and legal combinations."""
    assert validate_fmu(str(built(name, version)[1])) == []


@pytest.mark.parametrize("tolerance", [0.0, 1e-6], ids=["equal steps", "error control"])
@pytest.mark.parametrize("name", COMPONENTS)
def test_fmu_and_component_give_the_same_bits(built: Callable, name: str, tolerance: float) -> None:
    """Uneven macro steps, input polynomials of degree 2, own internal step: the very same doubles."""
    c, path, folder = built(name)
    steps = random_steps(c, 0.011, 40, size=0.1)
    with opened(path, folder) as it:
        it.initialize(tolerance=tolerance, internal_step=0.7e-3 if name not in ("rosenbrock", "radau") else 5e-3)
        got = np.array([it.step(*step) for step in steps])
    expected = in_process(c, steps, tolerance=tolerance, internal_step=0.7e-3 if name not in ("rosenbrock", "radau") else 5e-3)
    assert np.array_equal(got, expected)


@pytest.mark.parametrize("name", COMPONENTS)
def test_both_versions_give_the_same_bits(built: Callable, name: str) -> None:
    """FMI 2.0 and FMI 3.0 with held inputs."""
    results = []
    for version in "23":
        c, path, folder = built(name, version)
        steps = [(t, h, U * [1, 0, 0]) for t, h, U in random_steps(c, 0.02, 20, size=0.1)]
        with opened(path, folder) as it:
            it.initialize()
            results.append([it.step(*step) for step in steps])
    assert np.array_equal(*results)


@pytest.mark.parametrize("version", ["2", "3"])
@pytest.mark.parametrize("name", COMPONENTS)
def test_reference_results_inside_are_what_an_importer_gets(built: Callable, name: str, version: str) -> None:
    """The files in documentation/reference, replayed with FMPy's stepping; CasADi's interpreter made them, so to rounding."""
    c, path, folder = built(name, version)
    with zipfile.ZipFile(path) as archive:
        prefix = f"documentation/reference/{c.name}_{c.variant}"
        u, y = (
            np.genfromtxt(archive.open(f"{prefix}_{suffix}.csv"), delimiter=",", skip_header=1, ndmin=2)
            for suffix in ("in", "ref")
        )
    with opened(path, folder) as it:
        it.initialize()
        np.testing.assert_allclose(np.atleast_1d(it.outputs()), y[0, 1:], rtol=1e-12, atol=1e-14)
        for row, expected in zip(u, y[1:, 1:], strict=False):
            U = np.zeros((len(c.inputs), 3))
            U[:, 0] = row[1:]
            np.testing.assert_allclose(np.atleast_1d(it.step(row[0], 0.01, U)), expected, rtol=1e-10, atol=1e-14)


def test_outputs_follow_the_input_polynomial_then_new_inputs(built: Callable) -> None:
    """Direct feedthrough: after the step y holds u(t + h); after setting u it holds the new u; derivatives last one step."""
    _, path, folder = built("gain")
    with opened(path, folder) as it:
        it.initialize()
        assert it.step(0.0, 0.1, np.array([[1.0, 2.0, 30.0]])) == pytest.approx(3 * (1 + 0.2 + 0.15), rel=1e-15)
        assert it.get("u") == 1.0  # the input variable itself keeps what was set
        it.set(u=5.0)
        assert it.outputs() == 15.0
        assert it.step(0.1, 0.1) == 15.0


@pytest.mark.parametrize("version", ["2", "3"])
def test_tunable_parameters_take_effect_between_steps(built: Callable, version: str) -> None:
    c, path, folder = built("plain", version)
    U = np.array([[0.3, 0.0, 0.0]])
    first = in_process(c, [(0.0, 0.01, U)])
    with opened(path, folder) as it:
        it.initialize()
        assert np.array_equal(it.step(0.0, 0.01, U), first[0])
        it.set(k=90.0)
        changed = it.step(0.01, 0.01, U)
    with opened(path, folder) as it:
        it.initialize()
        it.step(0.0, 0.01, U)
        assert not np.array_equal(it.step(0.01, 0.01, U), changed)


@pytest.mark.parametrize("version", ["2", "3"])
def test_states_can_be_set_before_initialization_ends(built: Callable, version: str) -> None:
    _, path, folder = built("plain", version)
    with opened(path, folder) as it:
        it.initialize(phi=0.25, omega=-1.0)
        assert list(it.get("phi", "omega", "der(phi)")) == [0.25, -1.0, -1.0]


@pytest.mark.parametrize("name", ["gyro_unit:nonlinear", "plain", "sampled", "radau"])
@pytest.mark.parametrize("version", ["2", "3"])
def test_model_exchange_gives_the_same_solution(built: Callable, name: str, version: str) -> None:
    """SUNDIALS' CVode on Model Exchange, time events included, against Co-Simulation; both with errors far below 1e-5."""
    c, path, _ = built(name, version)
    values = {"radau": {"rate": 10.0}, "sampled": {"wish": 1.0}, "gyro_unit:nonlinear": {"yaw_rate": 3.0}}.get(name, {})
    common = {"filename": str(path), "stop_time": 0.5, "output_interval": 0.1}
    exact = fmpy.simulate_fmu(fmi_type="CoSimulation", start_values={**values, "internal_step": 1e-4}, **common)
    got = fmpy.simulate_fmu(fmi_type="ModelExchange", relative_tolerance=1e-9, start_values=values, **common)
    assert got["time"][-1] == exact["time"][-1] == 0.5
    for v in c.outputs:
        assert got[v.name][-1] == pytest.approx(exact[v.name][-1], abs=1e-5)
        assert got[v.name][0] == exact[v.name][0] or name == "sampled"  # its first sample is at the start


@pytest.mark.parametrize("name", ["gyro_unit:nonlinear", "vehicle:wheel_pair"])
@pytest.mark.parametrize("version", ["2", "3"])
def test_model_exchange_is_right_with_what_an_importer_takes_by_default(built: Callable, name: str, version: str) -> None:
    """Without a tolerance in the FMU FMPy took 1e-5, with errors of 1e-4 of the range and more."""
    c, path, _ = built(name, version)
    values = {"gyro_unit:nonlinear": {"yaw_rate": 0.5}}.get(name, {"yaw_moment": 0.01})
    common = {"filename": str(path), "stop_time": 2.0, "output_interval": 0.01, "start_values": values}
    exact, got = (fmpy.simulate_fmu(fmi_type=kind, **common) for kind in ("CoSimulation", "ModelExchange"))
    for v in c.outputs:
        assert np.abs(got[v.name] - exact[v.name]).max() <= 1e-5 * np.ptp(exact[v.name])


@pytest.mark.slow
@pytest.mark.parametrize("spec", [f"{p}:{v}" for p, variants in catalogue.components().items() for v in variants])
def test_every_component_of_the_project_has_an_fmu_without_faults(spec: str, tmp_path: Path) -> None:
    """All variants of all packages in the catalogue, both versions, validated and run for ten steps."""
    component = catalogue.component(spec)
    paths = fmus.export(component, tmp_path, fmi=("2", "3"))
    for path in paths:
        assert validate_fmu(str(path)) == []
        with opened(path, tmp_path / path.stem) as it:
            it.initialize()
            for i in range(10):
                y = it.step(i * 1e-3, 1e-3)
        assert np.all(np.isfinite(y))
