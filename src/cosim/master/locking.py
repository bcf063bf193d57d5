"""One run at a time into one file: who comes second is refused, and told who is there."""

import json
import os
import sys
from collections.abc import Iterable, Iterator
from contextlib import ExitStack, contextmanager
from pathlib import Path

try:
    import fcntl
except ImportError:
    fcntl = None  # type: ignore[assignment]


@contextmanager
def in_use(files: Iterable[Path]) -> Iterator[None]:
    """Keep other processes of ours out of these files; where files cannot be locked (Windows), nothing is kept out.

    The lock lies in a file beside each, which says whose it is and goes with it. The system frees it however a process ends.

    Raises
    ------
    ValueError
        Names the file and the process that has it.
    OSError
        Where there can be no file beside it.
    """
    with ExitStack() as locks:
        for file in dict.fromkeys(Path(os.path.realpath(f)) for f in files):
            if fcntl is not None and (file.is_file() or not file.exists()):
                locks.enter_context(_locked(file))
        yield


@contextmanager
def _locked(file: Path) -> Iterator[None]:
    lock = file.with_name(f".{file.name}.lock")
    while True:
        try:
            stream = lock.open("a+b")
        except OSError as error:
            raise OSError(error.errno, error.strerror, str(file)) from None
        try:
            fcntl.flock(stream, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except OSError:
            stream.seek(0)
            owner = _owner(stream.read(4096))
            stream.close()
            raise ValueError(f"file {str(file)!r} must not be in use, {owner} writes to it") from None
        if _same(stream.fileno(), lock):
            break
        stream.close()  # its owner has just taken it away
    try:
        stream.truncate(0)
        stream.write(json.dumps({"process": os.getpid(), "command": " ".join(sys.argv)[:1000]}).encode())
        stream.flush()
        yield
    finally:
        lock.unlink(missing_ok=True)
        stream.close()


def _same(descriptor: int, path: Path) -> bool:
    try:
        return os.path.samestat(os.fstat(descriptor), path.stat())
    except OSError:
        return False


def _owner(told: bytes) -> str:
    try:
        owner = json.loads(told)
        return f"process {int(owner['process'])} ({str(owner['command'])[:200]})"
    except (ValueError, KeyError, TypeError):
        return "another process"
