"""Someone who looks at a run as it goes on, and may pause it, end it, or change what its components let change on the way."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Protocol

import numpy as np

from ..coupling import History
from ..network import Network
from ..slaves import Signal, tunable
from .state import RunState

__all__ = ["Change", "Visitor", "changeable", "changed"]


@dataclass(frozen=True)
class Change:
    """A parameter that gets a value at a communication point.

    Parameters
    ----------
    component, name : str
        Whose, and which.
    value : float
        In the parameter's own unit.
    """

    component: str
    name: str
    value: float

    @property
    def words(self) -> str:
        """What it does."""
        return f"set {self.component}.{self.name} to {self.value:g}"


class Visitor(Protocol):
    """What a run calls as it goes on, in its own thread."""

    @property
    def at_most(self) -> int:
        """How many macro steps may be done at once."""

    def ready(self) -> None:
        """Before the first macro step; may wait. KeyboardInterrupt ends the run."""

    def saw(self, k: int, t: np.ndarray, Y: np.ndarray) -> None:
        """Points k, k + 1, ... of the run: times t (s), shape (n,), recorded outputs Y, shape (n, m); only read here and now."""

    def visit(self, t: float) -> Sequence[Change]:
        """The run is at the point t (s). What is to change there; may wait. KeyboardInterrupt ends the run."""


def changeable(network: Network) -> Mapping[str, Mapping[str, Signal]]:
    """The single numbers that may change on the way, by component and name; not those that a scenario changes by itself."""
    taken = {(tuned.i, tuned.name) for tuned in network.driving.tuned}
    found: dict[str, dict[str, Signal]] = {}
    for i, slave in enumerate(network.slaves):
        able = tunable(slave)
        if able is not None:
            of_slave = {
                name: able.description.settable[name]
                for name in sorted(able.description.tunable)
                if (i, name) not in taken and _is_number(able.description.settable.get(name))
            }
            found |= {slave.name: of_slave} if of_slave else {}
    return found


def _is_number(signal: Signal | None) -> bool:
    return signal is not None and not signal.shape and signal.type in ("real", "integer", "boolean", "enumeration")


def changed(state: RunState, network: Network, changes: Sequence[Change]) -> RunState:
    """The state after changes at its newest point, exactly as a scenario's `set` there makes it.

    Raises
    ------
    SlaveError
        A component does not take the value.
    """
    t = state.history.t[0]
    slaves = {slave.name: slave for slave in network.slaves}
    for change in changes:
        slave = tunable(slaves[change.component])
        assert slave is not None  # only what may change is offered
        slave.tune({change.name: change.value}, t)
    network.recall(())
    Y = network.outputs(state.history.Y[0].copy(), t)
    return replace(state, history=History((t,), (Y,), state.history.held), memory={})
