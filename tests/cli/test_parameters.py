"""cosim params: every parameter as a table and as a file that the other commands read; numbers in the wrong unit are told."""

import threading
import time
import tomllib
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import small_fmus

from gyro_cosim import System, SystemComponent, simulate, system
from gyro_cosim.cli.alone import given_alone, single
from gyro_cosim.cli.parameters import rows, toml_text
from gyro_cosim.slaves import open_slave
from gyro_cosim.slaves.processes.listening import listen
from gyro_cosim.slaves.signal import Signal, told_unit
from gyro_cosim.ssp.parameter_files import read_parameters

RUN = ("--in-process", "--stop", "0.05")


def test_every_parameter_has_value_unit_bounds_source_and_meaning(
    cosim_json: Callable[..., Any], cosim: Callable[..., Any]
) -> None:
    found = cosim_json("params", "wheel-pair", "--set", "gyro.rotor_speed=200rpm")["parameters"]
    by_name = {row["name"]: row for row in found}
    row = by_name["gyro.rotor_speed"]
    assert row["value"] == pytest.approx(20.943951)
    assert (row["unit"], row["min"], row["max"], row["given"]) == ("rad/s", -2000, 2000, True)
    assert (row["source"], row["meaning"]) == ("fig. 4, top (100 rpm)", "spin of the rotor")
    assert by_name["vehicle.yaw_inertia"]["source"] == "Table 1 names it without a value, assumed, 0.003 to 0.007"
    assert all(row["kind"] == "parameter" for row in found)
    alone = cosim_json("params", "gyro_unit:linear", "--all")["parameters"]
    assert {"rotor_speed", "gimbal_angle", "yaw_rate"} <= {row["name"] for row in alone}
    code, out, _ = cosim("params", "vehicle")
    assert code == 0
    assert "forward speed" in out
    code, _, err = cosim("params", "wheel-pair", "--set", "gyro.rotor_sped=1")
    assert (code, "did you mean 'rotor_speed'" in err) == (2, True)


def test_the_file_to_edit_gives_back_what_it_was_written_from(
    cosim: Callable[..., Any], cosim_json: Callable[..., Any], tmp_path: Path
) -> None:
    """Unchanged it changes no bit; edited, in any unit, it counts, and --set goes before it."""
    plain, file = cosim_json("run", "wheel-pair", *RUN), tmp_path / "p.toml"
    assert cosim("params", "wheel-pair", "--toml", "p.toml")[0] == 0
    assert cosim_json("run", "wheel-pair", "--params", "p.toml", *RUN)["end"] == plain["end"]
    text = file.read_text()
    assert '[vehicle]\nspeed = "10.0 m/s"' in text
    file.write_text(text.replace('speed = "10.0 m/s"', 'speed = "72 km/h"'))
    wanted = cosim_json("run", "wheel-pair", "--set", "vehicle.speed=20", *RUN)["end"]
    assert cosim_json("run", "wheel-pair", "--params", "p.toml", *RUN)["end"] == wanted != plain["end"]
    assert cosim_json("run", "wheel-pair", "--params", "p.toml", "--set", "vehicle.speed=10", *RUN)["end"] == plain["end"]
    assert cosim_json("pack", "wheel-pair", "--params", "p.toml", "-o", "p.ssp")["file"] == "p.ssp"
    packed = cosim_json("params", "p.ssp")["parameters"]
    assert next(row["value"] for row in packed if row["name"] == "vehicle.speed") == 20


def test_all_types_arrays_and_strange_names_go_through_the_file(tmp_path: Path) -> None:
    m, a = str(small_fmus.mixed(tmp_path)), str(small_fmus.arrays(tmp_path))
    parts = (SystemComponent("sub/m.x", m, {"text": 'so "so"', "mode": "fast"}), SystemComponent("a", a, {"gain": "1 2 3"}))
    plan = System("kinds", parts, ())
    file = tmp_path / "p.toml"
    file.write_text(toml_text(plan, rows(plan)), encoding="utf-8")
    table = tomllib.loads(file.read_text(encoding="utf-8"))
    assert table["sub/m.x"]["text"] == 'so "so"'
    assert table["a"]["gain"] == [1.0, 2.0, 3.0]
    again = System("kinds", tuple(SystemComponent(p.name, p.source) for p in parts), ())
    for target, value in read_parameters(file, again):
        again = again.with_value(target, value)
    assert [(r.label, r.value) for r in rows(again)] == [(r.label, r.value) for r in rows(plan)]


