"""An FMU without a binary for this machine is compiled from the C sources that it carries, where it says how.

FMI 2.0 lists the files of each interface in modelDescription.xml (SourceFiles); FMI 3.0 has sources/buildDescription.xml. An FMU
that lists none is not guessed at. FMI's own headers need not be in an FMU; FMPy ships them.
"""

import importlib.util
import logging
import shutil
import tempfile
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

from lxml import etree

from ...systems import archive, machine_code
from .description import MEMBER, Description

FOLDER, BUILD = "sources", "buildDescription.xml"
LANGUAGES = ("", "C", "C89", "C90", "C99", "C11", "C17")  # as far as the compiler that is asked takes them
_log = logging.getLogger(__name__)


@dataclass(frozen=True)
class Recipe:
    """Which C files make an FMU's library, relative to its folder of sources, and what the preprocessor is told."""

    files: tuple[str, ...]
    definitions: tuple[str, ...] = ()
    headers: tuple[str, ...] = ()


def compile_into(folder: Path, model: Description, file: Path, where: str) -> None:
    """Make `file`, the library of the FMU unpacked in `folder`, from its sources, or leave all as it is if it lists none.

    Raises
    ------
    ValueError
        The sources are not in the FMU, not in C, or the compiler refuses them or is missing. Begins with `where`.
    """
    recipe = _recipe(folder, model, where)
    if recipe is None:
        if model.version != "1" and any((folder / FOLDER).rglob("*.c")):
            told = f"{FOLDER}/{BUILD}" if model.version == "3" else "SourceFiles"
            raise ValueError(f"{where} has no binary for this machine, and must list its sources in {told} to be compiled")
        return
    identifier = model.interfaces[model.interface]["modelIdentifier"]
    for name in recipe.files:
        if not (folder / FOLDER / name).is_file():
            raise ValueError(f"{where} has no binary for this machine and must hold the source that it lists, {FOLDER}/{name}")
    with tempfile.TemporaryDirectory(dir=folder) as scratch:  # so that what is cached does not depend on objects
        copy = Path(scratch) / FOLDER
        shutil.copytree(folder / FOLDER, copy)
        headers = [*(copy / name for name in recipe.headers), *_headers_of_fmi()]
        try:
            library = machine_code.foreign(copy, recipe.files, identifier, recipe.definitions, headers)
        except RuntimeError as error:
            raise ValueError(f"{where} has no binary for this machine, and its sources do not compile: {error}") from None
    file.parent.mkdir(parents=True, exist_ok=True)
    shutil.copyfile(library, file)
    _log.info("%s has no binary for this machine; its %d C files were compiled", where, len(recipe.files))


def _recipe(folder: Path, model: Description, where: str) -> Recipe | None:
    """None: it says nothing of sources."""
    if model.version == "3":
        return _recipe_3(folder / FOLDER / BUILD, model, where)
    root = archive.xml((folder / MEMBER).read_bytes(), where)
    listed = tuple(_inside(e.get("name", ""), where) for e in root.iterfind(f"{model.interface}/SourceFiles/File"))
    return Recipe(listed) if listed else None


def _recipe_3(file: Path, model: Description, where: str) -> Recipe | None:
    if not file.is_file():
        return None
    said = f"{where}: its {BUILD}"
    identifier = model.interfaces[model.interface]["modelIdentifier"]
    root = archive.xml(file.read_bytes(), said)
    builds = [e for e in root.iterfind("BuildConfiguration") if e.get("modelIdentifier") == identifier and not e.get("platform")]
    if not builds:
        raise ValueError(f"{said} must have a BuildConfiguration of {identifier!r} for any platform")
    build = builds[0]
    sets: Sequence[etree._Element] = list(build.iterfind("SourceFileSet"))
    for one in sets:
        if one.get("language", "") not in LANGUAGES:
            raise ValueError(f"{said} must list sources in C, lists {one.get('language')}")
    needed = [f"{e.get('name')}" for e in build.iterfind("Library") if e.get("external") in ("true", "1")]
    if needed:
        raise ValueError(f"{said} must need no library from elsewhere, needs {', '.join(needed)}")
    return Recipe(
        tuple(_inside(e.get("name", ""), said) for one in sets for e in one.iterfind("SourceFile")),
        tuple(dict.fromkeys(_definition(e) for one in sets for e in one.iterfind("PreprocessorDefinition"))),
        tuple(_inside(e.get("name", ""), said) for one in sets for e in one.iterfind("IncludeDirectory")),
    )


def _definition(element: etree._Element) -> str:
    value = element.get("value")  # no shell sees it
    return f"{element.get('name')}" + (f"={value}" if value is not None else "")


def _inside(name: str, where: str) -> str:
    """A name from an FMU, which must stay in its folder of sources and be no option of a compiler."""
    if not name or name.startswith(("/", "-", "@")) or "\\" in name or ":" in name or ".." in name.split("/"):
        raise ValueError(f"{where} must list sources inside the FMU, lists {name!r}")
    return name


def _headers_of_fmi() -> list[Path]:
    spec = importlib.util.find_spec("fmpy")
    return [Path(place) / "c-code" for place in (spec.submodule_search_locations or ())] if spec else []
