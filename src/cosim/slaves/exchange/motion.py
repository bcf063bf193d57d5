"""How an FMU for Model Exchange moves: CVODE integrates x' = f(t, x, u), and where something happens there is an event.

    time event      at the time that the FMU has announced, exactly
    state event     where an event indicator changes its sign, located by CVODE; also where an input that jumps does that
    step event      where the FMU asks for it after a step of the integrator
    discrete input  where a step begins in which it differs from the one before
    tick            of an input clock, at its own time

There the FMU goes through event mode until its discrete states have settled, and the integrator begins anew. It does so, too,
where a continuous input jumps far, and after each save and restore, so that a repeated step repeats the bits.
"""

from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import NoReturn

import numpy as np

from ...errors import EndRequest, SlaveError
from ..fmi.events import UPDATES, EventState, hears_of_steps
from ..fmi.fmu import FmuSlave
from ..fmi.ticking import Ticking
from .equations import Equations
from .functions import Functions
from .inputs import Inputs
from .integrator import IntegrationError, Integrator

MOST = 100_000  # steps of the integrator in one step of the slave
STUCK = 1000  # events at one time after which an FMU counts as stuck
FAR = 1000.0
EPS = float(np.finfo(float).eps)


@dataclass(frozen=True)
class Known:
    """What is known of the FMU beside its state, saved and restored with it.

    note : events, the next one, the end, the discrete inputs. positive : which event indicators are above zero at the end of the
    last step; what differs under the next one's inputs is an event.
    """

    note: EventState
    positive: tuple[bool, ...] = ()


