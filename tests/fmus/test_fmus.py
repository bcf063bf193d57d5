"""FMUs of all sorts: both FMI versions, variables of every type, arrays, states that are kept, and what must be refused."""

import os
import subprocess
import sys
import zipfile
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
import small_fmus

from gyro_cosim import Connection, Jacobi, SlaveError, System, SystemComponent, WiringError, simulate
from gyro_cosim.slaves import Slave, linearisation, open_slave, serializable
from gyro_cosim.systems import catalogue


def both_versions(folder: Path) -> list[Slave]:
    """The same component as FMI 2.0 and FMI 3.0 FMU."""
    files = catalogue.export("gyro_unit:nonlinear", folder, fmi=("2", "3"))
    return [open_slave("s", str(file)) for file in files]


def test_fmi_2_and_fmi_3_give_the_same_numbers_under_inputs_of_degree_2(tmp_path: Path) -> None:
    """Intermediate update carries the whole polynomial: a parabola over an internal step, so that only rounding differs."""
    two, three = both_versions(tmp_path)
    rng = np.random.default_rng(1)
    try:
        assert (two.description.input_degree, three.description.input_degree) == (2, 2)
        for slave in (two, three):
            slave.initialize({"gimbal_angle": 0.1}, 0.0, 2.0)
        for k in range(50):
            U = rng.standard_normal((3, 3)) * np.array([[1.0], [10.0], [100.0]])
            for slave in (two, three):
                slave.step(U, 0.01 * k, 0.01)
            a, b = (slave.output(U[0], 0.01 * (k + 1)) for slave in (two, three))
            np.testing.assert_allclose(a, b, rtol=1e-10, atol=1e-13)  # the FMUs form the parabola in two ways
        for a, b in zip(vars(two.state_space()).values(), vars(three.state_space()).values(), strict=True):
            np.testing.assert_allclose(a, b, rtol=1e-12)
    finally:
        two.close()
        three.close()


@pytest.mark.parametrize("kind", ["component", "fmi2", "fmi3"])
def test_a_serialized_state_continues_bit_for_bit_in_a_fresh_slave(kind: str, tmp_path: Path) -> None:
    def fresh() -> Slave:
        if kind == "component":
            return open_slave("s", "gyro_unit:nonlinear", in_process=True)
        files = catalogue.export("gyro_unit:nonlinear", tmp_path, fmi=(kind[-1],))
        return open_slave("s", str(files[0]))

    U = np.array([[0.3] * 3, [2.0] * 3, [-5.0] * 3])
    slave = fresh()
    slave.initialize({"rotor_speed": 20.0}, 0.0, 1.0)
    slave.step(U, 0.0, 0.01)
    data = slave.serialize()
    slave.step(U, 0.01, 0.01)
    wanted = slave.output(U[0], 0.02)
    slave.close()
    slave = fresh()
    slave.initialize({"rotor_speed": 20.0}, 0.0, 1.0)
    slave.deserialize(data)
    slave.step(U, 0.01, 0.01)
    np.testing.assert_array_equal(slave.output(U[0], 0.02), wanted)
    with pytest.raises((ValueError, SlaveError)):
        slave.deserialize(b"nonsense")
    slave.close()


@pytest.mark.parametrize("in_process", [True, False])
def test_direct_feedthrough_is_that_of_differences(in_process: bool) -> None:
    slave = open_slave("s", "gyro_unit:nonlinear", in_process=in_process)
    try:
        slave.initialize({"gimbal_angle": 0.4}, 0.0, 1.0)
        u = np.array([0.2, -0.1, 0.3])
        slave.output(u, 0.0)
        space = slave.state_space()
        assert space is not None
        J = space.D
        for j in range(3):
            e = np.eye(3)[j] * 1e-6
            np.testing.assert_allclose((slave.output(u + e, 0.0) - slave.output(u - e, 0.0)) / 2e-6, J[:, j], atol=1e-9)
        assert (J != 0).any()
    finally:
        slave.close()


def test_what_cannot_serialize_says_so(tmp_path: Path) -> None:
    slave = open_slave("m", str(small_fmus.mixed(tmp_path)))
    slave.initialize({}, 0.0, 1.0)
    assert serializable(slave) is None
    assert linearisation(slave) is None
    with pytest.raises(ValueError, match="'m' must be able to serialize its state"):
        slave.serialize()
    slave.close()


