"""How many more vehicles a second does a core advance when several run side by side in the lanes of a vector register?

    python benchmarks/lanes.py [--stop S] [--rounds N] [--without-twins] [LAW ...]        lrt lrt_fastsim; two minutes

Eight runs of `lrt-curve`, the vehicle with two gyro units, at eight speeds, all outputs recorded: one after another, and as
many at once as the processor has lanes. All ways go in turn, in one process and one thread, and the fastest round of each counts,
since machines are shared and drift. Prints simulated seconds of vehicles per second of processor time and of wall time, the ratio
to the single run, whether all results are the same bytes, and how long the compiler took for each width.

The single run computes twin operations, of the two running gears and the two sides, at once. --without-twins adds FMUs of the
same components printed plainly, one operation at a time; it compiles them first, which takes a minute or two.

Exit code 1 if a result differs.
"""

import argparse
import hashlib
import sys
import tempfile
import time
from collections import deque
from collections.abc import Callable, Sequence
from contextlib import ExitStack
from pathlib import Path
from unittest import mock

from rich.console import Console
from rich.table import Table

from gyro_cosim import Jacobi, fmus, system
from gyro_cosim.fmus.library import LANES, lane_library
from gyro_cosim.kernel import native
from gyro_cosim.master import Run, open_network, run
from gyro_cosim.master.lanes import Job, Lanes, lane_codes
from gyro_cosim.network import Network
from gyro_cosim.slaves.fmi.lanes import widest
from gyro_cosim.systems import System, archive, catalogue

STEP = 1e-3  # s
SPEEDS = [5.0 + 0.5 * k for k in range(8)]  # m/s
Way = Callable[[], list[Run]]


def main() -> int:
    """Measure and print."""
    parser = argparse.ArgumentParser(description="Measure vehicles side by side in lanes.")
    parser.add_argument("laws", metavar="LAW", nargs="*", default=["lrt", "lrt_fastsim"], help="variants of the vehicle")
    parser.add_argument("--stop", type=float, default=5.0, help="s, of each run")
    parser.add_argument("--rounds", type=int, default=3, help="how often each way runs")
    parser.add_argument("--without-twins", action="store_true", help="also the single run of plainly printed FMUs")
    options = parser.parse_args()
    widths = [w for w in LANES if w <= widest()]
    table = Table("vehicle", "way", "x real time, processor", "wall", "x single", "same bytes", "compiled in, s", box=None)
    for column in table.columns[2:]:
        column.justify = "right"
    same = True
    for law in options.laws:
        plan = system("lrt-curve").with_source("vehicle", f"vehicle:{law}")
        took = {f"{w} lanes": seconds_to_compile(plan, w) for w in widths}
        with ExitStack() as stack:
            opened = [stack.enter_context(open_network(plan)) for _ in range(max(widths))]
            ways: dict[str, Way] = {"single": lambda n=opened[0]: one_by_one(n, options.stop)}
            ways |= {f"{w} lanes": lambda n=opened[:w]: in_lanes(n, options.stop) for w in widths}
            if options.without_twins:
                folder = stack.enter_context(tempfile.TemporaryDirectory())
                network = stack.enter_context(open_network(printed_plainly(plan, Path(folder))))
                ways["single, without twins"] = lambda n=network: one_by_one(n, options.stop)
            best, bytes_of = measured(ways, options.rounds)
        for name in ways:
            processor, wall = (options.stop * len(SPEEDS) / seconds for seconds in best[name])
            identical = bytes_of[name] == bytes_of["single"]
            same &= identical
            ratio = best["single"][0] / best[name][0]
            compiled = f"{took[name]:.1f}" if name in took else ""
            table.add_row(law, name, f"{processor:.0f}", f"{wall:.0f}", f"{ratio:.2f}", "yes" if identical else "NO", compiled)
    Console(highlight=False, width=130).print(table)
    print(f"{len(SPEEDS)} runs of {options.stop:g} s at {STEP * 1e3:g} ms, Jacobi, degree 1; best of {options.rounds} rounds")
    return 0 if same else 1


def at_speed(network: Network, speed: float) -> Network:
    """The open network with another speed of the vehicle."""
    return Network(network.system.with_value("vehicle.speed", speed), network.slaves)


def one_by_one(network: Network, stop: float) -> list[Run]:
    """The runs of all speeds, one after another."""
    return [run(at_speed(network, speed), Jacobi(1), STEP, stop) for speed in SPEEDS]


def in_lanes(opened: Sequence[Network], stop: float) -> list[Run]:
    """The same runs, as many at once as networks are open."""
    kernel, codes = native.kernel(), lane_codes(opened[0], len(opened))
    if not isinstance(kernel, native.Kernel) or isinstance(codes, str):
        raise RuntimeError(f"no lanes here: {kernel if isinstance(codes, list) else codes}")
    waiting = deque(enumerate(SPEEDS))

    def take(slot: int) -> Job | None:
        if not waiting:
            return None
        k, speed = waiting.popleft()
        return Job(k, at_speed(opened[slot], speed), Jacobi(1), STEP, stop)

    results = {key: result for key, result, _ in Lanes(kernel, codes, len(opened)).results(take)}
    for result in results.values():
        if isinstance(result, Exception):
            raise result
    return [results[k] for k in range(len(SPEEDS))]


def measured(ways: dict[str, Way], rounds: int) -> tuple[dict[str, tuple[float, float]], dict[str, str]]:
    """Least processor and wall time of each way, in s, and a hash of its results; one round before is not counted."""
    best = dict.fromkeys(ways, (float("inf"), float("inf")))
    bytes_of = {}
    for k in range(rounds + 1):
        for name, way in ways.items():
            began = time.thread_time(), time.perf_counter()
            results = way()
            spent = time.thread_time() - began[0], time.perf_counter() - began[1]
            if k:
                best[name] = min(best[name][0], spent[0]), min(best[name][1], spent[1])
            digest = hashlib.sha256()
            for result in results:
                digest.update(result.trajectory.t.tobytes() + result.trajectory.values.tobytes())
            bytes_of[name] = digest.hexdigest() if bytes_of.get(name, digest.hexdigest()) == digest.hexdigest() else "varies"
    return best, bytes_of


def seconds_to_compile(plan: System, width: int) -> float:
    """What the compiler takes for the lanes of all FMUs of a system, anew."""
    spent = 0.0
    for location in {component.source: None for component in located(plan).components}:
        with archive.opened(location) as members:
            names = [n for n in members.namelist() if n.startswith("sources/") and n.endswith((".c", ".h"))]
            sources = {name.removeprefix("sources/"): members.read(name).decode() for name in names}
        began = time.perf_counter()
        lane_library(sources, width)
        spent += time.perf_counter() - began
    return spent


def located(plan: System) -> System:
    """The system with the file of each built FMU for its component."""
    for component in plan.components:
        plan = plan.with_source(component.name, str(catalogue.fmu(component.source)))
    return plan


def printed_plainly(plan: System, folder: Path) -> System:
    """The system with FMUs in which no operations stand side by side."""
    with mock.patch("gyro_cosim.fmus.printing.has_twins", return_value=False):
        files = {source: str(fmus.export(catalogue.component(source), folder)[0])
                 for source in {component.source for component in plan.components}}  # fmt: skip
    for component in plan.components:
        plan = plan.with_source(component.name, files[component.source])
    return plan


if __name__ == "__main__":
    sys.exit(main())
