"""What viewers want of a run, carried from their threads into the run's own: begin, pause, pace, changes, the end."""

import threading
import time
from collections.abc import Callable, Mapping, Sequence
from typing import Any

import numpy as np

from ...errors import unknown
from ...master.visiting import Change
from ...slaves import Signal
from ...systems import Event
from .film import Film

__all__ = ["PACES", "Steering"]

PACES = (0.0, 0.1, 1.0, 10.0)  # times real time; 0: as fast as it goes
REACTION = 0.05  # s of the clock that macro steps done at once may stand for
ANY = 1 << 62  # macro steps
MOST = 1000  # changes in a run


class Steering:
    """The Visitor of a run that is seen live.

    Parameters
    ----------
    film : Film
        Where the rows of the run go.
    offered : mapping
        What may change on the way: component -> name -> signal.
    step : float
        Macro step, s.
    waits : bool
        Whether the run begins only when a viewer wants it to.
    on_pause : callable, optional
        Told after each pause how long it took, s: what paces the run must not take it for lateness.

    Attributes
    ----------
    events : list of Event
        What has been changed, as a scenario says it.
    """

    def __init__(
        self,
        film: Film,
        offered: Mapping[str, Mapping[str, Signal]],
        *,
        step: float,
        waits: bool,
        on_pause: Callable[[float], None] | None = None,
    ) -> None:
        self.events: list[Event] = []
        self._film, self._offered, self._step, self._on_pause = film, offered, step, on_pause
        self._waits = waits
        self._wanted = threading.Condition()
        self._pending: dict[tuple[str, str], float] = {}
        self._latest: dict[tuple[str, str], float] = {}
        self._state, self._ending, self._pace = ("waiting" if waits else "running"), False, 0.0
        self._moved = not waits  # something is wanted: looked at before every macro step, so it is one word
        self._since = (0.0, 0.0)  # clock and time of the run from which the pace counts, s
        self._t = -np.inf

    @property
    def at_most(self) -> int:
        """See Visitor: fewer where the pace is slow, so that what is seen comes evenly."""
        return ANY if self._pace == 0.0 else max(1, int(REACTION * self._pace / self._step))

    def saw(self, k: int, t: np.ndarray, Y: np.ndarray) -> None:
        """See Visitor."""
        self._film.add(k, t, Y)
        self._t = float(t[-1])

    def ready(self) -> None:
        """See Visitor."""
        with self._wanted:
            while self._state == "waiting" and not self._ending:
                self._wanted.wait(1.0)  # so that Ctrl-C is heard on every system
            self._count_from_here()
            if self._ending:
                raise KeyboardInterrupt

    def visit(self, t: float) -> Sequence[Change]:
        """See Visitor."""
        if not self._moved and self._pace == 0.0:
            return ()
        with self._wanted:
            self._moved = False
            if self._state == "paused" and not self._ending:
                self._pause()
            self._keep_pace(t)
            if self._ending:
                raise KeyboardInterrupt
            changes = tuple(Change(component, name, value) for (component, name), value in self._pending.items())
            self._pending.clear()
            self.events += [Event(t, "set", f"{change.component}.{change.name}", change.value) for change in changes]
            return changes

    def _pause(self) -> None:
        began = time.perf_counter()
        while self._state == "paused" and not self._ending:
            self._wanted.wait(1.0)
        self._count_from_here()
        if self._on_pause is not None:
            self._on_pause(time.perf_counter() - began)

    def _keep_pace(self, t: float) -> None:
        """Wait until the clock has come to t (s), unless something is wanted."""
        while self._pace and not self._moved:
            clock, began = self._since
            ahead = (t - began) / self._pace - (time.perf_counter() - clock)
            if ahead <= 0.0:
                return
            self._wanted.wait(min(ahead, 1.0))

    def _count_from_here(self) -> None:
        self._since = (time.perf_counter(), self._t)

    def over(self) -> None:
        """The run has ended."""
        with self._wanted:
            self._state = "over"

    def told(self) -> dict[str, Any]:
        """How the run is, for viewers."""
        changes = [{"at": event.at, "name": event.target, "value": event.value} for event in tuple(self.events)]
        return {"state": self._state, "t": self._t if np.isfinite(self._t) else None, "pace": self._pace, "changes": changes}

    def want(self, wish: Mapping[str, Any]) -> None:
        """Do what a viewer wants, in the viewer's thread: `do` is go, pause, stop, pace or set.

        Raises
        ------
        ValueError
            What is wrong with the wish.
        """
        does = wish.get("do")
        deeds: dict[str, Callable[[Mapping[str, Any]], None]] = {
            "go": self._go,
            "pause": self._hold,
            "stop": self._stop,
            "pace": self._choose_pace,
            "set": self._set,
        }
        if not isinstance(does, str) or does not in deeds:
            raise unknown("wish:", str(does), deeds)
        with self._wanted:
            if self._state == "over":
                raise ValueError("the run is over")
            deeds[does](wish)
            self._moved = True
            self._wanted.notify_all()

    def _go(self, wish: Mapping[str, Any]) -> None:
        self._state = "running"

    def _hold(self, wish: Mapping[str, Any]) -> None:
        if self._state == "running":
            self._state = "paused"

    def _stop(self, wish: Mapping[str, Any]) -> None:
        self._ending = True

    def _choose_pace(self, wish: Mapping[str, Any]) -> None:
        pace = wish.get("value")
        if isinstance(pace, bool) or pace not in PACES or not self._waits:
            known = ", ".join(f"{p:g}" for p in PACES)
            raise ValueError(f"the pace must be one of {known}, where --realtime does not set it, got {pace!r}")
        self._pace = float(pace)
        self._count_from_here()

    def _set(self, wish: Mapping[str, Any]) -> None:
        component, name, given = wish.get("component"), wish.get("name"), wish.get("value")
        signal = self._offered.get(str(component), {}).get(str(name))
        if signal is None:
            known = [f"{c}.{n}" for c, names in self._offered.items() for n in names]
            raise unknown("parameter that may change on the way:", f"{component}.{name}", known)
        if isinstance(given, bool) or not isinstance(given, int | float | str):
            raise ValueError(f"{component}.{name} must be a number, got {given!r}")
        try:
            value = signal.value(given)
        except ValueError as error:
            raise ValueError(f"{component}.{name} {error}") from None
        if len(self.events) + len(self._pending) >= MOST:
            raise ValueError(f"there may be {MOST} changes in a run, not more")
        assert isinstance(value, float | int)  # a single number, or it would not be offered
        if self._latest.get((str(component), str(name))) != float(value):
            self._pending[str(component), str(name)] = self._latest[str(component), str(name)] = float(value)