def typed(folder: Path) -> System:
    """Both hand-made FMUs; the FMI 2.0 one drives the other's integer, boolean and one element of its array."""
    parts = (
        SystemComponent("m", str(small_fmus.mixed(folder, unit_in="chain")), {"u": "1000m", "mode": "slow", "add": 2}),
        SystemComponent("a", str(small_fmus.arrays(folder)), {
            "u": "1 2 3", "gain": (2, 3, 4), "gain[2]": 10, "label": ("abc", "de"), "blob": "00ff01", "huge": 2**40,
            "single": 0.5, "mode": "fast",
        }),
    )  # fmt: skip
    return System("s", parts, (
        Connection(("m", "count"), ("a", "tiny")), Connection(("m", "on_out"), ("a", "on")),
        Connection(("m", "y"), ("a", "u[2]")),
    ), step=0.01, stop=0.1)  # fmt: skip


def test_every_type_takes_start_values_and_crosses_connections(tmp_path: Path) -> None:
    end = simulate(typed(tmp_path)).trajectory.end()
    chains = 1000 / 20.1168
    assert end["m.y"] == pytest.approx(2 * chains)  # a number in furlongs, as the FMU says
    assert end["a.y[2]"] == pytest.approx(10 * 2 * chains * 201.168)  # gain[2] times furlongs in metres
    assert (end["a.y[1]"], end["a.y[3]"]) == (2.0, 12.0)
    assert end["a.total"] == pytest.approx(end["a.y[1]"] + end["a.y[2]"] + end["a.y[3]"])
    assert end["m.count"] == 10 * (1 + 2)
    assert end["a.tiny_out"] == 27  # one step behind: held, not extrapolated
    assert (end["m.mode_out"], end["a.mode_out"], end["a.on_out"], end["m.on_out"]) == (2, 5, 1, 1)
    assert (end["a.huge_out"], end["a.single_out"]) == (2**40, 0.5)
    assert end["a.length"] == len("abc") + len("de") + 3


@pytest.mark.parametrize(
    ("target", "value", "words"),
    [
        ("a.mode", "medium", "a.mode: must be one of off, fast, got 'medium'"),
        ("a.mode", 2, r"must be one of off \(1\), fast \(5\), got 2"),
        ("a.tiny", 1.5, "must be a whole number, got 1.5"),
        ("a.tiny", 300, "must be at most 127, got 300"),
        ("a.huge", -1, "must be at least 0, got -1"),
        ("a.huge", 2**60, r"must be at most 2\^53"),
        ("a.on", "perhaps", "must be true or false, got 'perhaps'"),
        ("a.u", "1 2", r"must have 3 values \(3\), got 2"),
        ("a.label", 3, "must be text, got 3"),
        ("a.blob", "xyz", "must be bytes in hexadecimal digits, got 'xyz'"),
        ("m.u", "3 kg", "unit 'kg' cannot be expressed in 'chain'"),
        ("m.gain", "3 m", "must be a plain number, since no unit is stated"),
        ("a.tick", 1, "a.tick must be something that takes a value, is a Clock of an FMU without event mode"),
    ],
)
def test_values_that_do_not_fit_their_type_are_refused(tmp_path: Path, target: str, value: object, words: str) -> None:
    with pytest.raises(ValueError, match=words):
        simulate(typed(tmp_path).with_value(target, value))


@pytest.mark.parametrize(
    ("start", "end", "words"),
    [
        ("m.y", "a.tick", r"a\.tick is a Clock of an FMU without event mode, which takes no part in connections"),
        ("m.y", "m.text", r"types must fit: m\.y is of type real, m\.text of type string"),
        ("m.y", "a.mode", r"types must fit: m\.y is a real, a\.mode an enumeration"),
        ("m.count", "a.on", r"types must fit: m\.count is an integer, a\.on a boolean"),
        ("a.y", "m.u", "arrays must have the same shape, got 3 and a scalar"),
    ],
)
def test_connections_between_types_that_do_not_fit_are_refused(tmp_path: Path, start: str, end: str, words: str) -> None:
    (a, x), (b, y) = start.split("."), end.split(".")
    with pytest.raises(WiringError, match=words):
        simulate(replace(typed(tmp_path), connections=(Connection((a, x), (b, y)),)))


