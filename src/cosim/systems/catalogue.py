"""What is installed: components, systems and exporters, found through entry points, so that cosim names none of them.

A component is called `PACKAGE:VARIANT` ("gyro_unit:nonlinear"), `PACKAGE` (its first variant), or by a Python file that
defines `component` ("my_gyro.py", "my_gyro.py:other_name"): a Component or a function without arguments that makes one. Or by
a TOML file that describes a variant of a package ("my_vehicle.toml"): its table of the package's name says whose.
"""

import contextlib
import hashlib
import os
import platform
import shutil
import tempfile
import time
import tomllib
import zipfile
import zlib
from collections.abc import Mapping, Sequence
from dataclasses import fields, is_dataclass
from functools import cache
from importlib import metadata, resources, util
from pathlib import Path
from pkgutil import resolve_name
from typing import Any

import platformdirs

from ..errors import unknown

GROUP = "gyro_cosim"
SCRATCH = "building-"  # how the folders begin that FMUs are built in
STALE = 24 * 3600.0  # s


@cache
def components() -> dict[str, dict[str, str]]:
    """Package -> variant -> "module:function", for every installed package that offers components."""
    found = {}
    for entry in sorted(entries("components")):
        try:
            found[entry.name] = dict(entry.load())
        except Exception as error:  # another package's code can fail in any way; people need one line
            raise ValueError(f"components {entry.name!r} ({entry.value}) cannot be loaded: {error}") from error
    return found


@cache
def systems() -> dict[str, Path]:
    """Name -> .ssd file of every built-in system."""
    found = {}
    for entry in entries("systems"):
        folder = Path(str(resources.files(entry.value)))
        found.update({file.stem: file for file in sorted(folder.glob("*.ssd"))})
    return found


def entries(kind: str) -> metadata.EntryPoints:
    return metadata.entry_points(group=f"{GROUP}.{kind}")


def described_by(spec: str) -> str | None:
    """The package of which a TOML file describes a variant: the one whose name is that of a table in it; None if there is none.

    Entry points of the group `gyro_cosim.files` name, per package, the function that makes a component of such a file.
    """
    if not (spec.endswith(".toml") and Path(spec).is_file()):
        return None
    try:
        tables = tomllib.loads(Path(spec).read_text(encoding="utf-8"))
    except (OSError, UnicodeDecodeError, tomllib.TOMLDecodeError):
        return None
    return next((entry.name for entry in sorted(entries("files")) if isinstance(tables.get(entry.name), dict)), None)


def resolve(spec: str) -> str:
    """`spec` in full: "gyro_unit" -> "gyro_unit:linear"; a Python file -> "FILE.py:NAME". ValueError if it is not there."""
    if spec.endswith(".toml"):
        if not Path(spec).is_file():
            raise ValueError(f"component file {spec!r} must exist")
        if described_by(spec) is None:
            known = " or ".join(f"[{entry.name}]" for entry in sorted(entries("files")))
            raise ValueError(f"component file {spec!r} must be TOML with a table {known}")
        return spec
    head, _, tail = spec.rpartition(":") if ":" in spec and not spec.endswith(".py") else (spec, "", "")
    if head.endswith(".py"):
        if not Path(head).is_file():
            raise ValueError(f"component file {head!r} must exist")
        return f"{head}:{tail or 'component'}"
    if head not in components():
        raise unknown("component", head, components())
    variants = components()[head]
    variant = tail or next(iter(variants))
    if variant not in variants:
        raise unknown(f"variant of {head}", variant, variants)
    return f"{head}:{variant}"


def component(spec: str) -> Any:
    """The component that `spec` names, made anew.

    Parameters
    ----------
    spec : str
        As resolve() takes it.

    Returns
    -------
    gyro_cosim.component.Component
        Its table of variables and its functions.

    Raises
    ------
    ValueError
        Where it is not there, cannot be loaded, or is no component.
    """
    package = described_by(spec)
    if package is not None:
        (entry,) = entries("files").select(name=package)
        return entry.load()(spec)
    head, _, name = resolve(spec).rpartition(":")
    if head.endswith(".py"):
        module_spec = util.spec_from_file_location(Path(head).stem, head)
        if module_spec is None or module_spec.loader is None:
            raise ValueError(f"component file {head!r} must be a Python file")
        module = util.module_from_spec(module_spec)
        try:
            module_spec.loader.exec_module(module)
        except Exception as error:  # a user's file can fail in any way; the user needs one line
            raise ValueError(f"component file {head!r} cannot be loaded: {type(error).__name__}: {error}") from error
        if not hasattr(module, name):
            raise ValueError(f"component file {head!r} must define {name!r}")
        made = getattr(module, name)
    else:
        value = components()[head][name]
        try:
            made = resolve_name(value)
        except (ImportError, AttributeError, ValueError) as error:  # of another package, perhaps with names of before 0.2.0
            raise ValueError(f"component {head}:{name} ({value}) cannot be loaded: {error}") from error
    made = made() if callable(made) else made
    if not (hasattr(made, "rhs") and hasattr(made, "variables")):
        raise ValueError(f"component {spec!r} must be a Component, got {type(made).__name__}")
    return made


def spec_of_fmu(file_name: str) -> str | None:
    """The component that an FMU name in a system description stands for: "gyro_unit.linear.fmu" -> "gyro_unit:linear"."""
    package, _, variant = file_name.removesuffix(".fmu").partition(".")
    return f"{package}:{variant}" if variant in components().get(package, {}) else None


