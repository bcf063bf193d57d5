"""How many times real time do the vehicles run, as FMUs, with 1 ms macro steps?

The full vehicle and two gyro units in the curve, per creep law and speed; and a coach on two bogies, vehicle 1 of the Manchester
benchmarks, on straight track with the S1002 on 60E1 of its file, and with cones in their place.
Prints times real time, microseconds a macro step, and the share of it inside doStep.
Process time is shown beside wall time, since machines are shared. Run: python benchmarks/vehicle_speed.py
"""

import tempfile
import time
from collections.abc import Iterator
from importlib.resources import files
from pathlib import Path

from rich.console import Console
from rich.table import Table

from gyro_cosim import Jacobi, system
from gyro_cosim.master import open_network, run
from gyro_cosim.systems import System, SystemComponent

STOP = 30.0  # s
CASES = (("lrt", 5.0), ("lrt", 8.0), ("lrt_shen_hedrick_elkins", 8.0), ("lrt_fastsim", 8.0), ("lrt_half_space", 8.0))


CONES = """
[wheels.cone]
flange = "inside"
rolling_radius = "0.46 m"
contact_half_distance = "0.75 m"
conicity = "0.025"
conicity_gradient = "0 1/m"
"""


def cases(folder: Path) -> Iterator[tuple[str, float, System]]:
    """(what it is called, speed in m/s, system)."""
    for variant, speed in CASES:
        yield variant, speed, system("lrt-curve").with_source("vehicle", f"vehicle:{variant}").with_value("vehicle.speed", speed)
    measured = files("gyro_cosim.vehicle").joinpath("library", "manchester_1.toml").read_text(encoding="utf-8")
    for name, text in (("measured", measured), ("cones", measured[: measured.index("[wheels.")] + CONES)):
        file = folder / f"{name}.toml"
        file.write_text(text, encoding="utf-8")
        yield (
            f"manchester_1, {name}",
            30.0,
            System(name, (SystemComponent("vehicle", str(file)),), ()).with_value("vehicle.speed", 30.0),
        )


def main() -> None:
    """Run and print."""
    table = Table("vehicle", "v [m/s]", "x real time", "x process time", "us a step", "in doStep", box=None)
    for column in table.columns[1:]:
        column.justify = "right"
    with tempfile.TemporaryDirectory() as folder:
        for name, speed, plan in cases(Path(folder)):
            with open_network(plan) as network:
                run(network, Jacobi(1), 1e-3, STOP / 3)  # loads the compiled loop
                began = time.thread_time()
                result = run(network, Jacobi(1), 1e-3, STOP)
                spent = time.thread_time() - began
            loop, inside = result.timing.loop_s, sum(result.timing.do_step_s.values())
            row = f"{STOP / loop:.0f}", f"{STOP / spent:.0f}", f"{loop / result.steps * 1e6:.1f}", f"{inside / loop:.0%}"
            table.add_row(name, f"{speed:g}", *row)
    Console(highlight=False).print(table)


if __name__ == "__main__":
    main()
