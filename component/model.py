"""A component: its table of variables and its CasADi functions, checked against each other once, when it is made.

    x' = rhs(x, u, p)         continuous states between sample instants
    y  = output(x, u, p)      at any time
    x+ = sample(x, u, p)      at t = 0, period, 2 period, ... where the component has a sampled part

x, u, y and p are columns in the order of the rows of the table that are state, input, output and parameter. A row can be
state and output at once: its output is the state itself. All numbers are SI.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import Any

import casadi as ca
import numpy as np

from .integration import METHODS, step_function
from .scene import check_scene
from .variables import Variable, parameter

__all__ = ["Bond", "Component"]


@dataclass(frozen=True)
class Bond:
    """A power bond of a component: two signals, one each way, whose product is a power.

    Attributes
    ----------
    connector : str
        The mount that the bond belongs to, such as "mount" or "front".
    axis : str
        The axis about or along which both act, such as "yaw".
    motion, effort : str
        Names of an input and an output, in either order: a rate or velocity, and the moment or force about the same axis.
    inertia : str
        What of the unit's inertia about the axis rides on the body that carries it. Of a unit: the parameter that is it, or a
        number (kg m2). Of what carries: the parameter that it is to be given as. Empty: nothing is stated.
    """

    connector: str
    axis: str
    motion: str
    effort: str
    inertia: str = field(default="", compare=False)


@dataclass(frozen=True, kw_only=True, eq=False)
class Component:
    """A model that becomes an FMU or runs in this process: one value, complete when it is made. Made by `build`.

    Attributes
    ----------
    name, variant : str
        Such as "gyro_unit" and "nonlinear"; together `spec`, "gyro_unit:nonlinear".
    description : str
        One line on what the component is.
    equations : str
        The equations as plain text, for the documentation inside the FMU.
    variables : tuple of Variable
        The table. Its rows fix the order of x, u, y and p.
    rhs : casadi.Function
        (x, u, p) -> x', shapes (n_x,), (n_u,), (n_p,) -> (n_x,), SI.
    output : casadi.Function
        (x, u, p) -> y, shape (n_y,). An output that is a state is that state.
    internal_step : float
        Longest step (s) of the component's own integrator.
    method : str
        A key of `component.methods.METHODS`.
    bonds : tuple of Bond
        The power bonds of its connectors.
    sample, sample_period : casadi.Function and float, or None
        (x, u, p) -> x after a sample, shape (n_x,), and the time (s) between samples. Both or neither.
    longest_step : casadi.Function, or None
        (x, u, p) -> length (s) up to which an explicit step is stable, where it depends on the parameters.
    scene : mapping, or None
        What it looks like as it moves; see `component.scene`.
    step : casadi.Function
        (x, U, p, tau, h) -> x after one internal step, shape (n_x,); see `component.integration`. Computed.

    Raises
    ------
    ValueError
        If table and functions do not agree, or a derivative or output is not finite at the start values. The message names
        component, rule and value.
    """

    name: str
    variant: str
    description: str
    equations: str
    variables: tuple[Variable, ...]
    rhs: ca.Function
    output: ca.Function
    internal_step: float
    method: str = "rk4"
    bonds: tuple[Bond, ...] = ()
    sample: ca.Function | None = None
    sample_period: float | None = None
    longest_step: ca.Function | None = None
    scene: Mapping[str, Any] | None = None
    step: ca.Function = field(init=False)

    def __post_init__(self) -> None:
        """Check that table and functions agree; ValueError names component, variable and rule."""
        where = f"component {self.spec!r}"
        check_names(where, self.variables)
        if not (np.isfinite(self.internal_step) and self.internal_step > 0.0):
            raise ValueError(f"{where}: internal_step must be positive, got {self.internal_step!r}")
        if self.method not in METHODS:
            raise ValueError(f"{where}: method must be one of {', '.join(METHODS)}, got {self.method!r}")
        if (self.sample is None) != (self.sample_period is None):
            raise ValueError(f"{where}: sample and sample_period must be given together")
        if self.sample_period is not None and not self.sample_period > 0.0:
            raise ValueError(f"{where}: sample_period must be positive, got {self.sample_period!r}")
        n_x, n_u, n_p, n_y = (len(rows) for rows in (self.states, self.inputs, self.parameters, self.outputs))
        wanted = {"rhs": (self.rhs, n_x, "states"), "output": (self.output, n_y, "outputs")}
        if self.sample is not None:
            wanted["sample"] = (self.sample, n_x, "states")
        for label, (function, rows, of) in wanted.items():
            for index, (size, what) in enumerate(((n_x, "states"), (n_u, "inputs"), (n_p, "parameters"))):
                if function.n_in() != 3 or function.size1_in(index) != size or function.size2_in(index) not in (0, 1):
                    raise ValueError(f"{where}: {label} must take (x, u, p) with {size} {what} as argument {index + 1}")
            if function.n_out() != 1 or function.size1_out(0) != rows:
                raise ValueError(f"{where}: {label} must return one column of {rows} {of}, got {function.size1_out(0)} rows")
        known = {v.name: v.causality for v in self.variables}
        for bond in self.bonds:
            for name in (bond.motion, bond.effort):
                if known.get(name) not in ("input", "output"):
                    raise ValueError(f"{where}: bond {bond.axis!r} must join an input and an output, got {name!r}")
        if self.scene is not None:
            check_scene(where, self.scene, known)
        x, u, p = self.start_state, self.start_input, self.start_parameters
        if not np.all(np.isfinite(np.array(self.rhs(x, u, p)))):
            raise ValueError(f"{where}: rhs must be finite at the start values")
        y = np.array(self.output(x, u, p)).ravel()
        for row, value in zip(self.outputs, y, strict=True):
            if not np.isfinite(value):
                raise ValueError(f"{where}: output {row.name!r} must be finite at the start values, got {value!r}")
        self._check_output_states(x, u, p)
        object.__setattr__(self, "step", step_function(self.rhs, self.method, self.longest_step))

    def _check_output_states(self, x: np.ndarray, u: np.ndarray, p: np.ndarray) -> None:
        """Refuse an `output` that changes a row that is state and output: tried at one uneven state."""
        uneven = x + 0.01 * (1.0 + np.arange(x.size))
        y = np.array(self.output(uneven, u, p)).ravel()
        for row, index in self.output_states.items():
            if y[[v.name for v in self.outputs].index(row)] != uneven[index]:
                raise ValueError(f"component {self.spec!r}: output {row!r} must be the state of the same name")

    @property
    def spec(self) -> str:
        """`name:variant`, as the command line writes it."""
        return f"{self.name}:{self.variant}"

    @cached_property
    def states(self) -> tuple[Variable, ...]:
        """The rows of x."""
        return tuple(v for v in self.variables if v.is_state)

    @cached_property
    def inputs(self) -> tuple[Variable, ...]:
        """The rows of u."""
        return tuple(v for v in self.variables if v.causality == "input")

    @cached_property
    def outputs(self) -> tuple[Variable, ...]:
        """The rows of y, states among them."""
        return tuple(v for v in self.variables if v.causality == "output")

    @cached_property
    def parameters(self) -> tuple[Variable, ...]:
        """The rows of p."""
        return tuple(v for v in self.variables if v.causality == "parameter")

    @cached_property
    def integration_parameters(self) -> tuple[Variable, ...]:
        """What every component takes besides its own parameters, in process and as an FMU; not part of p."""
        return (
            parameter(
                "internal_step", self.internal_step, "s", "longest internal step; a macro step is divided evenly",
                source="component", min=self.internal_step * 1e-3, tunable=False,
            ),
            parameter(
                "tolerance", 0.0, "1", "relative error of an internal step with error control; 0 for equal steps",
                source="component", min=0.0, max=1.0, tunable=False,
            ),
        )  # fmt: skip

    @cached_property
    def output_states(self) -> dict[str, int]:
        """Name of each row that is output and state -> its place in x."""
        return {v.name: i for i, v in enumerate(self.states) if v.causality == "output"}

    def with_starts(self, values: Mapping[str, float]) -> "Component":
        """The same component, starting with other values.

        Parameters
        ----------
        values : mapping
            Start values by name, in the units of the table; `internal_step` (s) as well.

        Returns
        -------
        Component
            A new one. The source of a parameter that is given says so, and its assumed range is gone.

        Raises
        ------
        ValueError
            For a name that the table does not have, or a value that a row or the component must not have.
        """
        for name in values.keys() - {"internal_step", *(v.name for v in self.variables)}:
            raise ValueError(f"component {self.spec!r} has no variable {name!r} that could start with {values[name]:g}")
        rows = tuple(
            replace(v, start=v.check(values[v.name]), assumed=None, source="given" if v.source else "") if v.name in values else v
            for v in self.variables
        )
        return replace(self, variables=rows, internal_step=values.get("internal_step", self.internal_step))

    @property
    def start_state(self) -> np.ndarray:
        """x at the start, shape (n_x,)."""
        return np.array([v.start for v in self.states])

    @property
    def start_input(self) -> np.ndarray:
        """u at the start, shape (n_u,)."""
        return np.array([v.start for v in self.inputs])

    @property
    def start_parameters(self) -> np.ndarray:
        """p at the start, shape (n_p,)."""
        return np.array([v.start for v in self.parameters])

    @cached_property
    def feedthrough(self) -> np.ndarray:
        """Boolean (n_y, n_u): which output depends directly on which input, from the sparsity of `output`."""
        return np.array(ca.DM(self.output.jac_sparsity(0, 1), 1.0).full() != 0.0).reshape(len(self.outputs), len(self.inputs))


def check_names(where: str, variables: Sequence[Variable]) -> None:
    """Refuse a name that stands twice."""
    names = [v.name for v in variables]
    for name in names:
        if names.count(name) > 1:
            raise ValueError(f"{where}: variable names must differ, got {name!r} twice")
