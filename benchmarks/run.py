"""`make bench`: what the master costs, in one run, as ratios, since machines are shared and drift.

Prints, for the wheel pair and its gyro as FMUs at 1 ms: macro steps per second of each algorithm, the share of time inside
doStep, and the same pair in process. Then 10 000 steps in this process, and from the prompt to the result, beside the start of
a bare interpreter.
"""

import subprocess
import sys
import time

from rich.console import Console
from rich.table import Table

from gyro_cosim import GaussSeidel, Jacobi, simulate, system
from gyro_cosim.coupling import Algorithm

STOP = 30.0
SHORT = ["-m", "gyro_cosim", "run", "wheel-pair", "--step", "1e-3", "--stop", "10"]


def seconds(command: list[str]) -> float:
    """Least wall time of three runs of the interpreter, in s."""
    spent = []
    for _ in range(3):
        began = time.perf_counter()
        subprocess.run([sys.executable, *command], stdout=subprocess.DEVNULL, check=True)
        spent.append(time.perf_counter() - began)
    return min(spent)


def main() -> None:
    """Run and print."""
    plan = system("wheel-pair")
    simulate(plan, stop=60.0)  # builds the FMUs, compiles the loop
    table = Table("run", "macro steps/s", "x real time", "in doStep", box=None)
    for column in table.columns[1:]:
        column.justify = "right"
    cases: list[tuple[str, Algorithm, bool]] = [
        *((f"FMUs, {a.name}, degree {a.degree}", a, False) for a in (Jacobi(0), Jacobi(1), Jacobi(2), GaussSeidel(1))),
        ("in process, jacobi, degree 1", Jacobi(1), True),
    ]
    for name, algorithm, in_process in cases:
        run = simulate(plan, algorithm=algorithm, step=1e-3, stop=STOP, in_process=in_process)
        loop, inside = run.timing.loop_s, sum(run.timing.do_step_s.values())
        table.add_row(name, f"{run.steps / loop:,.0f}", f"{STOP / loop:,.0f}", f"{inside / loop:.0%}")
    began = time.perf_counter()
    simulate(plan, step=1e-3, stop=10.0)
    Console(highlight=False).print(table)
    print(f"10 000 macro steps of built FMUs, opening and closing included: {time.perf_counter() - began:.2f} s")
    print(f"the same from the prompt: {seconds(SHORT):.2f} s; a bare interpreter starts in {seconds(['-c', '']):.2f} s")


if __name__ == "__main__":
    main()
