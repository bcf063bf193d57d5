"""Temporary folders that go with their process, or else with the next one.

A process that is killed cannot remove its folders. So each holds a file that its owner keeps locked, and the kernel frees the
lock with the process, however that ends. Who takes a first folder looks for those whose lock is free, and removes them. The
file gets its name only once it is locked: a folder that has just been made is never taken for a stale one. Where files cannot
be locked (Windows), stale folders stay.
"""

import contextlib
import os
import shutil
import tempfile
import weakref
from functools import lru_cache
from pathlib import Path
from types import TracebackType
from typing import IO

try:
    import fcntl
except ImportError:
    fcntl = None  # type: ignore[assignment]

PREFIX, LOCK = "cosim-", ".cosim-lock"


class ScratchFolder:
    """A folder at `path`; remove() takes it away, at the latest when the program ends."""

    def __init__(self) -> None:
        clean(tempfile.gettempdir())
        self.path = Path(tempfile.mkdtemp(prefix=PREFIX))
        self.remove = weakref.finalize(self, _remove, self.path, _lock(self.path))

    def __enter__(self) -> Path:
        return self.path

    def __exit__(self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None) -> None:
        self.remove()


@lru_cache(maxsize=1)
def clean(place: str) -> None:
    """Remove the folders in `place` that this user's dead processes have left; once in this process."""
    if fcntl is None:
        return
    with contextlib.suppress(OSError), os.scandir(place) as entries:
        for entry in entries:
            if entry.name.startswith(PREFIX):
                with contextlib.suppress(OSError):  # somebody else's, or just gone
                    _clean_one(entry)


def _clean_one(entry: "os.DirEntry[str]") -> None:
    if entry.is_symlink() or entry.stat(follow_symlinks=False).st_uid != os.getuid():
        return
    with Path(entry.path, LOCK).open("rb") as file:
        fcntl.flock(file, fcntl.LOCK_EX | fcntl.LOCK_NB)  # BlockingIOError, an OSError, where the owner lives
        shutil.rmtree(entry.path, ignore_errors=True)


def _lock(folder: Path) -> IO[bytes] | None:
    """The open, locked file that says that the owner lives; None where there can be none."""
    if fcntl is None:
        return None
    try:
        file = (folder / f"{LOCK}-new").open("wb")
    except OSError:
        return None
    try:
        fcntl.flock(file, fcntl.LOCK_EX | fcntl.LOCK_NB)
        (folder / f"{LOCK}-new").rename(folder / LOCK)
    except OSError:
        file.close()
        return None
    return file


def _remove(folder: Path, lock: IO[bytes] | None) -> None:
    shutil.rmtree(folder, ignore_errors=True)
    if lock is not None:
        lock.close()
