"""Options mean the same in every command; those without effect are refused; 0 is a value."""

import json
import zipfile
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest
import small_fmus

from gyro_cosim import system
from gyro_cosim.cli.settings import read_settings, split_variants

RUN = ("run", "wheel-pair", "--stop", "0.1", "--in-process")


# ---- --set ------------------------------------------------------------------------------------------------------------


def test_one_parser_reads_values_and_variants() -> None:
    pair = system("wheel-pair")
    found = read_settings(
        ["gyro.rotor_speed=200rpm", "gyro=linear,hil, rate_delay=5ms,tcp://h:1?late=stop", "vehicle.speed = 5"], pair
    )
    assert found.values == (("gyro.rotor_speed", "200rpm"), ("vehicle.speed", "5"))
    assert found.variants == {"gyro": ("linear", "hil,rate_delay=5ms", "tcp://h:1?late=stop")}
    assert split_variants("a,x=1,y[2]=3,b") == ("a,x=1,y[2]=3", "b")


def test_set_swaps_a_variant_in_run_as_gyro_does(cosim_json: Callable[..., Any]) -> None:
    by_option, by_set = (cosim_json(*RUN, *words) for words in (("--gyro", "nonlinear"), ("--set", "gyro=nonlinear")))
    assert by_set["components"]["gyro"] == by_option["components"]["gyro"] == "gyro_unit:nonlinear"
    assert by_set["end"] == by_option["end"]
    own = cosim_json(*RUN, "--set", "gyro=nonlinear,rotor_speed=300rpm")
    assert own["end"] == cosim_json(*RUN, "--gyro", "nonlinear", "--set", "gyro.rotor_speed=300rpm")["end"] != by_set["end"]


def test_set_names_the_variants_of_a_comparison_and_of_a_sweep(cosim: Callable[..., Any]) -> None:
    documents = []
    for words in (("--set", "gyro=nonlinear,linear"), ("--gyro", "nonlinear", "--variant", "linear")):
        code, out, err = cosim("compare", *RUN[1:], *words, "--set", "vehicle.yaw_angle=0.02", "--json")
        assert code in (0, 1), err
        documents.append(json.loads(out))
    assert [v["variant"] for v in documents[0]["variants"]] == ["nonlinear", "linear"]
    assert documents[0]["component"] == "gyro"
    assert [v["signals"] for v in documents[0]["variants"]] == [v["signals"] for v in documents[1]["variants"]]
    code, _, err = cosim("sweep", "wheel-pair", "--stop", "0.02", "--set", "gyro=nonlinear,linear", "--output", "s.csv")
    assert code == 0, err
    assert {line.split(",")[1] for line in Path("s.csv").read_text().splitlines()[-2:]} == {"nonlinear", "linear"}


# ---- --degree ---------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("option", ["--degree", "--order"])
def test_degree_has_its_old_name_in_every_command(option: str, cosim: Callable[..., Any]) -> None:
    for command, given, expected in (
        (RUN, "2", lambda d: d["degree"] == 2),
        (("converge", "wheel-pair", "--rungs", "2", "--algorithm", "jacobi", "--stop", "0.8"), "0,2",
         lambda d: [row["degree"] for row in d["algorithms"]] == [0, 2]),
        (("compare", *RUN[1:], "--gyro", "linear,rotor_speed=1rpm", "--gyro", "linear,rotor_speed=1rpm"), "2",
         lambda d: d["degree"] == 2),
        (("delay", "wheel-pair", "--step", "50ms", "--stop", "1", "--longest", "50ms"), "0", lambda d: d["degree"] == 0),
    ):  # fmt: skip
        code, out, err = cosim(*command, option, given, "--json")
        assert code == 0, err
        assert expected(json.loads(out))
    code, _, err = cosim("sweep", "wheel-pair", "--stop", "0.02", option, "0,1", "--output", f"{option[2:]}.csv")
    assert code == 0, err


