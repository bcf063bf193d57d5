"""The log on the command line: nothing without -v, steps of the work with -v, every message with -vv."""

import logging
import sys
from collections.abc import Iterator, Sequence
from contextlib import contextmanager

FLAGS = {"-v": 1, "--verbose": 1, "-vv": 2}
LEVELS = (logging.WARNING, logging.INFO, logging.DEBUG)


class Plain(logging.Formatter):
    """One line a message, in which control characters are shown, not obeyed: an FMU may write what it likes."""

    def format(self, record: logging.LogRecord) -> str:
        return shown_plainly(super().format(record))


def shown_plainly(text: str) -> str:
    """`text` in one line, in which control characters are shown, not obeyed: an FMU may write what it likes."""
    return "".join(c if c.isprintable() else c.encode("unicode_escape").decode() for c in " ".join(text.split()))


def verbosity(arguments: Sequence[str]) -> tuple[int, list[str]]:
    """How often -v stands among the arguments of a command, wherever it does, and the other arguments."""
    end = arguments.index("--") if "--" in arguments else len(arguments)
    flags = [a for a in arguments[:end] if a in FLAGS]
    return sum(FLAGS[flag] for flag in flags), [*(a for a in arguments[:end] if a not in FLAGS), *arguments[end:]]


@contextmanager
def shown(times: int) -> Iterator[None]:
    """While it lasts, the log goes to standard error; `times` -v was given, 0: nothing does."""
    logger = logging.getLogger("gyro_cosim")
    if not times:
        yield
        return
    handler = logging.StreamHandler(sys.stderr)
    handler.setFormatter(Plain("%(levelname)s %(name)s: %(message)s"))
    before = logger.level
    logger.addHandler(handler)
    logger.setLevel(LEVELS[min(times, 2)])
    try:
        yield
    finally:
        logger.removeHandler(handler)
        logger.setLevel(before)
