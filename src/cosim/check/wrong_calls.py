"""Deliberately wrong calls, each on an instance of its own: what an FMU does with a mistake of its user.

The standard forbids such calls and leaves open what happens, so nothing here is a fault: a crash is a warning, an answer "OK" a
note.
"""

from collections.abc import Callable, Iterator

from .examined import Examined
from .findings import Say
from .instance import Instance, Refused


def misuse(fmu: Examined, say: Say) -> None:
    """Wrong calls are answered with an error, not with OK or a crash."""
    if fmu.kind == "se":
        return
    accepted = []
    for what, early, call in _calls(fmu):
        with fmu.instance() as it:
            if not early:
                it.initialize()
            try:
                call(it)
            except Refused:
                continue
            accepted.append(what)
    if accepted:
        say(f"wrong calls that it answers with OK, so that a mistake of its user stays unseen: {', '.join(accepted)}", "note")


def _calls(fmu: Examined) -> Iterator[tuple[str, bool, Callable[[Instance], object]]]:
    """(what, whether it comes before initialization, the call)."""
    used = {v.valueReference for v in fmu.model.modelVariables}
    unknown = next(r for r in range(1_000_000, 10**9) if r not in used)
    version = fmu.model.fmiVersion[0]
    get = "getReal" if version == "2" else "getFloat64"
    yield "getting an unknown variable", False, lambda it: it.call("get", lambda: getattr(it.fmu, get)([unknown]))
    if fmu.kind == "cs":
        yield "a step before initialization", True, lambda it: it.step(0.0, fmu.h)
        yield "a step backwards", False, lambda it: it.step(it.start, -fmu.h)
        yield "a step from a time not reached", False, lambda it: it.step(it.start + 10 * fmu.h, fmu.h)
    computed = [n for n in fmu.outputs if n in fmu.calculated]
    if computed:
        yield "setting an output", False, lambda it: it.set({computed[0]: 1.0})
    if fmu.constants:
        yield "setting a constant", False, lambda it: it.set({fmu.constants[0]: 1.0})
    if fmu.fixed:
        yield "setting a fixed parameter in a running model", False, lambda it: it.set({fmu.fixed[0]: fmu.start[fmu.fixed[0]]})
