"""The command line: documents, files, exit codes and one-line errors."""

import json
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import oscillators
import pytest

from gyro_cosim.systems import catalogue
from gyro_cosim.trajectory import read_csv

RUN = ("run", "wheel-pair", "--stop", "0.5")


def test_list_names_what_is_installed(cosim_json: Callable[..., Any], cosim: Callable[..., Any]) -> None:
    document = cosim_json("list")
    assert "wheel-pair" in document["systems"]
    assert {"linear", "nonlinear"} <= set(document["components"]["gyro_unit"])
    assert document["algorithms"]["jacobi"] == [1, 2, 3]
    code, out, _ = cosim("list")
    assert code == 0
    assert all(name in out for name in ("wheel-pair", "nonlinear", "gauss-seidel"))


def test_run_tells_what_it_did(cosim_json: Callable[..., Any]) -> None:
    document = cosim_json(*RUN, "--gyro", "linear", "--set", "gyro.rotor_speed=200rpm", "--step", "1ms")
    assert document["system"] == "wheel-pair"
    assert (document["step"], document["steps"], document["algorithm"], document["degree"]) == (1e-3, 500, "jacobi", 1)
    assert set(document["timing"]["do_step_s"]) == {"vehicle", "gyro"}
    assert abs(document["energy_residual"]) < 1e-6
    assert document["units"]["vehicle.yaw_angle"] == "rad"
    from gyro_cosim.accuracy.monolith import Monolith
    from gyro_cosim.ssp import system

    exact = Monolith(system("wheel-pair").with_value("gyro.rotor_speed", "200rpm")).solve(np.array([0.0, 0.5])).end()
    for name, value in exact.items():
        assert document["end"][name] == pytest.approx(value, rel=1e-3, abs=1e-9)  # second order at 1 ms


def test_defaults_are_the_papers_case(cosim_json: Callable[..., Any]) -> None:
    plain = cosim_json("run", "wheel-pair", "--in-process", "--stop", "2")
    stated = cosim_json(
        "run", "wheel-pair", "--in-process", "--stop", "2", "--gyro", "linear", "--step", "1ms",
        "--set", "vehicle.speed=36km/h", "--set", "vehicle.lateral_displacement=1mm", "--set", "vehicle.yaw_angle=0.314",
        "--set", "gyro.rotor_speed=100rpm", "--set", "vehicle.yaw_inertia=0.006", "--set", "vehicle.wheel_load=14.42N",
        "--set", "gyro.spring_arm=1",
    )  # fmt: skip
    for name, value in plain["end"].items():
        assert stated["end"][name] == pytest.approx(value, rel=1e-12)


def test_run_writes_what_it_is_told_to(cosim: Callable[..., Any]) -> None:
    code, out, err = cosim(*RUN, "--output", "a.csv", "--plot", "a.png", "--gyro", "nonlinear", "--algorithm", "gauss-seidel",
                           "--order", "2", "--sequence", "gyro,vehicle")  # fmt: skip
    assert (code, err) == (0, "")
    for words in ("gyro_unit:nonlinear", "gauss-seidel, input degree 2", "500 macro steps of 1 ms", "coupling energy residual"):
        assert words in out
    assert len(read_csv("a.csv")) == 501
    assert Path("a.png").read_bytes().startswith(b"\x89PNG")


def test_a_gyro_can_be_an_fmu_file_or_a_python_file(cosim_json: Callable[..., Any], tmp_path: Path) -> None:
    files = cosim_json("export", "gyro_unit:linear", "-o", str(tmp_path))["files"]
    built_in = cosim_json(*RUN)["end"]
    assert cosim_json(*RUN, "--gyro", files[0])["end"] == built_in
    file = tmp_path / "mine.py"
    file.write_text("from gyro_cosim.gyro_unit.linear import linear_small as component\n")
    assert cosim_json(*RUN, "--gyro", str(file))["end"] == built_in


