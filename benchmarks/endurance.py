"""Does anything grow in a process that lives long? Memory maps, descriptors, threads and memory, counted, and time.

runs    one run after another of the wheel pair with its gyro, as FMUs, in one process
steps   one run of many macro steps, of which every 1000th is kept in a file; its gyro at rest, so that the motion never ends
fmus    one system of many FMUs

Prints what there is at the start and after each tenth of the runs, after each run of `steps`, with each system of `fmus` open.
Exit code 1 where the runs leave a map, a descriptor or a thread behind, or more than 1 kB of memory each.

    python benchmarks/endurance.py [--runs N] [--steps N,...] [--fmus N,...]      default 1000, 1e6,1e7, 10,100,1000: minutes

A night: --runs 1e5 --steps 1e7,1e8,1e9 --fmus 100,1000,10000. Linux only.
"""

import argparse
import os
import sys
import tempfile
import time
from dataclasses import dataclass
from pathlib import Path

import scale
from rich.console import Console
from rich.table import Table

from gyro_cosim import Jacobi, simulate, system
from gyro_cosim.master import open_network, run
from gyro_cosim.master.recording import Recording
from gyro_cosim.master.stepping import Options

MACRO_STEP = 1e-3
FMU_STEPS = 2_000_000  # FMUs times macro steps of each system of `fmus`
PAGE = os.sysconf("SC_PAGE_SIZE") / 1024
MOST_KB = 1.0  # that a run may leave behind


@dataclass(frozen=True)
class Counts:
    """What this process holds: memory maps, descriptors, threads, resident memory in kB."""

    maps: int
    descriptors: int
    threads: int
    memory: float

    @classmethod
    def now(cls) -> "Counts":
        """As the system counts them."""
        own = Path("/proc/self")
        maps = len((own / "maps").read_text().splitlines())
        memory = int((own / "statm").read_text().split()[1]) * PAGE
        return cls(maps, len(list((own / "fd").iterdir())), len(list((own / "task").iterdir())), memory)

    @property
    def words(self) -> tuple[str, ...]:
        """For a row of a table."""
        return str(self.maps), str(self.descriptors), str(self.threads), f"{self.memory / 1024:.1f}"


def table(*columns: str) -> Table:
    """With the counts as its last columns."""
    made = Table(*columns, "maps", "descriptors", "threads", "memory, MB", box=None)
    for column in made.columns:
        column.justify = "right"
    return made


def many_runs(n: int) -> bool:
    """n runs; whether nothing grows from the first tenth on, by when all that is loaded or built once is there."""
    plan, told, marks = system("wheel-pair"), table("runs", "ms a run"), []
    for part in range(11):
        began = time.perf_counter()
        count = max(1, n // 10) if part else 1
        for _ in range(count):
            simulate(plan, stop=0.01)
        marks.append(Counts.now())
        told.add_row(str(part * count or 1), f"{(time.perf_counter() - began) / count * 1e3:.1f}", *marks[-1].words)
    Console(highlight=False).print(told)
    first, last = marks[1], marks[-1]
    grown = (last.memory - first.memory) / (0.9 * n)
    return (first.maps, first.descriptors, first.threads) >= (last.maps, last.descriptors, last.threads) and grown < MOST_KB


def many_steps(sizes: list[int]) -> None:
    """One run of each number of macro steps."""
    plan, told = system("wheel-pair").with_value("gyro.rotor_speed", 0.0), table("macro steps", "us a step")
    simulate(plan, stop=1.0, options=Options(compiled=True))  # builds and compiles what is built and compiled once
    with tempfile.TemporaryDirectory() as folder:
        for n in sizes:
            began = time.process_time()
            record = Recording(every=1000, stream=Path(folder) / "r.csv")
            simulate(plan, algorithm=Jacobi(1), stop=n * MACRO_STEP, options=Options(record))
            told.add_row(f"{n:.0e}", f"{(time.process_time() - began) / n * 1e6:.3f}", *Counts.now().words)
    Console(highlight=False).print(told)


def many_fmus(sizes: list[int]) -> None:
    """One system of each number of FMUs, counted while it is open, and once it is closed."""
    told = table("FMUs", "us per FMU and step")
    for n in sizes:
        steps = max(20, FMU_STEPS // n)
        with open_network(scale.pairs(n // 2)) as network:
            run(network, Jacobi(1), MACRO_STEP, 5 * MACRO_STEP, options=Options(compiled=True))
            done = run(network, Jacobi(1), MACRO_STEP, steps * MACRO_STEP, options=Options(Recording(every=steps)))
            told.add_row(str(n), f"{done.timing.loop_s / steps / n * 1e6:.3f}", *Counts.now().words)
        told.add_row("closed", "", *Counts.now().words)
    Console(highlight=False).print(told)


def main() -> int:
    """Measure and print."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    for option, default in (("--runs", "1e3"), ("--steps", "1e6,1e7"), ("--fmus", "10,100,1000")):
        parser.add_argument(option, default=default)
    given = parser.parse_args()
    holds = many_runs(round(float(given.runs)))
    many_steps([round(float(word)) for word in given.steps.split(",") if word])
    many_fmus([round(float(word)) for word in given.fmus.split(",") if word])
    return 0 if holds else 1


if __name__ == "__main__":
    sys.exit(main())
