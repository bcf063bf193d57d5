"""Probes of events: event mode of Co-Simulation, event indicators, clocks, model partitions."""

import ctypes
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from .examined import STEPS, Examined
from .findings import Say
from .instance import Instance

CHANGED = 2  # of fmi3IntervalQualifier
ROUNDS = 100  # of updateDiscreteStates, after which an event iteration counts as endless


def events(fmu: Examined, say: Say) -> None:
    """Model Exchange: event indicators can be read. Co-Simulation of FMI 3.0 with event mode: events come to an end, in order."""
    if fmu.model.modelExchange is not None:
        with fmu.instance("me") as it:
            _indicators(fmu, it.initialize(), say)
    if fmu.kind != "cs" or not fmu.can("hasEventMode"):
        return
    with fmu.instance("cs", events=True) as it:
        it.initialize()
        following = _handle(it, it.start, say)
        it.call("fmi3EnterStepMode", it.fmu.enterStepMode)
        if any(v.type == "Clock" and v.causality == "input" for v in fmu.model.modelVariables):
            return  # a step must not pass a tick, see clocks()
        t = it.start
        for _ in range(STEPS):
            h = fmu.h if following is None or following <= t else min(fmu.h, following - t)
            happened, ends, early, last = it.call("fmi3DoStep", lambda t=t, h=h: it.fmu.doStep(t, h))
            end = t + h
            if early:
                say(f"a step from {t:g} s over {h:g} s must not return early, which was not allowed")
                return
            if not abs(last - end) <= 1e-9 * max(abs(end), h):
                say(f"a step from {t:g} s over {h:g} s must say that it ends there, says {last!r} s")
                return
            t = end
            if ends:
                return
            if happened or (following is not None and t >= following):
                it.call("fmi3EnterEventMode", it.fmu.enterEventMode)
                following = _handle(it, t, say)
                it.call("fmi3EnterStepMode", it.fmu.enterStepMode)


def _handle(it: Instance, t: float, say: Say) -> float | None:
    """Update the discrete states until they agree; the time of the next event, if it is known."""
    for _ in range(ROUNDS):
        again, _ends, _nominals, _values, known, following = it.call("fmi3UpdateDiscreteStates", it.fmu.updateDiscreteStates)
        if not again:
            break
    else:
        say(f"the event iteration at {t:g} s must end, goes on after {ROUNDS} rounds")
    if not known:
        return None
    if not following > t:
        say(f"the next event at {t:g} s must lie in the future, is said to be at {following!r} s")
        return None
    return float(following)


def _indicators(fmu: Examined, it: Instance, say: Say) -> None:
    if it.version == "2":
        n = int(fmu.model.numberOfEventIndicators or 0)
    else:
        count = ctypes.c_size_t()
        it.call(
            "get number of event indicators", lambda: it.fmu.fmi3GetNumberOfEventIndicators(it.fmu.component, ctypes.byref(count))
        )
        n = count.value
        if n != len(fmu.model.eventIndicators):
            say(f"the FMU must have the {len(fmu.model.eventIndicators)} event indicators of ModelStructure, says {n}")
    if n:
        z = np.zeros(n)
        pointer = z.ctypes.data_as(ctypes.POINTER(ctypes.c_double))
        it.call("get event indicators", lambda: it.fmu.getEventIndicators(pointer, n))
        if not np.isfinite(z).all():
            say(f"event indicators must be finite at the start, got {z[~np.isfinite(z)][0]}")


def clocks(fmu: Examined, say: Say) -> None:
    """Every input clock can be ticked in event mode when it is due, every output clock asked for, by either interface."""
    found = [v for v in fmu.model.modelVariables if v.type == "Clock"]
    if fmu.kind == "se" or not found:
        return
    if fmu.kind == "cs" and not fmu.can("hasEventMode"):
        say("clocks need event mode in Co-Simulation, hasEventMode is not true")
        return
    if fmu.events_only:
        _clocks(fmu, "cs", found, say)
    _clocks(fmu, fmu.kind, found, say)


