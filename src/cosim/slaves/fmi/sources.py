"""An FMU without a binary for this machine is compiled from the C sources that it carries, where it says how.

sources/buildDescription.xml says it (FMI 3.0, and 2.0 from 2.0.4 on), else FMI 2.0's list of files of each interface
(SourceFiles). An FMU that lists none is not guessed at. FMI's own headers need not be in an FMU; FMPy ships them. Options for
another tool's compiler are not used; a log message says so where they are more than what ours does anyway.
"""

import importlib.util
import logging
import shutil
import tempfile
from collections.abc import Mapping
from pathlib import Path

from lxml import etree

from ...systems import archive, machine_code
from .description import MEMBER, Description
from .schema import BUILD_DESCRIPTION, judged

FOLDER, BUILD = "sources", "buildDescription.xml"
LANGUAGES = ("", "C", "C89", "C90", "C99", "C11", "C17")  # as far as the compiler that is asked takes them
OURS = ("-O", "-std=", "-W", "-w", "-fPIC", "-fvisibility=", "-ffp-contract=off", "-fno-math-errno", "-g")  # change no value
AT_HAND = ("m",)  # libraries of every system
Recipe = Mapping[str, tuple[str, ...]]  # C file, relative to the folder of sources -> options for the preprocessor
_log = logging.getLogger(__name__)


def compile_into(folder: Path, model: Description, file: Path, where: str) -> None:
    """Make `file`, the library of the FMU unpacked in `folder`, from its sources, or leave all as it is if it has none.

    Raises
    ------
    ValueError
        The sources are not listed or not there, not in C, or the compiler refuses them or is missing. Begins with `where`.
    """
    recipe = _recipe(folder, model, where)
    if recipe is None:
        if model.version != "1" and any((folder / FOLDER).rglob("*.c")):
            told = f"{FOLDER}/{BUILD}" if model.version == "3" else "SourceFiles"
            raise ValueError(f"{where} has no binary for this machine, and must list its sources in {told} to be compiled")
        return
    for name in recipe:
        if not (folder / FOLDER / name).is_file():
            raise ValueError(f"{where} has no binary for this machine and must hold the source that it lists, {FOLDER}/{name!r}")
    identifier = model.interfaces[model.interface]["modelIdentifier"]
    with tempfile.TemporaryDirectory(dir=folder) as scratch:  # so that what is cached does not depend on objects
        copy = shutil.copytree(folder / FOLDER, Path(scratch) / FOLDER)
        try:
            library = machine_code.foreign(copy, recipe, identifier, _headers_of_fmi())
        except (RuntimeError, ValueError) as error:
            raise ValueError(f"{where} has no binary for this machine, and its sources do not compile: {error}") from None
    file.parent.mkdir(parents=True, exist_ok=True)
    shutil.copyfile(library, file)
    _log.info("%s has no binary for this machine; its %d C files were compiled", where, len(recipe))


def _recipe(folder: Path, model: Description, where: str) -> Recipe | None:
    """None: it says nothing of sources."""
    build = folder / FOLDER / BUILD
    if model.version == "1":
        return None
    if build.is_file():
        return _described(build.read_bytes(), model.interfaces[model.interface]["modelIdentifier"], f"{where}: its {BUILD}")
    root = archive.xml((folder / MEMBER).read_bytes(), where)
    return {_inside(e.get("name", ""), where): () for e in root.iterfind(f"{model.interface}/SourceFiles/File")} or None


def _described(data: bytes, identifier: str, said: str) -> Recipe:
    """What a buildDescription.xml says of a library."""
    root, faults = judged(archive.xml(data, said), "3", BUILD_DESCRIPTION)
    for fault in faults:
        if not fault.harmless:
            raise ValueError(f"{said} must keep its schema: {fault}")
    builds = [e for e in root.iterfind("BuildConfiguration") if e.get("modelIdentifier") == identifier and not e.get("platform")]
    if not builds:
        raise ValueError(f"{said} must have a BuildConfiguration of {identifier!r} for any platform")
    needed = [name for e in builds[0].iterfind("Library") if (name := e.get("name", "")) not in AT_HAND]
    if needed:
        raise ValueError(f"{said} must need no library from elsewhere, needs {', '.join(needed)}")
    recipe: dict[str, tuple[str, ...]] = {}
    for one in builds[0].iterfind("SourceFileSet"):
        if one.get("language", "") not in LANGUAGES:
            raise ValueError(f"{said} must list sources in C, lists {one.get('language')}")
        strange = [word for word in one.get("compilerOptions", "").split() if not word.startswith(OURS)]
        if strange:
            _log.warning("%s asks for compiler options that are not used: %s", said, " ".join(strange))
        options = [
            f"-D{_definition(e)}" for e in one.iterfind("PreprocessorDefinition") if e.get("optional") not in ("true", "1")
        ]
        options += [f"-I{_inside(e.get('name', ''), said)}" for e in one.iterfind("IncludeDirectory")]
        recipe |= {_inside(e.get("name", ""), said): tuple(options) for e in one.iterfind("SourceFile")}
    if not recipe:
        raise ValueError(f"{said} must list a source of {identifier!r}, lists none")
    return recipe


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