class Motion:
    """From the end of initialization mode at t (s) on; `tolerance` is the relative one.

    The absolute one is a hundredth of it times the nominal value of each state, as FMI recommends. u : inputs at t, None where
    nobody has told them. note : what is known already.

    Attributes
    ----------
    known : Known
        To be kept, and put back by back().
    x : ndarray, shape (n_x,)
        The continuous states at the time reached.
    reached : callable or None
        To be called with the time (s) after each step of the integrator, and after each event.
    """

    reached: Callable[[float], None] | None = None

    def __init__(
        self, fmu: FmuSlave, calls: Functions, inputs: Inputs, ticking: Ticking, tolerance: float, t: float,
        u: np.ndarray | None, note: EventState,
    ) -> None:  # fmt: skip
        self._fmu, self._calls, self._inputs, self._ticking, self._tolerance = fmu, calls, inputs, ticking, tolerance
        self._instance, self._hears = fmu.instance, hears_of_steps(fmu.model)
        self._equations = Equations(fmu, calls, inputs, t)
        self._n_x, self._n_z = self._equations.n_x, self._equations.n_z
        self._nominals = np.ones(self._n_x)
        self._integrator = Integrator(self._n_x, self._n_z, self._equations.rates, self._equations.roots)
        self.x = self._integrator.x
        self._x_place = self.x.ctypes.data
        self.known = Known(ticking.tick(ticking.begin(replace(note, discrete=inputs.told(t)), t), u, t, 0.0))
        self._last = np.full(inputs.smooth.size, np.nan)  # continuous inputs at the end of the last step
        self.fresh, self._over, self._at = True, False, t
        self._settle(t, 0.0, told=True)

    def close(self) -> None:
        """Free the integrator."""
        self._integrator.close()

    # ---- between steps

    def offer(self, u: np.ndarray, t: float, h: float = 0.0) -> None:
        """The inputs u at t (s), through event mode where a discrete one has changed."""
        self._inputs.hold(u[self._inputs.smooth], t)
        if self._over:
            self._inputs.put_all(u, t, h)
        elif tuple(u[self._inputs.discrete].tolist()) != self.known.note.discrete:
            self._event(u, t, h)
        else:
            self._put(t, h)

    def back(self, known: Known, t: float) -> None:
        """The FMU has gone back to t (s), where `known` was known."""
        self.known, self.fresh, self._over, self._at = known, True, False, t
        self._equations.read_states(self._x_place, t, 0.0)
        self._nominals = self._equations.nominals(t, 0.0)

    def put_back(self, t: float, x: np.ndarray) -> None:
        """The FMU goes back to t (s) and the states x, all that it remembers."""
        self.x[:] = x
        self._inputs.varying = False
        self._place(t, 0.0)

    # ---- a step

    def step(self, U: np.ndarray, t: float, h: float) -> None:
        """See Slave."""
        if self.known.note.ends:
            raise EndRequest(self._fmu.name, t)
        self._fmu.final(t)  # the states that are held are of this time
        if U.shape[1]:
            self.fresh = self.fresh or self._jumps(U[0][self._inputs.smooth], t, h)
            self.offer(U[0], t, h)
            self._inputs.follow(U, t)
            if self._n_z and self._equations.signs(t, h) != self.known.positive:
                self._event(U[0], t, h)
        self._go(U, t, t + h)
        if U.shape[1]:
            self._last = self._inputs.at(t + h)
            self.known = replace(self.known, positive=self._equations.signs(t + h, h))

    def _jumps(self, value: np.ndarray, t: float, h: float) -> bool:
        """Whether the inputs jump so far at t (s) that within h a state moves by it FAR times further than the tolerance.

        Over the small jumps of extrapolated inputs CVODE goes on, with its error under control: to begin anew takes ten steps
        for one, and has the error of each.
        """
        if not self._n_x or np.array_equal(value, self._last):
            return False
        rates = []
        for one in (self._last, value):
            self._inputs.hold(one, t)
            self._put(t, h)
            rates.append(self._equations.present_rates(t, h))
        moved = h * np.abs(rates[1] - rates[0])
        return not bool(np.all(moved <= FAR * self._tolerance * (np.abs(self.x) + 0.01 * self._nominals)))

    def _go(self, U: np.ndarray, t: float, end: float) -> None:
        """From t to `end` (s), in as many parts as things happen in between."""
        h, steps, stuck, self._equations.trouble = end - t, 0, 0, ""
        close = 1e-9 * h + 4 * EPS * abs(end)
        now = self._at if abs(self._at - t) <= close else t  # an event may have been a hair beyond the last step
        while end - now > close or self._due <= now + close:
            due, before = self._due, now
            happens = due <= now + close
            if happens:
                now = max(now, due)
                self._place(now, h)
            else:
                now, happens = self._advance(now, due if due <= end + close else end)
                happens = self._arrive(now, h) or happens or due <= now
                if self.reached is not None:
                    self.reached(now)
                steps += 1
            if happens:
                s = now - t
                self._event(U[0] + s * (U[1] + s / 2 * U[2]), now, h)
                if self.reached is not None:
                    self.reached(now)
            stuck = 0 if now > before + close else stuck + 1
            if self.known.note.ends and end - now > close:
                raise EndRequest(self._fmu.name, now)
            if stuck > STUCK and happens:
                self._fails(f"the FMU must get on, stays at t = {now:.9g} s for {STUCK} events", t, h)
            if stuck > STUCK or steps > MOST:
                most = f"{min(steps, MOST)} steps of the integrator"
                self._fails(f"{most} must reach the end, they are at t = {now:.9g} s{self._why}", t, h)
        if now < end and not self._over:
            self._place(end, h)

    def _advance(self, now: float, stop: float) -> tuple[float, bool]:
        """One step of the integrator towards `stop` (s): the time reached, and whether an event indicator has its zero there."""
        if not self._n_x + self._n_z:
            return stop, False
        try:
            if self.fresh:
                self._integrator.restart(now, self._tolerance, 0.01 * self._tolerance * self._nominals)
                self.fresh = False
            reached, root = self._integrator.advance(stop)
        except IntegrationError as error:
            self._fails(f"{error}{self._why}", now, stop - now)
        return (stop if abs(stop - reached) <= 4 * EPS * abs(stop) else reached), root

    def _arrive(self, t: float, h: float) -> bool:
        """The FMU is told of a completed step of the integrator at t (s); whether it wants an event there."""
        self._place(t, h)
        if not self._hears:
            return False
        event, ends = self._calls.completed(self._instance, self._fmu.final(t), t, h)
        if ends:
            self.learn(replace(self.known.note, ends=True))
        return event

    def _place(self, t: float, h: float) -> None:
        """The FMU at t (s), with the states and inputs there."""
        calls, instance, prefix, self._at = self._calls, self._instance, self._calls.prefix, t
        self._fmu.check(calls.set_time(instance, t), f"{prefix}SetTime", t, h)
        if self._inputs.varying:
            self._put(t, h)
        if self._n_x:
            self._fmu.check(calls.set_states(instance, self._x_place, self._n_x), f"{prefix}SetContinuousStates", t, h)

    def _put(self, t: float, h: float) -> None:
        status, call = self._inputs.put(t)
        self._fmu.check(status, call, t, h)

    # ---- events

    def _event(self, u: np.ndarray, t: float, h: float) -> None:
        """Through event mode at t (s), where the inputs are u."""

        def happen() -> None:
            self._inputs.put_all(u, t, h)
            self.learn(replace(self.known.note, discrete=tuple(u[self._inputs.discrete].tolist())))
            self.learn(self._ticking.tick(self.known.note, u, t, h))

        self.through_event(happen, t, h)

    def through_event(self, change: Callable[[], None], t: float, h: float = 0.0) -> None:
        """Through event mode at t (s), where `change` is done."""
        self._calls.enter_event_mode(self._instance, t, h)
        change()
        self.learn(replace(self.known.note, events=self.known.note.events + 1))
        self._settle(t, h)

    @property
    def _due(self) -> float:
        """When the next event comes that is known beforehand (s)."""
        return min(self.known.note.due, self._ticking.due(self.known.note))

    def learn(self, note: EventState) -> None:
        """What is known from now on."""
        self.known = replace(self.known, note=note)

    def _settle(self, t: float, h: float, *, told: bool = False) -> None:
        """In event mode: update until nothing changes, then on in continuous-time mode. told : its nominal values are new.

        Where the FMU wants the run to end, it stays in event mode, in which its outputs can still be read.
        """
        self.learn(self._ticking.look(self.known.note, t))
        for _ in range(UPDATES):
            update = self._calls.update(self._instance, t, h)
            self.learn(self._ticking.look(self.known.note, t))
            told = told or update.nominals
            if update.ends or not update.more:
                break
        else:
            self._fails(f"the discrete states must settle, they do not in {UPDATES} updates", t, h)
        self._ticking.leave()
        self._over = update.ends
        if not self._over:
            self._calls.enter_continuous_time_mode(self._instance, t, h)
        self._equations.read_states(self._x_place, t, h)
        if told:
            self._nominals = self._equations.nominals(t, h)
        note = self.known.note
        self.known = Known(replace(note, due=update.due, ends=note.ends or update.ends), self._equations.signs(t, h))
        self.fresh = True

    @property
    def _why(self) -> str:
        """The last thing in this step that made the integrator try a shorter one."""
        trouble = self._equations.trouble
        return trouble and f": {trouble}"

    def _fails(self, reason: str, t: float, h: float) -> NoReturn:
        raise SlaveError(self._fmu.name, t, h, reason, self._fmu.log.said())
