"""What an FMU promises and does not keep, found before the run on an instance of its own.

FMI's flags say too little: none says up to which order an FMU takes derivatives of its inputs, and some FMUs answer with an
error where their flags say that they can. After an error an instance is lost, so it must not be the one that runs; nor may it
share anything with that, so its library is loaded from a copy of its own. FMUs of our own export are believed; so is what the run
does not use.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from typing import TYPE_CHECKING

from ...errors import RunError
from ..description import SlaveDescription
from ..signal import Value
from ..usage import Usage
from .description import Description
from .unpacked import OpenedFmu

if TYPE_CHECKING:
    from .promised import PromisedFmu

OURS = "gyro-cosim"  # the generation tool of our own export
BEST = ("their mean over a step, which keeps order 2", "the best line over a step, which keeps order 3")  # see network.projected


def kept(
    slave: PromisedFmu, opened: OpenedFmu, usage: Usage, values: Mapping[str, Value], t: float, stop: float
) -> tuple[SlaveDescription, tuple[str, ...]]:
    """What the FMU keeps of its description in such a run, and what is to be told of that.

    Raises
    ------
    ValueError
        What the run cannot do without.
    """
    name, model, full = slave.name, slave.model, slave.described
    if usage.uneven and not model.exchanged and not model.can("canHandleVariableCommunicationStepSize"):
        raise ValueError(
            f"component {name!r} must have steps of one length (its FMU says no canHandleVariableCommunicationStepSize): "
            f"{usage.uneven}"
        )
    degree = min(usage.degree, full.input_degree) if full.inputs else 0
    follows = degree > 0 and model.version != "3" and not model.exchanged
    goes_back = bool(usage.goes_back) and full.can_restore
    if ours(model) or not (follows or goes_back or full.counts_events):
        return full, ()
    if not opened.shareable:
        if not follows:
            return full, ()
        why = "which cannot be tried, since it can be instantiated once only"
        return replace(full, input_degree=0), (_lower(name, 0, "input derivatives", why),)
    notes: list[str] = []
    found = full
    while True:
        lost = _lost(slave, opened, found, follows, goes_back, values, t, stop)
        if lost is None:
            return found, tuple(notes)
        what, why = lost
        if what == "derivatives" and found.input_degree > 0:
            order = min(usage.degree, found.input_degree)
            found = replace(found, input_degree=order - 1)
            notes.append(_lower(name, order - 1, ("", "input derivatives", "second input derivatives")[order], why))
            follows = order > 1
        elif what == "states":
            if not usage.can_do_without:
                raise ValueError(
                    f"{usage.goes_back} needs components that can save and restore their state, {name!r} cannot: {why}"
                )
            found, goes_back = replace(found, can_restore=False, can_serialize=False), False
            notes.append(f"component {name!r} says that it can save and restore its state, and cannot ({why}): "
                         "the first steps of the run have a lower order")  # fmt: skip
        elif what == "events" and found.counts_events and "answered" in why:
            found = found.without_events()
            without = _lost(slave, opened, found, False, False, values, t, stop)
            if without is not None:
                return full, ()  # it is something else: the run will tell
            notes.append(f"component {name!r} says that it has event mode, and refuses it ({why}): it runs without")
        else:
            return full, ()


def untold(name: str, model: Description, usage: Usage) -> tuple[str, ...]:
    """What of such a run an FMU cannot be told, or cannot follow, by its version or description alone, one line each."""
    notes = []
    if usage.tolerance is not None and model.version == "1":
        notes.append(f"component {name!r} is told no tolerance, since FMI 1.0 has none in Co-Simulation")
    if 0.0 < usage.step * (1 + 1e-9) < model.own_step:
        notes.append(f"component {name!r} has steps of its own of {model.own_step:g} s (fixedInternalStepSize), longer than "
                     f"{usage.step:g} s: within one of them its outputs stay as they are")  # fmt: skip
    return tuple(notes)


def ours(model: Description) -> bool:
    """Whether the FMU is of our own export."""
    return model.identity.get("generationTool", "").startswith(OURS)


def _lower(name: str, degree: int, what: str, why: str) -> str:
    return f"component {name!r} does not take {what} ({why}): its inputs follow {BEST[degree]}"


def _lost(
    slave: PromisedFmu, opened: OpenedFmu, description: SlaveDescription, follows: bool, goes_back: bool,
    values: Mapping[str, Value], t: float, stop: float,
) -> tuple[str, str] | None:  # fmt: skip
    """What an instance that is like `slave`, but of this `description`, fails in ("events": in starting), and how; else None."""
    own = OpenedFmu(opened.location, opened.model.interface)  # some FMUs keep what a freed instance has left behind
    other = type(slave)(slave.name, own.take(), slave.given)
    what = "events"
    try:
        other.like(slave, description)
        other.initialize(values, t, stop)
        what = "states"
        if goes_back:
            state = other.save()
            other.restore(state)
            other.discard(state)
        what = "derivatives"
        if follows:
            other.try_derivatives(min(slave.usage.degree, description.input_degree), t)
    except RunError as error:
        return what, getattr(error, "reason", str(error))
    finally:
        other.close()
    return None
