"""The program inside the child process: python -m gyro_cosim.check.probes FOLDER REPORT PROBE... PARENT"""

import json
import sys
from functools import partial
from pathlib import Path

from ..slaves.processes import child
from . import behaviour, event_mode, numerics, variables, wrong_calls
from .examined import Examined
from .findings import Severity
from .instance import Refused, Unloadable

PROBES = {
    probe.__name__: probe
    for probe in (
        behaviour.instance, behaviour.start, variables.types, event_mode.events, event_mode.clocks, event_mode.scheduled,
        numerics.derivatives, numerics.dependencies, numerics.sensitivities, numerics.slope,
        behaviour.states, behaviour.instances, behaviour.reset, behaviour.bounds, wrong_calls.misuse,
    )
}  # fmt: skip


def main(folder: str, report: str, names: list[str]) -> None:
    """Run the probes; one JSON line for each begin and each finding, written at once so that a crash leaves them."""
    with Path(report).open("a", encoding="utf-8", buffering=1) as out:

        def tell(*row: str) -> None:
            out.write(json.dumps(row) + "\n")

        def found(rule: str, message: str, severity: Severity = "fault") -> None:
            tell("found", rule, message, severity)

        fmu = Examined(Path(folder))
        for name in names:
            tell("begin", name)
            try:
                PROBES[name](fmu, partial(found, name))
            except Refused as error:
                found(name, str(error), "warning" if name == wrong_calls.misuse.__name__ else "fault")
            except Unloadable as error:
                found(name, f"the binary cannot be loaded on this machine: {error}", "warning")
                break
        tell("end")


if __name__ == "__main__":
    if child.belongs():
        main(sys.argv[1], sys.argv[2], sys.argv[3:-1])
