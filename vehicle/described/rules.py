"""What a vehicle must be: connected, of possible inertias, with mounts and springs on bodies that exist."""

from collections.abc import Iterable
from dataclasses import replace
from typing import TYPE_CHECKING

from gyro_cosim.component import Variable

from .description import Body, Description, Wheelset
from .sections import Book, Section
from .statics import not_carried

if TYPE_CHECKING:
    from collections.abc import Mapping

__all__ = ["check", "overridden", "started"]

SLACK = 1e-3  # of an inertia: tables are rounded
ALIKE = 1e-9  # of a mass or a length


def started(book: Book, key: str, row: Variable, number: float) -> Variable:
    """A row with another start value; a value outside the assumed range loses that range."""
    try:
        row.check(number)
    except ValueError as error:
        raise book.error(key, str(error).removeprefix(f"{row.name} ")) from None
    inside = row.assumed is not None and row.assumed[0] <= number <= row.assumed[1]
    return replace(row, start=number, assumed=row.assumed if inside else None)


def overridden(section: Section, key: str, name: str) -> None:
    """Give the row `name`, which is there, the start value that the file has under `key`."""
    row = section.book.rows[name]
    number = section.measured(key, section.text(key), row.unit)[0]
    section.book.rows[name] = started(section.book, section.key(key), row, number)


def check(book: Book, d: Description) -> None:
    """Refuse a vehicle that cannot be; ValueError in one line."""
    if not d.wheelsets:
        raise book.error("wheelsets", "must hold one or more: a vehicle stands on rails")
    parts: Mapping[str, Body | Wheelset] = {**d.bodies, **d.wheelsets}
    for name in d.wheelsets:
        if name in d.bodies:
            raise book.error(f"wheelsets.{name}", "must have a name of its own: a body is called so")
    for body in d.bodies.values():
        _possible(book, f"bodies.{body.name}", [book.number(i) for i in (body.inertia.x, body.inertia.y, body.inertia.z)])
    for one in d.wheelsets.values():
        spin = 2 * book.number(one.spin_inertia)
        _possible(book, f"wheelsets.{one.name}", [book.number(one.inertia.x), book.number(one.inertia.y) + spin,
                                                  book.number(one.inertia.z)])  # fmt: skip
    _pivots(book, d)
    _joined(book, d, parts)
    for mount in d.mounts.values():
        if mount.body not in parts:
            raise book.unknown(f"mounts.{mount.name}.on", "body", mount.body, parts)
    for force in d.forces.values():
        if force.body not in parts:
            raise book.unknown(f"forces.{force.name}.on", "body", force.body, parts)
        if d.host(force.body) != force.body:
            raise book.error(f"forces.{force.name}.on", f"must be a body on no pivot, {force.body!r} turns on one")
    for torque in d.torques.values():
        key = f"torques.{torque.name}.against"
        if torque.against and torque.against not in parts:
            raise book.unknown(key, "body", torque.against, parts)
        if torque.against == torque.wheelset:
            raise book.error(key, "must be another body, or left out for the wheel frame", torque.against)
    _connected(book, d, parts)
    fallen = not_carried(d)
    if fallen is not None:
        kind = "bodies" if fallen in d.bodies else "wheelsets"
        raise book.error(f"{kind}.{fallen}", "must be carried: no spring with a stiffness along z holds its height or its pitch")


def _possible(book: Book, key: str, inertias: list[float]) -> None:
    """No inertia of a rigid body is larger than the other two together."""
    for axis, own in zip("xyz", inertias, strict=True):
        others = sum(inertias) - own
        if own > others * (1 + SLACK):
            raise book.error(f"{key}.inertia.{axis}", f"must be at most the other two together, {others:g} kg.m2", own)


def _joined(book: Book, d: Description, parts: "Mapping[str, Body | Wheelset]") -> None:
    """What joins two bodies is called by a name of its own, between two that are there and move apart."""
    seen: dict[str, str] = {}
    for kind, joints in (("springs", d.springs), ("links", d.links), ("roll_bars", d.roll_bars)):
        for name, joint in joints.items():
            if name in seen:
                raise book.error(f"{kind}.{name}", f"must have a name of its own: {seen[name]} are called so")
            seen[name], key = kind, f"{kind}.{name}.between"
            for end in (joint.upper, joint.lower):
                if end not in parts:
                    raise book.unknown(key, "body", end, parts)
            if d.host(joint.lower) != joint.lower:
                raise book.error(key, f"must have a body below that is on no pivot, {joint.lower!r} turns on one")
            if d.host(joint.upper) == joint.lower:
                raise book.error(key, "must join two bodies that move apart", [joint.upper, joint.lower])


def _pivots(book: Book, d: Description) -> None:
    for body in d.bodies.values():
        if body.pivot is None:
            continue
        key, host = f"bodies.{body.name}.on_pivot", d.bodies.get(body.pivot.host)
        if host is None:
            raise book.unknown(key, "body", body.pivot.host, d.bodies)
        if host.pivot is not None or host is body:
            raise book.error(key, "must be a body that is on no pivot itself", host.name)
        frames = d.pivoted(host.name)
        if len(frames) != 2:
            raise book.error(key, f"must carry two frames, one ahead and one behind, {host.name!r} carries {len(frames)}")
        one, other = frames
        for part in (host, *frames):
            if book.number(part.centre.y) != 0.0:
                raise book.error(f"bodies.{part.name}.centre.y", "must be 0 for a body with frames on pivots, and for those",
                                 part.centre.y.text)  # fmt: skip
        middle = book.number(host.centre.x)
        x = [book.number(frame.centre.x) - middle for frame in frames]
        if abs(x[0] + x[1]) > ALIKE * (abs(x[0]) + 1) or x[0] <= x[1]:
            raise book.error(f"bodies.{one.name}.centre.x", f"must be as far ahead as that of {other.name} is behind, the one "
                             "ahead first", x)  # fmt: skip
        pairs = [("mass", one.mass, other.mass), ("centre.z", one.centre.z, other.centre.z)]
        pairs += [(f"inertia.{axis}", getattr(one.inertia, axis), getattr(other.inertia, axis)) for axis in "xyz"]
        for what, a, b in pairs:
            if abs(book.number(a) - book.number(b)) > ALIKE * abs(book.number(a)):
                raise book.error(f"bodies.{other.name}.{what}", f"must be that of {one.name}: frames on pivots are alike", b.text)


def _connected(book: Book, d: Description, parts: Iterable[str]) -> None:
    """Everything hangs together."""
    joined: dict[str, set[str]] = {name: set() for name in parts}
    pairs = [(joint.upper, joint.lower) for joint in d.joints]
    pairs += [(body.name, body.pivot.host) for body in d.bodies.values() if body.pivot is not None]
    for a, b in pairs:
        joined[a].add(b)
        joined[b].add(a)
    first = next(iter(joined))
    reached, waiting = {first}, [first]
    while waiting:
        new = joined[waiting.pop()] - reached
        reached |= new
        waiting += new
    apart = [name for name in joined if name not in reached]
    if apart:
        kind = "bodies" if apart[0] in d.bodies else "wheelsets"
        raise book.error(
            f"{kind}.{apart[0]}", f"must be connected to the rest by springs, links or a pivot, nothing joins it to {first!r}"
        )
