"""What an FMU file holds, and how it gets to disk: complete, or not at all."""

import hashlib
import importlib.metadata
import importlib.util
import json
import tempfile
import uuid
from collections.abc import Sequence
from pathlib import Path

from gyro_cosim.component import Component
from gyro_cosim.component.scene import PLACE
from gyro_cosim.component.zip_files import write_zip

from . import code, description, description3, page, picture, reference
from .compiler import Platform, chosen, compile_libraries, universal
from .table import Table

__all__ = ["HEADERS", "SOURCES", "VERSIONS", "binaries", "header_folder", "write"]

VERSIONS = {"2": ".fmu", "3": ".fmi3.fmu"}
SOURCES = {
    "fmu.c": "-O3",
    "equations.c": "-O3",
    "rhs_derivatives.c": "-O2",
    "output_derivatives.c": "-O2",
}  # with the optimization of each
HEADERS = (
    "fmi2Functions.h", "fmi2FunctionTypes.h", "fmi2TypesPlatform.h",
    "fmi3Functions.h", "fmi3FunctionTypes.h", "fmi3PlatformTypes.h",
)  # fmt: skip


def write(component: Component, directory: Path, *, fmi: Sequence[str], platforms: Sequence[str], sources: bool) -> list[Path]:
    """Write the FMUs of `component` into `directory`: see `gyro_cosim.fmus.export`."""
    if isinstance(fmi, str) or not fmi:
        raise ValueError(f"fmi must be a sequence of versions, such as ('2', '3'), got {fmi!r}")
    for version in fmi:
        if version not in VERSIONS:
            raise ValueError(f"FMI version must be one of {', '.join(VERSIONS)}, got {version!r}")
    targets = chosen(platforms)
    if directory.exists() and not directory.is_dir():
        raise ValueError(f"directory must be a folder, got the file {str(directory)!r}")
    table = Table(component)
    identifier = f"{component.name}_{component.variant}"
    if not identifier.isidentifier() or not identifier.isascii():
        raise ValueError(f"component {component.spec!r}: name and variant must make a C identifier, got {identifier!r}")

    text = code.generate(table, identifier)
    files = {p.name: p.read_text(encoding="utf-8") for p in sorted((Path(__file__).parent / "c").iterdir())} | text
    files |= {name: (header_folder() / name).read_text(encoding="utf-8") for name in HEADERS}
    descriptions = {v: _description(v, table, identifier, "", sources) for v in VERSIONS}
    token = _token(files, descriptions)
    files["model_data.h"] = files["model_data.h"].replace("@TOKEN@", token)

    libraries = _libraries(files, identifier, targets)
    about = _documentation(table, identifier, sources)
    written = []
    for version in fmi:
        members = {"modelDescription.xml": _description(version, table, identifier, token, sources)}
        members |= binaries(version, identifier, libraries)
        if sources:
            members |= {f"sources/{name}": content.encode() for name, content in sorted(files.items())}
            members["sources/buildDescription.xml"] = description3.build_description(identifier, list(SOURCES))
        members |= about
        if version == "2":
            members["model.png"] = picture.png(component)
        else:  # FMI Library refuses an FMI 2.0 FMU that has terminals
            members["documentation/diagram.png"] = picture.png(component)
            members["documentation/diagram.svg"] = picture.svg(component)
            members[f"terminalsAndIcons/{description3.ICON}.png"] = picture.png(component)
            members[f"terminalsAndIcons/{description3.ICON}.svg"] = picture.svg(component)
            members["terminalsAndIcons/terminalsAndIcons.xml"] = description3.terminals(table)
        directory.mkdir(parents=True, exist_ok=True)
        file = directory / f"{component.name}.{component.variant}{VERSIONS[version]}"
        written.append(write_zip(file, members, executable="binaries/"))
    return written


def _description(version: str, table: Table, identifier: str, token: str, sources: bool) -> bytes:
    tool = f"gyro-cosim {importlib.metadata.version('gyro-cosim')}"
    if version == "3":
        return description3.fmi3(table, identifier, token, tool, code.output_order(table))
    return description.fmi2(table, identifier, token, tool, code.output_order(table), list(SOURCES) if sources else [])


def _documentation(table: Table, identifier: str, sources: bool) -> dict[str, bytes]:
    """The page, the reference results with their manifest and the licences, by path."""
    component = table.component
    members = {"documentation/index.html": page.html(table, identifier, sources=sources)}
    for suffix, (header, rows) in (("in", reference.inputs(component)), ("ref", reference.results(component))):
        members[f"{reference.FOLDER}/{identifier}_{suffix}.csv"] = reference.csv(header, rows)
    members[reference.MANIFEST] = reference.manifest(identifier)
    if component.scene is not None:
        members[PLACE] = json.dumps(component.scene, indent=1).encode()
    for file in sorted((Path(__file__).parent / "licenses").iterdir()):
        members[f"documentation/licenses/{file.name}"] = file.read_bytes()
    licence = importlib.metadata.distribution("gyro-cosim").read_text("licenses/LICENSE")
    if licence is None:
        raise RuntimeError("the installed package gyro-cosim must hold its LICENSE")
    members["documentation/licenses/gyro-cosim.txt"] = licence.encode()
    return members


def header_folder() -> Path:
    """FMI's headers, which FMPy ships; found without loading it."""
    spec = importlib.util.find_spec("fmpy")
    if spec is None or not spec.submodule_search_locations:
        raise RuntimeError("FMPy must be installed: it holds the headers of FMI")
    return Path(spec.submodule_search_locations[0]) / "c-code"


def _token(files: dict[str, str], descriptions: dict[str, bytes]) -> str:
    """A name for exactly this content, in the form of a GUID."""
    content = hashlib.sha256()
    for name, data in sorted({**{n: t.encode() for n, t in files.items()}, **descriptions}.items()):
        content.update(f"{name} {len(data)} ".encode() + data)
    return f"{{{uuid.UUID(bytes=content.digest()[:16], version=4)}}}"


def _libraries(files: dict[str, str], name: str, targets: dict[Platform, bool]) -> dict[Platform, bytes]:
    """The compiled library for each platform."""
    with tempfile.TemporaryDirectory(prefix="fmu-") as scratch:
        for file, content in files.items():
            Path(scratch, file).write_text(content, encoding="utf-8", newline="\n")
        return compile_libraries(Path(scratch), SOURCES, name, targets)


def binaries(version: str, identifier: str, libraries: dict[Platform, bytes]) -> dict[str, bytes]:
    """Members by path. FMI 2.0 has one folder for macOS; a library for both processors goes there."""
    members: dict[str, bytes] = {}
    macs = {p.name: data for p, data in libraries.items() if p.suffix == ".dylib"}
    for target, library in libraries.items():
        folder = target.name if version == "3" else target.folder
        if version == "2" and len(macs) == 2 and target.name in macs:
            library = universal(macs["x86_64-darwin"], macs["aarch64-darwin"])
        members[f"binaries/{folder}/{identifier}{target.suffix}"] = library
    return members
