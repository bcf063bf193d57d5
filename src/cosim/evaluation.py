"""How all outputs of a network become consistent with the inputs that they cause: an order of slaves, algebraic loops solved."""

from collections.abc import Mapping, Sequence

import numpy as np

from cosim.algebraic import Evaluating, LoopSolver
from cosim.dataflow import cycle, loops, strong_components
from cosim.errors import ConvergenceError

EXCHANGES = 50  # rounds after which inputs and outputs at the start must agree
AGREEMENT = 1e-10  # relative; loops are solved to 1e-12


class Evaluation:
    """For one set of direct dependencies: those of communication points, or those of initialization.

    feedthrough : per slave, boolean (n_y, n_u), which output depends directly on which input.
    feeds : place in Y -> the (slave, place in u) it feeds.
    order : slave indices, sources before what feeds through; ties in system order.
    one_pass : one evaluation of each slave in that order makes all outputs consistent.
    loops : each algebraic loop spelled out; outputs() solves them, with one of `solvers` each.
    """

    def __init__(
        self, network: Evaluating, feedthrough: Sequence[np.ndarray], feeds: Mapping[int, Sequence[tuple[int, int]]]
    ) -> None:
        self._network = network
        needs = _needs(network, feedthrough, feeds)
        owner = np.repeat(np.arange(len(network.slices)), [part.stop - part.start for part in network.slices])
        sources: dict[int, list[int]] = {}
        for y, places in needs.items():
            sources.setdefault(int(owner[y]), []).extend(int(owner[k]) for k in places)
        found = loops(needs, needs)
        self.loops = tuple(" -> ".join(network.names[k] for k in cycle(group, needs)) for group in found)
        self.solvers = [LoopSolver(network, group) for group in found]
        solvers = {int(owner[group[0]]): solver for group, solver in zip(found, self.solvers, strict=True)}
        self._groups: list[tuple[list[int], list[LoopSolver]]] = []
        self.one_pass = True
        for group in strong_components(range(len(network.slices)), sources):
            inside = [solvers[i] for i in group if i in solvers]
            # Slaves may need one another although no signal needs itself: then every chain is passed in len(group) sweeps.
            self.one_pass = self.one_pass and len(group) == 1
            self._groups.append((group if len(group) == 1 else group * len(group), inside))
        self.order = tuple(dict.fromkeys(i for group, _ in self._groups for i in group))
        joined = {i for ends in feeds.values() for i, _ in ends} | {int(owner[k]) for k in feeds}
        self._joined = [(group, inside) for group, inside in self._groups if joined & set(group)]

    def outputs(self, Y: np.ndarray, t: float) -> np.ndarray:
        """All outputs at t (s), consistent with the inputs they cause; Y, which may be old, is written in place."""
        for group, solvers in self._groups:
            for solver in solvers:
                solver.solve(Y, t)
            for i in group:
                self._network.evaluate(i, Y, t)
        return Y

    def settle(self, Y: np.ndarray, t: float) -> None:
        """The same for slaves in initialization mode, as far as something is connected to them; every input is set at last.

        A slave that computes its state from an input may say nothing of what then depends on it: the rounds go on until
        one changes nothing. ConvergenceError if none does.
        """
        changed = np.full(Y.shape, bool(self._joined))
        for _ in range(EXCHANGES):
            if not changed.any():
                return
            before = Y.copy()
            for group, solvers in self._joined:
                for solver in solvers:
                    solver.solve(Y, t)
                for i in group:
                    self._network.evaluate(i, Y, t)
            changed = np.abs(Y - before) > AGREEMENT * np.maximum(1.0, np.abs(Y))
        raise ConvergenceError(
            f"inputs and outputs must agree in initialization mode at t = {t:.9g} s, "
            f"{self._network.names[int(np.argmax(changed))]} still changes after {EXCHANGES} exchanges"
        )


def _needs(
    network: Evaluating, feedthrough: Sequence[np.ndarray], feeds: Mapping[int, Sequence[tuple[int, int]]]
) -> dict[int, list[int]]:
    """Place in Y -> the places that it depends on directly, through its own slave's inputs."""
    needs: dict[int, list[int]] = {}
    for source, targets in feeds.items():
        for i, j in targets:
            for row in np.flatnonzero(feedthrough[i][:, j]):
                needs.setdefault(network.slices[i].start + int(row), []).append(source)
    return needs
