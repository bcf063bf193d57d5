"""A component from a vehicle file."""

from collections.abc import Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

import casadi as ca

from gyro_cosim.component import Component, Variable, build

from ..track_parameters import parameters_of_track
from .description import Description
from .equations import longest_step, motion
from .reading import read
from .rows import bonds, signals
from .scene import scene_of

__all__ = ["component_of", "component_of_file", "with_starts"]

EQUATIONS = """\
m (v' + s' Omega x v) = F,   J omega' + omega x (J omega + h e_y) = M        each body in its track frame
I_y W' = r Fx + Mz sin(delta)                                               each wheel
J_b w' = M_springs + M_pivot                                                each frame on a pivot
F of the tread by Hertz and the creep law, F of the flange by the rail's lateral stiffness and creep"""


def with_starts(spec: str, table: Sequence[Variable], starts: Mapping[str, float]) -> tuple[Variable, ...]:
    """Give a table other start values; a value set outside its assumed range on purpose loses that range.

    Parameters
    ----------
    spec : str
        What the component is called, for messages.
    table : sequence of Variable
        The rows.
    starts : mapping of str to float
        New start values by name, in the units of the table.

    Returns
    -------
    tuple of Variable
        The rows in the same order.

    Raises
    ------
    ValueError
        If a name is not in the table, or a value not within min and max.
    """
    unknown = sorted(set(starts) - {v.name for v in table})
    if unknown:
        raise ValueError(f"{spec!r} has no variable {unknown[0]!r}")

    def changed(v: Variable) -> Variable:
        start = v.check(starts[v.name])
        inside = v.assumed is not None and v.assumed[0] <= start <= v.assumed[1]
        return replace(v, start=start, assumed=v.assumed if inside else None)

    return tuple(changed(v) if v.name in starts else v for v in table)


def component_of(d: Description, starts: Mapping[str, float] | None = None) -> Component:
    """Make the component of a vehicle.

    Parameters
    ----------
    d : Description
        The vehicle.
    starts : mapping of str to float, optional
        Start values of parameters or states that replace those of the file, SI.

    Returns
    -------
    Component
        The component `vehicle:NAME`; its connectors are the mounts.

    Raises
    ------
    ValueError
        For a name or value that the table does not allow.
    """
    table = (*signals(d), *d.parameters, *parameters_of_track(d.knots, d.harmonics))
    rows = with_starts(f"vehicle:{d.name}", table, starts or {})

    def model(s: dict[str, ca.SX]) -> tuple[dict[str, Any], dict[str, Any]]:
        equations = motion(s, d)
        rates, outputs = equations.derivatives, equations.outputs
        values = ca.cse([ca.SX(value) for value in (*rates.values(), *outputs.values())])
        n = len(rates)
        return dict(zip(rates, values[:n], strict=True)), dict(zip(outputs, values[n:], strict=True))

    return build(name="vehicle", variant=d.name, description=d.text, equations=EQUATIONS, variables=rows, model=model,
                 internal_step=d.internal_step, bonds=bonds(d), longest_step=lambda s: longest_step(s, d),
                 scene=scene_of(d, [row.name for row in rows]))  # fmt: skip


def component_of_file(path: str | Path) -> Component:
    """Make the component of a vehicle file.

    Parameters
    ----------
    path : str or Path
        A .toml file; docs/vehicle-files.md says what is in it.

    Returns
    -------
    Component
        As `component_of`.

    Raises
    ------
    ValueError
        In one line: file, key, rule, value.
    """
    return component_of(read(path))
