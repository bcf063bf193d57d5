"""Where results come from, for every result of the command line: the command, versions, hashes of what was read."""

import hashlib
import os
import platform
import re
from collections.abc import Iterator, Sequence
from importlib import metadata
from pathlib import Path

from ..systems import System, archive, catalogue
from ..trajectory import Origin
from .given import arguments

PACKAGES = ("gyro-cosim", "casadi", "fmpy", "numpy", "scipy")


def versions() -> dict[str, str]:
    """What a run depends on that no file of its own tells."""
    found = {name: metadata.version(name) for name in PACKAGES}
    return {**found, "python": platform.python_version(), "machine": f"{platform.system()} {platform.machine()}"}


def origin(*plans: System, written: Sequence[Path] = ()) -> Origin:
    """Where results of the present command on `plans` come from; hashes of files are SHA-256.

    written : files that the command writes, which decide on nothing.
    """
    command = arguments()
    own = {file.absolute() for file in written}
    hashes: dict[str, str] = {}
    for name in _files(command):
        if Path(name).absolute() not in own:
            hashes[name] = hash_of_file(name)
    for source in dict.fromkeys(part.source for plan in plans for part in plan.components):
        if not source.startswith(("process:", "tcp://")) and _shown(source) not in hashes:
            hashes[_shown(source)] = hash_of_source(source)
    return Origin(command, str(Path.cwd()), versions(), hashes)


def hash_of_file(name: str) -> str:
    """SHA-256 of a file, or of a member of an archive."""
    if "#" in name and not Path(name).is_file():
        return hashlib.sha256(archive.read(name)).hexdigest()
    with Path(name).open("rb") as stream:
        return hashlib.file_digest(stream, "sha256").hexdigest()


def hash_of_source(source: str) -> str:
    """Of what a component comes from: an FMU's file, or all that decides on a component of the catalogue."""
    if source.endswith(".fmu"):
        return hash_of_file(source)
    return catalogue.decided_by(source)


def _shown(source: str) -> str:
    """A source as seen from the current folder, where it lies below it."""
    here = f"{Path.cwd()}{os.sep}"
    return Path(source[len(here) :]).as_posix() if source.startswith(here) else source


def _files(command: Sequence[str]) -> Iterator[str]:
    """The files that the words of a command name, alone or as in NAME=FILE,A=B."""
    seen = set()
    for word in command:
        for name in (word, *re.split(r"[=,]", word)):
            if name and name not in seen and Path(name).is_file():
                seen.add(name)
                yield name
