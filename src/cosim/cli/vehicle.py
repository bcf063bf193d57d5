"""cosim vehicle check: reads a vehicle's file; degrees of freedom, what the wheels carry at rest, modes."""

from typing import Annotated

import numpy as np
import typer
from rich.table import Table

from ..stability.at_rest import AtRest
from ..systems import catalogue
from .common import AsJson, say
from .modes import ignorable, mode_words, modes_of, velocities
from .parameters import single

LOAD = "_vertical_force"


def command(
    action: Annotated[str, typer.Argument(metavar="check", help="what to do: check")],
    file: Annotated[str, typer.Argument(metavar="FILE", help="a vehicle's .toml file, or a variant such as vehicle:lrt")],
    as_json: AsJson = False,
) -> int:
    """Read a vehicle, count its degrees of freedom, and list what its wheels carry at rest and its modes there.

    Exit code 2 with one line where the file must not say what it says.
    """
    if action != "check":
        raise ValueError(f"cosim vehicle must be followed by check, got {action!r}")
    plan = single(file)
    made = catalogue.component(file)
    values = np.array(made.output(made.start_state, made.start_input, made.start_parameters)).ravel()
    loads = {v.name.removesuffix(LOAD): float(y) for v, y in zip(made.outputs, values, strict=True) if v.name.endswith(LOAD)}
    rest = AtRest(plan, (), ignorable(plan))
    found = {
        "vehicle": made.spec, "velocities": velocities(rest.states), "rest_error": rest.rest_error(rest.q0),
        "wheel_loads": loads, "modes": modes_of(rest),
    }  # fmt: skip
    table = Table("wheel", "load at rest [N]", box=None, pad_edge=False)
    for wheel, load in loads.items():
        table.add_row(wheel, f"{load:.6g}")
    head = f"equilibrium: states are {found['rest_error']:.1g} away from where the file puts them (SI units)"
    say(as_json, lambda: found, head, table, "", *mode_words({**found, "system": made.spec}))
    return 0
