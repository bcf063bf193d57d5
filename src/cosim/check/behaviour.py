"""Probes of behaviour: start, saved states, several instances, reset, values at the bounds."""

import numpy as np

from .description import attribute
from .examined import Examined
from .findings import Say
from .instance import Refused, real_scalars

AGREES = 1e-9  # share of an output's size: repeated runs that differ by more are not the same run


def _compare(say: Say, rule: str, got: list[np.ndarray], wanted: list[np.ndarray]) -> None:
    """The same steps must give the same numbers: to rounding by the standard, to the last bit for a run that can be repeated."""
    a, b = np.array(got), np.array(wanted)
    if a.shape == b.shape and np.array_equal(a, b, equal_nan=True):
        return
    size = np.maximum(np.abs(b).max(axis=0, initial=0.0), np.finfo(float).tiny) if a.shape == b.shape else 1.0
    off = float(np.nanmax(np.abs(a - b) / size)) if a.shape == b.shape else np.inf
    if off > AGREES:
        say(f"{rule} must give the same outputs, they differ by {off:.2g} of their size")
    else:
        say(f"{rule} gives the same outputs to {off:.1g} only, not to the last bit: a resumed run will differ", "note")


def instance(fmu: Examined, say: Say) -> None:
    """It can be instantiated, initialized, stepped and freed."""
    for kind, interface in (("cs", fmu.model.coSimulation), ("me", fmu.model.modelExchange)):
        if interface is None:
            continue
        if kind == "cs" and fmu.events_only:
            say("by Co-Simulation it can be instantiated with event mode only; the rest was tried by Model Exchange", "note")
            continue
        with fmu.instance(kind) as it:
            it.initialize()
            if kind == "cs":  # FMI lets an output be infinite or NaN, but nothing can be done with it
                for y in fmu.run(it, 0):
                    for name, value in zip(fmu.outputs, y, strict=True):
                        if not np.isfinite(value):
                            say(f"output {name!r} should be finite with inputs near their start values, got {value}", "warning")
                            return


def start(fmu: Examined, say: Say) -> None:
    """Variables that start exactly have their start values."""
    if fmu.kind == "se":
        return
    with fmu.instance() as it:
        it.initialize(stay=True)
        exact = [v.name for v in real_scalars(fmu.model) if v.initial == "exact" and v.start is not None]
        for name, value in zip(exact, it.get(exact), strict=True):
            if value != fmu.start[name]:
                say(f"variable {name!r} must start with {fmu.start[name]!r} as described, starts with {float(value)!r}")


def states(fmu: Examined, say: Say) -> None:
    """A restored state, also one from bytes, repeats the run bit for bit."""
    if fmu.kind != "cs" or not fmu.can("canGetAndSetFMUstate", "canGetAndSetFMUState"):
        return
    with fmu.instance() as it:
        it.initialize().goes_back = True
        for _ in fmu.run(it, 1, 0, 3):
            pass
        state = it.save()
        y = it.get(fmu.outputs)
        expected = list(fmu.run(it, 1, 3))
        it.restore(state)
        _compare(say, "a state that is restored", [it.get(fmu.outputs)], [y])
        _compare(say, "after restoring a state the same steps", list(fmu.run(it, 1, 3)), expected)
        if fmu.can("canSerializeFMUstate", "canSerializeFMUState"):
            data = it.serialized(state)
            again = it.deserialized(data)
            it.restore(again)
            _compare(say, "after restoring a state from bytes the same steps", list(fmu.run(it, 1, 3)), expected)
            it.discard(again)
        it.discard(state)


def instances(fmu: Examined, say: Say) -> None:
    """Two instances in one process do not touch each other."""
    if fmu.kind != "cs" or fmu.can("canBeInstantiatedOnlyOncePerProcess"):
        return
    with fmu.instance() as it:
        alone = list(fmu.run(it.initialize(), 2))
    with fmu.instance() as it, fmu.instance(name="other") as other:
        it.initialize()
        other.initialize()
        together = [y for y, _ in zip(fmu.run(it, 2), fmu.run(other, 3), strict=True)]
    _compare(say, "an instance beside another one", together, alone)


def reset(fmu: Examined, say: Say) -> None:
    """After a reset a run is what it was at first."""
    if fmu.kind != "cs":
        return
    with fmu.instance() as it:
        first = list(fmu.run(it.initialize({}), 4))
        it.reset()
        _compare(say, "after a reset the same steps", list(fmu.run(it.initialize({}), 4)), first)


def bounds(fmu: Examined, say: Say) -> None:
    """With each start value at its declared min or max, one at a time, initialization works and a step gives finite outputs."""
    for v in fmu.settable if fmu.kind != "se" else ():
        for side in ("min", "max"):
            value = attribute(v, side)
            if value is None or abs(value) > 1e300:
                continue
            try:
                with fmu.instance() as it:
                    it.initialize({v.name: value})
                    if it.kind == "cs":
                        it.step(it.start, fmu.h)
                    y = it.get(fmu.outputs)
            except Refused as error:
                say(f"{v.name!r} at its {side} {value:g}: {error}", "warning")
                continue
            bad = [n for n, y_i in zip(fmu.outputs, y, strict=True) if not np.isfinite(y_i)]
            if bad:
                say(f"{v.name!r} at its {side} {value:g}: output {bad[0]!r} is not finite", "warning")