def test_a_single_component_s_file_has_no_tables_and_a_parameter_set_of_ssp_is_read_too(tmp_path: Path) -> None:
    plan = single("gyro_unit:linear")
    text = toml_text(plan, rows(plan, alone=True))
    assert "[" not in text.replace("[1]", "")
    file = tmp_path / "g.toml"
    file.write_text('rotor_speed = "300 rpm"\n')
    assert read_parameters(file, plan) == [("gyro_unit.rotor_speed", "300 rpm")]
    ssv = tmp_path / "p.ssv"
    ssv.write_text(
        '<ssv:ParameterSet version="1.0" name="p" xmlns:ssv="http://ssp-standard.org/SSP1/SystemStructureParameterValues">'
        '<ssv:Parameters><ssv:Parameter name="gyro.rotor_speed"><ssv:Real value="200" unit="rpm"/></ssv:Parameter>'
        '<ssv:Parameter name="vehicle.speed"><ssv:Real value="12"/></ssv:Parameter></ssv:Parameters></ssv:ParameterSet>'
    )
    pair = system("wheel-pair")
    for target, value in read_parameters(ssv, pair):
        pair = pair.with_value(target, value)
    wanted = system("wheel-pair").with_value("gyro.rotor_speed", "200rpm").with_value("vehicle.speed", 12)
    ends = [simulate(p, stop=0.02, in_process=True).trajectory.end() for p in (pair, wanted)]
    assert ends[0] == ends[1]


@pytest.mark.parametrize(
    ("name", "text", "words"),
    [
        ("p.toml", "speed = 3", r"p\.toml': names must be COMPONENT.PARAMETER with a component of 'wheel-pair', got 'speed'"),
        ("p.toml", "[gyros]\nrotor_speed = 3", r"p\.toml': names must be .*, got 'gyros.rotor_speed' \(did you mean 'gyro'\?\)"),
        (
            "p.toml",
            "[gyro]\nrotor_speed = 2026-01-01",
            r"p\.toml': gyro.rotor_speed must be a number, text, truth value or a list",
        ),
        ("p.toml", "[gyro]\nrotor_speed = []", r"gyro.rotor_speed must be a number"),
        ("p.toml", "[gyro", r"p\.toml' must be TOML: "),
        ("p.json", "", r"parameter file must end in .toml or .ssv, got"),
        ("p.ssv", "<x/>", r"p\.ssv' must hold an SSP ParameterSet, got 'x'"),
    ],
)
def test_a_file_that_does_not_fit_is_refused_with_file_and_key(tmp_path: Path, name: str, text: str, words: str) -> None:
    (tmp_path / name).write_text(text)
    with pytest.raises(ValueError, match=words):
        read_parameters(tmp_path / name, system("wheel-pair"))


def test_a_misspelt_parameter_of_a_file_has_its_nearest_name(cosim: Callable[..., Any], tmp_path: Path) -> None:
    (tmp_path / "p.toml").write_text("[gyro]\nrotor_sped = 3")
    code, _, err = cosim("run", "wheel-pair", "--params", "p.toml", *RUN)
    assert (code, "unknown parameter of 'gyro': 'rotor_sped'; did you mean 'rotor_speed'" in err) == (2, True)
    for command in ("run", "converge", "compare", "delay", "sweep", "pack", "params"):
        code, _, err = cosim(command, "wheel-pair", "--params", "q.toml")
        assert (code, err) == (2, "cosim: parameter file 'q.toml' cannot be read: No such file or directory\n")


SPIN = Signal("spin", "parameter", "rad/s", 10.472, display="rpm")
SPEED = Signal("speed", "parameter", "m/s", 10.0, display="km/h")


@pytest.mark.parametrize(
    ("signal", "given", "told"),
    [
        (SPIN, "2000", "2000 rad/s = 19099 rpm"),
        (SPIN, 100, "100 rad/s = 954.93 rpm"),  # what the start value is in rpm
        (SPEED, "80", "80 m/s = 288 km/h"),
        (Signal("y", "state", "m", 0.001, display="mm"), "3", "3 m = 3000 mm"),
        (Signal("y", "state", "rad", None, display="deg", nominal=0.1), "20", "20 rad = 1145.9 deg"),
        (SPIN, "2000rpm", ""),  # a unit was written
        (SPIN, "20", ""),  # twice the usual speed
        (SPIN, "0", ""), (SPIN, "off", ""), (SPIN, True, ""), (SPIN, "-15", ""),
        (SPIN, "0.001", ""),  # far, but rpm would be farther
        (SPEED, "36", ""),  # fast in either unit, 10 m/s being usual
        (Signal("spin", "parameter", "rad/s", 10.472), "2000", ""),  # nobody reads it in another unit
        (Signal("spin", "parameter", "rad/s", 0.0, display="rpm"), "2000", ""),  # no usual size is known
    ],
)  # fmt: skip
def test_a_bare_number_is_told_where_the_unit_people_read_was_meant(signal: Signal, given: object, told: str) -> None:
    assert told_unit(signal, given) == told


