"""How many times real time does the full vehicle run? Vehicle and two gyro units as FMUs, 1 ms macro step, in the curve.

Prints, per creep law and speed: times real time, microseconds a macro step, and the share of it inside doStep.
Process time is shown beside wall time, since machines are shared. Run: python benchmarks/vehicle_speed.py
"""

import time

from rich.console import Console
from rich.table import Table

from gyro_cosim import Jacobi, system
from gyro_cosim.master import open_network, run

STOP = 30.0  # s
CASES = (("lrt", 5.0), ("lrt", 8.0), ("lrt_shen_hedrick_elkins", 8.0), ("lrt_fastsim", 8.0))


def main() -> None:
    """Run and print."""
    table = Table("vehicle", "v [m/s]", "x real time", "x process time", "us a step", "in doStep", box=None)
    for column in table.columns[1:]:
        column.justify = "right"
    for variant, speed in CASES:
        plan = system("lrt-curve").with_source("vehicle", f"vehicle:{variant}").with_value("vehicle.speed", speed)
        with open_network(plan) as network:
            run(network, Jacobi(1), 1e-3, STOP / 3)  # loads the compiled loop
            began = time.thread_time()
            result = run(network, Jacobi(1), 1e-3, STOP)
            spent = time.thread_time() - began
        loop, inside = result.timing.loop_s, sum(result.timing.do_step_s.values())
        row = f"{STOP / loop:.0f}", f"{STOP / spent:.0f}", f"{loop / result.steps * 1e6:.1f}", f"{inside / loop:.0%}"
        table.add_row(variant, f"{speed:g}", *row)
    Console(highlight=False).print(table)


if __name__ == "__main__":
    main()