def test_converge_measures_the_order(cosim_json: Callable[..., Any], cosim: Callable[..., Any]) -> None:
    options = ("converge", "wheel-pair", "--stop", "1.6", "--rungs", "3")
    document = cosim_json(*options)
    assert document["reference"] == "matrix exponential"
    assert {(row["algorithm"], row["degree"]) for row in document["algorithms"]} == {
        (name, degree) for name in ("jacobi", "gauss-seidel") for degree in range(3)
    }
    for row in document["algorithms"]:
        assert len(row["errors"]) == len(row["steps"]) == 3
        assert row["observed_order"] == pytest.approx(row["degree"] + 1, abs=0.15)
    code, out, _ = cosim(
        *options, "--algorithm", "jacobi", "--order", "1", "--gyro", "nonlinear", "--in-process", "--plot", "c.png"
    )
    assert code == 0
    assert "DOP853" in out
    assert Path("c.png").is_file()


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (("run", "nothing"), "unknown system 'nothing'; known: "),
        (("run", "nothing.ssd"), "'nothing.ssd' cannot be read"),
        (("run", "wheel-pair", "--gyro", "liner"), "unknown variant of gyro_unit 'liner'; did you mean 'linear'?"),
        (("run", "wheel-pair", "--gyro", "gone.fmu"), "FMU 'gone.fmu' must exist"),
        (("run", "wheel-pair", "--gyro", "gone.py"), "component file 'gone.py' must exist"),
        (("run", "wheel-pair", "--set", "giro.rotor_speed=1"), "unknown component of system 'wheel-pair': 'giro'"),
        (
            ("run", "wheel-pair", "--set", "gyro.rotorspeed=1"),
            "unknown parameter of 'gyro': 'rotorspeed'; did you mean 'rotor_speed'",
        ),
        (("run", "wheel-pair", "--set", "gyro.rotor_speed=1kg"), "gyro.rotor_speed: unit 'kg' cannot be expressed in 'rad/s'"),
        (("run", "wheel-pair", "--set", "gyro.rotor_speed=1furlong"), "gyro.rotor_speed: unknown unit 'furlong'"),
        (("run", "wheel-pair", "--set", "vehicle.speed=0"), "vehicle.speed: must be at least 0.1 m/s, got 0"),
        (("run", "wheel-pair", "--set", "vehicle.speed=nan"), "vehicle.speed: must be finite, got nan"),
        (
            ("run", "wheel-pair", "--set", "vehicle.speed"),
            "--set must be COMPONENT.PARAMETER=VALUE or COMPONENT=VARIANT, got 'vehicle.speed'",
        ),
        (("run", "wheel-pair", "--step", "0"), "`step` must be positive, got 0 s"),
        (("run", "wheel-pair", "--step", "2", "--stop", "1"), "`step` must be at most the run's length of 1 s, got 2 s"),
        (("run", "wheel-pair", "--step", "1kg"), "--step unit 'kg' cannot be expressed in 's'"),
        (("run", "wheel-pair", "--algorithm", "magic"), "nepce, iterated, newton, got 'magic'"),
        (("run", "wheel-pair", "--order", "3"), "degree must be 0, 1 or 2, got 3"),
        (("run", "wheel-pair", "--sequence", "vehicle,gyro"), "a sequence of components goes with gauss-seidel only"),
        (("run", "wheel-pair", "--output", "no/where.csv"), "the folder of 'no/where.csv' must exist"),
        (("run", "wheel-pair", "--output", "a.xls"), "output file must end in .csv, .mat, .parquet or .mf4, got 'a.xls'"),
        (("run", "wheel-pair", "--plot", "a.docx"), "plot file must end in one of"),
        (("run", "wheel-pair", "--frobnicate"), "No such option: --frobnicate"),
        (("run",), "Missing argument 'SYSTEM'"),
        (("frobnicate",), "No such command 'frobnicate'"),
        (("export", "gyro"), "unknown component 'gyro'; did you mean 'gyro_unit'?"),
        (("export", "gyro_unit:cubic"), "unknown variant of gyro_unit 'cubic'"),
        (("export", "gyro_unit", "--fmi", "4"), "--fmi must be 2, 3 or both, got '4'"),
        (("export", "gyro_unit", "--platform", "amiga"), "amiga"),
        (
            ("converge", "wheel-pair", "--stop", "1", "--step", "0.3"),
            "`stop` must be a multiple of the coarsest step 0.3 s, got 1 s",
        ),
        (("converge", "wheel-pair", "--order", "x"), "--degree must be degrees such as 0,1,2, got 'x'"),
    ],
)
def test_wrong_use_is_one_line_and_exit_code_2(cosim: Callable[..., Any], arguments: tuple[str, ...], words: str) -> None:
    code, out, err = cosim(*arguments)
    assert code == 2
    assert out == ""
    assert words in err
    assert err.count("\n") == 1
    assert list(Path().iterdir()) == []  # nothing half-done is left behind


def test_a_failed_run_is_exit_code_1_and_keeps_its_results(cosim: Callable[..., Any], tmp_path: Path) -> None:
    file = tmp_path / "s.ssd"
    text = catalogue.systems()["wheel-pair"].read_text()
    # The clock of the tests stands where the vehicle was, alone.
    start, end = text.index("<ssd:Connections>"), text.index("</ssd:System>")
    text = text[:start] + "<ssd:Connections/>" + text[end:]
    file.write_text(text)
    code, _, err = cosim("run", str(file), "--set", "vehicle.speed=10", "--gyro", f"{oscillators.HERE}:fails", "--step", "0.1",
                         "--stop", "1", "--output", "kept.csv")  # fmt: skip
    assert code == 1
    assert "component 'gyro' failed at t = " in err
    assert "kept.csv" in err
    assert read_csv("kept.csv").t[-1] == pytest.approx(0.5)