# ---- what has no effect, and what is 0 --------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        ((*RUN, "--isolate"), "--isolate has no effect with --in-process where no component is an FMU file"),
        ((*RUN, "--estimate", "energy"), "--estimate has no effect without --adaptive, got 'energy'"),
        ((*RUN, "--estimate", "magic"), "--estimate must be one of doubling, energy, got 'magic'"),
        ((*RUN, "--overrun", "skip"), "--overrun has no effect without --realtime, got 'skip'"),
        ((*RUN, "--overrun", "wait"), "--overrun must be one of count, skip, stop, got 'wait'"),
        ((*RUN, "--priority", "5"), "--priority has no effect without --realtime, got 5"),
        ((*RUN, "--priority", "100"), "--priority must be 1 to 99, got 100"),
        ((*RUN, "--every", "1s"), "--every has no effect without --checkpoint, got '1s'"),
        ((*RUN, "--every", "1kg"), "--every unit 'kg' cannot be expressed in 's'"),
        ((*RUN, "--checkpoint", "c.npz", "--every", "0"), "the time between checkpoints must be positive, got 0 s"),
        ((*RUN, "--substeps", "gyro=-1"), "--substeps must be COMPONENT=N, got 'gyro=-1'"),
        ((*RUN, "--set", "gyro=linear,nonlinear"), "--set gyro must be one variant here (compare and sweep take several), got"),
        ((*RUN, "--set", "gyro=linear", "--gyro", "off"), "--gyro is short for --set gyro=VARIANT: give one of the two"),
        ((*RUN, "--set", "gyro=linear", "--set", "gyro=off"), "--set must name the variants of component 'gyro' once"),
        ((*RUN, "--set", "gyro="), "--set must be COMPONENT.PARAMETER=VALUE or COMPONENT=VARIANT, got 'gyro='"),
        ((*RUN, "--set", "gear=linear"), "unknown component of system 'wheel-pair': 'gear'"),
        (("sweep", "wheel-pair", "--set", "gyro.rotor_speed=1,2", "--seed", "0"), "--seed has no effect without --lhs, got 0"),
        (
            ("sweep", "wheel-pair", "--set", "gyro.rotor_speed=1,2", "--workers", "2", "--scheduler", "tcp://h:1"),
            "--workers has no effect with --scheduler, got 2",
        ),
        (("sweep", "wheel-pair", "--set", "gyro=hil,rate_delay=1ms"), "a sweep takes variants of 'gyro' without values of their"),
        (("sweep", "wheel-pair", "--set", "gyro.rotor_speed="), "--set must be COMPONENT.PARAMETER=VALUES or"),
        (("sweep", "wheel-pair", "--set", "gyro.rotor_speed=1,2", "--step", "0"), "`step` must be positive, got 0 s"),
        (("paper", "--draws", "0", "--seed", "3"), "--seed has no effect without draws (--draws N), got 3"),
        (("compare", *RUN[1:3], "0", "--set", "gyro=linear,off"), "`stop`"),
        (("compare", *RUN[1:], "--step", "0", "--set", "gyro=linear,off"), "`step` must be positive, got 0 s"),
        (("compare", *RUN[1:], "--set", "gyro=linear,off", "--gyro", "off"), "--set gyro=... names the variants as --variant"),
        (("compare", *RUN[1:], "--set", "gyro=linear,off", "--set", "vehicle=a,b"), "compare exchanges one component, got"),
        (("compare", *RUN[1:], "--set", "gyro=linear,off", "--component", "vehicle"), "--component must be the one that --set"),
        (("delay", "wheel-pair", "--stop", "0"), "`stop`"),
        (("delay", "wheel-pair", "--step", "0"), "`step` must be positive, got 0 s"),
        (("delay", "wheel-pair", "--longest", "0"), "the longest delay must be at least the macro step of 0.01 s, got 0 s"),
        (("delay", "wheel-pair", "--map", "gyro.rotor_speed"), "--map must be COMPONENT.PARAMETER=LOW:HIGH:N or A,B,..."),
        (("converge", "wheel-pair", "--step", "0"), "--step must be positive, got 0"),
        (("converge", "wheel-pair", "--stop", "0"), "`stop` must be positive, got 0 s"),
        (("converge", "wheel-pair", "--degree", ","), "--degree must be degrees such as 0,1,2, got ','"),
    ],
)
def test_it_is_refused_in_one_line(arguments: tuple[str, ...], words: str, cosim: Callable[..., Any]) -> None:
    extra = ("--plot", "map.png") if "--map" in arguments else ()
    code, out, err = cosim(*arguments, *extra)
    assert (code, out, err.count("\n")) == (2, "", 1), err
    assert words in err
    assert list(Path().iterdir()) == []


