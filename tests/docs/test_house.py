"""The house: wings whose names say what is in them, files that can be read in one go, faces that hide no module."""

import importlib
import inspect
import pkgutil
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
PARTS = ("component", "vehicle", "gyro_unit", "fmus")  # an editable install maps them: a walk of gyro_cosim alone misses them
FOLDERS = ("src/cosim", *PARTS)
BESIDE_THE_WINGS = {"__init__.py", "__main__.py", "errors.py", "py.typed"}
LONGEST = 300  # lines of a file of the package


def _modules() -> list[str]:
    """Every module of the package but those that run something."""
    found = []
    for name in ("gyro_cosim", *(f"gyro_cosim.{part}" for part in PARTS)):
        package = importlib.import_module(name)
        found += [name, *(module.name for module in pkgutil.walk_packages(package.__path__, f"{name}."))]
    return sorted({name for name in found if name != "gyro_cosim" and not name.endswith("__main__")})


MODULES = _modules()


def test_the_walk_sees_every_module() -> None:
    files = [p for folder in FOLDERS for p in (ROOT / folder).rglob("*.py") if p.name != "__main__.py"]
    assert len(MODULES) == len(files) - 1  # gyro_cosim itself is not among those it walks


@pytest.mark.parametrize("name", MODULES)
def test_no_face_shadows_a_module(name: str) -> None:
    """Where a face hands on a function of its module's name, `import gyro_cosim.x.y as y` would give the function."""
    module = importlib.import_module(name)
    parent, _, leaf = name.rpartition(".")
    assert getattr(importlib.import_module(parent), leaf) is module


@pytest.mark.parametrize("name", MODULES)
def test_no_function_has_the_name_of_its_module(name: str) -> None:
    same = getattr(importlib.import_module(name), name.rpartition(".")[2], None)
    assert not (inspect.isfunction(same) and same.__module__ == name)


def test_no_file_of_the_package_is_long() -> None:
    lines = {
        path.relative_to(ROOT).as_posix(): len(path.read_text(encoding="utf-8").splitlines())
        for folder in FOLDERS
        for path in (ROOT / folder).rglob("*")
        if path.suffix in (".py", ".c", ".h", ".ssd", ".toml")
    }
    assert len(lines) > 200
    assert {path: n for path, n in lines.items() if n > LONGEST} == {}


def test_only_what_everyone_needs_stands_outside_a_wing() -> None:
    entries = [p for p in (ROOT / "src" / "cosim").iterdir() if p.name != "__pycache__"]
    assert {p.name for p in entries if p.is_file()} == BESIDE_THE_WINGS
    for wing in (p for p in entries if p.is_dir()):
        assert (wing / "__init__.py").is_file(), f"{wing.name} must be a package"
