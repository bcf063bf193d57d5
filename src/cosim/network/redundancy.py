"""States that two components hold both: each integrates the rate that one sends the other.

    x_a' = c_a v    in the component that receives v,        x_b' = c_b v    in the one that sends it.

Their difference should stay what it was at the start, and nothing in the equations sees to that: it is moved by the coupling
error of every step and never comes back. A force that hangs on x_a then acts at another place than x_b. Sending the position
besides the rate, or holding it once, takes the fault away.
Source: Kyllingstad, arXiv:2512.13845 (2025).
"""

from dataclasses import dataclass

import numpy as np

from ..slaves.base import StateSpace, linearisation
from .network import Network

ZERO = 1e-9  # share of a row's largest entry


@dataclass(frozen=True)
class Redundant:
    """A signal whose integral is held twice.

    Parameters
    ----------
    signal : str
        The output that is integrated, as component.variable.
    sender, receiver : str
        The components that both hold its integral.
    """

    signal: str
    sender: str
    receiver: str

    def __str__(self) -> str:
        return (
            f"{self.receiver} and {self.sender} both integrate {self.signal}: the two states drift apart with every coupling "
            "error, and no step brings them together again (send the integral as well, or hold it once)"
        )


def redundant_states(network: Network) -> tuple[Redundant, ...]:
    """Which signals are integrated on both sides of two components that drive one another.

    It looks at the linearisations of the slaves where they stand; a slave that gives none is passed over.
    """
    drives = {(source, i) for i in range(len(network.slaves)) for source, _ in _sources(network, i)}
    spaces: dict[int, StateSpace | None] = {}
    found = []
    for i, slave in enumerate(network.slaves):
        for j, k, place in ((j, k, p) for j, places in _sources(network, i) for p, k in places):
            if j == i or (i, j) not in drives:
                continue
            for s in (i, j):
                if s not in spaces:
                    spaces[s] = linearisation(network.slaves[s])
            mine, its = spaces[i], spaces[j]
            if mine is None or its is None:
                continue
            local = place - network.slices[j].start
            if _integrates_input(mine, k) and _integrates_output(its, local):
                found.append(Redundant(network.names[place], network.slaves[j].name, slave.name))
    return tuple(dict.fromkeys(found))


def _sources(network: Network, i: int) -> list[tuple[int, list[tuple[int, int]]]]:
    """The slaves that feed slave i, each with (place in Y, place in u)."""
    by: dict[int, list[tuple[int, int]]] = {}
    for place, k, _, _ in network.wires(i):
        j = next(n for n, part in enumerate(network.slices) if part.start <= place < part.stop)
        by.setdefault(j, []).append((place, k))
    return list(by.items())


def _integrates_input(space: StateSpace, k: int) -> bool:
    """Whether a state is the integral of input k alone: x' = c u_k."""
    whole = np.hstack([space.A, space.B])
    column = space.A.shape[1] + k
    others = np.delete(np.abs(whole), column, axis=1).max(axis=1, initial=0.0)
    return bool((others <= ZERO * np.abs(whole[:, column])).any(where=whole[:, column] != 0.0))


def _integrates_output(space: StateSpace, y: int) -> bool:
    """Whether a state is the integral of output y alone: x' = c y."""
    rows, row = np.hstack([space.A, space.B]), np.hstack([space.C, space.D])[y]
    size = float(row @ row)
    if size == 0.0:
        return False
    factors = rows @ row / size
    rest = np.abs(rows - np.outer(factors, row)).max(axis=1, initial=0.0)
    return bool((rest <= ZERO * np.abs(factors) * np.sqrt(size)).any(where=factors != 0.0))
