"""Paces a run to the wall clock: sleep, then spin; says truly what was late.

    pacer = Pacer(1e-3, steps=60_000)
    with pacer:
        simulate(plan, step=1e-3, stop=60.0, before_step=pacer)
    print(pacer.report())

Macro step k is due at start + (k - 1) period; the call before it returns then, never earlier. A call that comes after the
step is due is an overrun: the work of the steps before took too long. What happens then is the policy:

    count   go on at once; the time table stays, so that the run catches up
    skip    the periods that have begun are given up; the step is done when the next one begins, and so on from there
    stop    RealTimeError; the run keeps its results

Sleeping wakes up tens of microseconds late on a common kernel, spinning costs a core: so the wait sleeps until `spin` seconds
before it is due and then reads the clock. While the pacer is active the garbage collector is off (and run once before), the
process's memory is locked where the system allows it, so that no page has to be fetched, and the kernel's timer slack is 1 us
instead of 50.
"""

import ctypes
import gc
import os
import sys
import time
from dataclasses import dataclass
from types import TracebackType
from typing import Literal

import numpy as np

from ..errors import RunError

__all__ = ["POLICIES", "Pacer", "Policy", "RealTimeError", "Report"]

Policy = Literal["count", "skip", "stop"]
POLICIES: tuple[Policy, ...] = ("count", "skip", "stop")
PERCENTILES = (50.0, 90.0, 99.0, 99.9, 100.0)
_MCL_CURRENT, _MCL_FUTURE = 1, 2
_PR_SET_TIMERSLACK, _PR_GET_TIMERSLACK = 29, 30


class RealTimeError(RunError):
    """A step came too late and the policy is to stop."""


@dataclass(frozen=True, eq=False)
class Report:
    """The timing of a run.

    Parameters
    ----------
    wanted
        The period, s.
    policy
        What was done about overruns.
    overruns, lost
        Macro steps that came after they were due; periods given up by the policy skip.
    period
        Between the beginnings of successive steps, s, shape (steps - 1,).
    latency
        How long after it was due each step began, s, shape (steps,).
    slack
        What was left of the period when the step came, negative for an overrun, s, shape (steps,).
    locked, preferred
        Whether memory was locked, and whether the real-time scheduler was used.
    """

    wanted: float
    policy: Policy
    overruns: int
    lost: int
    period: np.ndarray
    latency: np.ndarray
    slack: np.ndarray
    locked: bool
    preferred: bool

    @property
    def steps(self) -> int:
        """Macro steps begun."""
        return self.latency.size

    def percentiles(self, values: np.ndarray) -> dict[str, float]:
        """The percentiles of PERCENTILES by name ("p99"), "max" for 100; empty without values."""
        if not values.size:
            return {}
        sizes = np.percentile(values, PERCENTILES)
        return {"max" if p == 100.0 else f"p{p:g}": float(v) for p, v in zip(PERCENTILES, sizes, strict=True)}

    def histogram(self, bins: int = 60) -> tuple[np.ndarray, np.ndarray]:
        """How many periods deviate by how much from the wanted one (s): counts (bins,), edges (bins + 1,)."""
        deviation = self.period - self.wanted
        reach = max(1e-6, float(np.percentile(np.abs(deviation), 99.9))) if deviation.size else 1e-6
        return np.histogram(np.clip(deviation, -reach, reach), bins, (-reach, reach))

    def document(self) -> dict[str, object]:
        """The report as JSON holds it."""
        counts, edges = self.histogram()
        return {
            "period_s": self.wanted, "policy": self.policy, "steps": self.steps, "overruns": self.overruns, "lost": self.lost,
            "memory_locked": self.locked, "realtime_scheduler": self.preferred, "period": self.percentiles(self.period),
            "period_deviation": self.percentiles(np.abs(self.period - self.wanted)), "latency": self.percentiles(self.latency),
            "least_slack_s": float(self.slack.min()) if self.slack.size else None,
            "histogram": {"counts": counts.tolist(), "edges_s": edges.tolist()},
        }  # fmt: skip

    def words(self) -> str:
        """Three lines for people."""
        off = self.percentiles(np.abs(self.period - self.wanted))
        late = self.percentiles(self.latency)

        def microseconds(sizes: dict[str, float]) -> str:
            return ", ".join(f"{name} {value * 1e6:.1f}" for name, value in sizes.items()) or "none"

        return (
            f"real time at {self.wanted * 1e3:g} ms: {self.steps} steps, {self.overruns} overruns ({self.policy}), {self.lost} "
            f"periods given up; memory {'locked' if self.locked else 'not locked'}\n"
            f"period off by [us]: {microseconds(off)}\nlatency [us]: {microseconds(late)}"
        )


