"""CoFmuPy: its Coordinator, step by step. Without logging, its master is stepped directly, which alone can leave it out."""

import contextlib
import sys

from case import answer, asked, timed
from cofmupy import Coordinator


def main() -> None:
    """Jacobi or Gauss-Seidel, in its words."""
    case = asked()
    config = {
        "fmus": [{"id": name, "path": path, "name": name} for name, path in case.fmus.items()],
        "connections": [
            {"source": {"id": a, "variable": out, "unit": "", "type": "fmu"},
             "target": [{"id": b, "variable": into, "unit": "", "type": "fmu"}]}
            for a, out, b, into in case.connections
        ],
        "cosim_method": case.algorithm.replace("-", "_"),
        "iterative": False,
    }  # fmt: skip
    coordinator = Coordinator()
    with contextlib.redirect_stdout(sys.stderr):
        coordinator.start(config)
    coordinator.master.sequence_order = [list(case.fmus)]  # its own comes from a set and differs from run to run

    def loop() -> None:
        for _ in range(case.steps):
            if case.log:
                coordinator.do_step(case.step)
            else:
                coordinator.master.do_step(case.step, record_outputs=False)

    seconds = timed(loop)
    answer(seconds, {name: float(coordinator.get_variable(tuple(name.split(".", 1)))[0]) for name in case.names()})


main()