def export(spec: str, directory: Path, *, starts: Mapping[str, float] | None = None, **options: Any) -> list[Path]:
    """Write the FMUs of a component with the installed exporter.

    Parameters
    ----------
    spec : str
        As resolve() takes it.
    directory : Path
        Where to write.
    starts : mapping
        Values, by name, with which they start in the place of the component's own.
    **options
        The exporter's own.

    Returns
    -------
    list of Path
        The files written.
    """
    made = component(spec)
    return _exported(made.with_starts(starts) if starts else made, directory, **options)


def _exported(made: Any, directory: Path, **options: Any) -> list[Path]:
    (entry, *_) = entries("exporters")
    files: list[Path] = entry.load()(made, directory, **options)
    return files


def fmu(spec: str) -> Path:
    """The FMI 2.0 FMU of a component for this machine, built if anything that decides its content has changed since.

    Parameters
    ----------
    spec : str
        As resolve() takes it.

    Returns
    -------
    Path
        The file, in the user's cache.
    """
    spec = resolve(spec)
    made = None if _is_ours(spec) else component(spec)
    folder = cache_folder() / fingerprint(spec, made)
    built = list(folder.glob("*.fmu"))
    if built and not _is_whole(built[0]):
        shutil.rmtree(folder, ignore_errors=True)
        built = []
    if not built:
        folder.parent.mkdir(parents=True, exist_ok=True)
        _clean(folder.parent)
        with tempfile.TemporaryDirectory(dir=folder.parent, prefix=SCRATCH) as scratch:
            built = _exported(component(spec) if made is None else made, Path(scratch) / "fmu")
            for file in built:
                _to_disk(file)
            try:
                (Path(scratch) / "fmu").rename(folder)
            except OSError:  # another process built the same in the meantime, or an empty folder stands there that is not ours
                if not list(folder.glob("*.fmu")):
                    raise
        built = list(folder.glob("*.fmu"))
    return built[0]


def _is_whole(file: Path) -> bool:
    """Whether a built FMU is what was written: a disk that was full or a loss of power can have cut it off."""
    try:
        with zipfile.ZipFile(file) as archive:
            return archive.testzip() is None
    except (zipfile.BadZipFile, OSError, EOFError, zlib.error):
        return False


def _to_disk(file: Path) -> None:
    with file.open("rb+") as stream:
        os.fsync(stream.fileno())


def _clean(folder: Path) -> None:
    """Remove what builders that were killed have left more than a day ago; nobody builds so long."""
    for left in folder.glob(f"{SCRATCH}*"):
        with contextlib.suppress(OSError):
            if time.time() - left.stat().st_mtime > STALE:
                shutil.rmtree(left, ignore_errors=True)


def cache_folder() -> Path:
    """Where built FMUs are kept: $GYRO_COSIM_CACHE, or the user's cache folder."""
    return Path(os.environ.get("GYRO_COSIM_CACHE") or platformdirs.user_cache_dir("gyro-cosim")) / "fmu"


def _module(spec: str) -> str:
    """The module that makes a component; empty for a file."""
    head, _, name = spec.rpartition(":")
    return "" if head.endswith(".py") or spec.endswith(".toml") else components()[head][name].partition(":")[0]


def _is_ours(spec: str) -> bool:
    """Whether a component stands in this package, where its folder, the contract and the exporter decide on all of it."""
    return _module(spec).startswith("gyro_cosim.")


def decided_by(spec: str) -> str:
    """A hash of what decides on a component of the catalogue, and on its FMU, whatever the machine and its tools."""
    spec = resolve(spec)
    return fingerprint(spec, None if _is_ours(spec) else component(spec), ())


def fingerprint(spec: str, made: Any, tools: Sequence[Any] | None = None) -> str:
    """A hash of all that decides on the FMU of `spec`: the model, the contract's and the exporter's sources, tools, machine.

    The model is the sources of its folder where it is ours, for they are read faster than it is made. Anyone else's may come
    from anywhere, and so the component `made` of it is hashed: its table, its functions, its equations.
    tools : in the place of this machine's.
    """
    (entry, *_) = entries("exporters")
    packages = ["gyro_cosim.component", entry.module, *([] if made is not None else [_module(spec).rpartition(".")[0]])]
    if tools is None:
        tools = (metadata.version("casadi"), metadata.version("gyro-cosim"), platform.platform(), os.environ.get("CC"))
    digest = hashlib.sha256(repr((spec, None if made is None else _content(made), tools)).encode())
    for package in packages:
        place = util.find_spec(package)
        for root in (place.submodule_search_locations or ()) if place else ():
            for file in sorted(Path(root).rglob("*")):
                if file.is_file() and "__pycache__" not in file.parts and file.suffix != ".ssd":  # systems decide on no FMU
                    digest.update(file.relative_to(root).as_posix().encode() + b"\0" + file.read_bytes())
    return digest.hexdigest()[:20]


def _content(made: Any) -> list[tuple[str, str]]:
    """What a component is, name by name: CasADi functions as they are serialized, everything else as it is shown."""
    names = [field.name for field in fields(made)] if is_dataclass(made) else sorted(vars(made))
    values = [(name, getattr(made, name)) for name in names]
    return [(name, value.serialize() if hasattr(value, "serialize") else repr(value)) for name, value in values]
