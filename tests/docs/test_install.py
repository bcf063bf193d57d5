"""What is installed: one package, and nothing under a name that others use. It works from any folder and in any process."""

import multiprocessing
import runpy
import shutil
import subprocess
import sys
import sysconfig
import tomllib
import zipfile
from importlib import metadata
from pathlib import Path
from typing import Any
from unittest import mock

import pytest

from gyro_cosim import system

ROOT = Path(__file__).parents[2]
PROJECT = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]
BESIDE = {"_gyro_cosim_old_names.py", "gyro_cosim_old_names.pth"}
FOREIGN = ("cosim", "component", "vehicle", "gyro_unit", "fmus")  # names that are not ours alone


@pytest.fixture(scope="module")
def layout() -> dict[str, Any]:
    """What setup.py defines."""
    with mock.patch("setuptools.setup"):
        return runpy.run_path(str(ROOT / "setup.py"))


def _content(folders: dict[str, str]) -> set[str]:
    """Every file of the tree that belongs into the package, as it is called in a wheel."""
    return {
        f"{name.replace('.', '/')}/{file.relative_to(ROOT / folder).as_posix()}"
        for name, folder in folders.items()
        for file in (ROOT / folder).rglob("*")
        if file.is_file() and "__pycache__" not in file.parts
    }


def test_the_folders_of_setup_are_those_of_the_tree(layout: dict[str, Any]) -> None:
    packages = {folder.name for folder in ROOT.iterdir() if (folder / "__init__.py").is_file()}
    assert set(layout["FOLDERS"].values()) == packages | {"src/cosim"}
    for name, folder in layout["FOLDERS"].items():
        assert name == "gyro_cosim" or name == f"gyro_cosim.{folder}"
        for file in (ROOT / folder).rglob("*.py"):
            assert (file.parent / "__init__.py").is_file(), f"{file.parent} would not be installed"
    files = {entry.name for entry in (ROOT / "src").iterdir() if entry.is_file()}
    assert files == BESIDE == {Path(file).name for file in layout["BESIDE"]}


def test_entry_points_are_those_of_the_project_and_resolve() -> None:
    stated = {("console_scripts", name, value) for name, value in PROJECT["scripts"].items()}
    stated |= {(group, name, value) for group, entries in PROJECT["entry-points"].items() for name, value in entries.items()}
    installed = metadata.distribution("gyro-cosim").entry_points
    assert {(entry.group, entry.name, entry.value) for entry in installed} == stated
    for entry in installed:
        assert entry.value.startswith("gyro_cosim")
        assert entry.load() is not None


def test_the_command_runs_as_a_module_from_any_folder(tmp_path: Path) -> None:
    ended = subprocess.run(
        [sys.executable, "-m", "gyro_cosim", "--version"], cwd=tmp_path, capture_output=True, text=True, check=True
    )
    assert PROJECT["version"] in ended.stdout
    assert metadata.version("gyro-cosim") == PROJECT["version"]


def test_the_version_is_that_of_changelog_and_citation() -> None:
    version = PROJECT["version"]
    assert f"\n## {version} - " in (ROOT / "CHANGELOG.md").read_text(encoding="utf-8")
    citation = (ROOT / "CITATION.cff").read_text(encoding="utf-8")
    assert f"\nversion: {version}\n" in citation
    assert f'\nrepository-code: "{PROJECT["urls"]["Repository"]}"\n' in citation


def test_a_system_crosses_into_a_new_process_and_back() -> None:
    """A spawned process imports everything anew, so nothing may be pickled under a name that only this one knows."""
    sent = system("lrt-curve").with_value("gyro_front.rotor_speed", "200rpm")
    with multiprocessing.get_context("spawn").Pool(1) as pool:
        received = pool.apply(type(sent).with_value, (sent, "gyro_rear.rotor_speed", "100rpm"))
    assert received == sent.with_value("gyro_rear.rotor_speed", "100rpm")


