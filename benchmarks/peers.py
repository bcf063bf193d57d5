"""Against peers: the same two FMUs, the same algorithm, the same step, in one run; do all get the same result, and how fast?

The wheel pair and its gyro unit, exported as FMI 2.0 FMUs, at 1 ms with held inputs. The yardstick is a bare C loop over
the FMUs' functions (contenders/loop.c). Every contender runs in a process of its own, several times in turn, and the
fastest counts, since machines are shared and drift. Peers are installed from the package index into an environment of
their own; one that cannot be had, or fails, is a row with the reason.

    python benchmarks/peers.py [--steps N] [--rounds N] [--offline] [--only NAME,...]

Exit code 1 if a contender that ran disagrees about the result.
"""

import argparse
import json
import subprocess
import sys
from collections.abc import Sequence
from dataclasses import dataclass, field
from pathlib import Path

import fmpy
import numpy as np
from rich.console import Console
from rich.table import Table

from gyro_cosim import system
from gyro_cosim.accuracy.monolith import Monolith
from gyro_cosim.systems import catalogue

HERE = Path(__file__).parent
PEERS = HERE.parent / ".venv" / "peers"
STEP = 1e-3
TOLERANCE = 1e-9  # all do the same sums, up to rounding and to how they count time
SPENT = 600.0  # s, for one process
YARDSTICK, OURS = "bare C loop", "gyro-cosim"


@dataclass(frozen=True)
class Contender:
    """A tool: its file in contenders/, what it can do, and whether it runs in the peers' environment."""

    name: str
    file: str
    algorithms: tuple[str, ...] = ("jacobi", "gauss-seidel")
    always_logs: bool = False
    peer: bool = True


CONTENDERS = (
    Contender(YARDSTICK, "with_c.py", peer=False),
    Contender(OURS, "with_gyro_cosim.py", always_logs=True, peer=False),
    Contender("Ecos", "with_ecos.py", ("jacobi",)),
    Contender("libcosim", "with_libcosim.py", ("jacobi",)),
    Contender("FMPy", "with_fmpy.py", peer=False),
    Contender("CoFmuPy", "with_cofmupy.py"),
)


@dataclass
class Result:
    """Steps per second without and with logging, the outputs at the end, or why there are none."""

    rate: dict[bool, float] = field(default_factory=dict)
    end: dict[str, float] = field(default_factory=dict)
    reason: str = ""


def main() -> int:
    """Measure, print, compare."""
    parser = argparse.ArgumentParser(description="Measure gyro-cosim against its peers on one pair of FMUs.")
    parser.add_argument("--steps", type=int, default=100_000, help="macro steps of 1 ms")
    parser.add_argument("--rounds", type=int, default=2, help="how often each contender runs")
    parser.add_argument("--offline", action="store_true", help="install nothing")
    parser.add_argument("--only", metavar="NAME,...", help="these contenders alone, beside the yardstick and ourselves")
    options = parser.parse_args()
    if not options.offline:
        install()
    chosen = None if options.only is None else {YARDSTICK, OURS, *options.only.split(",")}
    results = measured(options.steps, options.rounds, [c for c in CONTENDERS if chosen is None or c.name in chosen])
    exact = Monolith(system("wheel-pair")).solve(np.array([0.0, STEP * options.steps])).end()
    return report(results, exact, options.steps)


def install() -> None:
    """The peers' environment, as far as it can be had; what is missing says so when it is run."""
    if not PEERS.is_dir():
        subprocess.run([sys.executable, "-m", "virtualenv", "--quiet", str(PEERS)], check=False)
    for line in (HERE / "peers.txt").read_text().splitlines():
        if line and not line.startswith("#"):
            subprocess.run(
                [interpreter(True), "-m", "pip", "install", "--quiet", *line.split()], check=False, stderr=subprocess.DEVNULL
            )


def interpreter(peer: bool) -> str:
    """The Python that a contender runs in."""
    return str(PEERS / "bin" / "python") if peer else sys.executable


