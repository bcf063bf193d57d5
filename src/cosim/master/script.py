"""A scenario as a run goes on: what takes effect at which communication point.

What jumps (a value set, a connection that fails or is mended) takes effect at the first communication point at or after its
time; macro steps that adapt end there exactly. A ramp of an input is followed from its own times on; a parameter that ramps
has, over each macro step, the value of the step's beginning.
"""

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, replace
from math import ceil, floor, inf

import numpy as np

from ..coupling import History
from ..network import Network
from ..network.scripted import Fault
from ..slaves import tunable
from ..systems import Event
from ..systems.scenario import OF_CONNECTIONS
from .state import RunState
from .time_grid import TimeGrid


@dataclass(frozen=True)
class Happened:
    """An event that has taken effect.

    Parameters
    ----------
    at, since : float
        When it was to be, and the communication point from which on it counted, s.
    words : str
        What it was.
    """

    at: float
    since: float
    words: str


class Script:
    """Lets series and scenario of a network take effect in one run.

    Parameters
    ----------
    network : Network
        The run's.
    grid : TimeGrid
        Its communication points.
    adaptive : bool
        Whether they are chosen on the way instead.

    Raises
    ------
    ValueError
        An event outside the run, or one that would never have an effect.
    """

    def __init__(self, network: Network, grid: TimeGrid, *, adaptive: bool) -> None:
        self._network, self._grid, self._adaptive = network, grid, adaptive
        self._driving = network.driving
        scenario = network.system.scenario
        self._events = () if scenario is None else scenario.events
        where = "" if scenario is None else scenario.where
        for event in self._events:
            self._check(event, where)
        self._jumps = sorted(
            {t for course in self._driving.courses.values() for t in course.jumps}
            | {event.at for event in self._events} | {event.end for event in self._events}
        )  # fmt: skip
        self._still = -inf  # up to when inputs and parameters are known to stay as they are
        self._told = [tuned.course.pieces[0].first for tuned in self._driving.tuned]
        self._active: dict[tuple[int, int], Fault] = {}
        self._depends = {
            (i, j): bool(network.slaves[i].description.feedthrough[:, j].any())
            for i, j in (*self._driving.courses, *self._driving.faults)
        }
        depending = (course for end, course in self._driving.courses.items() if self._depends[end])
        self._jumped = self._points(t for course in depending for t in course.jumps)
        self._tuned = [self._points(tuned.course.jumps) for tuned in self._driving.tuned]

    def _check(self, event: Event, where: str) -> None:
        grid, what = self._grid, f"{where}: {event.does} {event.target} at t = {event.at:g} s"
        if not grid.start <= event.at < grid.stop:
            raise ValueError(f"{what} must lie in the run, from {grid.start:g} s to before {grid.stop:g} s")
        if event.does != "ramp" and self.since(event) >= grid.stop:
            raise ValueError(f"{what} has no effect: the next communication point is the end of the run at {grid.stop:g} s")
        for other in self._events:
            if other.target == event.target and other.at < event.at and self.since(other) == self.since(event):
                raise ValueError(f"{what} and {other.does} at t = {other.at:g} s must not fall into the same macro step")

    def since(self, event: Event) -> float:
        """The communication point from which on an event counts, s."""
        return event.at if self._adaptive or event.does == "ramp" else self._grid.time(self._after(event.at))

    def _after(self, t: float) -> int:
        """The number of the first communication point at or after t (s)."""
        return max(0, min(self._grid.n, ceil((t - self._grid.start) / self._grid.step - 1e-9)))

    def _points(self, jumps: Iterable[float]) -> np.ndarray:
        """The communication points from which on jumps count, in order, s."""
        times = sorted(jumps)
        return np.array(times if self._adaptive else [self._grid.time(self._after(t)) for t in times])

    def _on(self, points: np.ndarray, t: float) -> bool:
        """Whether one of `points` is the communication point t (s)."""
        near = 1e-9 * self._grid.step
        place = int(np.searchsorted(points, t - near))
        return place < points.size and bool(points[place] <= t + near)

    @property
    def nothing_frozen(self) -> np.ndarray:
        """What the state of a run keeps for freezes that are still to come."""
        return np.full(self._driving.frozen, np.nan)

    def steps_at_rest(self, done: int) -> int:
        """How many macro steps after the first `done` there are in which nothing changes; 0 where something is on its way."""
        t = self._grid.time(done)
        if t >= self._still:
            courses = (*self._driving.courses.values(), *(tuned.course for tuned in self._driving.tuned))
            ahead = [fault.at for faults in self._driving.faults.values() for fault in faults if self._after(fault.at) > done]
            self._still = min([course.still_until(t) for course in courses] + ahead, default=inf)
        if self._still == inf:
            return self._grid.n - done
        return max(0, floor((self._still - self._grid.start) / self._grid.step + 1e-9) - done)

    def next_jump(self, t: float) -> float:
        """When something jumps next after t (s); a macro step that adapts ends there at the latest."""
        place = int(np.searchsorted(self._jumps, t + 1e-12 * max(1.0, abs(t)), "right"))
        return self._jumps[place] if place < len(self._jumps) else inf

    def adopt(self, state: RunState) -> None:
        """Go on from a state in which what is due has taken effect already."""
        t = state.history.t[0]
        self._told = [tuned.course.at(t) for tuned in self._driving.tuned]
        self._active = self._due(t)
        self._network.alter(self._changes(state.frozen))

    def at(self, state: RunState) -> RunState:
        """The state after what takes effect at its newest point; the same object where nothing does.

        Where outputs may jump, the history begins anew: nothing is extrapolated over a jump.
        """
        t, network = state.history.t[0], self._network
        changed, jumps = self._tune(t, started=state.done > 0)
        frozen, active = state.frozen, self._due(t)
        if active != self._active:
            fresh = {end: fault for end, fault in active.items() if self._active.get(end) != fault}
            for (i, j), fault in fresh.items():
                if np.isnan(fault.value):
                    frozen = frozen.copy()
                    frozen[fault.place] = network.inputs(i, state.history.Y[0][None, :], t)[0, j]
            self._active = active
            network.alter(self._changes(frozen))
            changed, jumps = True, jumps or any(self._depends[end] for end in fresh)
        jumped = self._on(self._jumped, t)
        if not (changed or jumped):
            return state
        network.recall(())
        Y = network.outputs(state.history.Y[0].copy(), t)
        if jumps or jumped:
            return replace(state, history=History((t,), (Y,), state.history.held), memory={}, frozen=frozen)
        history = History(state.history.t, (Y, *state.history.Y[1:]), state.history.held)
        return replace(state, history=history, frozen=frozen)

    def _tune(self, t: float, *, started: bool) -> tuple[bool, bool]:
        """Give parameters their values at t (s): whether any has changed, and whether one has jumped."""
        changed = jumps = False
        for k, tuned in enumerate(self._driving.tuned):
            value = tuned.course.at(t)
            if value != self._told[k]:
                slave = tunable(self._network.slaves[tuned.i])
                assert slave is not None  # the network has looked
                slave.tune({tuned.name: value}, t)
                self._told[k] = value
                changed = True
                jumps = jumps or not started or self._on(self._tuned[k], t)
        return changed, jumps

    def _due(self, t: float) -> dict[tuple[int, int], Fault]:
        """The newest fault of each connection at t (s)."""
        found = {}
        for end, faults in self._driving.faults.items():
            for fault in faults:
                reached = fault.at if self._adaptive else self._grid.time(self._after(fault.at))
                if reached <= t + 1e-9 * self._grid.step:
                    found[end] = fault
        return found

    def _changes(self, frozen: np.ndarray) -> dict[tuple[int, int], tuple[float, float]]:
        """What alter() is told: factor and value of each connection at fault."""
        kept: Mapping[tuple[int, int], Fault] = self._active
        return {
            end: (fault.factor, float(frozen[fault.place]) if np.isnan(fault.value) else fault.value)
            for end, fault in kept.items()
            if (fault.factor, fault.value) != (1.0, 0.0)
        }

    def happened(self, state: RunState) -> tuple[Happened, ...]:
        """What has taken effect by a state, in the order of time."""
        t = state.history.t[0]
        reached = [event for event in self._events if self.since(event) <= t + 1e-9 * self._grid.step]
        return tuple(Happened(event.at, self.since(event), self._words(event, state.frozen)) for event in reached)

    def _words(self, event: Event, frozen: np.ndarray) -> str:
        joint = {"offset": " by ", "scale": " by "}.get(event.does, " to ")
        value = f"{event.value:g}" if isinstance(event.value, float | int) and not isinstance(event.value, bool) else event.value
        words = f"{event.does} {event.target}" + ("" if event.value is None else f"{joint}{value}")
        words += f" over {event.over:g} s" if event.over else ""
        if event.does not in OF_CONNECTIONS or event.does != "freeze":
            return words
        kept = [
            float(frozen[fault.place])
            for (i, j), faults in self._driving.faults.items()
            for fault in faults
            if fault.at == event.at and np.isnan(fault.value) and self._means(event, i, j)
        ]
        return f"{words} at {', '.join(f'{value:.6g}' for value in kept)}"

    def _means(self, event: Event, i: int, j: int) -> bool:
        slave = self._network.slaves[i]
        full = self._network.system.full(event.target)
        owner = self._network.system.owner(full) or full.partition(".")[0]
        return full[len(owner) + 1 :] == slave.inputs[j].name and slave.name in self._network.system.addressed(owner)
