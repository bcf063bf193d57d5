"""What every contender is asked and what it answers. Standard library only: each runs in the interpreter its tool lives in.

A contender is called with one argument, a JSON document that holds the case, and prints one JSON line that begins with
MARK: seconds of the loop alone (loading, initializing and closing left out) and the outputs at the end.
"""

import json
import sys
import time
from collections.abc import Callable
from dataclasses import dataclass

MARK = "ANSWER "


@dataclass(frozen=True)
class Case:
    """Two FMI 2.0 FMUs in a loop at a fixed macro step; inputs are held over it.

    fmus : name -> path, in the order of stepping. outputs : name -> Real outputs, all of them.
    connections : (component, output, component, input). step : s. log : whether all outputs of all steps are kept.
    """

    fmus: dict[str, str]
    outputs: dict[str, list[str]]
    connections: list[tuple[str, str, str, str]]
    step: float
    steps: int
    algorithm: str
    log: bool

    @property
    def stop(self) -> float:
        """The end of the run, s."""
        return self.step * self.steps

    def names(self) -> list[str]:
        """All outputs as `component.variable`."""
        return [f"{fmu}.{name}" for fmu, names in self.outputs.items() for name in names]


def asked() -> Case:
    """The case on the command line."""
    fields = json.loads(sys.argv[1])
    return Case(**fields | {"connections": [tuple(wire) for wire in fields["connections"]]})


def answer(loop_s: float, end: dict[str, float]) -> None:
    """Print the answer; it starts a line of its own, whatever the tool has printed before."""
    print(f"\n{MARK}{json.dumps({'loop_s': loop_s, 'end': end})}", flush=True)


def timed(loop: Callable[[], None]) -> float:
    """Seconds that `loop` takes."""
    began = time.perf_counter()
    loop()
    return time.perf_counter() - began
