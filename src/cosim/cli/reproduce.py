"""cosim reproduce: run the command that made a file of results again, and compare bit by bit."""

import contextlib
import os
import subprocess
import sys
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, Any

import typer

from ..errors import RunError
from ..slaves.scratch import ScratchFolder
from ..trajectory import Origin, Trajectory, read_with_origin
from ..trajectory.sameness import Difference, first_difference
from .common import AsJson, say, tell
from .provenance import hash_of_file, hash_of_source, versions

INNER = "--integrator-steps"
# Options of `run` that decide on no number of its results, with how many words belong to each besides.
WITHOUT_EFFECT = {
    "--output": 1, "--plot": 1, "--checkpoint": 1, "--every": 1, "--resume": 1, "--json": 0, "--realtime": 0, "--overrun": 1,
    "--priority": 1, "--reference": 1, "--tolerance-band": 1, "--certify": 0, "--robust": 0, "--starts": 1, "--within": 1,
    "--report": 1, "--report-variants": 1, "--seed": 1, INNER: 1, "--live": 0,
}  # fmt: skip


def command(
    file: Annotated[Path, typer.Argument(metavar="RESULT", help="a .csv, .mat, .parquet or .mf4 that cosim run has written")],
    as_json: AsJson = False,
) -> int:
    """Run the command that made RESULT again, with what is installed now, and compare the results bit by bit.

    What has changed since, versions and files, is told before. Exit code 1 unless every bit is the same: the first signal and
    time that differ are named. The command runs in the folder where it ran then, as seen from RESULT.
    """
    made = Made.of(file)
    tell(made.changed)
    after = made.again()
    different = first_difference(made.results, after)
    told = document(file, made.arguments, made.changed, made.results, different)
    say(as_json, lambda: told, f"cosim {' '.join(made.arguments)}", _words(made.results, different))
    return 0 if different is None else 1


@dataclass(frozen=True)
class Made:
    """Results, and what made them.

    Attributes
    ----------
    file : Path
        Where they stand.
    results : Trajectory
        As they were read.
    arguments : tuple of str
        Of `cosim`, those that decide on the results.
    folder : Path
        Where the command ran.
    changed : tuple of str
        What is not as it was then, a line each.
    component : str
        Whose integrator's steps the file holds; empty: the results of the run.
    """

    file: Path
    results: Trajectory
    arguments: tuple[str, ...]
    folder: Path
    changed: tuple[str, ...]
    component: str = ""

    @classmethod
    def of(cls, file: Path) -> "Made":
        """What a file says; ValueError where it says nothing, or its command cannot be run again."""
        results, origin = read_with_origin(file)
        if origin is None:
            rule = "must say where it comes from: cosim run writes FILE.origin.json beside .csv and .mat"
            raise ValueError(f"{str(file)!r} {rule}")
        if origin.command[:1] != ("run",):
            said = " ".join(origin.command) or "no command"
            raise ValueError(f"{str(file)!r} must come from cosim run to be run again, it comes from {said!r}")
        folder = (file.resolve().parent / origin.folder).resolve()
        if not folder.is_dir():
            raise ValueError(f"{str(file)!r}: the folder where its command ran must exist, {str(folder)!r} does not")
        component = _component_of(origin.command, folder, file)
        return cls(file, results, (*deciding(origin.command),), folder, (*_changed(origin, folder),), component)

    def again(self, *more: str) -> Trajectory:
        """The results of the command, run in a process of its own with `more` options, in a file of the same format."""
        with ScratchFolder() as scratch:
            result = scratch / f"again{self.file.suffix}"
            wanted = [INNER, f"{self.component}={result}"] if self.component else ["--output", str(result)]
            call = [sys.executable, "-P", "-m", "gyro_cosim", *self.arguments, *wanted, *more]
            done = subprocess.run(call, cwd=self.folder, stdout=subprocess.DEVNULL, stderr=None, env=os.environ, check=False)
            if not result.is_file():
                raise RunError(f"the command must give results again, it left with exit code {done.returncode} and none")
            return read_with_origin(result)[0]


def document(
    file: Path, arguments: Sequence[str], changed: Sequence[str], before: Trajectory, different: Difference | None
) -> dict[str, Any]:
    """The answer as JSON holds it."""
    return {
        "file": str(file), "command": list(arguments), "changed": list(changed), "same": different is None,
        "points": len(before), "signals": len(before.names),
        "difference": None if different is None else vars(different),
    }  # fmt: skip


def _words(before: Trajectory, different: Difference | None) -> str:
    if different is None:
        return f"the same, bit by bit: {len(before)} points of {len(before.names)} signals"
    return f"not the same: {different}"


def deciding(command: Sequence[str]) -> Iterator[str]:
    """The words of a command that decide on its results."""
    left = 0
    for word in command:
        if left:
            left -= 1
            continue
        option, equals, _ = word.partition("=")
        if option in WITHOUT_EFFECT:
            left = 0 if equals else WITHOUT_EFFECT[option]
            continue
        yield word


def _changed(origin: Origin, folder: Path) -> Iterator[str]:
    """What is not as it was when the results were made."""
    own = versions()
    for name, version in origin.versions.items():
        if own.get(name, "none") != version:
            yield f"{name} was {version}, is {own.get(name, 'none')}"
    with contextlib.chdir(folder):
        yield from _changed_files(origin.hashes)


def _changed_files(hashes: Mapping[str, str]) -> Iterator[str]:
    for name, digest in hashes.items():
        place = name.partition("#")[0]
        try:
            present = hash_of_file(name) if Path(place).is_file() else hash_of_source(name)
        except (ValueError, OSError) as error:
            yield f"{name} cannot be had any more: {error}"
            continue
        if present != digest:
            yield f"{name} has changed"


def _component_of(command: Sequence[str], folder: Path, file: Path) -> str:
    """The component whose --integrator-steps went into the file; empty where the file holds the results."""
    for option, equals, more in (word.partition("=") for word in command):
        if option == INNER and equals:  # --integrator-steps=COMPONENT=FILE
            option, _, more = more.partition("=")
        if more and (folder / more).resolve() == file.resolve():
            return "" if option == "--output" else option
    return ""
