"""A, B, C and D of an FMU where it stands, from its directional derivatives."""

from collections.abc import Callable, Sequence

import numpy as np

from ..base import StateSpace
from ..description import SlaveDescription
from .buffers import Group
from .description import Description


def derivatives(
    model: Description, signals: SlaveDescription, inputs: Sequence[Group], outputs: Sequence[Group],
    sensitivity: Callable[[list[int], int, np.ndarray], int],
) -> StateSpace | None:  # fmt: skip
    """The linearisation; None where a signal is an array or not smooth, or the FMU does not give what is needed.

    sensitivity : writes d(unknowns) / d(known), given by value references, and returns the status.
    """
    states, rows = model.states, {row.name: row for row in model.rows}
    plain = all(row.size == 1 for part in (*inputs, *outputs) for row in part.rows)
    if not plain or any(not s.smooth for s in (*signals.inputs, *signals.outputs)) or len(outputs) > 1:
        return None
    n_x, n_u, n_y = len(states), len(signals.inputs), len(signals.outputs)
    unknowns = [derivative for _, derivative in states] + [rows[s.name].reference for s in signals.outputs]
    knowns = [state for state, _ in states] + [rows[s.name].reference for s in signals.inputs]
    M, column = np.zeros((n_x + n_y, n_x + n_u)), np.zeros(n_x + n_y)
    for k, known in enumerate(knowns if unknowns else []):
        if sensitivity(unknowns, known, column) > 1:
            return None  # states as knowns are beyond what the standard asks of Co-Simulation
        M[:, k] = column
    return StateSpace(M[:n_x, :n_x], M[:n_x, n_x:], M[n_x:, :n_x], M[n_x:, n_x:])
