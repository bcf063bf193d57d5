"""A component from a table of variables and a function of symbols: what models are written with."""

from collections.abc import Callable, Mapping, Sequence
from typing import Any

import casadi as ca

from .model import Bond, Component, check_names
from .variables import Variable

__all__ = ["build"]


def build(
    *,
    name: str,
    variant: str,
    description: str,
    equations: str,
    variables: Sequence[Variable],
    model: Callable[[dict[str, ca.SX]], tuple[dict[str, Any], dict[str, Any]]],
    internal_step: float,
    method: str = "rk4",
    bonds: Sequence[Bond] = (),
    sample: Callable[[dict[str, ca.SX]], dict[str, Any]] | None = None,
    sample_period: float | None = None,
    longest_step: Callable[[dict[str, ca.SX]], Any] | None = None,
    scene: Mapping[str, Any] | None = None,
) -> Component:
    """Make a component from a table of variables and a function of their symbols.

    Parameters
    ----------
    name, variant, description, equations : str
        As in `Component`.
    variables : sequence of Variable
        The table, in the order that x, u, y and p shall have.
    model : callable
        Gets a dict of symbols by name (states, inputs and parameters), returns two dicts by name: derivatives of the states and
        outputs, expressions in SI. Outputs that are states need not be returned, nor derivatives of discrete states, which
        are 0.
    internal_step : float
        Longest internal step (s).
    method : str
        "rk4", "rosenbrock" or "radau": a key of `component.methods.METHODS`.
    bonds : sequence of Bond
        The power bonds of its connectors.
    sample : callable, optional
        Gets the symbols, returns the states that a sample changes, by name.
    sample_period : float, optional
        Time (s) between samples; the first is at the first multiple of it from the start on.
    longest_step : callable, optional
        Gets the symbols, returns the longest stable explicit step (s).
    scene : mapping, optional
        What it looks like as it moves; see `component.scene`.

    Returns
    -------
    Component
        The component, checked.

    Raises
    ------
    ValueError
        If a name stands twice, is missing or is not in the table, or for what `Component` refuses.

    Examples
    --------
    >>> from gyro_cosim.component import build, input_, parameter, state
    >>> lag = build(
    ...     name="lag", variant="first", description="First-order lag", equations="T x' = u - x", internal_step=1e-2,
    ...     variables=(input_("u", "1", "input"), state("x", "1", "state", is_output=True),
    ...                parameter("T", 0.5, "s", "time constant", source="example", min=0.01)),
    ...     model=lambda s: ({"x": (s["u"] - s["x"]) / s["T"]}, {}),
    ... )
    >>> lag.spec
    'lag:first'
    """
    check_names(f"component '{name}:{variant}'", variables)
    symbols = {v.name: ca.SX.sym(v.name) for v in variables if v.is_state or v.causality in ("input", "parameter")}
    derivatives, outputs = model(symbols)
    states = [v.name for v in variables if v.is_state]
    computed = [v.name for v in variables if v.causality == "output"]
    outputs = {n: symbols[n] for n in computed if n in states} | outputs
    derivatives = {v.name: 0 for v in variables if v.is_state and v.variability == "discrete"} | derivatives
    sampled = sample(symbols) if sample is not None else {}
    for changed in sampled:
        if changed not in states:
            raise ValueError(f"component '{name}:{variant}': sample must give states, got {changed!r}")
    for what, got, wanted in (("derivatives", derivatives, states), ("outputs", outputs, computed)):
        if set(got) != set(wanted):
            odd = ", ".join(sorted(set(got) ^ set(wanted)))
            raise ValueError(
                f"component '{name}:{variant}': {what} must be given for exactly the rows of the table, differs in {odd}"
            )

    def column(kind: Callable[[Variable], bool]) -> ca.SX:
        return ca.vertcat(ca.SX(0, 1), *(symbols[v.name] for v in variables if kind(v)))

    args = [
        column(lambda v: v.is_state),
        column(lambda v: v.causality == "input"),
        column(lambda v: v.causality == "parameter"),
    ]
    labels = ["x", "u", "p"]
    return Component(
        name=name, variant=variant, description=description, equations=equations, variables=tuple(variables),
        rhs=ca.Function("rhs", args, [ca.vertcat(ca.SX(0, 1), *(derivatives[n] for n in states))], labels, ["x_dot"]),
        output=ca.Function("output", args, [ca.vertcat(ca.SX(0, 1), *(outputs[n] for n in computed))], labels, ["y"]),
        internal_step=internal_step, method=method, bonds=tuple(bonds), sample_period=sample_period,
        sample=None if sample is None else ca.Function(
            "sample", args, [ca.vertcat(ca.SX(0, 1), *(sampled.get(n, symbols[n]) for n in states))], labels, ["x_next"]
        ),
        longest_step=None if longest_step is None else ca.Function("longest_step", args, [longest_step(symbols)], labels, ["h"]),
        scene=scene,
    )  # fmt: skip
