"""From a vehicle file to a `Description`: sections, keys, units, defaults. docs/vehicle-files.md is the schema in words."""

import re
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any, TypeVar

import numpy as np

from gyro_cosim.component import parameter
from gyro_cosim.component.units import unit

from ..creep_laws import LAWS
from ..lrt_parameters import RUN, drive_rows
from . import part_sections, rules
from .course import course_of
from .description import Body, Description, Drive, Mount, Pivot, Wheelset
from .extending import document, extended
from .sections import Book, Section, check_name
from .values import ZERO, formula
from .wheels import wheels_of

__all__ = ["read", "read_text"]

SECTIONS = ("vehicle", "parameters", "bodies", "wheelsets", "springs", "links", "roll_bars", "wheels", "rails", "contact",
            "mounts", "forces", "torques", "drive", "track")  # fmt: skip
INERTIA = {axis: f"i{axis}{axis}" for axis in "xyz"}
T = TypeVar("T")
STEP = 5e-4  # s; benchmarks/vehicle_step.py shows why


def read(path: str | Path) -> Description:
    """Read a vehicle file.

    Parameters
    ----------
    path : str or Path
        A .toml file.

    Returns
    -------
    Description
        What it says, checked.

    Raises
    ------
    ValueError
        In one line: file, key, rule, value.
    """
    path = Path(path)
    try:
        text = path.read_text(encoding="utf-8")
    except OSError as error:
        raise ValueError(f"vehicle file {str(path)!r} cannot be read: {error.strerror}") from None
    except UnicodeDecodeError:
        raise ValueError(f"vehicle file {str(path)!r} must be UTF-8 text") from None
    return read_text(text, path.name, path.parent)


def read_text(text: str, file: str, folder: Path = Path()) -> Description:
    """The same for a text, called `file` in messages; the profiles that it names are looked for in `folder`."""
    data = extended(document(text, file), file, folder)
    book = Book(file)
    if "vehicle" not in data:
        raise book.error("vehicle", "must be given: the table that makes this a vehicle file")
    for key in data:
        if key not in SECTIONS:
            raise book.unknown("file", "key", key, SECTIONS)
    head = book.section("vehicle", data["vehicle"])
    for row in RUN:
        book.add("vehicle", row)
    for row in RUN:
        if head.has(row.name):
            rules.overridden(head, row.name, row.name)
    name = head.text("name", re.sub(r"\W", "_", Path(file).stem))
    check_name(book, "vehicle.name", name)
    line = head.text("description", "Vehicle of the file " + file)
    law = head.text("creep_law", "polach", LAWS)
    step = head.measured("internal_step", head.text("internal_step"), "s")[0] if head.has("internal_step") else STEP
    if not 1e-6 <= step <= 0.01:
        raise head.error("internal_step", "must be from 1 us to 10 ms", head.data["internal_step"])
    head.end()
    _parameters(book, data.get("parameters", {}))
    wheels = wheels_of(book, data, folder)
    bodies = _each(book, data, "bodies", _body)
    wheelsets = _each(book, data, "wheelsets", _wheelset)
    springs = _each(book, data, "springs", part_sections.springs)
    links = _each(book, data, "links", part_sections.link)
    bars = _each(book, data, "roll_bars", part_sections.roll_bar)
    mounts = _each(book, data, "mounts", _mount)
    forces = _each(book, data, "forces", part_sections.force)
    torques = _each(book, data, "torques", lambda one, key: part_sections.torque(one, key, wheelsets))
    drive = _drive(book, data, wheelsets)
    track = book.section("track", data.get("track", {}))
    knots, harmonics = track.count("knots", 4, 200), track.count("harmonics", 0, 200)
    course = course_of(track, folder, max((book.number(one.x) for one in wheelsets.values()), default=0.0))
    if course.speeds is not None and "speed" not in data["vehicle"]:
        first = float(np.interp(0.0, course.speeds.distance, course.speeds.speed))
        book.rows["speed"] = rules.started(book, "track.speed", book.rows["speed"], first)
    track.end()
    found = Description(
        name, line, tuple(book.rows.values()), bodies, wheelsets, springs, links, bars, mounts, forces, torques, drive, wheels,
        law, 7, knots, harmonics, course, step,
    )  # fmt: skip
    rules.check(book, found)
    return found


def _each(book: Book, data: Mapping[str, Any], kind: str, make: Callable[[Section, str], T]) -> dict[str, T]:
    """The parts of a kind, in the file's order; `like = "OTHER"` takes over what another one before it says."""
    tables = data.get(kind, {})
    if not isinstance(tables, dict):
        raise book.error(kind, "must be a table of tables", tables)
    parts: dict[str, T] = {}
    sections: dict[str, Section] = {}
    for name, table in tables.items():
        check_name(book, kind, name)
        section = book.section(f"{kind}.{name}", table, prefix=name)
        if section.has("like"):
            other = section.text("like")
            if other not in sections:
                raise book.unknown(section.key("like"), f"part of {kind} before this one", other, sections)
            section.inherit(sections[other])
        parts[name], sections[name] = make(section, name), section
    return parts