def test_run_tells_a_bare_number_in_process_and_as_an_fmu(cosim_json: Callable[..., Any]) -> None:
    for way in ((), ("--in-process",)):
        (note,) = cosim_json("run", "wheel-pair", "--set", "gyro.rotor_speed=1900", "--stop", "0.002", *way)["notes"]
        assert note == "gyro.rotor_speed=1900: 1900 rad/s = 18144 rpm (a number without a unit is in rad/s)"
    assert cosim_json("run", "wheel-pair", "--set", "gyro.rotor_speed=1900rpm", "--stop", "0.002", "--in-process")["notes"] == []


def test_info_describes_a_component(cosim_json: Callable[..., Any], cosim: Callable[..., Any]) -> None:
    found = cosim_json("info", "gyro_unit:linear")
    assert found["component"] == "gyro_unit:linear"
    assert {"name": "yaw_rate", "causality": "input", "unit": "rad/s"}.items() <= found["variables"][0].items()
    assert {"output": "pitch_moment", "inputs": ["pitch_rate"]} in found["direct_feedthrough"]
    code, out, _ = cosim("info", "vehicle")
    assert code == 0
    assert out.startswith("vehicle:wheel_pair (cosim params vehicle:wheel_pair says where its values come from)")
    code, _, err = cosim("info", "vehicle:lrtt")
    assert (code, err) == (2, "cosim: unknown variant of vehicle 'lrtt'; did you mean 'lrt'?\n")


def test_a_component_is_exported_with_values_of_the_users_own(cosim: Callable[..., Any], cosim_json: Callable[..., Any],
                                                              tmp_path: Path) -> None:  # fmt: skip
    """The FMU starts with them: a run of it gives the bits of one that is given the values."""
    (tmp_path / "own.toml").write_text("[gyro_unit]\ngimbal_damping = '2e-3 N.m.s/rad'\n")
    options = ("--params", str(tmp_path / "own.toml"), "--set", "rotor_speed=200rpm")
    made = cosim_json("export", "gyro_unit:linear", *options, "-o", str(tmp_path))
    (file,) = made["files"]
    found = {row["name"]: row["value"] for row in cosim_json("params", file)["parameters"]}
    assert (found["gimbal_damping"], found["rotor_speed"]) == (2e-3, pytest.approx(20.943951))
    plan = system("wheel-pair").with_value("gyro.rotor_speed", found["rotor_speed"]).with_value("gyro.gimbal_damping", 2e-3)
    of = [simulate(one, stop=0.2).trajectory for one in (plan, system("wheel-pair").with_source("gyro", file))]
    given = set(plan.components[1].values) | set(plan.components[0].values)
    assert {"rotor_speed", "gimbal_damping"} <= given
    np.testing.assert_array_equal(of[1].values, of[0].values)


def test_values_that_a_component_cannot_start_with_are_refused(cosim: Callable[..., Any], tmp_path: Path) -> None:
    for value, words in (
        ("rotor_sped=3", "did you mean 'rotor_speed'"),
        ("rotor_speed=3m", "unit 'm' cannot be expressed in 'rad/s'"),
        ("rotor_inertia=-1", "rotor_inertia: must be at least 0 kg.m2, got -1"),
        ("tolerance=0.1", "an FMU starts with equal internal steps"),
        ("gyro_unit=nonlinear", "not exchange it for gyro_unit:nonlinear"),
    ):
        code, _, err = cosim("export", "gyro_unit:linear", "--set", value, "-o", str(tmp_path / "none"))
        assert (code, words in err) == (2, True), err
    assert not (tmp_path / "none").exists()


def test_a_unit_is_served_with_values_that_count_where_a_master_gives_none() -> None:
    values = given_alone("gyro_unit:linear", ["rotor_speed=200rpm", "gimbal_damping=2e-3"], None)
    slave, ports = open_slave("unit", "gyro_unit:linear", in_process=True), []
    thread = threading.Thread(
        target=listen, args=(slave, ("127.0.0.1", 0)), kwargs={"once": True, "ready": ports.append, "values": values}
    )
    thread.start()
    while not ports:
        time.sleep(1e-3)
    there = system("wheel-pair").with_source("gyro", f"tcp://127.0.0.1:{ports[0]}").with_value("gyro.rotor_speed", 5.0)
    done = simulate(there, stop=0.1, in_process=True).trajectory
    thread.join(10.0)
    slave.close()
    here = system("wheel-pair").with_value("gyro.rotor_speed", 5.0).with_value("gyro.gimbal_damping", 2e-3)
    np.testing.assert_array_equal(done.values, simulate(here, stop=0.1, in_process=True).trajectory.values)


def test_info_shows_a_system_with_what_the_command_makes_of_it(cosim_json: Callable[..., Any], cosim: Callable[..., Any]) -> None:
    plain, changed = (cosim_json("info", "wheel-pair", *more) for more in ((), ("--gyro", "multibody")))
    assert plain != changed
    code, _, err = cosim("info", "gyro_unit:linear", "--set", "rotor_speed=3")
    assert (code, "--set must be given with a system, 'gyro_unit:linear' is none" in err) == (2, True)
