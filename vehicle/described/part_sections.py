"""Springs, links, roll bars, forces and torques of a vehicle file, key by key."""

from collections.abc import Mapping
from itertools import pairwise

from .between import AXES, NO_VECTOR, Curve, Link, RollBar, Springs
from .description import Force, Torque, Wheelset
from .sections import Section
from .values import ZERO, Value

__all__ = ["force", "link", "roll_bar", "springs", "torque"]

SLIDING, ROUNDING = "2 mm/s", "0.2 mm"  # where a file names none


def _between(one: Section) -> tuple[str, str]:
    names = one.names("between")
    if len(names) != 2:
        raise one.error("between", "must name two bodies, the upper one first", names)
    return names[0], names[1]


def _rest(one: Section, name: str, numbers: list[float]) -> int | None:
    """Which point of a curve is that of rest; None where all are on one side of it."""
    if numbers[0] >= 0.0:
        return None
    if 0.0 not in numbers[:-1]:
        raise one.error(name, "must have a point at rest, and one beyond it, where it has points on both sides", numbers)
    return numbers.index(0.0)


def _curve(one: Section, name: str, under: str, rounding: Value) -> Curve | None:
    """A list of [travel, force]."""
    pairs = one.pairs(name)
    if pairs is None or isinstance(pairs, Curve):
        return pairs
    if len(pairs) < 2:
        raise one.error(name, 'must have two points or more, such as [["25 mm", "0 N"], ["30 mm", "600 N"]]', pairs)
    points = []
    for i, (travel, pull) in enumerate(pairs, 1):
        points.append((one.reading(name, travel, "m", f"{under}_travel_{i}", f"travel at point {i}"),
                       one.reading(name, pull, "N", f"{under}_force_{i}", f"force at point {i}")))  # fmt: skip
    travels, pulls = ([one.book.number(point[i]) for point in points] for i in (0, 1))
    if any(b <= a for a, b in pairwise(travels)):
        raise one.error(name, "must have travels that rise", pairs)
    if any(b < a for a, b in pairwise(pulls)):
        raise one.error(name, "must have forces that do not fall: no negative stiffness", pairs)
    rest = _rest(one, name, travels)
    if pulls[rest or 0] != 0.0:
        raise one.error(name, "must have no force at rest, nor at the end of its gap", pairs[rest or 0])
    curve = Curve(tuple(points), rounding, rest, rest is None and travels[0] > 0.0)
    one.taken[name] = curve
    return curve


def _rounding(one: Section) -> Value:
    if not one.has("rounding"):
        one.data["rounding"] = ROUNDING
    return one.value("rounding", "m", above=0.0, meaning="half the length over which corners are rounded")


def _sliding(one: Section, *, rubs: bool) -> Value:
    if not rubs:
        return ZERO
    if not one.has("friction_speed"):
        one.data["friction_speed"] = SLIDING
    return one.value("friction_speed", "m/s", above=0.0, meaning="sliding speed that smooths dry friction")


def springs(one: Section, name: str) -> Springs:
    """A table of `springs`."""
    upper, lower = _between(one)
    at, half = one.vector("at", "m", needed="z"), one.vector("half_spacing", "m", "xy", least=0.0)
    stiffness, damping = one.vector("stiffness", "N/m", least=0.0), one.vector("damping", "N.s/m", least=0.0)
    series = one.vector("series_stiffness", "N/m", least=0.0) if one.has("series_stiffness") else NO_VECTOR
    friction = one.vector("friction", "N", least=0.0) if one.has("friction") else NO_VECTOR
    for axis in AXES:
        _held(one, f"series_stiffness.{axis}", getattr(series, axis), getattr(damping, axis))
    curves = {}
    if one.has("curve"):
        table, rounding = one.table("curve", AXES), _rounding(one)
        curves = {axis: curve for axis in AXES if (curve := _curve(table, axis, f"curve_{axis}", rounding)) is not None}
        one.taken["curve"] = curves
    found = Springs(name, upper, lower, at, half.x, half.y, stiffness, damping, series, friction,
                    _sliding(one, rubs=not friction.is_zero), curves)  # fmt: skip
    one.end()
    return found


def _held(one: Section, key: str, series: Value, damping: Value) -> None:
    if series.is_zero:
        return
    if one.book.number(series) == 0.0:
        raise one.error(key, "must be more than 0: leave it out where a damper is held firmly", series.text)
    if damping.is_zero or one.book.number(damping) == 0.0:
        raise one.error(key, "must have a damper that it holds: give damping along the same axis", series.text)


def link(one: Section, name: str) -> Link:
    """A table of `links`."""
    upper, lower = _between(one)
    ends = [one.vector(key, "m", needed="xz") for key in ("upper_end", "lower_end")]
    stiffness, damping = one.value("stiffness", "N/m", least=0.0, default=ZERO), one.value("damping", "N.s/m", least=0.0,
                                                                                           default=ZERO)  # fmt: skip
    series = one.value("series_stiffness", "N/m", least=0.0, default=ZERO)
    _held(one, "series_stiffness", series, damping)
    rub = one.value("friction", "N", least=0.0, default=ZERO)
    curve = _curve(one, "curve", "curve", _rounding(one)) if one.has("curve") else None
    found = Link(name, upper, lower, ends[0], ends[1], one.flag("mirrored", False), stiffness, damping, series, rub,
                 _sliding(one, rubs=not rub.is_zero), curve)  # fmt: skip
    start, end = ([one.book.number(value) for value in (place.x, place.y, place.z)] for place in ends)
    if start == end:
        raise one.error("lower_end", "must be apart from upper_end: a link acts along the line between them", end)
    if found.mirrored and start[1] == end[1] == 0.0:
        raise one.error("mirrored", "must have ends off the middle of the track, y is 0 at both")
    one.end()
    return found


def roll_bar(one: Section, name: str) -> RollBar:
    """A table of `roll_bars`."""
    upper, lower = _between(one)
    bar = RollBar(name, upper, lower, one.value("stiffness", "N.m/rad", least=0.0),
                  one.value("damping", "N.m.s/rad", least=0.0, default=ZERO))  # fmt: skip
    one.end()
    return bar


def force(one: Section, name: str) -> Force:
    """A table of `forces`."""
    table = one.table("force", AXES)
    starts = {axis: table.measured(axis, table.text(axis), "N")[0] for axis in AXES if table.has(axis)}
    if not starts:
        raise one.error("force", 'must name an axis, such as { y = "0 N" }', {})
    found = Force(name, one.what, one.text("on"), one.vector("at", "m", needed="xz"), starts)
    one.end()
    return found


def torque(one: Section, name: str, wheelsets: Mapping[str, Wheelset]) -> Torque:
    """A table of `torques`."""
    on, against = one.text("on"), one.text("against", "")
    if on not in wheelsets:
        raise one.book.unknown(one.key("on"), "wheelset", on, wheelsets)
    if not against and not wheelsets[on].pitches:
        raise one.error("against", f"must name the body that takes the reaction: {on!r} does not pitch")
    start = one.measured("torque", one.text("torque", "0 N.m"), "N.m")[0]
    one.end()
    return Torque(name, one.what, on, against, start, wheelsets[on].solid)