def _parameters(book: Book, tables: Any) -> None:
    """Named parameters: value, meaning, source, min, max, assumed, symbol."""
    whole = book.section("parameters", tables)
    for name, table in whole.data.items():
        check_name(book, "parameters", name)
        one = book.section(f"parameters.{name}", table)
        text = one.text("value")
        used = re.sub(r"^\s*[-+]?(\d+\.?\d*|\.\d+)([eE][-+]?\d+)?\s*", "", text).strip() or "1"
        try:
            si = _si(used)
        except ValueError as error:
            raise one.error("value", str(error), text) from None

        def number(key: str, one: Section = one, si: str = si) -> float | None:
            return one.measured(key, one.text(key), si)[0] if one.has(key) else None

        assumed = None
        if one.has("assumed"):
            ends = one.names("assumed")
            if len(ends) != 2:
                raise one.error("assumed", "must be two values, the least and the largest", ends)
            assumed = (one.measured("assumed", ends[0], si)[0], one.measured("assumed", ends[1], si)[0])
        try:
            row = parameter(
                name, one.measured("value", text, si)[0], si, one.text("meaning", name.replace("_", " ")),
                symbol=one.text("symbol", ""), source=one.source, assumed=assumed, min=number("min"), max=number("max"),
                nominal=number("nominal"), display_unit=used if used != si else None,
            )  # fmt: skip
        except ValueError as error:
            raise book.error(f"parameters.{name}", f"is not allowed: {error}") from None
        one.end()
        book.add(f"parameters.{name}", row)


def _si(name: str) -> str:
    """The SI unit of a unit's dimension, written with the units that engineers use."""
    wanted = unit(name)
    if wanted.factor == 1.0 and wanted.offset == 0.0:
        return name
    for known in ("1", "m", "kg", "s", "rad", "m/s", "rad/s", "m/s2", "N", "N.m", "kg.m2", "N/m", "N.s/m", "N.m/rad", "N.m.s/rad",
                  "Pa", "W", "1/m", "rad/m", "s/m"):  # fmt: skip
        if unit(known).dimension == wanted.dimension:
            return known
    raise ValueError("must be in an SI unit, or in one of a usual quantity")


def _body(one: Section, name: str) -> Body:
    pivot = None
    if one.has("on_pivot"):
        pivot = Pivot(
            one.text("on_pivot"),
            one.value("pivot_damping", "N.m.s/rad", least=0.0, default=ZERO),
            one.value("pivot_inertance", "kg.m2", least=0.0, default=ZERO),
        )
    body = Body(
        name, one.what, one.value("mass", "kg", above=0.0),
        one.vector("inertia", "kg.m2", needed="xyz", above=0.0, names=INERTIA),
        one.vector("centre", "m", needed="z"), pivot,
    )  # fmt: skip
    one.end()
    return body


def _wheelset(one: Section, name: str) -> Wheelset:
    solid = one.text("axle", among=("solid", "independent")) == "solid"
    pitches = one.flag("pitches", not solid)
    found = Wheelset(
        name, one.what, one.value("mass", "kg", above=0.0),
        one.vector("inertia", "kg.m2", needed="xyz" if pitches else "xz", above=0.0, names=INERTIA),
        one.value("x", "m", default=ZERO), one.value("spin_inertia", "kg.m2", above=0.0), solid, pitches,
        one.value("load", "N", default=ZERO),
    )  # fmt: skip
    one.end()
    return found


def _mount(one: Section, name: str) -> Mount:
    table = one.table("carries", INERTIA)
    carries = {axis: table.text(axis) for axis in INERTIA if table.has(axis)}
    for axis, row in carries.items():
        known = [row.name for row in one.book.rows.values() if row.unit == "kg.m2"]
        if row not in known:
            raise one.book.unknown(table.key(axis), "parameter in kg.m2", row, known)
    mount = Mount(name, one.text("on"), carries)
    one.end()
    return mount


def _drive(book: Book, data: Mapping[str, Any], wheelsets: Mapping[str, Wheelset]) -> Drive:
    for row in drive_rows():
        book.add("drive", row)
    one = book.section("drive", data.get("drive", {}))
    for key, name in (("gain", "drive_gain"), ("on", "drive_on")):
        if one.has(key):
            rules.overridden(one, key, name)
    limits = [one.value(key, "N", above=0.0, under=f"drive_{key}") if one.has(key) else None
              for key in ("traction_limit", "braking_limit")]  # fmt: skip
    drive = Drive(tuple(one.names("wheelsets", list(wheelsets))), formula("drive_gain"), formula("drive_on"), *limits)
    for name in drive.wheelsets:
        if name not in wheelsets:
            raise book.unknown(one.key("wheelsets"), "wheelset", name, wheelsets)
    one.end()
    return drive
