"""What every coupling algorithm is."""

from abc import ABC, abstractmethod
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from ..network import Network
from ..slaves import Restorable, restorable
from .history import MAX_DEGREE, History

Used = list[np.ndarray]  # the input polynomials that the slaves followed, per slave of shape (3, n_u)
Memory = Mapping[str, np.ndarray]  # what an algorithm remembers from one macro step to the next, by names of its own


@dataclass(frozen=True, eq=False)
class Step:
    """What a macro step came to.

    Parameters
    ----------
    Y : ndarray, shape (n_Y,)
        Consistent outputs at its end.
    used : list of ndarray, each of shape (3, n_u)
        The input polynomials that the slaves followed.
    memory : mapping of str to ndarray
        What the algorithm wants to be handed with the next step.
    passes : int
        How often the step was done where the algorithm iterates; else 0.
    """

    Y: np.ndarray
    used: Used
    memory: Memory = field(default_factory=dict)
    passes: int = 0


@dataclass(frozen=True)
class Algorithm(ABC):
    """A coupling algorithm. It keeps nothing itself, and writes to nobody.

    Parameters
    ----------
    degree : {0, 1, 2}
        Of the polynomials that inputs follow over a macro step.
    """

    degree: int = 1

    def __post_init__(self) -> None:
        if self.degree not in range(MAX_DEGREE + 1):
            raise ValueError(f"degree must be 0, 1 or 2, got {self.degree!r}")

    @property
    def order(self) -> int:
        """The order of the error of the states in the macro step."""
        return self.degree + 1

    @property
    def looks_back(self) -> int:
        """How many communication points before the newest one the algorithm needs."""
        return self.degree

    @property
    @abstractmethod
    def name(self) -> str:
        """As the command line writes it."""

    @abstractmethod
    def advance(self, network: Network, history: History, h: float, memory: Memory) -> Step:
        """One macro step of h (s) from the newest point of `history`.

        Parameters
        ----------
        network : Network
            Whose slaves stand at that point, and at its end afterwards.
        history : History
            Outputs so far.
        h : float
            Length, s.
        memory : mapping of str to ndarray
            What the step before returned as such; empty for the first.

        Raises
        ------
        SlaveError
            A component failed.
        ConvergenceError
            An iteration did not end.
        """

    def check(self, network: Network) -> None:  # noqa: B027  (most algorithms take any network)
        """ValueError if the network cannot be run with this algorithm."""


def step_all(network: Network, C: np.ndarray, t: float, h: float) -> Used:
    """Step every slave over h (s) under the polynomials C, shape (3, n_Y), of all outputs."""
    used = {i: network.step(i, network.inputs(i, C, t, h), t, h) for i in network.stepping}
    return [used[i] for i in range(len(used))]


@dataclass(frozen=True, eq=False)
class Saved:
    """The state of every slave at one time. Free it with discard(), or leave that to a `with`."""

    slaves: Sequence[Restorable]
    states: Sequence[Any]

    def go_back(self) -> None:
        """Put every slave back there."""
        for slave, state in zip(self.slaves, self.states, strict=True):
            slave.restore(state)

    def discard(self) -> None:
        """Free it."""
        for slave, state in zip(self.slaves, self.states, strict=True):
            slave.discard(state)

    def __enter__(self) -> "Saved":
        return self

    def __exit__(self, *_: object) -> None:
        self.discard()


def save_all(network: Network, what: str = "a repeated step") -> Saved:
    """The present state of every slave; ValueError names the first that cannot go back, for `what` needs it to."""
    slaves = require_restore(network, what)
    return Saved(slaves, [slave.save() for slave in slaves])


def can_restore(network: Network) -> bool:
    """Whether every slave can go back, and anything is connected, so that it is worth it."""
    return bool(network.coupled.size) and all(restorable(slave) is not None for slave in network.slaves)


def best_order(network: Network) -> int:
    """The order of accuracy that the input degrees of the slaves allow, see network.projected."""
    degrees = [slave.description.input_degree for i, slave in enumerate(network.slaves) if network.wires(i)]
    return 2 + min(degrees, default=MAX_DEGREE)


def require_restore(network: Network, what: str) -> list[Restorable]:
    """The slaves, all of which can go back; ValueError names the first that cannot."""
    slaves = []
    for slave in network.slaves:
        able = restorable(slave)
        if able is None:
            raise ValueError(f"{what} needs components that can save and restore their state, {slave.name!r} cannot")
        slaves.append(able)
    return slaves
