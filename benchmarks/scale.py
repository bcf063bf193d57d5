"""Does the cost grow linearly with the number of FMUs? 10, 100, 1000 wheel pairs with their gyros in one system.

Prints milliseconds to open each FMU, and microseconds per FMU and macro step, for Jacobi and Gauss-Seidel.
"""

import sys
import time

from rich.console import Console
from rich.table import Table

from gyro_cosim import Connection, GaussSeidel, Jacobi, System, SystemComponent
from gyro_cosim.master import open_network, run
from gyro_cosim.master.stepping import Options
from gyro_cosim.systems import catalogue

STEP = 1e-3
FMU_STEPS = 2_000_000  # FMUs times macro steps of each run


def pairs(n: int) -> System:
    """n wheel pairs, each with its gyro unit and of a speed of its own, in one system."""
    vehicle, gyro = str(catalogue.fmu("vehicle:wheel_pair")), str(catalogue.fmu("gyro_unit:linear"))
    parts = [SystemComponent(f"vehicle{k}", vehicle, {"speed": 5.0 + 10.0 * k / n}) for k in range(n)]
    parts += [SystemComponent(f"gyro{k}", gyro) for k in range(n)]
    wires = [Connection((f"vehicle{k}", "yaw_rate"), (f"gyro{k}", "yaw_rate")) for k in range(n)]
    wires += [Connection((f"gyro{k}", "yaw_moment"), (f"vehicle{k}", "yaw_moment")) for k in range(n)]
    return System(f"{n} pairs", tuple(parts), tuple(wires))


def main() -> None:
    """Measure and print."""
    table = Table("pairs", "FMUs", "opened, ms per FMU", "jacobi, us per FMU and step", "gauss-seidel", "inside doStep", box=None)
    for column in table.columns:
        column.justify = "right"
    for n in (int(word) for word in sys.argv[1:] or ("1", "10", "100", "1000")):
        plan = pairs(n)
        steps = max(20, FMU_STEPS // (2 * n))
        began = time.perf_counter()
        with open_network(plan) as network:
            opened = (time.perf_counter() - began) / (2 * n)
            cost, inside = [], 0.0
            for algorithm in (Jacobi(1), GaussSeidel(1)):
                run(network, algorithm, STEP, 5 * STEP, options=Options(compiled=True))  # what is compiled or built once
                done = run(network, algorithm, STEP, steps * STEP)
                cost.append(done.timing.loop_s / steps / (2 * n))
                inside = inside or sum(done.timing.do_step_s.values()) / done.timing.loop_s
        table.add_row(str(n), str(2 * n), f"{opened * 1e3:.2f}", *(f"{c * 1e6:.2f}" for c in cost), f"{inside:.0%}")
    Console(highlight=False).print(table)


if __name__ == "__main__":
    main()
