"""The program inside the child process: python -m gyro_cosim.check.probes FOLDER REPORT PROBE... PARENT"""

import json
import sys
from functools import partial
from pathlib import Path

from ..slaves.processes import child
from . import behaviour, numerics
from .examined import Examined
from .instance import Refused

PROBES = {
    probe.__name__: probe
    for probe in (
        behaviour.instance, behaviour.start, numerics.derivatives, numerics.dependencies, numerics.sensitivities, numerics.slope,
        behaviour.states, behaviour.instances, behaviour.reset, behaviour.bounds,
    )
}  # fmt: skip


def main(folder: str, report: str, names: list[str]) -> None:
    """Run the probes; one JSON line for each begin and each fault, written at once so that a crash leaves them."""
    with Path(report).open("a", encoding="utf-8", buffering=1) as out:

        def tell(*row: str) -> None:
            out.write(json.dumps(row) + "\n")

        fmu = Examined(Path(folder))
        for name in names:
            tell("begin", name)
            try:
                PROBES[name](fmu, partial(tell, "fault", name))
            except Refused as error:
                tell("fault", name, str(error))
        tell("end")


if __name__ == "__main__":
    if child.belongs():
        main(sys.argv[1], sys.argv[2], sys.argv[3:-1])