def test_whole_arrays_are_connected_element_by_element(tmp_path: Path) -> None:
    file = str(small_fmus.arrays(tmp_path))
    plan = System(
        "s", (SystemComponent("a", file, {"u": "1 2 3"}), SystemComponent("b", file)), (Connection(("a", "y"), ("b", "u")),)
    )
    end = simulate(plan, step=0.01, stop=0.05, algorithm=Jacobi(0)).trajectory.end()
    assert [end[f"b.y[{i}]"] for i in (1, 2, 3)] == [1, 2, 3]


def test_an_fmi_3_step_that_ends_early_without_leave_is_a_failure(tmp_path: Path) -> None:
    with pytest.raises(SlaveError, match=r"must do the whole step, returned early at t = 0\.005 s"):
        simulate(typed(tmp_path).with_value("a.leave_early", True))


def test_an_fmu_that_is_a_hair_beyond_a_step_by_its_own_account_is_taken_at_its_end_and_that_is_told(tmp_path: Path) -> None:
    done = simulate(typed(tmp_path).with_value("a.beyond", True))
    assert done.status == "done"
    count, first = done.warnings["a"]
    assert count == done.steps
    assert first.startswith("says that a step from 0 s over")


def test_integers_that_would_be_rounded_are_refused(tmp_path: Path) -> None:
    """2^53 comes through to the last digit, the 2^53 + 1 that this FMU makes of it does not."""
    plan = System("s", (SystemComponent("a", str(small_fmus.arrays(tmp_path)), {"huge": 2**53 - 1, "tiny": -128}),), ())
    end = simulate(plan, step=0.1, stop=0.2).trajectory.end()
    assert (end["a.huge_out"], end["a.tiny_out"]) == (2**53 - 1, -128)
    with pytest.raises(SlaveError, match=r"output 'huge_out' must be at most 2\^53 in size .*, got 9007199254740993"):
        simulate(plan.with_value("a.huge", 2**53), step=0.1, stop=0.2)


def test_an_fmu_may_ask_to_end_the_run(tmp_path: Path) -> None:
    """That is no failure: the step in which it asked counts, and there is no other."""
    run = simulate(typed(tmp_path).with_value("a.ask_end", True))
    assert (run.status, run.steps) == ("ended", 1)
    assert run.ended_by == "component 'a' asks to end the run at t = 0.01 s"
    quits = 9  # of mixed2.c: discard, and terminated
    run = simulate(typed(tmp_path).with_value("m.fault", quits))
    assert (run.status, run.steps) == ("ended", 4)
    assert run.ended_by == "component 'm' asks to end the run at t = 0.0425 s"


@pytest.mark.parametrize(
    ("fault", "words"),
    [
        (
            "discard",
            r"fmi2DoStep answered discard, having reached t = 0\.0425 s; it says: it broke at 0\.04 s: why \[logStatusError",
        ),
        ("error", "fmi2DoStep answered error; it says: it broke"),
        ("fatal", "fmi2DoStep answered fatal; it says: it broke"),
        ("nan", "output 'y' must be finite, got nan"),
    ],
)
def test_failures_stop_at_the_last_good_point_with_the_fmu_s_log(tmp_path: Path, fault: str, words: str) -> None:
    plan = typed(tmp_path).with_value("m.fault", small_fmus.FAULTS[fault]).with_value("m.text", "why")
    with pytest.raises(SlaveError, match=words) as caught:
        simulate(plan)
    assert caught.value.partial.trajectory.t[-1] == pytest.approx(0.04)
    assert np.isfinite(caught.value.partial.trajectory.values).all()


