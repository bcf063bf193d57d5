"""The results of a run whose process an FMU takes down, or in which one does not come back: written all the same."""

import atexit
import os
import sys
from pathlib import Path

from ..master.simulation import Running
from .kept import voice
from .results import Files

__all__ = ["Rescue"]

HINT = "--isolate gives each FMU a process of its own"


class Rescue:
    """What LastWord calls: `word`. files : where the results go."""

    def __init__(self, files: Files) -> None:
        self._files = files
        self._running: Running | None = None
        self._streamed: Path | None = None
        self._written = False

    def begun(self, running: Running, streamed: Path | None) -> None:
        """The run that is to be rescued, and the file that its rows go to by themselves."""
        self._running, self._streamed = running, streamed

    def written(self) -> None:
        """Its results are on disk: there is nothing to rescue any more."""
        self._running, self._written = None, True

    def word(self, reason: str) -> None:
        """Write the results so far and say what has happened, one line each; the process ends here."""
        lines, who, when = [], "a component", ""
        if self._written:
            when = " after the run, whose results were written before"
        if self._running is not None:
            trajectory, name = self._running.rescue()
            who = f"component {name!r}" if name else who
            when = f" at t = {trajectory.t[-1]:.9g} s"
            kept = self._files.rescue(trajectory, self._streamed)
            lines = [f"kept the results up to t = {trajectory.t[-1]:g} s in {file}" for file in kept]
        lines.append(f"cosim: {who} {reason}{when}; {HINT}")
        text = "".join(f"{' '.join(line.split())}\n" for line in lines)
        sys.stderr.flush()
        try:
            os.write(2, text.encode(errors="replace"))
            voice().told()
            atexit._run_exitfuncs()  # temporary folders; whoever keeps this process sees to it, too
        finally:
            os._exit(1)
