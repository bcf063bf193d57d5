"""A coupled system as one FMU: the bits of a run of the system, in other importers and as a part of a larger system."""

import sys
from collections.abc import Callable, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

import fmpy
import numpy as np
import oscillators
import pytest
import small_fmus
from fmu_opening import opened

from gyro_cosim import Connection, GaussSeidel, Jacobi, Newton, System, SystemComponent, fmus, simulate, system
from gyro_cosim.check import check_fmu
from gyro_cosim.coupling import Algorithm, Nepce
from gyro_cosim.export import pack_fmu
from gyro_cosim.fmus.compiler import host
from gyro_cosim.slaves import linearisation, open_slave
from gyro_cosim.systems import StopWhen, catalogue

ALGORITHMS = [A(k) for A in (Jacobi, GaussSeidel, Nepce) for k in range(3)]


@pytest.fixture(scope="module")
def packed(tmp_path_factory: pytest.TempPathFactory) -> Callable[[str], tuple[System, Path]]:
    """A system by name and its FMU, packed once; with ".fmi3" behind the name that of FMI 3.0."""
    plans = {"wheel-pair": system("wheel-pair"), "oscillators": oscillators.pair(cubic=3.0)}
    files: dict[str, Path] = {}

    def pack(name: str) -> tuple[System, Path]:
        base = name.removesuffix(".fmi3")
        if name not in files:
            files[base], files[f"{base}.fmi3"] = pack_fmu(plans[base], tmp_path_factory.mktemp("packed"), fmi=("2", "3"))
        return plans[base], files[name]

    return pack


def in_fmpy(file: Path, stop: float, h: float, outputs: list[str], **values: float) -> Any:
    """A run in FMPy with communication points every h (s)."""
    return fmpy.simulate_fmu(str(file), stop_time=stop, output_interval=h, step_size=h, output=outputs, start_values=values)


@pytest.mark.parametrize("name", ["wheel-pair", "oscillators", "oscillators.fmi3"])
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


@pytest.mark.parametrize("name", ["wheel-pair", "wheel-pair.fmi3", "oscillators", "oscillators.fmi3"])
def test_check_finds_no_fault(packed: Callable[[str], tuple[System, Path]], name: str) -> None:
    assert [f for f in check_fmu(packed(name)[1]) if f.severity != "note"] == []


@pytest.mark.parametrize("name", ["wheel-pair", "wheel-pair.fmi3"])
def test_the_fmu_runs_as_a_component_of_a_system(packed: Callable[[str], tuple[System, Path]], name: str) -> None:
    plan, file = packed(name)
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


def test_two_components_of_one_name_do_not_meet(tmp_path: Path) -> None:
    """From two files that differ in a number: their C functions are called alike."""
    text = Path(oscillators.HERE).read_text(encoding="utf-8")
    other = tmp_path / "harder.py"
    other.write_text(text.replace("40.0", "80.0"), encoding="utf-8")
    parts = (SystemComponent("soft", f"{oscillators.HERE}:left"), SystemComponent("hard", f"{other}:left"))
    plan = System("s", parts, (), step=1e-3, stop=0.2)
    (file,) = pack_fmu(plan, tmp_path)
    run = simulate(plan).trajectory
    result = in_fmpy(file, 0.2, 1e-3, list(run.names))
    for signal in run.names:
        np.testing.assert_array_equal(result[signal], run[signal], err_msg=signal)
    assert not np.array_equal(run["soft.position"], run["hard.position"])


