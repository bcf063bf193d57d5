"""A coupled system as one FMU: the bits of a run of the system, in other importers and as a part of a larger system."""

from collections.abc import Callable
from pathlib import Path
from typing import Any

import fmpy
import numpy as np
import oscillators
import pytest
from fmu_opening import opened

from gyro_cosim import GaussSeidel, Jacobi, Newton, System, SystemComponent, simulate, system
from gyro_cosim.check import check_fmu
from gyro_cosim.coupling import Algorithm, Nepce
from gyro_cosim.export import pack_fmu

ALGORITHMS = [A(k) for A in (Jacobi, GaussSeidel, Nepce) for k in range(3)]


@pytest.fixture(scope="module")
def packed(tmp_path_factory: pytest.TempPathFactory) -> Callable[[str], tuple[System, Path]]:
    """A system by name and its FMU, packed once."""
    plans = {"wheel-pair": system("wheel-pair"), "oscillators": oscillators.pair(cubic=3.0)}
    files: dict[str, Path] = {}

    def pack(name: str) -> tuple[System, Path]:
        if name not in files:
            (files[name],) = pack_fmu(plans[name], tmp_path_factory.mktemp("packed"))
        return plans[name], files[name]

    return pack


def in_fmpy(file: Path, stop: float, h: float, outputs: list[str], **values: float) -> Any:
    """A run in FMPy with communication points every h (s)."""
    return fmpy.simulate_fmu(str(file), stop_time=stop, output_interval=h, step_size=h, output=outputs, start_values=values)


@pytest.mark.parametrize("name", ["wheel-pair", "oscillators"])
@pytest.mark.parametrize("algorithm", ALGORITHMS, ids=repr)
def test_a_run_in_fmpy_has_the_bits_of_a_run_of_the_system(
    packed: Callable[[str], tuple[System, Path]], name: str, algorithm: Algorithm
) -> None:
    """From the cold start on, and with five macro steps from one communication point to the next."""
    plan, file = packed(name)
    run = simulate(plan, algorithm=algorithm, step=2e-3, stop=0.5).trajectory
    number = {"jacobi": 1, "gauss-seidel": 2, "nepce": 3}[algorithm.name]
    values = {"algorithm": number, "degree": algorithm.degree, "macro_step": 2e-3}
    for every in (1, 5):
        result = in_fmpy(file, 0.5, every * 2e-3, list(run.names), **values)
        assert len(result) == 250 // every + 1
        for signal in run.names:
            np.testing.assert_array_equal(result[signal], run[signal][::every], err_msg=signal)


def test_a_value_of_a_component_is_a_parameter(packed: Callable[[str], tuple[System, Path]]) -> None:
    plan, file = packed("wheel-pair")
    run = simulate(plan.with_value("gyro.rotor_speed", 30.0).with_value("vehicle.yaw_angle", 0.1), stop=0.2).trajectory
    result = in_fmpy(file, 0.2, 1e-3, list(run.names), **{"gyro.rotor_speed": 30.0, "vehicle.yaw_angle": 0.1})
    for signal in run.names:
        np.testing.assert_array_equal(result[signal], run[signal], err_msg=signal)
    assert not np.array_equal(run["gyro.gimbal_angle"], simulate(plan, stop=0.2).trajectory["gyro.gimbal_angle"])


@pytest.mark.parametrize("name", ["wheel-pair", "oscillators"])
def test_check_finds_no_fault(packed: Callable[[str], tuple[System, Path]], name: str) -> None:
    assert check_fmu(packed(name)[1]) == []


def test_the_fmu_runs_as_a_component_of_a_system(packed: Callable[[str], tuple[System, Path]]) -> None:
    plan, file = packed("wheel-pair")
    alone = simulate(plan, step=1e-3, stop=0.3).trajectory
    whole = System("larger", (SystemComponent("pair", str(file)), SystemComponent("left", f"{oscillators.HERE}:left")), ())
    run = simulate(whole, step=1e-3, stop=0.3).trajectory
    for signal in alone.names:
        np.testing.assert_array_equal(run[f"pair.{signal}"], alone[signal])


def test_a_step_that_is_no_whole_number_of_macro_steps_ends_with_a_shorter_one(
    packed: Callable[[str], tuple[System, Path]], tmp_path: Path
) -> None:
    """As the last step of a run: 0.0125 s are six macro steps of 2 ms and one of 0.5 ms."""
    plan, file = packed("oscillators")
    run = simulate(plan, algorithm=Jacobi(2), step=2e-3, stop=0.0125).trajectory
    with opened(file, tmp_path) as fmu:
        fmu.fmu.setInteger([fmu.vr["degree"]], [2])
        fmu.initialize(macro_step=2e-3)
        fmu.step(0.0, 0.0125)
        np.testing.assert_array_equal(fmu.get(*run.names), run.values[-1])


@pytest.mark.parametrize(
    ("change", "rule"),
    [
        (lambda plan: {"algorithm": Newton(1)}, r"algorithm of a system as one FMU must be one of jacobi, gauss-seidel, nepce"),
        (lambda plan: {"fmi": ("1",)}, r"FMI version must be one of 2"),
        (lambda plan: {"step": -1.0}, r"`step` must be positive"),
    ],
)
def test_what_cannot_be_packed_is_refused_in_one_line(
    change: Callable[[System], dict[str, Any]], rule: str, tmp_path: Path
) -> None:
    plan = oscillators.pair()
    with pytest.raises(ValueError, match=rule) as caught:
        pack_fmu(plan, tmp_path / "out", **change(plan))
    assert "\n" not in str(caught.value)
    assert not (tmp_path / "out").exists()