def test_paper_prints_the_ledger_and_draws_the_figures(cosim_json: Callable[..., Any], cosim: Callable[..., Any]) -> None:
    document = cosim_json("paper", "-o", "out", "--only-wheel-pair")
    claims = {claim["id"]: claim for claim in document["claims"]}
    assert set(claims) >= {"C1", "C2", "C3", "C4"}
    for claim in claims.values():
        assert claim["verdict"].startswith(("reproduced", "partly", "not reproduced"))
        assert claim["measured"]
    for name in ("figure_2.png", "figure_3.png", "figure_4.png", "damping_map.png"):
        assert (Path("out") / name).read_bytes().startswith(b"\x89PNG")
    assert json.loads((Path("out") / "ledger.json").read_text())["claims"] == document["claims"]
    assert "| C4 |" in (Path("out") / "ledger.md").read_text()


def test_a_certified_run_tells_how_right_it_is(cosim_json: Callable[..., Any], cosim: Callable[..., Any]) -> None:
    certificate = cosim_json(*RUN, "--certify", "--step", "5ms")["certificate"]
    assert certificate["observed_order"] == pytest.approx(2.0, abs=0.2)
    assert certificate["stability"]["stable"]
    assert 0.05 < certificate["stability"]["largest_stable_step"] < 0.5
    assert 0.0 < certificate["errors"]["vehicle.yaw_angle"]["largest"] < 1e-3
    code, out, _ = cosim(*RUN, "--certify", "--in-process")
    assert code == 0
    assert "largest stable step" in out


def test_options_of_the_run_reach_it(cosim_json: Callable[..., Any], cosim: Callable[..., Any]) -> None:
    adapted = cosim_json(*RUN, "--adaptive", "1e-3", "--in-process", "--step", "0.1")
    assert adapted["steps"] < 100
    iterated = cosim_json(*RUN, "--algorithm", "newton", "--substeps", "gyro=2", "--step", "10ms", "--loops", "refuse")
    assert iterated["iterations"] >= iterated["steps"] == 50
    code, _, err = cosim(*RUN, "--select", "vehicle.yaw_*", "--record-every", "100", "--output", "a.csv")
    assert code == 0, err
    thin = read_csv("a.csv")
    assert thin.names == ("vehicle.yaw_angle", "vehicle.yaw_rate")
    np.testing.assert_allclose(thin.t, [0.0, 0.1, 0.2, 0.3, 0.4, 0.5])


def test_a_run_goes_on_from_its_checkpoint(cosim: Callable[..., Any]) -> None:
    options = ("run", "wheel-pair", "--stop", "2", "--checkpoint", "c.npz", "--every", "0.5s")
    assert cosim(*options, "--output", "whole.csv")[0] == 0
    whole = Path("whole.csv").read_bytes()
    Path("whole.csv").write_bytes(whole[: len(whole) // 10 * 9] + b"rubbish of a killed run")  # beyond the last checkpoint
    code, _, err = cosim("run", "wheel-pair", "--stop", "2", "--resume", "c.npz", "--output", "whole.csv")
    assert code == 0, err
    assert Path("whole.csv").read_bytes() == whole


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (("--substeps", "gyro"), "--substeps must be COMPONENT=N, got 'gyro'"),
        (("--substeps", "giro=2"), "unknown component with sub-steps: 'giro'; did you mean 'gyro'?"),
        (("--loops", "ignore"), "--loops must be solve or refuse, got 'ignore'"),
        (("--adaptive", "0"), "tolerance must be positive, got 0.0"),
        (("--adaptive", "1e-3", "--algorithm", "nepce"), "NEPCE needs even macro steps"),
        (("--record-every", "0"), "`every` must be a whole number of at least 1, got 0"),
        (("--select", "vehicle.yaw"), "unknown signal to record: 'vehicle.yaw'"),
        (("--certify", "--record-every", "2"), "--certify needs all results of the whole run"),
        (("--resume", "gone.npz"), "checkpoint 'gone.npz' must exist"),
    ],
)
def test_wrong_options_of_a_run_are_one_line(cosim: Callable[..., Any], arguments: tuple[str, ...], words: str) -> None:
    code, _, err = cosim(*RUN, *arguments)
    assert code == 2
    assert words in err
    assert err.count("\n") == 1
