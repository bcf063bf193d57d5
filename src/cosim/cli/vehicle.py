"""cosim vehicle check: reads a vehicle's file; degrees of freedom, what the wheels carry at rest, modes."""

from pathlib import Path
from typing import Annotated

import numpy as np
import typer
from rich.table import Table

from gyro_cosim.component import Component

from ..stability.at_rest import AtRest
from ..systems import catalogue
from . import drawing
from .alone import single
from .common import AsJson, say
from .modes import ignorable, mode_words, modes_of, velocities

LOAD = "_vertical_force"
STABLE = 2.78  # of the classical Runge-Kutta method, along the negative axis


def step_of(made: Component) -> float:
    """The internal step at the start (s)."""
    if made.longest_step is None:
        return made.internal_step
    return min(made.internal_step, float(made.longest_step(made.start_state, made.start_input, made.start_parameters)))


def command(
    action: Annotated[str, typer.Argument(metavar="check", help="what to do: check")],
    file: Annotated[str, typer.Argument(metavar="FILE", help="a vehicle's .toml file, or a variant such as vehicle:lrt")],
    plot: Annotated[
        Path | None,
        typer.Option(metavar="FILE", help="draw it from the side and from above, and the contact of wheel and rail"),
    ] = None,
    as_json: AsJson = False,
) -> int:
    """Read a vehicle, count its degrees of freedom, and list what its wheels carry at rest and its modes there.

    Exit code 2 with one line where the file must not say what it says.
    """
    if action != "check":
        raise ValueError(f"cosim vehicle must be followed by check, got {action!r}")
    drawing.check(plot)
    plan = single(file)
    made = catalogue.component(file)
    values = np.array(made.output(made.start_state, made.start_input, made.start_parameters)).ravel()
    loads = {v.name.removesuffix(LOAD): float(y) for v, y in zip(made.outputs, values, strict=True) if v.name.endswith(LOAD)}
    rest = AtRest(plan, (), ignorable(plan), settled=True)
    step = step_of(made)
    fastest = float(np.abs(rest.roots(rest.q0)).max()) * step
    found = {
        "vehicle": made.spec, "velocities": velocities(rest.states), "rest_error": float(np.abs(rest.equilibrium(rest.q0)).max()),
        "step": step, "fastest_root_times_step": fastest, "wheel_loads": loads, "modes": modes_of(rest),
    }  # fmt: skip
    if plot is not None:
        from ..figures import views

        if not (made.scene and made.scene.get("bodies")):
            raise ValueError(f"--plot requires a component with a scene of bodies, {made.spec} has none")
        drawing.save(views(made.scene, f"{made.spec}: {made.description}"), plot)
    table = Table("wheel", "load at rest [N]", box=None, pad_edge=False)
    for wheel, load in loads.items():
        table.add_row(wheel, f"{load:.6g}")
    head = f"equilibrium: states are {found['rest_error']:.1g} away from where the file puts them (SI units)"
    pace = f"steps of {step * 1e3:.3g} ms: the fastest root times that is {fastest:.2f}, an explicit method is stable to {STABLE}"
    say(as_json, lambda: found, head, pace, table, "", *mode_words({**found, "system": made.spec}))
    return 0
