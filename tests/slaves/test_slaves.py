"""Slaves of every kind behave alike: FMU and component give the same numbers, a step repeats after a restore."""

import re
import zipfile
from pathlib import Path

import numpy as np
import oscillators
import pytest

from gyro_cosim import GaussSeidel, Jacobi, SlaveError, System, SystemComponent, simulate, system
from gyro_cosim.component import Component, build, output, state
from gyro_cosim.slaves import open_slave
from gyro_cosim.systems import catalogue

SPECS = [f"{package}:{variant}" for package, variants in catalogue.components().items() for variant in variants]
SMALL = [spec for spec in SPECS if "lrt" not in spec and "wheelset" not in spec]


@pytest.mark.parametrize("algorithm", [Jacobi(0), Jacobi(2), GaussSeidel(1)], ids=repr)
@pytest.mark.parametrize("variant", ["linear", "nonlinear"])
def test_fmus_and_components_give_the_same_numbers(variant: str, algorithm: Jacobi) -> None:
    plan = system("wheel-pair").with_source("gyro", variant).with_value("gyro.rotor_speed", "200rpm")
    a, b = (simulate(plan, algorithm=algorithm, step=2.5e-3, stop=2.0, in_process=here).trajectory for here in (True, False))
    assert a.names == b.names
    assert a.units == b.units
    size = np.abs(a.values).max(axis=0) + 1e-300
    assert (np.abs(a.values - b.values).max(axis=0) / size).max() < 1e-12  # rounding, over 800 steps


@pytest.mark.parametrize(
    "spec",
    [pytest.param(spec, marks=pytest.mark.slow) if spec.endswith("hil_full") else spec for spec in SMALL],  # as hil, longer
)
@pytest.mark.parametrize("in_process", [True, False], ids=["component", "fmu"])
def test_a_step_repeats_bit_for_bit_after_a_restore(spec: str, in_process: bool) -> None:
    slave = open_slave("s", spec, in_process=in_process)
    try:
        slave.initialize({}, 0.0, 1.0)
        U = np.array([[0.3] * len(slave.inputs), [2.0] * len(slave.inputs), [-5.0] * len(slave.inputs)])
        slave.step(U, 0.0, 0.01)
        snapshot = slave.save()
        first = []
        for k in (1, 2):
            slave.step(U, 0.01 * k, 0.01)
            first.append(slave.output(U[0], 0.01 * (k + 1)))
        slave.restore(snapshot)
        for k in (1, 2):
            slave.step(U, 0.01 * k, 0.01)
            np.testing.assert_array_equal(slave.output(U[0], 0.01 * (k + 1)), first[k - 1])
        slave.restore(snapshot)
        slave.discard(snapshot)
    finally:
        slave.close()


@pytest.mark.parametrize("spec", SMALL)
def test_an_fmu_shows_the_master_what_its_component_does(spec: str) -> None:
    """Signals, units, bounds, start values and direct feedthrough come through the FMU's description unchanged."""
    here, there = open_slave("s", spec, in_process=True), open_slave("s", spec)
    try:
        for kind in ("inputs", "outputs"):
            assert [(s.name, s.unit) for s in getattr(here, kind)] == [(s.name, s.unit) for s in getattr(there, kind)]
        np.testing.assert_array_equal(here.description.feedthrough, there.description.feedthrough)
        assert there.description.input_degree == here.description.input_degree
        assert there.description.can_restore
        for name, signal in here.description.settable.items():
            other = there.description.settable[name]
            assert (signal.unit, signal.start, signal.min, signal.max) == (other.unit, other.start, other.min, other.max)
    finally:
        there.close()


def test_start_values_of_states_and_unconnected_inputs_can_be_set() -> None:
    plan = system("wheel-pair").with_value("vehicle.yaw_angle", "10deg").with_value("gyro.pitch_rate", 0.5)
    for in_process in (True, False):
        run = simulate(plan, step=1e-3, stop=0.2, in_process=in_process)
        assert run.trajectory["vehicle.yaw_angle"][0] == pytest.approx(np.radians(10))
        assert run.trajectory["gyro.gimbal_angle"][-1] < -0.01  # the frame pitches away under the gimbal


def test_a_sampled_part_acts_at_its_own_period_whatever_the_macro_step() -> None:
    """A counter that adds one every 10 ms, and a ramp that follows it: the same at every macro step."""
    plan = System("s", (SystemComponent("s", f"{oscillators.HERE}:counter"),), ())
    for h in (1e-3, 4e-3, 0.01, 0.025):
        for in_process in (True, False):
            end = simulate(plan, step=h, stop=0.1, in_process=in_process).trajectory.end()
            assert end["s.count"] == 10  # at 0, 10, ... 90 ms; the one at 100 ms belongs to the next step
            assert end["s.total"] == pytest.approx(0.01 * sum(range(1, 11)), rel=1e-9)


def test_error_control_is_the_same_in_process_and_in_the_fmu() -> None:
    """With `tolerance` the internal steps adapt; fewer or more, they are the same ones on both sides."""
    plan = system("wheel-pair").with_source("gyro", "nonlinear").with_value("gyro.tolerance", 1e-9)
    a, b = (simulate(plan, step=0.05, stop=1.0, in_process=here).trajectory.values for here in (True, False))
    np.testing.assert_allclose(a, b, rtol=1e-12, atol=1e-14)
    fixed = simulate(plan.with_value("gyro.tolerance", 0.0), step=0.05, stop=1.0, in_process=True).trajectory.values
    assert not np.array_equal(a, fixed)
    np.testing.assert_allclose(a, fixed, rtol=0, atol=1e-6)


