"""Doors under mutated input: whatever comes in, a value comes out, or one line that says what is wrong.

    python campaigns/fuzz.py [--inputs N] [--seed K] [--keep FOLDER] [DOOR ...]      `make fuzz`

Every door reads one kind of input. Of a good one, N are made with a mistake in each, by a generator seeded with K, the door and
the number, so that any can be made again. An input is

    read       the door takes it
    refused    in one line: a ValueError or RunError without a line break
    silent     a key, element or attribute is misspelt, and the door takes it without a word, but reads something else than before
    traceback  any other error, or one of more than a line
    hang       10 s and no end
    memory     more than 1 GB
    crash      the process is gone

The last five are findings: written to FOLDER with the number that makes them again, and exit code 1.
"""

import argparse
import logging
import os
import random
import re
import resource
import signal
import sys
import tempfile
import time
from collections import Counter
from multiprocessing import get_context
from pathlib import Path
from typing import Any

import numpy as np
from doors import Door, doors
from mutation import Changed

from gyro_cosim.errors import RunError

LONGEST, MEMORY = 10, 1 << 30  # s; bytes over what the process needs anyway
FINDINGS = ("silent", "traceback", "hang", "memory", "crash")


class _Heard(logging.Handler):
    """Whether anything was said."""

    def __init__(self) -> None:
        super().__init__(logging.INFO)
        self.said = False

    def emit(self, record: logging.LogRecord) -> None:
        """Take note."""
        self.said = True


def made(door: Door, name: str, seed: int, number: int) -> Changed:
    """The input of a number."""
    return door.mutate(door.good, random.Random(f"{seed} {name} {number}"))


def judged(door: Door, file: Path, content: Changed, expected: str) -> tuple[str, str]:
    """What becomes of an input, and the error's words. expected : the good input as it is read."""
    data, misspelt = content
    file.write_bytes(data)
    heard = _Heard()
    logger = logging.getLogger("gyro_cosim")
    logger.addHandler(heard)
    try:
        found = door.read(file)
        told = heard.said or bool(getattr(found, "notes", ()))
        told = told or (isinstance(found, tuple) and bool(getattr(found[0], "schema_faults", ())))  # which a run tells
        silent = misspelt and not told and _shown(found) != expected
        return ("silent", "a misspelt name was taken, and what it stood for was not") if silent else ("read", "")
    except _Hang:
        return "hang", f"no end within {LONGEST} s"
    except MemoryError:
        return "memory", "more than 1 GB"
    except (ValueError, RunError) as error:
        return ("traceback", f"more than a line: {str(error)!r}") if "\n" in str(error) else ("refused", str(error))
    except Exception as error:
        return "traceback", f"{type(error).__name__}: {error}"
    finally:
        logger.removeHandler(heard)


class _Hang(BaseException):
    """An input that takes too long."""


def _late(number: int, frame: Any) -> None:
    raise _Hang


def _shown(found: Any) -> str:
    with np.printoptions(threshold=sys.maxsize):
        return re.sub(r" at 0x[0-9a-f]+", "", repr(found))  # where an object lies says nothing of it


def some(name: str, door: Door, seed: int, numbers: range, folder: Path, at: Any, results: Any) -> None:
    """A process: judges the inputs of some numbers, and says at which it is, should it end."""
    logging.getLogger("gyro_cosim").setLevel(logging.INFO)
    logging.getLogger("gyro_cosim").propagate = False
    data = int(Path("/proc/self/statm").read_text(encoding="ascii").split()[5]) * os.sysconf("SC_PAGE_SIZE")
    limit = data + MEMORY
    resource.setrlimit(resource.RLIMIT_DATA, (limit, limit))
    signal.signal(signal.SIGALRM, _late)
    file = folder / f"input-{os.getpid()}{door.ending}"
    file.write_bytes(door.good)
    expected = _shown(door.read(file))
    for number in numbers:
        at.value = number
        signal.alarm(LONGEST)
        try:
            outcome = judged(door, file, made(door, name, seed, number), expected)
        except _Hang:
            outcome = "hang", f"no end within {LONGEST} s"
        finally:
            signal.alarm(0)
        results.put((number, *outcome))
    results.put(None)


def campaign(name: str, door: Door, seed: int, count: int, folder: Path) -> tuple[Counter[str], list[tuple[int, str, str]]]:
    """(how many of each outcome, the findings as (number, outcome, words)) of a door."""
    context = get_context("fork")
    outcomes: Counter[str] = Counter()
    findings = []
    first = 0
    while first < count:
        at, results = context.Value("l", first), context.SimpleQueue()
        process = context.Process(target=some, args=(name, door, seed, range(first, count), folder, at, results))
        process.start()
        results._writer.close()  # so that the reader hears of the end
        try:
            while (told := results.get()) is not None:
                number, outcome, words = told
                outcomes[outcome] += 1
                first = number + 1
                if outcome in FINDINGS:
                    findings.append((number, outcome, words))
            first = count
        except EOFError:
            outcomes["crash"] += 1
            findings.append((at.value, "crash", "the process is gone"))
            first = at.value + 1
        process.join()
    return outcomes, findings


def main() -> int:
    """Exit code 1 where there are findings."""
    parser = argparse.ArgumentParser(description="doors under mutated input")
    parser.add_argument("doors", nargs="*")
    parser.add_argument("--inputs", type=int, default=2000, help="of each door; fewer where one takes long")
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--keep", type=Path, help="a folder for what was found")
    chosen = parser.parse_args()
    total: Counter[str] = Counter()
    with tempfile.TemporaryDirectory() as scratch:
        there = doors(Path(scratch))
        for name in chosen.doors or there:
            began = time.perf_counter()
            count = max(1, round(chosen.inputs * there[name].share))
            outcomes, findings = campaign(name, there[name], chosen.seed, count, Path(scratch))
            total += outcomes
            told = ", ".join(f"{outcome} {n}" for outcome, n in sorted(outcomes.items()))
            print(f"{name:<16} {sum(outcomes.values()):>7} inputs, {time.perf_counter() - began:5.0f} s: {told}", flush=True)
            for number, outcome, words in findings[:5]:
                print(f"    {outcome} {number}: {' '.join(words.split())[:160]}", flush=True)
            if chosen.keep is not None:
                for number, outcome, _ in findings:
                    chosen.keep.mkdir(parents=True, exist_ok=True)
                    content, _ = made(there[name], name, chosen.seed, number)
                    (chosen.keep / f"{name}-{outcome}-{number}{there[name].ending}").write_bytes(content)
    wrong = sum(total[outcome] for outcome in FINDINGS)
    print(f"{sum(total.values())} inputs over {len(chosen.doors or there)} doors: {wrong} findings")
    return 1 if wrong else 0


if __name__ == "__main__":
    sys.exit(main())
