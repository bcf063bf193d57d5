"""The FMU of a coupled system as a file: complete, or not at all."""

import hashlib
import importlib.metadata
import re
import uuid
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

from gyro_cosim.component.zip_files import write_zip

from ..coupling import Algorithm, Jacobi
from ..master import macro_steps, open_network
from ..systems import System, archive, linking
from . import description, tables
from .components import Packed, packed, refuse_what_the_kernel_cannot
from .description import Identity
from .variables import ALGORITHMS, Variables

__all__ = ["VERSIONS", "pack_fmu"]

VERSIONS = {"2": (".fmu", description.fmi2), "3": (".fmi3.fmu", description.fmi3)}
KERNEL = Path(__file__).parent.parent / "kernel" / "kernel.c"


def pack_fmu(
    system: System,
    directory: str | Path,
    *,
    algorithm: Algorithm | None = None,
    step: float | None = None,
    fmi: Sequence[str] = ("2",),
    platforms: Sequence[str] = ("host",),
    sources: bool = True,
) -> list[Path]:
    """Write a coupled system as FMUs for Co-Simulation that need nothing but themselves.

    A file appears complete or not at all. A run of it gives the bits of a run of the system.

    Parameters
    ----------
    system : System
        Its components of the catalogue are compiled in, FMUs from files are carried inside and loaded by it.
    directory : str or Path
        The folder for the files; made where there is none. With one version it may be a file that ends in .fmu.
    algorithm : Algorithm, optional
        What the FMU's parameters `algorithm` and `degree` start with; Jacobi(1) where None.
    step : float, optional
        The same of `macro_step`, s; the system's own where None.
    fmi : sequence of str
        "2", "3" or both. Files are called SYSTEM.fmu and SYSTEM.fmi3.fmu.
    platforms : sequence of str
        "host" (with the machine's own C compiler if it has one), "all", or names such as "x86_64-windows".
    sources : bool
        Whether to ship the C sources.

    Returns
    -------
    list of Path
        The files, in the order of `fmi`.

    Raises
    ------
    ValueError
        The inner loop cannot run the system or has no such algorithm, or a component has no library for a platform.
    RuntimeError
        There is no compiler, or it refuses the code.
    """
    system.refuse_driven("a system as one FMU")
    for version in fmi:
        if version not in VERSIONS:
            raise ValueError(f"FMI version must be one of {', '.join(VERSIONS)}, got {version!r}")
    chosen = Jacobi(1) if algorithm is None else algorithm
    if chosen.name not in ALGORITHMS:
        raise ValueError(f"algorithm of a system as one FMU must be one of {', '.join(ALGORITHMS)}, got {chosen.name!r}")
    if step is not None:
        macro_steps(step, max(step, system.stop - system.start))
        system = replace(system, step=step)
    directory = Path(directory)
    file_name = directory.name if directory.suffix == ".fmu" and not directory.is_dir() else ""
    if file_name and len(fmi) > 1:
        raise ValueError(f"two versions of FMI must go into a folder, got the file {str(directory)!r}")
    directory = directory.parent if file_name else directory
    if directory.exists() and not directory.is_dir():
        raise ValueError(f"directory must be a folder, got the file {str(directory)!r}")
    identifier = re.sub(r"\W", "_", system.name, flags=re.ASCII)
    identifier = identifier if identifier[:1].isalpha() else f"system_{identifier}"
    with open_network(system) as network:
        refuse_what_the_kernel_cannot(system, network)
        components = packed(system, network)
        variables = Variables(system, network, components, chosen)
        data = tables.system_data(system, network, components, variables, chosen)
    master = {file.name: file.read_text(encoding="utf-8") for file in sorted((Path(__file__).parent / "c").iterdir())}
    master |= {"kernel.c": KERNEL.read_text(encoding="utf-8"), "system_data.h": data}
    _refuse_missing_libraries(components, linking.platform_folders(tuple(platforms)))
    parts, carried = _sources(components), _carried(components)
    token = _token(master, parts, components)
    master["system_data.h"] = data.replace("@TOKEN@", token)
    linked = linking.linked(identifier, master, parts, platforms=tuple(platforms), loads=bool(carried))
    tool = f"gyro-cosim {importlib.metadata.version('gyro-cosim')}"
    identity = Identity(identifier, token, tool, tuple(linked.compiled) if sources else ())
    written = []
    for version in fmi:
        suffix, describe = VERSIONS[version]
        members = {"modelDescription.xml": describe(system, components, variables, identity)}
        members |= linked.binaries[version] | carried
        if sources:
            members |= {f"sources/{name}": text.encode() for name, text in sorted(linked.files.items())}
            members["sources/buildDescription.xml"] = description.build_description(identity)
        directory.mkdir(parents=True, exist_ok=True)
        written.append(write_zip(directory / (file_name or f"{system.name}{suffix}"), members, executable="binaries/"))
    return written


def _sources(components: Sequence[Packed]) -> dict[str, dict[str, str]]:
    """The C files of every linked FMU, by the prefix of its functions; no two have a function in common."""
    found = {}
    identifiers = {part.location: part.model.interfaces["CoSimulation"]["modelIdentifier"] for part in components}
    taken: set[str] = set()
    for location, prefix in tables.prefixes(components).items():
        with archive.opened(location) as members:
            names = sorted(name for name in members.namelist() if name.startswith("sources/") and name.endswith((".c", ".h")))
            files = {name.removeprefix("sources/"): members.read(name).decode() for name in names}
        identifier = identifiers[location]
        if identifier in taken:  # its generated functions begin with it
            files = {name: re.sub(rf"\b{identifier}(?=_)", f"{prefix}{identifier}", text) for name, text in files.items()}
        taken.add(identifier)
        found[prefix] = files
    return found


def _carried(components: Sequence[Packed]) -> dict[str, bytes]:
    """The files of every carried FMU, by path."""
    found: dict[str, bytes] = {}
    for i, place in tables.carried(components).items():
        part = components[i]
        with archive.opened(part.location) as members:
            for name in members.namelist():
                if name.startswith(("binaries/", "resources/", "modelDescription.xml")) and not name.endswith("/"):
                    found[f"resources/{place}/{name}"] = members.read(name)
    return found


def _refuse_missing_libraries(components: Sequence[Packed], folders: dict[str, tuple[str, ...]]) -> None:
    """ValueError where a carried FMU has no library for a platform that there is one of the whole for."""
    for part in components:
        if part.linked:
            continue
        with archive.opened(part.location) as members:
            held = {name.split("/")[1] for name in members.namelist() if name.startswith("binaries/") and not name.endswith("/")}
        for needed in sorted(set(folders[part.model.version]) - held):
            has = ", ".join(sorted(held)) or "none"
            raise ValueError(f"FMU {part.location!r} of {part.name!r} must hold a binary for {needed}, has {has}")


def _token(master: dict[str, str], parts: dict[str, dict[str, str]], components: Sequence[Packed]) -> str:
    """A name for exactly this content, in the form of a GUID."""
    texts = [master, *parts.values()]
    content = hashlib.sha256()
    for name, text in ((name, text) for files in texts for name, text in sorted(files.items())):
        content.update(f"{name} {len(text)} {text}".encode())
    for part in components:
        if not part.linked:
            content.update(archive.read(part.location))
    return f"{{{uuid.UUID(bytes=content.digest()[:16], version=4)}}}"
