"""Child processes that run a module of this package: started alike, and none outlives its parent."""

import ctypes
import os
import signal
import subprocess
import sys
from collections.abc import Sequence
from pathlib import Path
from typing import IO

TIME_TO_LEAVE = 2.0  # s that a child has to leave before it is killed
_DIE_WITH_PARENT = 1  # prctl's PR_SET_PDEATHSIG


def start(
    module: str, arguments: Sequence[str], *, descriptor: int | None = None, words: IO[bytes] | None = None,
    folder: Path | None = None, temporary: Path | None = None,
) -> "subprocess.Popen[bytes]":  # fmt: skip
    """Run `python -P -m MODULE ARGUMENT... [DESCRIPTOR] PARENT`, the last being this process's id; see belongs().

    Nothing is imported from the current folder: a file there that is called like a module we need is data, not ours.

    descriptor : of a socket that it inherits. words : where what it prints goes. folder : where it runs.
    temporary : where its own temporary files go.
    """
    passed = () if descriptor is None else (descriptor,)
    environment = {**os.environ, "PYTHONPATH": os.pathsep.join(safe_path()), "PYTHONSAFEPATH": "1"}
    if temporary is not None:
        environment["TMPDIR"] = str(temporary)
    return subprocess.Popen(
        [sys.executable, "-P", "-m", module, *arguments, *map(str, passed), str(os.getpid())], env=environment, pass_fds=passed,
        cwd=folder, stdin=subprocess.DEVNULL, stdout=words, stderr=None if words is None else subprocess.STDOUT,
    )  # fmt: skip


def safe_path() -> list[str]:
    """Where this process imports from, without the current folder."""
    here = os.path.realpath(".")
    return [place for place in sys.path if place and os.path.realpath(place) != here]


def end(child: "subprocess.Popen[bytes]") -> None:
    """Wait for a child that was told to leave, and kill one that does not."""
    try:
        child.wait(TIME_TO_LEAVE)
    except subprocess.TimeoutExpired:
        child.kill()
        child.wait()


def belongs() -> bool:
    """The first thing in a child: Ctrl-C is its parent's business, and it dies when that dies; False if that is gone already."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    if sys.platform == "linux":
        ctypes.CDLL(None).prctl(_DIE_WITH_PARENT, signal.SIGKILL)
    if sys.platform == "win32":  # in a virtual environment the parent there is a launcher
        return True
    return os.getppid() == int(sys.argv[-1])