def test_descriptions_that_break_the_rules_are_refused_with_file_and_line(tmp_path: Path) -> None:
    good = small_fmus.mixed(tmp_path)
    with zipfile.ZipFile(good) as archive:
        members = {name: archive.read(name) for name in archive.namelist()}
    text = members["modelDescription.xml"].decode()
    bomb = text.replace("<fmiModel", '<!DOCTYPE x [<!ENTITY a "a"><!ENTITY b "&a;&a;">]><fmiModel', 1)
    for changed, words in (
        (text[:200], "must be well-formed XML"),
        (bomb, "must have no document type declaration"),
        (text.replace('causality="input"', 'causality="both"', 1), "must keep the schema of FMI 2.0: line"),
        (text.replace('declaredType="Mode"', 'declaredType="Mood"', 1), "refers to 'Mood', which is not there"),
        (text.replace('Unknown index="2"', 'Unknown index="99"', 1), "refers to variable 99, it has 12"),
        (text.replace('factor="201.168"', 'factor="0"', 1), "unit 'furlong' must have a finite factor other than 0"),
        (text.replace('fmiVersion="2.0"', 'fmiVersion="1.0"'), "must keep the schema of FMI 1.0"),
        (text.replace("CoSimulation", "ModelExchange"), "its binary lacks the function fmi2SetTime"),
        (text.replace('modelIdentifier="mixed"', 'modelIdentifier="other"'), "must hold a binary for .*, other"),
    ):
        file = tmp_path / "bad.fmu"
        with zipfile.ZipFile(file, "w") as archive:
            for name, data in (members | {"modelDescription.xml": changed.encode()}).items():
                archive.writestr(name, data)
        with pytest.raises(ValueError, match=words) as caught:
            open_slave("s", str(file))
        assert "bad.fmu" in str(caught.value)
        assert "\n" not in str(caught.value)


def test_units_with_an_offset_are_shifted(tmp_path: Path) -> None:
    """Heights "uphill" count from 100 m."""
    m, a = small_fmus.mixed(tmp_path, unit_out="uphill"), small_fmus.arrays(tmp_path)
    plan = System(
        "s", (SystemComponent("m", str(m), {"u": 3.0}), SystemComponent("a", str(a))), (Connection(("m", "y"), ("a", "u[1]")),)
    )
    end = simulate(plan, step=0.01, stop=0.05, algorithm=Jacobi(0)).trajectory.end()
    assert (end["m.y"], end["a.y[1]"]) == (6, 106)


def test_an_output_whose_dependencies_are_not_stated_depends_on_every_input(tmp_path: Path) -> None:
    file = small_fmus.mixed(tmp_path)
    with zipfile.ZipFile(file) as archive:
        members = {name: archive.read(name) for name in archive.namelist()}
    with zipfile.ZipFile(file, "w") as archive:
        for name, data in members.items():
            archive.writestr(name, data.replace(b'index="2" dependencies=""', b'index="2"'))
    slave = open_slave("m", str(file))
    assert {s.name: row.all() for s, row in zip(slave.outputs, slave.description.feedthrough, strict=True)} == {
        "y": True, "count": False, "mode_out": False, "on_out": False,
    }  # fmt: skip
    slave.close()


def test_an_array_of_absurd_size_is_refused(tmp_path: Path) -> None:
    with zipfile.ZipFile(tmp_path / "bad.fmu", "w") as archive:
        archive.writestr("modelDescription.xml", small_fmus.ARRAYS.replace('Dimension start="3"', 'Dimension start="4000000000"'))
    with pytest.raises(ValueError, match="variable 'u' must have at most 1000000 elements, has 4000000000"):
        open_slave("s", str(tmp_path / "bad.fmu"))


def test_members_that_lie_outside_are_refused_on_every_system(tmp_path: Path) -> None:
    link = zipfile.ZipInfo("resources/link")
    link.create_system, link.external_attr = 3, 0o120777 << 16
    for member in ("/etc/x", "../x", "resources/../../x", "C:/x", "C:\\x", "resources\\..\\..\\x", "\\\\host\\share\\x", link):
        file = tmp_path / "bad.fmu"
        with zipfile.ZipFile(file, "w") as archive:
            archive.writestr("modelDescription.xml", "<x/>")
            archive.writestr(member, "content")
        with pytest.raises(ValueError, match=r"bad\.fmu': member .* (must lie inside the archive|is a symbolic link)"):
            open_slave("s", str(file))
    assert [p.name for p in tmp_path.iterdir()] == ["bad.fmu"]


def test_a_program_that_forgets_to_close_leaves_no_temporary_folder(tmp_path: Path) -> None:
    code = "import sys; from gyro_cosim.slaves import open_slave; a = open_slave('a', sys.argv[1]); a.initialize({}, 0.0, 1.0)"
    file = small_fmus.mixed(tmp_path)
    scratch = tmp_path / "scratch"
    scratch.mkdir()
    environment = {**os.environ, "TMPDIR": str(scratch), "PYTHONDONTWRITEBYTECODE": "1"}
    subprocess.run([sys.executable, "-c", code, str(file)], env=environment, check=True)
    assert list(scratch.iterdir()) == []
