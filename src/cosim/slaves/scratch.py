"""Temporary folders that go with their process, or else with the next one.

A process that is killed cannot remove its folders. So it keeps each locked, and the kernel frees the lock with the process,
however that ends. Who takes a first folder looks for those whose lock is free, and removes them. One that is taken for a left one
after it was made and before it was locked is made again. Where folders cannot be locked (Windows), stale ones stay.
"""

import contextlib
import os
import shutil
import tempfile
import weakref
from functools import lru_cache
from pathlib import Path
from types import TracebackType

try:
    import fcntl
except ImportError:
    fcntl = None  # type: ignore[assignment]

PREFIX = "cosim-scratch-"


class ScratchFolder:
    """A folder at `path`; remove() takes it away, at the latest when the program ends."""

    def __init__(self) -> None:
        clean(tempfile.gettempdir())
        self.path, lock = _made()
        self.remove = weakref.finalize(self, _remove, self.path, lock)

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
    folder = os.open(entry.path, os.O_RDONLY | os.O_DIRECTORY)
    try:
        fcntl.flock(folder, fcntl.LOCK_EX | fcntl.LOCK_NB)  # BlockingIOError, an OSError, where the owner lives
        shutil.rmtree(entry.path, ignore_errors=True)
    finally:
        os.close(folder)


def _made() -> tuple[Path, int | None]:
    """A new folder, and what keeps its lock; None where there can be none."""
    while True:
        path = Path(tempfile.mkdtemp(prefix=PREFIX))
        if fcntl is None:
            return path, None
        try:
            lock = os.open(path, os.O_RDONLY | os.O_DIRECTORY)
        except FileNotFoundError:
            continue
        try:
            fcntl.flock(lock, fcntl.LOCK_EX)
        except OSError:  # a file system without locks
            os.close(lock)
            return path, None
        if path.is_dir():
            return path, lock
        os.close(lock)


def _remove(folder: Path, lock: int | None) -> None:
    shutil.rmtree(folder, ignore_errors=True)
    if lock is not None:
        os.close(lock)
