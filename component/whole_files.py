"""Files that are there as a whole or not at all, whatever happens while they are written: a full disk, a crash."""

import os
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path

__all__ = ["moved_in", "whole_file", "write_whole"]


@contextmanager
def whole_file(path: Path) -> Iterator[Path]:
    """A place beside `path` to write to; what is there at the end takes the place of `path`, once it is on the disk.

    Parameters
    ----------
    path : Path
        The file, in a folder that exists. What is no plain file (a device, a pipe) is written to directly.

    Yields
    ------
    Path
        With the same ending as `path`.

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
        handle, name = tempfile.mkstemp(prefix=f".{goal.stem}.", suffix=goal.suffix, dir=goal.parent)
    except OSError as error:
        raise OSError(error.errno, error.strerror, str(path)) from error
    os.close(handle)
    beside = Path(name)
    try:
        mask = os.umask(0)
        os.umask(mask)
        beside.chmod(goal.stat().st_mode & 0o777 if goal.exists() else 0o666 & ~mask)
        yield beside
        moved_in(beside, goal)
    except OSError as error:
        raise OSError(error.errno, error.strerror or str(error), str(path)) from error
    finally:
        with suppress(OSError):
            beside.unlink(missing_ok=True)


def write_whole(path: Path, text: str) -> None:
    """Write a text file in UTF-8, as a whole or not at all; OSError names it."""
    with whole_file(path) as beside:
        beside.write_text(text, encoding="utf-8")


def moved_in(beside: Path, goal: Path) -> None:
    """Put a file that is complete in the place of another, so that a loss of power leaves one of the two."""
    with beside.open("rb+") as file:
        os.fsync(file.fileno())
    beside.replace(goal)
    if os.name != "nt":  # a folder is a file there that cannot be opened
        folder = os.open(goal.parent, os.O_RDONLY)
        try:
            os.fsync(folder)
        except OSError:  # a file system that has no such thing
            pass
        finally:
            os.close(folder)
