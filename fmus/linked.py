"""Several FMUs of ours in one library: each FMU's sources with a prefix before its functions, as the FMI standard has it."""

import re
import tempfile
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

from .compiler import chosen, compile_libraries
from .package import HEADERS, SOURCES, VERSIONS, binaries, header_folder

__all__ = ["Linked", "folders", "link"]


@dataclass(frozen=True)
class Linked:
    """What link() has made.

    Attributes
    ----------
    files : dict of str to str
        All C files by path below sources/.
    compiled : tuple of str
        Those that a compiler is given.
    binaries : dict of str to dict of str to bytes
        By FMI version, the libraries by their path in the FMU.
    """

    files: dict[str, str]
    compiled: tuple[str, ...]
    binaries: dict[str, dict[str, bytes]]


def link(
    name: str, master: Mapping[str, str], parts: Mapping[str, Mapping[str, str]], platforms: Sequence[str], *, loads: bool = False
) -> Linked:
    """Compile a master with the FMUs that it calls.

    Parameters
    ----------
    name : str
        Of the library, a C identifier.
    master : mapping of str to str
        C files by name; system.c is compiled and includes the others.
    parts : mapping of str to mapping of str to str
        For each prefix of functions the sources of an FMU of this exporter.
    platforms : sequence of str
        As for export().
    loads : bool
        Whether the master loads libraries itself.

    Returns
    -------
    Linked
        Sources and libraries.

    Raises
    ------
    CompilerError
        There is no compiler, or it refuses the code.
    """
    files = dict(master) | {header: (header_folder() / header).read_text(encoding="utf-8") for header in HEADERS}
    levels = {"system.c": "-O3"}
    for prefix, sources in parts.items():
        folder = prefix.rstrip("_")
        files |= {f"{folder}/{file}": text for file, text in sources.items()}
        files |= {f"{folder}/fmi{version}Functions.h": _prefixed(prefix, version, files) for version in VERSIONS}
        levels |= {f"{folder}/{file}": level for file, level in SOURCES.items()}
    with tempfile.TemporaryDirectory(prefix="fmu-") as scratch:
        for file, text in files.items():
            path = Path(scratch, file)
            path.parent.mkdir(exist_ok=True)
            path.write_text(text, encoding="utf-8", newline="\n")
        libraries = compile_libraries(Path(scratch), levels, name, chosen(platforms), libraries=("m", "dl") if loads else ("m",))
    return Linked(files, tuple(levels), {version: binaries(version, name, libraries) for version in VERSIONS})


def folders(platforms: Sequence[str]) -> dict[str, tuple[str, ...]]:
    """What FMUs call platforms in their binaries.

    Parameters
    ----------
    platforms : sequence of str
        As for export().

    Returns
    -------
    dict of str to tuple of str
        By FMI version.
    """
    targets = chosen(platforms)
    return {version: tuple(p.name if version == "3" else p.folder for p in targets) for version in VERSIONS}


def _prefixed(prefix: str, version: str, headers: Mapping[str, str]) -> str:
    """FMI's header of functions for one FMU among several: a prefix before each name, and nothing is exported.

    The standard's own macro for that, FMI2_FUNCTION_PREFIX, is missing in some copies of its header.
    """
    declared = re.findall(
        rf"^\s*FMI{version}_Export\s+(\w+)\s+(fmi{version}\w+)\s*;", headers[f"fmi{version}Functions.h"], re.MULTILINE
    )
    lines = [
        f"/* The functions of FMI {version}.0, each with a prefix. */",
        "#include <stdlib.h>",
        f'#include "fmi{version}FunctionTypes.h"',
        f'#define fmi{version}Version "{version}.0"',
    ]
    for kind, name in declared:
        lines += [f"#define {name} {prefix}{name}", f"{kind} {name};"]
    return "\n".join(lines) + "\n"