def measured(steps: int, rounds: int, contenders: Sequence[Contender]) -> dict[tuple[str, str], Result]:
    """(name, algorithm) -> result; rounds go over all contenders in turn."""
    fmus = {"vehicle": str(catalogue.fmu("vehicle:wheel_pair")), "gyro": str(catalogue.fmu("gyro_unit:linear"))}
    outputs = {
        name: [v.name for v in fmpy.read_model_description(path).modelVariables if v.causality == "output" and v.type == "Real"]
        for name, path in fmus.items()
    }
    wires = [("vehicle", "yaw_rate", "gyro", "yaw_rate"), ("gyro", "yaw_moment", "vehicle", "yaw_moment")]
    results: dict[tuple[str, str], Result] = {}
    for _ in range(rounds):
        for contender in contenders:
            for algorithm in contender.algorithms:
                result = results.setdefault((contender.name, algorithm), Result())
                for log in (True,) if contender.always_logs else (False, True):
                    case = {"fmus": fmus, "outputs": outputs, "connections": wires, "step": STEP, "steps": steps,
                            "algorithm": algorithm, "log": log}  # fmt: skip
                    loop, end, reason = run(contender, case)
                    if reason:
                        result.reason = reason
                        break
                    result.rate[log] = max(result.rate.get(log, 0.0), steps / loop)
                    result.end = end
    return results


def run(contender: Contender, case: dict[str, object]) -> tuple[float, dict[str, float], str]:
    """Seconds of the loop, outputs at the end, or the reason why there are none."""
    command = [interpreter(contender.peer), str(HERE / "contenders" / contender.file), json.dumps(case)]
    try:
        done = subprocess.run(command, capture_output=True, text=True, errors="replace", timeout=SPENT, check=False)
    except subprocess.TimeoutExpired:
        return 0.0, {}, f"took more than {SPENT:g} s"
    except OSError as error:
        return 0.0, {}, f"cannot be started: {error.strerror}"
    answers = [line.removeprefix("ANSWER ") for line in done.stdout.splitlines() if line.startswith("ANSWER ")]
    if not answers:
        said = done.stderr.strip().splitlines() or [f"exit code {done.returncode}"]
        return 0.0, {}, said[-1][:90]
    answer = json.loads(answers[-1])
    return answer["loop_s"], answer["end"], ""


def difference(a: dict[str, float], b: dict[str, float]) -> float:
    """Largest relative difference of a from b over all outputs; those that are zero in b must be so in a."""
    return max(
        abs(a[name] - value) / abs(value) if value else (0.0 if not a[name] else float("inf")) for name, value in b.items()
    )


def report(results: dict[tuple[str, str], Result], exact: dict[str, float], steps: int) -> int:
    """Print the table; 1 if a result is not that of the yardstick."""
    table = Table("contender", "algorithm", "steps/s, no log", "with log", "x C loop", "x ours", "off the C loop",
                  "off the exact", box=None, pad_edge=False)  # fmt: skip
    for column in table.columns[2:]:
        column.justify = "right"
    agree = True
    for (name, algorithm), result in sorted(results.items(), key=lambda item: item[0][1], reverse=True):
        if result.reason:
            table.add_row(name, algorithm, "-", "-", "-", "-", "-", result.reason)
            continue
        yardstick, ours = results[YARDSTICK, algorithm], results[OURS, algorithm]
        off = difference(result.end, yardstick.end) if yardstick.end else float("nan")
        agree &= off <= TOLERANCE
        ratios = [f"{result.rate[True] / other.rate[True]:.3g}" if other.rate else "-" for other in (yardstick, ours)]
        table.add_row(
            name, algorithm, f"{result.rate[False]:,.0f}" if False in result.rate else "", f"{result.rate[True]:,.0f}", *ratios,
            f"{off:.1e}" + ("" if off <= TOLERANCE else " DISAGREES"), f"{difference(result.end, exact):.2e}",
        )  # fmt: skip
    Console(highlight=False, width=None if sys.stdout.isatty() else 150).print(table)
    print(
        f"{steps} macro steps of {STEP * 1e3:g} ms, inputs held; ratios with all outputs logged; relative differences at the end"
    )
    print(f"all that ran agree to {TOLERANCE:g}" if agree else f"NOT all agree to {TOLERANCE:g}")
    return 0 if agree else 1


if __name__ == "__main__":
    sys.exit(main())