@pytest.fixture(scope="module")
def copy(tmp_path_factory: pytest.TempPathFactory, layout: dict[str, Any]) -> Path:
    """The sources as somebody else gets them, without what building has left here."""
    folder = tmp_path_factory.mktemp("sources")
    for file in ("setup.py", "pyproject.toml", "README.md", "LICENSE", *layout["BESIDE"]):
        (folder / file).parent.mkdir(exist_ok=True)
        shutil.copy(ROOT / file, folder / file)
    for name in layout["FOLDERS"].values():
        shutil.copytree(ROOT / name, folder / name, ignore=shutil.ignore_patterns("__pycache__"))
    return folder


def _run(*command: str | Path, folder: Path) -> None:
    ended = subprocess.run([*map(str, command)], cwd=folder, capture_output=True, text=True, check=False)
    assert ended.returncode == 0, ended.stderr


@pytest.fixture(scope="module")
def wheels(copy: Path, tmp_path_factory: pytest.TempPathFactory) -> dict[str, Path]:
    """What pip asks setuptools for: the wheel, and that of an editable install."""
    stale = copy / "build" / "lib" / "gyro_cosim" / "stale.py"  # as a build before a file was renamed leaves it
    stale.parent.mkdir(parents=True)
    stale.write_text("")
    made = {}
    for what, hook in {"wheel": "build_wheel", "editable": "build_editable"}.items():
        folder = tmp_path_factory.mktemp(what)
        _run(sys.executable, "-c", f"from setuptools.build_meta import {hook}; {hook}({str(folder)!r})", folder=copy)
        (made[what],) = folder.glob("*.whl")
    return made


@pytest.mark.slow
def test_the_wheel_holds_the_package_and_nothing_else(wheels: dict[str, Path], layout: dict[str, Any]) -> None:
    with zipfile.ZipFile(wheels["wheel"]) as archive:
        names = set(archive.namelist())
    information = f"gyro_cosim-{PROJECT['version']}.dist-info/"
    assert {name for name in names if not name.startswith(information)} == _content(layout["FOLDERS"]) | BESIDE
    assert f"{information}licenses/LICENSE" in names


@pytest.mark.slow
@pytest.mark.parametrize("how", ["wheel", "editable"])
def test_installed_into_a_new_environment_it_runs(how: str, copy: Path, wheels: dict[str, Path], tmp_path: Path) -> None:
    """What it depends on is lent by this environment, behind all else; its own package is not, as no .pth is read there."""
    environment = tmp_path / "environment"
    _run(sys.executable, "-m", "venv", "--without-pip", environment, folder=tmp_path)
    interpreter = environment / ("Scripts" if sys.platform == "win32" else "bin") / "python"
    pip = (sys.executable, "-m", "pip", "--quiet", "--disable-pip-version-check", "--python", interpreter)
    _run(*pip, "install", "--no-deps", wheels[how], folder=tmp_path)
    site = next(environment.rglob("gyro_cosim_old_names.pth")).parent
    assert not [entry.name for entry in site.iterdir() if entry.stem in FOREIGN]
    lent = site / "zz_lent.pth"
    lent.write_text("".join(f"{sysconfig.get_path(path)}\n" for path in ("purelib", "platlib")))
    (tmp_path / "empty").mkdir()

    def python(*arguments: str) -> subprocess.CompletedProcess[str]:
        return subprocess.run([interpreter, *arguments], cwd=tmp_path / "empty", capture_output=True, text=True, check=False)

    place = python("-c", "import gyro_cosim, gyro_cosim.vehicle; print(gyro_cosim.__file__); print(gyro_cosim.vehicle.__file__)")
    base = copy if how == "editable" else environment
    places = [Path(line).resolve() for line in place.stdout.splitlines()]
    assert [place.is_relative_to(base.resolve()) for place in places] == [True, True], places
    for name in FOREIGN:
        assert f"No module named {name!r}: it is called 'gyro_cosim" in python("-c", f"import {name}").stderr
    ran = python("-m", "gyro_cosim", "run", "wheel-pair", "--in-process", "--stop", "0.1")
    assert ran.returncode == 0, ran.stderr
    assert "wheel-pair" in ran.stdout
    lent.unlink()
    _run(*pip, "uninstall", "--yes", "gyro-cosim", folder=tmp_path)
    assert not list(environment.rglob("*gyro_cosim*"))
