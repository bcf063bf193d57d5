"""Another field registers what it says of a run, and a command, through entry points; the command line names none."""

import ast
import json
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

import gyro_cosim.cli
from gyro_cosim.cli import assessments

FIELD = '''
from gyro_cosim import figures


class Spin:
    key = "rotors"

    def assess(self, trajectory):
        return [n for n in trajectory.names if n.endswith("gimbal_angle")]

    def lines(self, finding):
        return ["", f"rotor of {finding}: in balance"]

    def document(self, finding):
        return {"signal": finding, "imbalance_kg_m": float("nan")}

    def figure(self, finding, trajectory, title):
        return figures.time_histories(trajectory, [finding], "drawn by Spin")


SPIN = Spin()


def balance(rotor: str) -> int:
    """Balance a rotor."""
    print(f"balanced {rotor}")
    return 0


def run() -> int:
    """Not the one that is built in."""
    return 3
'''
RUN = ("run", "wheel-pair", "--stop", "0.2", "--in-process")


@pytest.fixture
def register(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Callable[[str], None]:
    """Installs a distribution with the module `spin` and these entry points."""

    def install(entries: str) -> None:
        site = tmp_path / "site"
        (site / "spin-1.0.dist-info").mkdir(parents=True)
        (site / "spin.py").write_text(FIELD)
        (site / "spin-1.0.dist-info" / "METADATA").write_text("Metadata-Version: 2.1\nName: spin\nVersion: 1.0\n")
        (site / "spin-1.0.dist-info" / "entry_points.txt").write_text(entries)
        monkeypatch.syspath_prepend(str(site))
        monkeypatch.delitem(sys.modules, "spin", raising=False)

    return install


def test_the_railway_is_registered_and_says_nothing_of_a_wheel_pair(cosim_json: Callable[..., Any]) -> None:
    assert [field.key for field in assessments.fields()] == ["vehicles"]
    assert cosim_json(*RUN)["vehicles"] == []


def test_a_second_field_stands_beside_it(register: Callable[[str], None], cosim: Callable[..., Any]) -> None:
    register("[gyro_cosim.assessments]\nspin = spin:SPIN\n")
    code, out, err = cosim(*RUN, "--plot", "a.png")
    assert code == 0, err
    assert "rotor of gyro.gimbal_angle: in balance" in out
    code, plain, err = cosim(*RUN, "--json")
    assert code == 0, err
    document = json.loads(plain, parse_constant=pytest.fail)
    assert document["rotors"] == [{"signal": "gyro.gimbal_angle", "imbalance_kg_m": None}]
    assert document["vehicles"] == []


def test_the_figure_of_a_field_takes_the_place_of_time_histories(
    register: Callable[[str], None], cosim: Callable[..., Any], monkeypatch: pytest.MonkeyPatch
) -> None:
    from gyro_cosim import figures

    titles: list[str] = []
    plain = figures.time_histories
    monkeypatch.setattr(figures, "time_histories", lambda *a: titles.append(a[2]) or plain(*a))
    assert cosim(*RUN, "--plot", "a.png")[0] == 0
    register("[gyro_cosim.assessments]\nspin = spin:SPIN\n")
    assert cosim(*RUN, "--plot", "a.png")[0] == 0
    assert titles == ["wheel-pair: vehicle = vehicle:wheel_pair, gyro = gyro_unit:linear", "drawn by Spin"]


@pytest.mark.parametrize(
    ("value", "words"),
    [
        ("spin:NOTHING", "assessment 'spin' (spin:NOTHING) cannot be loaded: "),
        ("gone:SPIN", "assessment 'spin' (gone:SPIN) cannot be loaded: No module named 'gone'"),
        ("spin:balance", "assessment 'spin' (spin:balance) must have 'key', function has none"),
    ],
)
def test_a_field_that_cannot_be_used_is_one_line(
    value: str, words: str, register: Callable[[str], None], cosim: Callable[..., Any]
) -> None:
    register(f"[gyro_cosim.assessments]\nspin = {value}\n")
    code, _, err = cosim(*RUN)
    assert (code, err.count("\n")) == (1, 1)
    assert words in err


def test_a_key_that_is_taken_is_refused(register: Callable[[str], None], cosim: Callable[..., Any]) -> None:
    register("[gyro_cosim.assessments]\nagain = gyro_cosim.railway.field:RAILWAY\n")
    code, _, err = cosim(*RUN)
    assert (code, err) == (1, "cosim: the key of an assessment must be its own, 'vehicles' is taken\n")


def test_a_field_brings_a_command_and_takes_none_of_ours(
    register: Callable[[str], None], cosim: Callable[..., Any], capsys: pytest.CaptureFixture[str]
) -> None:
    register("[gyro_cosim.commands]\nbalance = spin:balance\nrun = spin:run\n")
    assert cosim("balance", "front") == (0, "balanced front\n", "")
    help_ = cosim("--help")[1]
    assert all(name in help_ for name in ("balance", "Balance a rotor.", "paper"))
    assert "Not the one that is built in" not in help_
    assert cosim(*RUN)[0] == 0


def test_only_the_commands_of_a_field_import_it() -> None:
    folder = Path(gyro_cosim.cli.__file__).parent
    for file in folder.glob("*.py"):
        tree = ast.walk(ast.parse(file.read_text()))
        names = {node.module or "" for node in tree if isinstance(node, ast.ImportFrom)}
        assert file.name == "assess.py" or not any(name.split(".")[0] == "railway" for name in names), file
        assert file.name == "paper.py" or not any(name.split(".")[0] == "paper" for name in names), file
