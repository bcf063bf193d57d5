"""Who imports a name of before 0.2.0 is told the new one; whoever else uses such a name notices nothing."""

import importlib
import importlib.util
import json
import re
import subprocess
import sys
from importlib.machinery import ModuleSpec
from pathlib import Path
from types import ModuleType

import pytest

EXAMPLE = " (from gyro_cosim import simulate)"
IMPORTS = {  # statement -> what is missing, what it is called now
    "import cosim": ("cosim", "gyro_cosim"),
    "from cosim import Jacobi, simulate": ("cosim", "gyro_cosim"),
    "import vehicle": ("vehicle", "gyro_cosim.vehicle"),
    "import gyro_unit": ("gyro_unit", "gyro_cosim.gyro_unit"),
    "import component": ("component", "gyro_cosim.component"),
    "import fmus": ("fmus", "gyro_cosim.fmus"),
    "from cosim.studies import AtRest": ("cosim.studies", "gyro_cosim.stability"),
    "import cosim.studies.rest": ("cosim.studies.rest", "gyro_cosim.stability.at_rest"),
    "from cosim.ssd import system": ("cosim.ssd", "gyro_cosim.ssp"),
    "import cosim.certificate as c": ("cosim.certificate", "gyro_cosim.accuracy.certificate"),
    "from cosim.sweep import Sweep": ("cosim.sweep", "gyro_cosim.sweeps"),
    "from cosim.sweep.axes import Axis": ("cosim.sweep.axes", "gyro_cosim.sweeps.axes"),
    "from cosim.trajectory import Trajectory": ("cosim.trajectory", "gyro_cosim.trajectory"),
    "from gyro_unit.mount import BONDS": ("gyro_unit.mount", "gyro_cosim.gyro_unit.mount"),
    "import importlib; importlib.import_module('fmus.compiler')": ("fmus.compiler", "gyro_cosim.fmus.compiler"),
}
MODULES = {  # every module of 0.1.0
    "cosim": "adaptive algebraic archive assessment bonds calls catalogue certificate checkpoint comfort compare compensation "
    "convergence dataflow delay difference energy errors evaluation fast figures linear loop loop_numba march master monolith "
    "network packing quantities realtime recording report response safety sampled system tolerance trajectory unit_energy "
    "unit_figures wiring __main__",
    "cosim.check": "archive behaviour bench child description numerics probes subject",
    "cosim.cli": "check common compare converge delay export info listing pack paper plot run serve summary sweep",
    "cosim.coupling": "base explicit history iterated",
    "cosim.paper": "cases chance draws measures open_parameters pair_draws pair_measures sensitivity sensitivity_figures "
    "sensitivity_page studied vehicle vehicle_draws wheel_pair",
    "cosim.slaves": "asking base child description events fmi2 fmi3 fmu groups in_process interface isolated library opened "
    "remote scratch serving signal states variables wire",
    "cosim.ssd": "documents parameters structure tree",
    "cosim.studies": "optimum paths release rest signals",
    "cosim.sweep": "axes cluster inquiry maps measure plan pool runner store table",
    "component": "calling integration joined methods model units variables",
    "vehicle": "alignment car_body contact creep_laws irregularity kalker lrt lrt_parameters lrt_signals parameter_sets "
    "parameters profiles rotation running_gear spectra suspension track track_parameters trim variants wheel_frame "
    "wheel_pair wheel_rail wheel_report wheelset",
    "gyro_unit": "held hil linear mount multibody noise nonlinear parameters rig_parameters rotor_parameters transport twin",
    "fmus": "code compiler description description3 package page picture reference systems table",
}
TRIED = """
import json, sys
answers = {}
for statement in json.loads(sys.argv[1]):
    try:
        exec(statement)
        answers[statement] = "imported", None
    except ImportError as error:
        answers[statement] = f"{type(error).__name__}: {error}", error.name
print(json.dumps([answers, [name for name in sys.modules if name.startswith("gyro_cosim")]]))
"""


def _python(*arguments: str, folder: Path) -> subprocess.CompletedProcess[str]:
    return subprocess.run([sys.executable, *arguments], cwd=folder, capture_output=True, text=True, check=False)


@pytest.fixture(scope="module")
def old_names() -> ModuleType:
    """The module that Python has loaded at its start, from beside the package."""
    return sys.modules["_gyro_cosim_old_names"]


