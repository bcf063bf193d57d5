"""The variables of an FMU: the component's table, what every FMU adds to it, and the value references."""

from dataclasses import dataclass
from functools import cached_property
from typing import Literal

from gyro_cosim.component import Component, Variable

__all__ = ["Kind", "Row", "Table", "derivative_unit", "describe"]

Kind = Literal["time", "state", "input", "output", "parameter", "derivative"]


@dataclass(frozen=True)
class Row:
    """A variable of the FMU. Its value reference is its place in the table.

    Attributes
    ----------
    kind : str
        What it is to the model.
    index : int
        Its place in x, u, y, p or x'.
    name, unit, description : str
        As in modelDescription.xml.
    variable : Variable or None
        The component's row; None for time and derivatives.
    """

    kind: Kind
    index: int
    name: str
    unit: str
    description: str
    variable: Variable | None


def derivative_unit(unit: str) -> str:
    """The unit of the time derivative of something in `unit`: rad -> rad/s, m/s -> m/s2."""
    over, _, under = unit.partition("/")
    atoms = under.split(".") if under else []
    for i, atom in enumerate(atoms):
        if atom[:1] == "s" and (atom[1:] or "1").isdigit():
            atoms[i] = f"s{int(atom[1:] or 1) + 1}"
            return f"{over}/{'.'.join(atoms)}"
    return f"{over}/{'.'.join([*atoms, 's'])}"


@dataclass(frozen=True)
class Table:
    """All variables of the FMU of `component`; ValueError, when they are asked for, where a name is one of the FMU's own."""

    component: Component

    @cached_property
    def added(self) -> tuple[Variable, ...]:
        """The parameters that every FMU has besides the component's own; they follow these in p."""
        return self.component.integration_parameters

    @cached_property
    def parameters(self) -> tuple[Variable, ...]:
        """The rows of p inside the FMU."""
        return (*self.component.parameters, *self.added)

    @cached_property
    def rows(self) -> tuple[Row, ...]:
        """Every variable in the order of the value references."""
        c = self.component
        place = {
            "state": {v.name: i for i, v in enumerate(c.states)},
            "input": {v.name: i for i, v in enumerate(c.inputs)},
            "output": {v.name: i for i, v in enumerate(c.outputs)},
            "parameter": {v.name: i for i, v in enumerate(self.parameters)},
        }
        rows = [Row("time", 0, "time", "s", "simulation time", None)]
        for v in (*c.variables, *self.added):
            if any(v.name == row.name for row in rows):
                raise ValueError(f"component {c.spec!r}: the FMU has a variable {v.name!r} of its own")
            kind: Kind = "state" if v.is_state else v.causality  # type: ignore[assignment]
            rows.append(Row(kind, place[kind][v.name], v.name, v.unit, describe(v), v))
        for i, v in enumerate(c.states):
            if v.variability == "continuous":
                meaning = f"time derivative of {v.name}"
                rows.append(Row("derivative", i, f"der({v.name})", derivative_unit(v.unit), meaning, None))
        return tuple(rows)

    @cached_property
    def reference(self) -> dict[str, int]:
        """Value reference by name."""
        return {row.name: i for i, row in enumerate(self.rows)}

    @cached_property
    def continuous(self) -> tuple[int, ...]:
        """Places in x of the continuous states."""
        return tuple(i for i, v in enumerate(self.component.states) if v.variability == "continuous")

    def of(self, kind: Kind, index: int) -> Row:
        """The row of `kind` at place `index`; an output that is a state is found as the state."""
        if kind == "output" and self.component.outputs[index].is_state:
            kind, index = "state", self.component.output_states[self.component.outputs[index].name]
        return next(row for row in self.rows if row.kind == kind and row.index == index)


def describe(v: Variable) -> str:
    """Meaning, symbol, source and assumed range in one line."""
    text = v.meaning
    if v.symbol:
        text += f" ({v.symbol})"
    if v.source:
        text += f"; source: {v.source}"
    if v.assumed is not None:
        text += f"; assumed, range {v.assumed[0]:g} to {v.assumed[1]:g} {v.unit}"
    return text