def test_two_slaves_of_one_fmu_do_not_touch_each_other() -> None:
    alone = open_slave("a", "gyro_unit:linear")
    other = open_slave("b", "gyro_unit:linear")
    try:
        for slave, angle in ((alone, 0.1), (other, 0.7)):
            slave.initialize({"gimbal_angle": angle}, 0.0, 1.0)
        other.step(np.ones((3, 3)), 0.0, 0.01)
        row = [s.name for s in alone.outputs].index("gimbal_angle")
        assert alone.output(np.zeros(3), 0.0)[row] == 0.1
    finally:
        alone.close()
        other.close()


def test_fmus_leave_no_temporary_folder_behind(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    import tempfile

    monkeypatch.setattr(tempfile, "tempdir", str(tmp_path))
    simulate(system("wheel-pair"), step=0.01, stop=0.05)
    with pytest.raises(ValueError, match="must hold a binary"):
        open_slave("s", str(_without_binaries(tmp_path)))
    assert [p.name for p in tmp_path.iterdir()] == ["none.fmu"]


def _without_binaries(folder: Path) -> Path:
    with zipfile.ZipFile(catalogue.fmu("gyro_unit:linear")) as source, zipfile.ZipFile(folder / "none.fmu", "w") as target:
        for member in source.namelist():
            if not member.startswith(("binaries/", "sources/")):
                target.writestr(member, re.sub(rb"<SourceFiles>.*?</SourceFiles>", b"", source.read(member), flags=re.S))
    return folder / "none.fmu"


def test_fmus_that_cannot_be_used_are_refused(tmp_path: Path) -> None:
    text = tmp_path / "text.fmu"
    text.write_text("no zip")
    empty = tmp_path / "empty.fmu"
    with zipfile.ZipFile(empty, "w") as archive:
        archive.writestr("readme.txt", "nothing")
    outside = tmp_path / "outside.fmu"
    with zipfile.ZipFile(catalogue.fmu("gyro_unit:linear")) as source, zipfile.ZipFile(outside, "w") as target:
        target.writestr("modelDescription.xml", source.read("modelDescription.xml"))
        target.writestr("resources/../../../out.txt", "x")
    for file, words in (
        (tmp_path / "missing.fmu", "must exist"),
        (text, "must be a zip archive"),
        (empty, "must hold modelDescription.xml"),
        (_without_binaries(tmp_path), "must hold a binary for"),
        (outside, "must lie inside the archive"),
    ):
        with pytest.raises(ValueError, match=words):
            open_slave("s", str(file))
    assert not (tmp_path.parent / "out.txt").exists()


def test_an_fmu_that_fails_in_a_step_says_when_and_why() -> None:
    """A component whose state runs to infinity in finite time: x' = x^2 from x = 1 ends at t = 1."""
    broken = System("s", (SystemComponent("fast", f"{__file__}:runaway"),), ())
    for in_process in (True, False):
        with pytest.raises(SlaveError, match=r"component 'fast' failed at t = (0\.9|1)") as caught:
            simulate(broken, step=0.1, stop=3.0, in_process=in_process)
        assert caught.value.partial.trajectory.t[-1] == pytest.approx(0.9, abs=0.11)
        assert np.isfinite(caught.value.partial.trajectory.values).all()


def runaway() -> Component:
    """x' = x^2 and a little more, so that fixed steps overflow soon after x(t) = 1 / (1 - t) has left the scale."""
    return build(
        name="test", variant="runaway", description="runs to infinity", equations="", internal_step=1e-3,
        variables=[state("x", "1", "grows", start=1.0, is_output=True)],
        model=lambda s: ({"x": s["x"] ** 2 * (1 + s["x"] ** 8 * 1e-9)}, {}),
    )  # fmt: skip


def test_a_gyro_from_a_file_takes_the_place_of_a_built_in_one(tmp_path: Path) -> None:
    """The oscillators' file serves as a catalogue of its own, in process and as FMUs, with the same results."""
    plan = oscillators.pair()
    a, b = (simulate(plan, step=2e-3, stop=1.0, in_process=here).trajectory.values for here in (True, False))
    np.testing.assert_allclose(a, b, rtol=0, atol=1e-12)


def huge() -> Component:
    """Two outputs that are finite, and whose sum is not."""
    return build(
        name="huge", variant="two", description="two large outputs", equations="", internal_step=1e-3,
        variables=(state("x", "1", "clock"), output("a", "1", "a"), output("b", "1", "b")),
        model=lambda s: ({"x": 1}, {"a": 1.2e308 + 0 * s["x"], "b": 1.2e308 + 0 * s["x"]}),
    )  # fmt: skip


@pytest.mark.parametrize("in_process", [True, False])
def test_finite_outputs_pass_though_their_sum_overflows(in_process: bool) -> None:
    plan = System("s", (SystemComponent("h", f"{__file__}:huge"),), ())
    assert simulate(plan, step=0.1, stop=0.2, in_process=in_process).trajectory.end() == {"h.a": 1.2e308, "h.b": 1.2e308}
