"""What the pages name exists: files, folders, modules and what is in them."""

import re
import tomllib
from importlib import import_module
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
PAGES = sorted([*ROOT.glob("*.md"), *(ROOT / "docs").rglob("*.md"), ROOT / "studies" / "README.md"])
TEXTS = {page.relative_to(ROOT).as_posix(): page.read_text(encoding="utf-8") for page in PAGES}
TOP = "|".join(
    sorted(re.escape(entry.name) for entry in ROOT.iterdir() if not entry.name.startswith((".venv", "build", "results")))
)
PATHS = re.compile(rf"`((?:{TOP})(?:/[\w.-]+)*/?)`")
NAMES = re.compile(r"\bgyro_cosim(?:\.[A-Za-z_]\w*)+")
PROJECT = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))
GROUPS = tuple(PROJECT["project"]["entry-points"])
GUESSES = re.search(r"\n## Where is what\n(.*?)(?:\n## |\Z)", TEXTS["CONTRIBUTING.md"], flags=re.DOTALL)


@pytest.mark.parametrize("page", TEXTS)
def test_paths_exist(page: str) -> None:
    for path in PATHS.findall(TEXTS[page]):
        assert (ROOT / path).exists(), path
    for link in re.findall(r"\]\(((?!http)[^)#]+)\)", TEXTS[page]):
        assert ((ROOT / page).parent / link).exists(), link


def _resolves(name: str) -> bool:
    """Whether `name` is a module or stands in one."""
    try:
        import_module(name)
    except ImportError:
        owner, _, leaf = name.rpartition(".")
        return hasattr(import_module(owner), leaf)
    return True


@pytest.mark.parametrize("page", TEXTS)
def test_names_resolve(page: str) -> None:
    for name in NAMES.findall(TEXTS[page]):
        assert name in GROUPS or _resolves(name), name


def test_the_fifteen_guesses_lead_somewhere() -> None:
    """A stranger finds what he looks for where the list says: the file exists, and it is one of the package's own."""
    assert GUESSES is not None
    rows = re.findall(r"^\| (?!-|You look for)(.+?) \| (.+?) \|$", GUESSES[1], flags=re.MULTILINE)
    assert len(rows) == 15
    for guess, answer in rows:
        paths = re.findall(r"`([^`]+)`", answer)
        assert paths, guess
        for path in paths:
            assert (ROOT / path).is_file(), f"{guess}: {path}"
            assert path.split("/")[0] in ("src", "component", "vehicle", "gyro_unit", "fmus")


def test_the_contract_on_the_page_is_the_one_that_is_checked() -> None:
    contracts = PROJECT["tool"]["importlinter"]["contracts"]
    layers = next(contract["layers"] for contract in contracts if contract["type"] == "layers")
    assert layers[0] == "__main__"
    assert "\n".join(layers[1:]) in TEXTS["CONTRIBUTING.md"]


def test_the_readme_names_every_wing_and_every_folder() -> None:
    wings = {folder.parent.name for folder in (ROOT / "src" / "cosim").glob("*/__init__.py")}
    layout = TEXTS["README.md"].partition("\n## Layout\n")[2]
    named = re.findall(r"`(\w+)`", " ".join(re.findall(r"^\| ((?:`\w+`(?:, )?)+) \|", layout, flags=re.MULTILINE)))
    assert sorted(named) == sorted(wings)
    folders = dict(re.findall(r"^\| `([\w/]+)/` \| `([\w.]+)` \|", layout, flags=re.MULTILINE))
    assert len(folders) == 5
    assert all((ROOT / folder / "__init__.py").samefile(str(import_module(name).__file__)) for folder, name in folders.items())