def _clocks(fmu: Examined, kind: str, found: Sequence[Any], say: Say) -> None:
    inputs = [v for v in found if v.causality == "input"]
    outputs = [v for v in found if v.causality == "output"]
    with fmu.instance(kind, events=kind == "cs") as it:
        it.initialize(stay=True)
        said = {v.name: _said(it, v, say) for v in inputs if v.name in fmu.unstated}
        it.call("fmi3ExitInitializationMode", it.fmu.exitInitializationMode)  # into event mode
        due = {v.name: it.start + said[v.name] if v.name in said else _first(it, v, fmu.shifts[v.name], say) for v in inputs}
        _tick(it, inputs, due, outputs, it.start, say)
        leave = it.fmu.enterStepMode if kind == "cs" else it.fmu.enterContinuousTimeMode
        it.call("leave event mode", leave)
        next_ = min((t for t in due.values() if t > it.start), default=np.inf)
        if kind == "cs" and fmu.can("canHandleVariableCommunicationStepSize") and np.isfinite(next_):
            happened, ends, early, last = it.call("fmi3DoStep", lambda: it.fmu.doStep(it.start, next_ - it.start))
            if not (happened or ends or early) and abs(last - next_) <= 1e-9 * max(1.0, abs(next_)):
                it.call("fmi3EnterEventMode", it.fmu.enterEventMode)
                _tick(it, inputs, due, outputs, next_, say)
                it.call("fmi3EnterStepMode", it.fmu.enterStepMode)


def _tick(it: Instance, inputs: Sequence[Any], due: Mapping[str, float], outputs: Sequence[Any], t: float, say: Say) -> None:
    """In event mode at t (s): the clocks that are due, and those that others tick; output clocks are asked before an update."""
    for v in inputs:
        if v.intervalVariability == "triggered" or abs(due[v.name] - t) <= 1e-9 * max(1.0, abs(t)):
            it.call(f"tick clock {v.name} at {t:g} s", lambda v=v: it.fmu.setClock([v.valueReference], [True]))
            for output in outputs:
                it.values(output)
            _handle(it, t, say)


def _first(it: Instance, clock: Any, shift: float, say: Say) -> float:
    """When a clock ticks first (s); infinite where that is not known, or others tick it."""
    kind = clock.intervalVariability
    if kind == "triggered":
        return float("inf")
    known, interval = (1, 0.0) if kind in ("constant", "fixed") else _interval(it, clock, say)
    if kind == "countdown":
        return it.start + interval if known == CHANGED else float("inf")
    return it.start + shift


def _said(it: Instance, clock: Any, say: Say) -> float:
    """In initialization mode: the shift (s) of a clock whose interval and shift follow from parameters."""
    _, interval = _interval(it, clock, say)
    if not interval > 0.0:
        say(f"clock {clock.name!r}: its interval must be positive, got {interval} s")
    shift = (ctypes.c_double * 1)()
    references = (ctypes.c_uint * 1)(clock.valueReference)
    it.call(f"get shift of {clock.name}", lambda: it.fmu.getShiftDecimal(references, shift))
    return float(shift[0])


def _interval(it: Instance, clock: Any, say: Say) -> tuple[int, float]:
    """Qualifier and interval (s) that the FMU gives: positive, or it says that there is none now."""
    interval, qualifier = (ctypes.c_double * 1)(), (ctypes.c_int * 1)()
    references = (ctypes.c_uint * 1)(clock.valueReference)
    it.call(f"get interval of {clock.name}", lambda: it.fmu.getIntervalDecimal(references, interval, qualifier))
    if qualifier[0] not in (0, 1, 2):
        say(f"clock {clock.name!r}: the qualifier of its interval must be 0, 1 or 2, got {qualifier[0]}")
    elif qualifier[0] == CHANGED and not (interval[0] > 0.0 or (clock.intervalVariability == "countdown" and interval[0] >= 0.0)):
        say(f"clock {clock.name!r}: its interval must be positive, got {interval[0]} s")
    return qualifier[0], interval[0]


def scheduled(fmu: Examined, say: Say) -> None:
    """Scheduled Execution: it starts, and each model partition can be activated once."""
    if fmu.model.scheduledExecution is None:
        return
    if fmu.kind == "se":
        say("it offers Scheduled Execution only: it was started and its partitions activated, `cosim run` cannot use it", "note")
    with fmu.instance("se") as it:
        it.initialize()
        for v in fmu.model.modelVariables:
            if v.type == "Clock" and v.causality == "input":
                it.call(f"activate {v.name}", lambda v=v: it.fmu.activateModelPartition(v.valueReference, it.start))
