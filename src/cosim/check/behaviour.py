"""Probes of behaviour: start, saved states, several instances, reset, values at the bounds."""

import numpy as np

from .description import attribute
from .examined import Bench, Say
from .instance import Refused, real_scalars


def instance(bench: Bench, say: Say) -> None:
    """It can be instantiated, initialized, stepped and freed."""
    for kind, interface in (("cs", bench.model.coSimulation), ("me", bench.model.modelExchange)):
        if interface is None:
            continue
        with bench.instance(kind) as it:
            it.initialize()
            if kind == "cs":
                for y in bench.run(it, 0):
                    for name, value in zip(bench.outputs, y, strict=True):
                        if not np.isfinite(value):
                            say(f"output {name!r} must be finite with inputs near their start values, got {value}")
                            return


def start(bench: Bench, say: Say) -> None:
    """Variables that start exactly have their start values."""
    with bench.instance() as it:
        it.initialize(stay=True)
        exact = [v.name for v in real_scalars(bench.model) if v.initial == "exact" and v.start is not None]
        for name, value in zip(exact, it.get(exact), strict=True):
            if value != bench.start[name]:
                say(f"variable {name!r} must start with {bench.start[name]!r} as described, starts with {float(value)!r}")


def states(bench: Bench, say: Say) -> None:
    """A restored state, also one from bytes, repeats the run bit for bit."""
    if bench.kind != "cs" or not bench.can("canGetAndSetFMUstate", "canGetAndSetFMUState"):
        return
    with bench.instance() as it:
        it.initialize()
        for _ in bench.run(it, 1, 0, 3):
            pass
        state = it.save()
        y = it.get(bench.outputs)
        expected = list(bench.run(it, 1, 3))
        it.restore(state)
        if not np.array_equal(it.get(bench.outputs), y, equal_nan=True):
            say("after restoring a state the outputs must be those of the moment it was saved")
        if not np.array_equal(list(bench.run(it, 1, 3)), expected, equal_nan=True):
            say("after restoring a state the same steps must give the same bits")
        if bench.can("canSerializeFMUstate", "canSerializeFMUState"):
            data = it.serialized(state)
            again = it.deserialized(data)
            it.restore(again)
            if not np.array_equal(list(bench.run(it, 1, 3)), expected, equal_nan=True):
                say("after restoring a state from bytes the same steps must give the same bits")
            if it.serialized(again) != data:
                say("a state read from bytes must give the same bytes again")
            it.discard(again)
        it.discard(state)


def instances(bench: Bench, say: Say) -> None:
    """Two instances in one process do not touch each other."""
    if bench.kind != "cs" or bench.can("canBeInstantiatedOnlyOncePerProcess"):
        return
    with bench.instance() as it:
        alone = list(bench.run(it.initialize(), 2))
    with bench.instance() as it, bench.instance(name="other") as other:
        it.initialize()
        other.initialize()
        together = [y for y, _ in zip(bench.run(it, 2), bench.run(other, 3), strict=True)]
    if not np.array_equal(alone, together, equal_nan=True):
        say("an instance beside another one must give what it gives alone")


def reset(bench: Bench, say: Say) -> None:
    """After a reset a run is what it was at first."""
    if bench.model.coSimulation is None:
        return
    with bench.instance() as it:
        first = list(bench.run(it.initialize({}), 4))
        it.reset()
        if not np.array_equal(list(bench.run(it.initialize({}), 4)), first, equal_nan=True):
            say("after a reset the same steps must give the same bits")


def bounds(bench: Bench, say: Say) -> None:
    """With each start value at its declared min or max, one at a time, initialization works and a step gives finite outputs."""
    for v in bench.settable:
        for side in ("min", "max"):
            value = attribute(v, side)
            if value is None or abs(value) > 1e300:
                continue
            try:
                with bench.instance() as it:
                    it.initialize({v.name: value})
                    if it.kind == "cs":
                        it.step(it.start, bench.h)
                    y = it.get(bench.outputs)
            except Refused as error:
                say(f"{v.name!r} at its {side} {value:g}: {error}")
                continue
            bad = [n for n, y_i in zip(bench.outputs, y, strict=True) if not np.isfinite(y_i)]
            if bad:
                say(f"{v.name!r} at its {side} {value:g}: output {bad[0]!r} is not finite")