@pytest.mark.parametrize(
    ("change", "rule"),
    [
        (lambda plan: {"algorithm": Newton(1)}, r"algorithm of a system as one FMU must be one of jacobi, gauss-seidel, nepce"),
        (lambda plan: {"fmi": ("1",)}, r"FMI version must be one of 2, 3, got '1'"),
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


def exported(plan: System, versions: Sequence[str], folder: Path) -> System:
    """The same system with its components as FMUs of these versions, foreign ones to the packer; "" leaves one as it is."""
    components = []
    for component, version in zip(plan.components, versions, strict=True):
        if version:
            (file,) = fmus.export(catalogue.component(component.source), folder, fmi=(version,))
            component = replace(component, source=str(file))
        components.append(component)
    return replace(plan, components=tuple(components))


@pytest.mark.parametrize("versions", [
    ("2", "2"), pytest.param(("3", "3"), marks=pytest.mark.slow), ("2", "3"), pytest.param(("", "3"), marks=pytest.mark.slow),
])  # fmt: skip
def test_carried_fmus_give_the_same_bits(versions: Sequence[str], tmp_path: Path) -> None:
    """FMI 2.0 and 3.0, the latter asking for its inputs within a step; in a folder whose name a URI has to quote."""
    plan = exported(oscillators.pair(cubic=3.0), versions, tmp_path)
    (file,) = pack_fmu(plan, tmp_path)
    folder = tmp_path / "unpacked here, 100 %"
    fmpy.extract(str(file), str(folder))
    for number, algorithm in ((1, Jacobi(2)), (2, GaussSeidel(1)), (3, Nepce(1))):
        run = simulate(plan, algorithm=algorithm, step=2e-3, stop=0.2).trajectory
        values = {"algorithm": number, "degree": algorithm.degree, "macro_step": 2e-3}
        result = in_fmpy(folder, 0.2, 1e-2, list(run.names), **values)
        for signal in run.names:
            np.testing.assert_array_equal(result[signal], run[signal][::5], err_msg=signal)


@pytest.mark.parametrize(
    "make",
    [
        lambda folder: small_fmus.ball(folder, smooth=True),
        lambda folder: small_fmus.ball(folder, events=False, smooth=True),
        lambda folder: small_fmus.follower(folder, 2),
        lambda folder: small_fmus.follower(folder, 3, says="anything"),
    ],
    ids=["event mode", "events of its own", "follower of FMI 2.0", "follower of FMI 3.0"],
)
def test_events_and_starts_of_carried_fmus_are_those_of_a_run(make: Callable[[Path], Path], tmp_path: Path) -> None:
    """A ball bounces at its own times; a follower's state follows from its input in initialization mode."""
    parts = (SystemComponent("foreign", str(make(tmp_path))), SystemComponent("left", f"{oscillators.HERE}:left"))
    plan = System("s", parts, (), step=1e-2, stop=2.0)
    (file,) = pack_fmu(plan, tmp_path / "out")
    run = simulate(plan).trajectory
    result = in_fmpy(file, 2.0, 1e-2, list(run.names))
    for signal in run.names:
        np.testing.assert_array_equal(result[signal], run[signal], err_msg=signal)


@pytest.mark.parametrize("name", ["oscillators", "oscillators.fmi3"])
def test_a_saved_state_repeats_the_run(packed: Callable[[str], tuple[System, Path]], name: str, tmp_path: Path) -> None:
    """Also one taken within the cold start, and from bytes in another instance."""
    _, file = packed(name)

    def steps(it: Any, first: int, n: int) -> list[np.ndarray]:
        return [it.step(1e-3 * k, 1e-3) for k in range(first, first + n)]

    with opened(file, tmp_path) as it, opened(file, tmp_path) as other:
        setter = it.fmu.setInteger if it.version == "2" else it.fmu.setInt32
        setter([it.vr["degree"]], [2])
        it.initialize()
        other.initialize()
        steps(it, 0, 1)
        get, put, free = (getattr(it.fmu, f"{v}FMU{'s' if it.version == '2' else 'S'}tate") for v in ("get", "set", "free"))
        state = get()
        expected = steps(it, 1, 6)
        put(state)
        np.testing.assert_array_equal(steps(it, 1, 6), expected)
        size = "s" if it.version == "2" else "S"
        data = getattr(it.fmu, f"serializeFMU{size}tate")(state)
        read = "deSerializeFMUstate" if it.version == "2" else "deserializeFMUState"
        again = getattr(other.fmu, read)(data)
        getattr(other.fmu, f"setFMU{size}tate")(again)
        np.testing.assert_array_equal(steps(other, 1, 6), expected)
        getattr(other.fmu, f"freeFMU{size}tate")(again)
        free(state)


def test_a_stop_condition_ends_the_run(tmp_path: Path) -> None:
    """In FMPy and as a component of a run, after the macro step that meets it."""
    plan = replace(oscillators.pair(), stop_when=(StopWhen(("left", "velocity"), 0.5, "too fast"),), step=1e-2, stop=5.0)
    (file,) = pack_fmu(plan, tmp_path)
    run = simulate(plan)
    assert run.status == "ended"
    assert 10 < len(run.trajectory.t) < 500
    whole = simulate(System("larger", (SystemComponent("pair", str(file)),), (), step=1e-2, stop=5.0))
    assert whole.status == "ended"
    np.testing.assert_array_equal(whole.trajectory["pair.left.position"], run.trajectory["left.position"])


@pytest.mark.parametrize("name", ["oscillators", "wheel-pair.fmi3"])
def test_directional_derivatives_are_those_of_the_system_coupled_continuously(
    packed: Callable[[str], tuple[System, Path]], name: str, tmp_path: Path
) -> None:
    """Outputs and derivatives of all states, along states and inputs of the whole, against central differences of them."""
    file = packed(name)[1]
    with opened(file, tmp_path) as it:
        read = it.description
        states = [v.derivative.name for v in read.modelVariables if v.derivative is not None]
        unknowns = [v.name for v in read.modelVariables if v.derivative is not None] + it.names["output"]
        knowns = [*states, *it.names["input"]]
        assert len(states) >= 2
        if it.version == "2":
            it.fmu.setupExperiment(startTime=0.0)
        it.fmu.enterInitializationMode()
        base = it.get(*knowns)
        derivative = it.fmu.getDirectionalDerivative
        for j, known in enumerate(knowns):
            one = np.array(derivative([it.vr[n] for n in unknowns], [it.vr[known]], [1.0]))
            d = 1e-4
            ends = []
            for side in (d, -d):
                it.set(**{known: base[j] + side})
                ends.append(it.get(*unknowns))
            it.set(**{known: base[j]})
            np.testing.assert_allclose(one, (ends[0] - ends[1]) / (2 * d), rtol=1e-5, atol=1e-6, err_msg=known)


def test_the_whole_is_linearised_as_a_component(tmp_path: Path) -> None:
    """Newton's Jacobian and the stability margin take it from there: the matrix of the two masses."""
    (file,) = pack_fmu(oscillators.pair(), tmp_path)
    slave = open_slave("whole", str(file))
    try:
        slave.initialize({}, 0.0, 1.0)
        space = linearisation(slave)
    finally:
        slave.close()
    assert space is not None
    exact = [[0, 1, 0, 0], [-70, -1, 30, 0.6], [0, 0, 0, 1], [30 / 1.5, 0.6 / 1.5, -90 / 1.5, -1.1 / 1.5]]
    np.testing.assert_allclose(space.A, exact, rtol=1e-12, atol=1e-12)
    np.testing.assert_allclose(space.C, [[1, 0, 0, 0], [0, 1, 0, 0], [-30, -0.6, 30, 0.6]], rtol=1e-12, atol=1e-12)


@pytest.mark.parametrize(
    ("make", "rule"),
    [
        (lambda folder: small_fmus.mixed(folder), "outputs must be continuous, a.count is held"),
        (lambda folder: small_fmus.arrays(folder), "outputs must be continuous, a.tiny_out is held"),
        (lambda folder: f"{oscillators.HERE}:crossed", "must have no algebraic loop"),
    ],
    ids=["types", "arrays", "loop"],
)
def test_systems_that_the_kernel_cannot_run_are_refused(make: Callable[[Path], Path], rule: str, tmp_path: Path) -> None:
    wires = (Connection(("a", "y"), ("a", "u")),) if rule.endswith("loop") else ()
    plan = System("s", (SystemComponent("a", str(make(tmp_path))),), wires)
    with pytest.raises(ValueError, match=rule) as caught:
        pack_fmu(plan, tmp_path / "out")
    assert "\n" not in str(caught.value)
    assert not (tmp_path / "out").exists()


def test_an_fmu_without_a_library_for_the_platform_is_refused(tmp_path: Path) -> None:
    plan = exported(oscillators.pair(), ("2", "2"), tmp_path)
    other = next(name for name in ("x86_64-windows", "aarch64-linux") if name != host().name)
    with pytest.raises(ValueError, match=r"of 'left' must hold a binary for (win64|aarch64-linux), has "):
        pack_fmu(plan, tmp_path / "out", platforms=(other,))


@pytest.mark.skipif(sys.platform != "linux", reason="libcosimpy has wheels for Linux only")
def test_libcosim_gets_the_same_bits(packed: Callable[[str], tuple[System, Path]]) -> None:
    pytest.importorskip("libcosimpy", reason="has no wheel for this Python")
    from libcosimpy.CosimExecution import CosimExecution
    from libcosimpy.CosimObserver import CosimObserver
    from libcosimpy.CosimSlave import CosimLocalSlave

    plan, file = packed("wheel-pair")
    run = simulate(plan, step=1e-3, stop=0.1).trajectory
    execution = CosimExecution.from_step_size(step_size=1_000_000)  # ns
    slave = execution.add_local_slave(CosimLocalSlave(fmu_path=str(file), instance_name="whole"))
    references = {v.name.decode(): v.reference for v in execution.slave_variables(slave)}
    observer = CosimObserver.create_last_value()
    execution.add_observer(observer)
    for row in run.values[1:]:
        assert execution.step(1)
        got = observer.last_real_values(slave_index=slave, variable_references=[references[n] for n in run.names])
        np.testing.assert_array_equal(got, row)


def test_the_command_line_packs_and_runs_it(cosim: Callable[..., Any]) -> None:
    """What it starts with is given; the FMU runs alone, and `info` shows its parameters."""
    options = ("--algorithm", "nepce", "--degree", "0", "--step", "2ms", "--set", "gyro.rotor_speed=200rpm")
    code, out, err = cosim("pack", "wheel-pair", "--as-fmu", *options, "-o", "whole.fmu")
    assert (code, out, err) == (0, "wrote whole.fmu\n", "")
    code, out, _ = cosim("info", "whole.fmu")
    assert code == 0
    assert "macro_step" in out
    plan = system("wheel-pair").with_value("gyro.rotor_speed", "200rpm")
    run = simulate(plan, algorithm=Nepce(0), step=2e-3, stop=0.1).trajectory
    result = in_fmpy(Path("whole.fmu"), 0.1, 2e-3, list(run.names))
    for signal in run.names:
        np.testing.assert_array_equal(result[signal], run[signal], err_msg=signal)


@pytest.mark.parametrize(
    ("arguments", "line"),
    [
        (("--fmi", "3"), "cosim: --fmi has no effect without --as-fmu, got '3'"),
        (("--as-fmu", "--fmi", "4"), "cosim: --fmi must be 2, 3 or both, got '4'"),
        (
            ("--as-fmu", "--algorithm", "iterated"),
            "cosim: algorithm of a system as one FMU must be one of jacobi, gauss-seidel, nepce, got 'iterated'",
        ),
        (
            ("--as-fmu", "--fmi", "both", "-o", "one.fmu"),
            "cosim: two versions of FMI must go into a folder, got the file 'one.fmu'",
        ),
    ],
)
def test_wrong_use_of_pack_is_one_line(cosim: Callable[..., Any], arguments: Sequence[str], line: str) -> None:
    code, out, err = cosim("pack", "wheel-pair", *arguments)
    assert (code, out, " ".join(err.split())) == (2, "", line)