class Pacer:
    """Paces a run to the wall clock; see the module's docstring.

    Parameters
    ----------
    period
        Of the macro steps, s, at least 0.1 ms.
    steps
        How many to make room for; a longer run makes more.
    overrun
        What to do about a step that comes late: "count", "skip" or "stop".
    spin
        How long before it is due a step stops sleeping, s; at least the whole period means never to sleep.
    grace
        By how much a call may come late before it counts as an overrun, s.
    priority
        Of the real-time scheduler SCHED_FIFO for this thread, 1 to 99, where the system allows it; 0 keeps the usual one.
    """

    def __init__(
        self,
        period: float,
        *,
        steps: int = 1000,
        overrun: Policy = "count",
        spin: float = 300e-6,
        grace: float = 0.0,
        priority: int = 0,
    ) -> None:
        if not (np.isfinite(period) and period >= 1e-4):
            raise ValueError(f"`period` must be at least 0.1 ms, got {period:g} s")
        if overrun not in POLICIES:
            raise ValueError(f"`overrun` must be one of {', '.join(POLICIES)}, got {overrun!r}")
        for name, value in (("spin", spin), ("grace", grace)):
            if not (np.isfinite(value) and value >= 0.0):
                raise ValueError(f"`{name}` must not be negative, got {value:g} s")
        if priority not in range(100):
            raise ValueError(f"`priority` must be 0 to 99, got {priority!r}")
        self._period, self._policy, self._spin, self._grace, self._priority = period, overrun, spin, grace, priority
        self._asked, self._began, self._due = (np.zeros(max(1, steps)) for _ in range(3))
        self._n = self._overruns = self._lost = 0
        self._start = self._paused = 0.0
        self._locked, self._preferred, self._collecting, self._slack_ns = False, False, False, -1

    def __enter__(self) -> "Pacer":
        self._n = self._overruns = self._lost = 0
        self._paused = 0.0
        self._collecting = gc.isenabled()
        gc.collect()
        gc.disable()
        self._locked = _memory(lock=True)
        self._slack_ns = _timer_slack(1000)
        self._preferred = self._priority > 0 and _prefer(self._priority)
        for array in (self._asked, self._began, self._due):
            array[:] = 0.0  # touched now, so that no page is fetched later
        return self

    def __exit__(self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None) -> None:
        if self._locked:
            _memory(lock=False)
        if self._preferred:
            _prefer(0)
        if self._slack_ns >= 0:
            _timer_slack(self._slack_ns)
        if self._collecting:
            gc.enable()

    def __call__(self, k: int) -> None:
        """Wait until macro step k = 1, 2, ... is due; the first one is due at once."""
        asked = time.perf_counter() - self._paused
        if self._n == 0:
            self._start = asked - (k - 1) * self._period
        if self._n == self._asked.size:
            self._asked, self._began, self._due = (
                np.concatenate([a, np.zeros(a.size)]) for a in (self._asked, self._began, self._due)
            )
        due = self._start + (k - 1) * self._period
        if asked > due + self._grace:
            self._overruns += 1
            if self._policy == "stop":
                late = (asked - due) * 1e6
                raise RealTimeError(
                    f"real time: step {k} must begin at {due - self._start:.6f} s, its turn came {late:.0f} us later"
                )
            if self._policy == "skip":
                missed = int(np.ceil((asked - due) / self._period))
                self._lost += missed
                self._start += missed * self._period
                due += missed * self._period
        sleep = due - (time.perf_counter() - self._paused) - self._spin
        if sleep > 0.0:
            time.sleep(sleep)
        now = time.perf_counter() - self._paused
        while now < due:
            now = time.perf_counter() - self._paused
        n = self._n
        self._asked[n], self._began[n], self._due[n] = asked, now, due
        self._n = n + 1

    def postpone(self, seconds: float) -> None:
        """All that is still to come is due so much later: the run was paused on purpose, which is no lateness."""
        self._paused += seconds

    def report(self) -> Report:
        """What has been seen so far."""
        n = self._n
        asked, began, due = (a[:n].copy() for a in (self._asked, self._began, self._due))
        return Report(
            self._period,
            self._policy,
            self._overruns,
            self._lost,
            np.diff(began),
            began - due,
            due - asked,
            self._locked,
            self._preferred,
        )


def _libc() -> ctypes.CDLL | None:
    return ctypes.CDLL(None, use_errno=True) if sys.platform.startswith("linux") else None


def _memory(*, lock: bool) -> bool:
    """Lock or unlock this process's memory; whether that was allowed. Only what is mapped now where the limit forbids more."""
    libc = _libc()
    if libc is None:
        return False
    if not lock:
        return bool(libc.munlockall() == 0)
    if os.geteuid() != 0:  # with a limit, MCL_FUTURE would make later allocations fail
        return bool(libc.mlockall(_MCL_CURRENT) == 0)
    return bool(libc.mlockall(_MCL_CURRENT | _MCL_FUTURE) == 0)


def _prefer(priority: int) -> bool:
    """Put this thread under SCHED_FIFO with `priority`, or back with 0; whether that was allowed."""
    if not hasattr(os, "sched_setscheduler"):
        return False
    try:
        os.sched_setscheduler(0, os.SCHED_FIFO if priority else os.SCHED_OTHER, os.sched_param(priority))
    except OSError:
        return False
    return True


def _timer_slack(nanoseconds: int) -> int:
    """Set this thread's timer slack; returns the one before, or -1 where there is none."""
    libc = _libc()
    if libc is None:
        return -1
    before = int(libc.prctl(_PR_GET_TIMERSLACK, 0, 0, 0, 0))
    libc.prctl(_PR_SET_TIMERSLACK, ctypes.c_ulong(nanoseconds), 0, 0, 0)
    return before
