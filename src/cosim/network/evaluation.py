"""How all outputs of a network become consistent with the inputs that they cause: an order of slaves, algebraic loops solved."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from ..errors import ConvergenceError
from .loops import Evaluating, LoopSolver, cycle, self_dependent, strong_components

EXCHANGES = 50  # rounds after which inputs and outputs at the start must agree
AGREEMENT = 1e-10  # relative; loops are solved to 1e-12


@dataclass(frozen=True, eq=False)
class Stage:
    """Slaves to evaluate one after another, then loops to solve.

    solved : places in Y of the loops that have been solved by then. Evaluating their slaves again must leave them: it would
    multiply what is left of their error by the loop's gain. None: there are none.
    """

    slaves: Sequence[int]
    loops: Sequence[tuple[int, LoopSolver]] = ()  # number, and what solves it
    solved: np.ndarray | None = None


class Evaluation:
    """For one set of direct dependencies: those of communication points, or those of initialization.

    feedthrough : per slave, boolean (n_y, n_u), which output depends directly on which input.
    feeds : place in Y -> the (slave, place in u) it feeds.
    order : slave indices, sources before what feeds through; ties in system order.
    one_pass : one evaluation of each slave in that order makes all outputs consistent.
    loops : each algebraic loop spelled out; outputs() solves them. looping : the places in Y that are in one.
    kept : of each loop, in this order, the Jacobian that its last solution left, None where there is none yet. It decides on
    the last bits of the next solution, so it belongs to the state of a run; recall() puts it back.
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
        loops = self_dependent(needs, needs)
        self.loops = tuple(" -> ".join(network.names[k] for k in cycle(group, needs)) for group in loops)
        self.looping = [k for group in loops for k in group]
        self.kept: tuple[np.ndarray | None, ...] = (None,) * len(loops)
        groups = strong_components(range(len(network.slices)), sources)
        self.one_pass = all(len(group) == 1 for group in groups)
        self.order = tuple(i for group in groups for i in group)
        joined = {i for ends in feeds.values() for i, _ in ends} | {int(owner[k]) for k in feeds}
        self._stages: list[Stage] = []
        self._joined: list[Stage] = []
        of_slave: dict[int, list[_Loop]] = {}
        for number, places in enumerate(loops):
            of_slave.setdefault(int(owner[places[0]]), []).append((places, (number, LoopSolver(network, places))))
        for group in groups:
            inside = [loop for i in group for loop in of_slave.get(i, ())]
            stages = _stages(group, inside, needs, owner)
            self._stages += stages
            self._joined += stages if joined & set(group) else []

    @property
    def exchange(self) -> tuple[int, ...]:
        """The slaves in the order in which one round of settle() evaluates them."""
        return tuple(i for stage in self._joined for i in stage.slaves)

    def recall(self, kept: Sequence[np.ndarray | None] = ()) -> None:
        """Put back what `kept` was; nothing is kept where nothing is said."""
        self.kept = tuple(kept) or (None,) * len(self.kept)

    def outputs(self, Y: np.ndarray, t: float) -> np.ndarray:
        """All outputs at t (s), consistent with the inputs they cause; Y, which may be old, is written in place."""
        self._pass(self._stages, Y, t)
        return Y

    def _pass(self, stages: Sequence["Stage"], Y: np.ndarray, t: float) -> None:
        for stage in stages:
            untouched, new = stage.solved, [n for n, _ in stage.loops if self.kept[n] is None]
            if new:  # whose solution begins at the start values that Y holds
                untouched = np.array([*(() if untouched is None else untouched), *self.looping])
            for i in stage.slaves:
                if untouched is None:
                    self._network.evaluate(i, Y, t)
                else:
                    solution = Y[untouched]
                    self._network.evaluate(i, Y, t)
                    Y[untouched] = solution
            for number, solver in stage.loops:
                solved = solver.solve(Y, t, self.kept[number])
                self.kept = (*self.kept[:number], solved, *self.kept[number + 1 :])

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
            self._pass(self._joined, Y, t)
            changed = np.abs(Y - before) > AGREEMENT * np.maximum(1.0, np.abs(Y))
        raise ConvergenceError(
            f"inputs and outputs must agree in initialization mode at t = {t:.9g} s, "
            f"{self._network.names[int(np.argmax(changed))]} still changes after {EXCHANGES} exchanges"
        )


_Loop = tuple[list[int], tuple[int, LoopSolver]]  # places in Y; number, and what solves it


def _stages(group: list[int], inside: Sequence[_Loop], needs: Mapping[int, Sequence[int]], owner: np.ndarray) -> list[Stage]:
    """How a group of slaves that need one another is evaluated; `inside` are the loops in it.

    Without a loop every chain from slave to slave is passed in as many sweeps as there are slaves. With loops, signals are
    taken in levels, each after all that it needs; a last sweep gives every slave its inputs.
    """
    if not inside:
        return [Stage(group if len(group) == 1 else group * len(group))]
    places = [int(k) for k in np.flatnonzero(np.isin(owner, group))]
    within = {y: [k for k in needs.get(y, ()) if owner[k] in group] for y in places}
    level: dict[int, int] = {}
    for signals in strong_components(places, within):
        above = [level[k] for y in signals for k in within[y] if k in level]
        level |= dict.fromkeys(signals, 1 + max(above, default=-1))
    looping = {k for signals, _ in inside for k in signals}
    stages: list[Stage] = []
    solved: list[int] = []
    for step in range(max(level[k] for k in places) + 1):
        slaves = dict.fromkeys(int(owner[k]) for k in places if level[k] == step and k not in looping)
        due = [(signals, loop) for signals, loop in inside if level[signals[0]] == step]
        stages.append(Stage(list(slaves), [loop for _, loop in due], np.array(solved, dtype=int) if solved else None))
        solved += [k for signals, _ in due for k in signals]
    return [*stages, Stage(group, (), np.array(solved, dtype=int))]


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
