"""The model structure of a coupled system's FMU: which unknown depends on which variables."""

from collections import defaultdict

from .variables import Variables

__all__ = ["Unknown", "calculated_at_start", "derivatives", "outputs"]

Unknown = tuple[int, list[int] | None]  # value reference, and those that it depends on; None: they are not told


def outputs(variables: Variables) -> list[Unknown]:
    """Each output with what it depends on at communication points.

    Parameters
    ----------
    variables : Variables
        Of the FMU.

    Returns
    -------
    list of Unknown
        In the order of the variables.
    """
    states = {(variables.all[state].component, variables.all[state].reference): state for _, state in variables.derivatives}
    inputs = _inputs(variables)
    rows: list[Unknown] = []
    for reference, v in enumerate(variables.all):
        if v.kind == "output":
            reach = variables.reach(v.index)
            known = [inputs[place] for place in reach.inputs] + [states[s] for s in reach.states if s in states]
            rows.append((reference, sorted(known)))
    return rows


def _inputs(variables: Variables) -> dict[tuple[int, int], int]:
    """Value references of the unconnected inputs, by component and place among its inputs."""
    return {variables.external[v.index]: reference for reference, v in enumerate(variables.all) if v.kind == "input"}


def derivatives(variables: Variables) -> list[Unknown]:
    """The derivatives of the states; what they depend on is not told.

    Parameters
    ----------
    variables : Variables
        Of the FMU.

    Returns
    -------
    list of Unknown
        In the order of the variables.
    """
    return [(derivative, None) for derivative, _ in variables.derivatives]


def calculated_at_start(variables: Variables) -> list[Unknown]:
    """What is calculated in initialization mode: all that decides on a component may decide on its outputs.

    Parameters
    ----------
    variables : Variables
        Of the FMU.

    Returns
    -------
    list of Unknown
        In the order of the variables.
    """
    inputs = _inputs(variables)
    settable: dict[int, list[int]] = defaultdict(list)
    for reference, v in enumerate(variables.all):
        if v.kind in ("forwarded", "output") and v.start is not None:
            settable[v.component].append(reference)
    rows: list[Unknown] = []
    for reference, v in enumerate(variables.all):
        if v.kind == "derivative":
            rows.append((reference, None))
        elif v.kind == "output" and v.start is None:
            reach = variables.reach(v.index, start=True)
            known = [inputs[place] for place in reach.inputs] + [k for i in reach.components for k in settable[i]]
            rows.append((reference, sorted(known)))
    return rows
