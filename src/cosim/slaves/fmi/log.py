"""What an FMU says: kept for error messages, counted, and handed to Python's logging."""

import logging
from collections import deque
from collections.abc import Callable

from .library import STATUS

LEVELS = (logging.DEBUG, logging.WARNING, logging.WARNING, logging.ERROR, logging.CRITICAL, logging.DEBUG)  # by status


class Log:
    """The messages of the FMU that is called `name` in its system.

    warnings, first_warning : how many messages with status warning there have been since clear(), and the first one's text.

    Every message goes to the logger `gyro_cosim.fmu.NAME`, too, as debug, warning, error or critical by its status.
    """

    def __init__(self, name: str) -> None:
        self._lines: deque[tuple[int, str, str]] = deque(maxlen=100)
        self._logger = logging.getLogger(f"gyro_cosim.fmu.{name}")
        self.name = name
        self._listener: Callable[[int, str, str], None] | None = None
        self.warnings, self.first_warning = 0, ""

    def add(self, status: int, category: bytes | None, message: bytes | None) -> None:
        """Keep a message; those with status ok tell of no trouble and are handed on only."""
        self.say(status, (category or b"").decode(errors="replace"), " ".join((message or b"").decode(errors="replace").split()))

    def say(self, status: int, category: str, text: str) -> None:
        """The same for what is text already."""
        line = (status, category, text)
        level = LEVELS[status] if 0 <= status < len(LEVELS) else logging.ERROR
        if self._logger.isEnabledFor(level):
            self._logger.log(level, "%s: %s", self.name, shown(line))
        if status == STATUS.index("warning"):
            self.warnings += 1
            self.first_warning = self.first_warning or shown(line)
        if status > 0:
            self._lines.append(line)
            if self._listener is not None:
                self._listener(*line)

    def listen(self, listener: Callable[[int, str, str], None]) -> None:
        """Call `listener` with status, category and text of every message that tells of trouble, at once."""
        self._listener = listener

    def clear(self) -> None:
        """Forget; a new run begins."""
        self._lines.clear()
        self.warnings, self.first_warning = 0, ""

    def said(self) -> str:
        """The last lines worth repeating: those of failures, or else warnings."""
        failures = [line for line in self._lines if line[0] > 1]
        return "; ".join(dict.fromkeys(shown(line) for line in (failures or list(self._lines))[-3:]))


def shown(line: tuple[int, str, str]) -> str:
    """A message as people read it: its text, and its category, or status where it has none."""
    status, category, text = line
    return f"{text} [{category or STATUS[status] if status < len(STATUS) else category}]"
