"""Probes of variables of every type and shape: what is described can be got, and what may be set is kept."""

import math
from typing import Any

from .examined import Examined
from .findings import Say
from .instance import Instance, Refused, elements

LARGEST = 10_000  # elements of an array that is still looked at


def types(fmu: Examined, say: Say) -> None:
    """Every variable can be got; in initialization mode those that start exactly start so, and what is set is got again."""
    if fmu.kind == "se":
        return
    with fmu.instance() as it:
        it.initialize(stay=True)
        for v in fmu.model.modelVariables:
            if v.type != "Clock" and not _clocked(v) and elements(v) <= LARGEST:
                _one(it, v, say)
        it.finish()
        for v in fmu.model.modelVariables:
            if v.type != "Clock" and not _clocked(v) and elements(v) <= LARGEST:
                try:
                    it.values(v)
                except Refused as error:
                    say(f"variable {v.name!r} must be readable in a running model: {error}")


def _clocked(v: Any) -> bool:
    """Whether it has a value only where its clock ticks."""
    return bool(v.clocks)


def _one(it: Instance, v: Any, say: Say) -> None:
    """A variable in initialization mode."""
    where = f"variable {v.name!r} ({v.type}{f', {elements(v)} elements' if v.dimensions else ''})"
    try:
        got = it.values(v)
    except (Refused, UnicodeDecodeError) as error:
        say(f"{where} must be readable: {error}")
        return
    started = _started(v)
    if v.initial == "exact" and started is not None and not _same(got, started) and v not in it.reals:  # `start` looks at those
        given = v.causality in ("parameter", "structuralParameter", "input") or v.variability == "constant"
        text = f"{where} must start with {_shown(started)} as described, starts with {_shown(got)}"
        say(text, "fault" if given else "warning")
    if v.variability == "constant" or not (v.initial in ("exact", "approx") or v.causality == "input"):
        return
    if v.causality == "structuralParameter" or any(d.variable is not None for d in v.dimensions or ()):
        return
    if started is None or (v.type == "Binary" and None in got):
        return
    try:
        kept = it.values(v, started)
    except Refused as error:
        say(f"{where} must take its own start value: {error}")
        return
    if not _same(kept, started):
        say(f"{where} must keep the value that it is given, {_shown(started)}, gives back {_shown(kept)}")


def _started(v: Any) -> list[Any] | None:
    """The start values as described, one for each element; None where there are none that can be read."""
    if v.start is None:
        return None
    texts: list[Any] = v.start if isinstance(v.start, list) else [v.start] if v.type == "String" else str(v.start).split()
    try:
        if v.type == "Boolean":
            values: list[Any] = [{"true": True, "1": True, "false": False, "0": False}[t] for t in texts]
        elif v.type == "String":
            values = [str(t) for t in texts]
        elif v.type == "Binary":
            values = [bytes.fromhex(str(t)) for t in texts]
        elif v.type.startswith(("Float", "Real")):
            values = [float(t) for t in texts]
        else:
            values = [int(t) for t in texts]
    except (KeyError, ValueError):
        return None
    n = elements(v)
    return values * n if len(values) == 1 else values if len(values) == n else None


def _same(got: list[Any], wanted: list[Any]) -> bool:
    return len(got) == len(wanted) and all(_equal(a, b) for a, b in zip(got, wanted, strict=True))


def _equal(a: Any, b: Any) -> bool:
    if isinstance(b, float):
        return float(a) == b or (math.isnan(b) and math.isnan(float(a))) or math.isclose(float(a), b, rel_tol=1e-7)
    if isinstance(a, bytes) and isinstance(b, str):
        return a.decode(errors="replace") == b
    return bool(a == b)


def _shown(values: list[Any]) -> str:
    text = ", ".join(map(repr, values[:4]))
    return f"{text}, ..." if len(values) > 4 else text