def test_an_import_of_an_old_name_says_the_new_one_in_one_line(tmp_path: Path) -> None:
    answers, loaded = json.loads(_python("-c", TRIED, json.dumps(list(IMPORTS)), folder=tmp_path).stdout)
    for statement, (old, new) in IMPORTS.items():
        said = (
            f"ModuleNotFoundError: No module named {old!r}: it is called {new!r} since 0.2.0{EXAMPLE if old == 'cosim' else ''}"
        )
        assert answers[statement] == [said, old.split(".")[0]]
    assert loaded == []  # to say so, the package need not be loaded


@pytest.mark.parametrize("name", ["cosim", "cosim.cli"])
def test_running_an_old_name_says_the_new_one(name: str, tmp_path: Path) -> None:
    ended = _python("-m", name, "list", folder=tmp_path)
    assert ended.returncode != 0
    assert f"No module named 'cosim': it is called 'gyro_cosim' since 0.2.0{EXAMPLE}" in ended.stderr
    assert "Traceback" not in ended.stderr


def test_every_module_of_before_has_a_successor(old_names: ModuleType) -> None:
    names = [f"{package}.{leaf}" for package, leaves in MODULES.items() for leaf in leaves.split()]
    for old in (*MODULES, *names):
        new = old_names.successor(old)
        assert importlib.util.find_spec(new) is not None, f"{old} -> {new}"
    assert set(old_names.MOVED) <= {*MODULES, *names}


def test_the_table_holds_no_module_that_is_called_as_before(old_names: ModuleType) -> None:
    for old, new in old_names.MOVED.items():
        package, _, leaf = old.rpartition(".")
        assert new != f"{old_names.successor(package)}.{leaf}"


def test_files_of_the_user_under_these_names_are_imported_as_ever(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Beside a script that simulates: neither does our package take theirs for its own, nor is theirs refused."""
    names = ("cosim", "vehicle", "gyro_unit", "component", "fmus")
    for name in names:
        (tmp_path / f"{name}.py").write_text(f"WHOSE = 'the user, {name}'\n")
    (tmp_path / "script.py").write_text(
        f"import {', '.join(names)}\n"
        "from gyro_cosim import simulate, system\n"
        f"print(*(m.WHOSE for m in ({', '.join(names)})), sep='; ')\n"
        "print(simulate(system('wheel-pair'), step=1e-3, stop=0.01, in_process=True).trajectory.t[-1])\n"
    )
    ended = _python("script.py", folder=tmp_path)
    assert ended.stderr == ""
    assert ended.stdout.splitlines() == ["; ".join(f"the user, {name}" for name in names), "0.01"]


def test_a_folder_of_the_user_without_init_is_a_package_as_ever(tmp_path: Path) -> None:
    (tmp_path / "vehicle").mkdir()
    (tmp_path / "vehicle" / "bogie.py").write_text("WHEELS = 4\n")
    assert _python("-c", "import vehicle.bogie; print(vehicle.bogie.WHEELS)", folder=tmp_path).stdout == "4\n"


def test_finders_that_came_later_go_first(old_names: ModuleType, monkeypatch: pytest.MonkeyPatch) -> None:
    """An editable install of somebody's `vehicle` may add its finder behind ours."""

    class Theirs:
        @staticmethod
        def find_spec(name: str, path: object = None, target: object = None) -> ModuleSpec | None:
            return ModuleSpec(name, None) if name == "vehicle" else None

    assert old_names.OldName.find_spec("vehicle") is not None
    monkeypatch.setattr(sys, "meta_path", [*sys.meta_path, Theirs])
    assert old_names.OldName.find_spec("vehicle") is None
    assert old_names.OldName.find_spec("fmus") is not None


def test_other_names_are_left_alone(old_names: ModuleType) -> None:
    for name in ("cosim_tools", "vehicles", "gyro", "gyro_cosim", "numpy"):
        assert old_names.OldName.find_spec(name) is None


def test_python_starts_with_one_small_module_more(tmp_path: Path) -> None:
    """It imports nothing, so it costs what reading it costs: some tenths of a millisecond."""
    report = _python("-X", "importtime", "-c", "pass", folder=tmp_path).stderr
    assert "gyro_cosim.cli" not in report
    times = re.search(r"(\d+) \| +(\d+) \| +_gyro_cosim_old_names$", report, flags=re.MULTILINE)
    assert times is not None
    assert times[1] == times[2]  # of its own, and with what it imports (microseconds)
