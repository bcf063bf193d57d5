"""What every coupling algorithm is."""

from abc import ABC, abstractmethod
from dataclasses import dataclass

import numpy as np

from ..network import Network
from .history import MAX_DEGREE, History

Used = list[np.ndarray]  # the input polynomials that the slaves followed, per slave of shape (3, n_u)


@dataclass(frozen=True)
class Algorithm(ABC):
    """A coupling algorithm with input polynomials of `degree` 0, 1 or 2."""

    degree: int = 1

    def __post_init__(self) -> None:
        if self.degree not in range(MAX_DEGREE + 1):
            raise ValueError(f"degree must be 0, 1 or 2, got {self.degree!r}")

    @property
    def order(self) -> int:
        """The order of the error of the states in the macro step."""
        return self.degree + 1

    @property
    def memory(self) -> int:
        """How many communication points before the newest one the algorithm looks back."""
        return self.degree

    @property
    @abstractmethod
    def name(self) -> str:
        """As the command line writes it."""

    @abstractmethod
    def advance(self, network: Network, history: History, h: float) -> tuple[np.ndarray, Used]:
        """One macro step of h (s) from the newest point; returns consistent Y there and the inputs that were used."""

    def check(self, network: Network) -> None:  # noqa: B027  (most algorithms take any network)
        """ValueError if the network cannot be run with this algorithm."""


def step_all(network: Network, C: np.ndarray, t: float, h: float) -> Used:
    """Step every slave over h (s) under the polynomials C, shape (3, n_Y), of all outputs."""
    return [network.step(i, network.inputs(i, C), t, h) for i in range(len(network.slaves))]


def go_back(network: Network, states: list[object]) -> None:
    """Put every slave back to a saved state."""
    for slave, state in zip(network.slaves, states, strict=True):
        slave.restore(state)


def save_all(network: Network) -> list[object]:
    """The present state of every slave; free it with discard_all()."""
    return [slave.save() for slave in network.slaves]


def discard_all(network: Network, states: list[object]) -> None:
    """Free what save_all() returned."""
    for slave, state in zip(network.slaves, states, strict=True):
        slave.discard(state)


def can_restore(network: Network) -> bool:
    """Whether every slave can go back."""
    return all(slave.can_restore for slave in network.slaves)


def require_restore(network: Network, what: str) -> None:
    """ValueError naming the first slave that cannot go back."""
    for slave in network.slaves:
        if not slave.can_restore:
            raise ValueError(f"{what} needs components that can save and restore their state, {slave.name!r} cannot")