def test_isolate_has_an_effect_where_a_component_is_an_fmu_file(cosim_json: Callable[..., Any]) -> None:
    (file,) = cosim_json("export", "gyro_unit:linear", "-o", ".")["files"]
    plain, isolated = (cosim_json(*RUN, "--gyro", file, *words) for words in ((), ("--isolate",)))
    assert plain["end"] == isolated["end"]


def test_a_system_that_names_nothing_to_exchange_needs_a_component(cosim: Callable[..., Any], tmp_path: Path) -> None:
    from gyro_cosim.systems import catalogue

    text = catalogue.systems()["wheel-pair"].read_text()
    note = next(line for line in text.splitlines(keepends=True) if "gc:Exchange" in line)
    (tmp_path / "silent.ssd").write_text(text.replace(note, ""))
    for command in (("compare", "silent.ssd", "--gyro", "linear", "--gyro", "off"), ("delay", "silent.ssd")):
        code, out, err = cosim(*command)
        assert (code, out, err.count("\n")) == (2, "", 1)
        assert "system 'wheel-pair' does not say which component is exchanged: name one (--component NAME)" in err
    code, _, err = cosim("compare", "silent.ssd", "--component", "gyro", "--gyro", "linear", "--gyro", "linear", "--stop", "0.1",
                         "--in-process")  # fmt: skip
    assert code == 0, err


def test_gyro_exchanges_what_the_system_says(cosim_json: Callable[..., Any], tmp_path: Path) -> None:
    from gyro_cosim.systems import catalogue

    text = catalogue.systems()["wheel-pair"].read_text().replace('"gyro"', '"damper"').replace('"gyro.', '"damper.')
    (tmp_path / "damped.ssd").write_text(text)
    found = cosim_json("run", "damped.ssd", *RUN[2:], "--gyro", "nonlinear")
    assert found["components"] == {"vehicle": "vehicle:wheel_pair", "damper": "gyro_unit:nonlinear"}
    swept = cosim_json("sweep", "damped.ssd", "--stop", "0.02", "--gyro", "nonlinear,linear", "--output", "s.csv")
    assert (swept["done"], swept["failed"]) == (2, 0)


def test_the_version_is_that_of_the_package(cosim: Callable[..., Any]) -> None:
    from importlib.metadata import version

    assert cosim("--version") == (0, f"gyro-cosim {version('gyro-cosim')}\n", "")


def test_plot_takes_patterns_of_names(cosim: Callable[..., Any]) -> None:
    assert cosim(*RUN, "--output", "a.csv")[0] == 0
    assert cosim("plot", "a.csv", "vehicle.yaw_*", "gyro.gimbal_angle")[0] == 0
    code, _, err = cosim("plot", "a.csv", "vehicle.yaw_angel")
    assert code == 2
    assert "unknown signal 'vehicle.yaw_angel'; did you mean 'vehicle.yaw_angle'?" in err


def test_info_loads_no_library(tmp_path: Path, cosim: Callable[..., Any], cosim_json: Callable[..., Any]) -> None:
    """It tells of an FMU, alone and in a system, whose library nobody can load; a run says why."""
    (tmp_path / "good").mkdir()
    bad = tmp_path / "bad.fmu"
    with zipfile.ZipFile(small_fmus.mixed(tmp_path / "good")) as source, zipfile.ZipFile(bad, "w") as target:
        for name in source.namelist():
            target.writestr(name, b"no library" if name.startswith("binaries/") else source.read(name))
    plan = tmp_path / "plan.ssd"
    plan.write_text(
        '<ssd:SystemStructureDescription xmlns:ssd="http://ssp-standard.org/SSP1/SystemStructureDescription" '
        'xmlns:ssc="http://ssp-standard.org/SSP1/SystemStructureCommon" name="p" version="1.0"><ssd:System name="top">'
        '<ssd:Elements><ssd:Component name="a" source="bad.fmu"/></ssd:Elements></ssd:System>'
        '<ssd:DefaultExperiment stopTime="1"/></ssd:SystemStructureDescription>'
    )
    assert cosim_json("info", str(bad))["model"] == "mixed"
    (found,) = cosim_json("info", str(plan))["components"]
    assert found["outputs"]
    code, _, err = cosim("run", str(plan), "--step", "0.1")
    assert code == 2
    assert "its binary cannot be loaded" in err
