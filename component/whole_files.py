"""Files that are there as a whole or not at all, whatever happens while they are written: a full disk, a crash, no power."""

import os
import re
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path

try:
    import fcntl
except ImportError:  # Windows: what a killed process was writing stays beside its goal there
    fcntl = None  # type: ignore[assignment]

__all__ = ["folder_to_disk", "moved_in", "removed_from_disk", "whole_file", "write_whole"]

BESIDE = "cosim"  # .STEM.cosim-RANDOM.SUFFIX is a file that is being written


@contextmanager
def whole_file(path: Path, outdated: Path | None = None) -> Iterator[Path]:
    """A place beside `path` to write to; what is there at the end takes the place of `path`, once it is on the disk.

    Parameters
    ----------
    path : Path
        The file, in a folder that exists. What is no plain file (a device, a pipe) is written to directly.
    outdated : Path, optional
        See moved_in().

    Yields
    ------
    Path
        With the same ending as `path`. It is locked as long as this process lives: what one that was killed has left beside
        `path` is removed by the next.

    Raises
    ------
    OSError
        Where it cannot be written, naming `path`. The file that was there is untouched then, and nothing is left beside it.
    """
    if path.exists() and not path.is_file():
        yield path
        return
    goal = Path(os.path.realpath(path))  # a link stays a link
    try:
        _clean(goal)
        handle, beside = _begun(goal)
    except OSError as error:
        raise OSError(error.errno, error.strerror, str(path)) from error
    try:
        mask = os.umask(0)
        os.umask(mask)
        beside.chmod(goal.stat().st_mode & 0o777 if goal.exists() else 0o666 & ~mask)
        yield beside
        moved_in(beside, goal, outdated)
    except OSError as error:
        raise OSError(error.errno, error.strerror or str(error), str(path)) from error
    finally:
        with suppress(OSError):
            beside.unlink(missing_ok=True)
        if handle is not None:
            os.close(handle)


def write_whole(path: Path, text: str) -> None:
    """Write a text file in UTF-8, as a whole or not at all; OSError names it."""
    with whole_file(path) as beside:
        beside.write_text(text, encoding="utf-8")


def moved_in(beside: Path, goal: Path, outdated: Path | None = None) -> None:
    """Put a file that is complete in the place of another, so that a loss of power leaves one of the two.

    outdated : a file that tells something of the one that is replaced; it is gone for sure before the other comes.
    """
    with beside.open("rb+") as file:
        os.fsync(file.fileno())
    if outdated is not None:
        removed_from_disk(outdated)
    beside.replace(goal)
    folder_to_disk(goal.parent)


def removed_from_disk(path: Path) -> None:
    """Remove a file, if there is one, for sure before what comes next."""
    if path.exists():
        path.unlink()
        folder_to_disk(path.parent)


def folder_to_disk(folder: Path) -> None:
    """Force the names in a folder to the disk: files that were made, renamed, removed."""
    if os.name == "nt":  # a folder is a file there that cannot be opened
        return
    handle = os.open(folder, os.O_RDONLY)
    try:
        with suppress(OSError):  # a file system that has no such thing
            os.fsync(handle)
    finally:
        os.close(handle)


def _begun(goal: Path) -> tuple[int | None, Path]:
    """A new file beside `goal`, and what keeps its lock, where there are locks."""
    while True:
        handle, name = tempfile.mkstemp(prefix=f".{goal.stem}.{BESIDE}-", suffix=goal.suffix, dir=goal.parent)
        if fcntl is None:
            os.close(handle)
            return None, Path(name)
        with suppress(OSError):  # a file system without locks
            fcntl.flock(handle, fcntl.LOCK_EX)
        if os.fstat(handle).st_nlink:
            return handle, Path(name)
        os.close(handle)  # somebody has taken it for a left one before it was locked


def _clean(goal: Path) -> None:
    """Remove what processes that are gone have begun beside `goal`."""
    if fcntl is None:
        return
    left = re.compile(rf"\.{re.escape(goal.stem)}\.{BESIDE}-\w{{8}}{re.escape(goal.suffix)}")
    with os.scandir(goal.parent) as entries:
        names = [entry.path for entry in entries if left.fullmatch(entry.name) and entry.is_file(follow_symlinks=False)]
    for name in names:
        with suppress(OSError):  # somebody else's, still written, or just gone
            handle = os.open(name, os.O_RDONLY)
            try:
                fcntl.flock(handle, fcntl.LOCK_EX | fcntl.LOCK_NB)
                Path(name).unlink()
            finally:
                os.close(handle)
