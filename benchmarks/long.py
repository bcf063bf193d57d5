"""Does the cost grow linearly with the number of macro steps, and does memory stay bounded when results go to disk?

The wheel pair with its gyro at rest, whose yaw motion never ends, at 1 ms; every 1000th step goes to a file. Prints for each
number of steps microseconds of processor time a step and the largest memory of the process so far.

    python benchmarks/long.py [STEPS ...]      default 1e5 1e6 1e7; 1e8 takes about half a minute
"""

import resource
import sys
import tempfile
import time
from pathlib import Path

from rich.console import Console
from rich.table import Table

from gyro_cosim import Jacobi, simulate, system
from gyro_cosim.master.recording import Recording
from gyro_cosim.master.stepping import Options

STEP = 1e-3


def main() -> None:
    """Measure and print."""
    table = Table("macro steps", "us a step", "rows in the file", "peak memory, MB", box=None)
    for column in table.columns:
        column.justify = "right"
    plan = system("wheel-pair").with_value("gyro.rotor_speed", 0.0)
    simulate(plan, stop=1.0, options=Options(compiled=True))  # builds and compiles what is built and compiled once
    with tempfile.TemporaryDirectory() as folder:
        for steps in (round(float(word)) for word in sys.argv[1:] or ("1e5", "1e6", "1e7")):
            file = Path(folder) / f"{steps}.csv"
            began = time.process_time()
            simulate(plan, algorithm=Jacobi(1), stop=steps * STEP, options=Options(Recording(every=1000, stream=file)))
            spent = time.process_time() - began
            rows = sum(1 for _ in file.open()) - 1
            peak = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / (1 << 10 if sys.platform != "darwin" else 1 << 20)
            table.add_row(f"{steps:.0e}", f"{spent / steps * 1e6:.2f}", str(rows), f"{peak:.0f}")
    Console(highlight=False).print(table)


if __name__ == "__main__":
    main()
