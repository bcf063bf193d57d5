"""What is installed: components, systems and exporters, found through entry points, so that cosim names none of them.

A component is called `PACKAGE:VARIANT` ("gyro_unit:nonlinear"), `PACKAGE` (its first variant), or by a Python file that
defines `component` ("my_gyro.py", "my_gyro.py:other_name"): a Component or a function without arguments that makes one.
"""

import hashlib
import os
import platform
import tempfile
from functools import cache
from importlib import metadata, resources, util
from pathlib import Path
from pkgutil import resolve_name
from typing import Any

import platformdirs

from ..errors import unknown

GROUP = "gyro_cosim"


@cache
def components() -> dict[str, dict[str, str]]:
    """Package -> variant -> "module:function", for every installed package that offers components."""
    return {entry.name: dict(entry.load()) for entry in sorted(_entries("components"))}


@cache
def systems() -> dict[str, Path]:
    """Name -> .ssd file of every built-in system."""
    found = {}
    for entry in _entries("systems"):
        folder = Path(str(resources.files(entry.value)))
        found.update({file.stem: file for file in sorted(folder.glob("*.ssd"))})
    return found


def _entries(kind: str) -> metadata.EntryPoints:
    return metadata.entry_points(group=f"{GROUP}.{kind}")


def resolve(spec: str) -> str:
    """`spec` in full: "gyro_unit" -> "gyro_unit:linear"; a Python file -> "FILE.py:NAME". ValueError if it is not there."""
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
    """The component (component.Component) that `spec` names, made anew."""
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
        made = resolve_name(components()[head][name])
    made = made() if callable(made) else made
    if not (hasattr(made, "rhs") and hasattr(made, "variables")):
        raise ValueError(f"component {spec!r} must be a Component, got {type(made).__name__}")
    return made


def spec_of_fmu(file_name: str) -> str | None:
    """The component that an FMU name in a system description stands for: "gyro_unit.linear.fmu" -> "gyro_unit:linear"."""
    package, _, variant = file_name.removesuffix(".fmu").partition(".")
    return f"{package}:{variant}" if variant in components().get(package, {}) else None


def export(spec: str, directory: Path, **options: Any) -> list[Path]:
    """Write the FMUs of a component with the installed exporter; `options` are the exporter's own."""
    (entry, *_) = _entries("exporters")
    files: list[Path] = entry.load()(component(spec), directory, **options)
    return files


def fmu(spec: str) -> Path:
    """The FMI 2.0 FMU of a component for this machine, built if its sources have changed since it was built last."""
    spec = resolve(spec)
    folder = cache_folder() / _fingerprint(spec)
    built = list(folder.glob("*.fmu"))
    if not built:
        folder.parent.mkdir(parents=True, exist_ok=True)
        with tempfile.TemporaryDirectory(dir=folder.parent) as scratch:
            built = export(spec, Path(scratch) / "fmu")
            try:
                (Path(scratch) / "fmu").rename(folder)
            except OSError:  # another process built the same in the meantime
                if not folder.is_dir():
                    raise
        built = list(folder.glob("*.fmu"))
    return built[0]


def cache_folder() -> Path:
    """Where built FMUs are kept: $GYRO_COSIM_CACHE, or the user's cache folder."""
    return Path(os.environ.get("GYRO_COSIM_CACHE") or platformdirs.user_cache_dir("gyro-cosim")) / "fmu"


def _fingerprint(spec: str) -> str:
    """A hash of all that decides what the FMU of `spec` contains: model, contract and exporter sources, tools, machine."""
    head = spec.rpartition(":")[0]
    (entry, *_) = _entries("exporters")
    packages = ["gyro_cosim.component", entry.module]
    files = [Path(head)] if head.endswith(".py") else []
    packages += [] if files else [components()[head][spec.rpartition(":")[2]].partition(":")[0].rpartition(".")[0]]
    for package in packages:
        found = util.find_spec(package)
        for root in (found.submodule_search_locations or ()) if found else ():
            files += [f for f in sorted(Path(root).rglob("*")) if f.is_file() and "__pycache__" not in f.parts]
    digest = hashlib.sha256(f"{spec} {metadata.version('casadi')} {platform.platform()} {os.environ.get('CC')}".encode())
    for file in files:
        digest.update(file.name.encode() + b"\0" + file.read_bytes())
    return digest.hexdigest()[:20]
