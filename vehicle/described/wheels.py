"""Wheels, rails and their contact in a vehicle file: cones, whose sizes are parameters, or profiles given by points.

One wheel and one rail profile for the whole vehicle; with points, the right side may have its own.
"""

import re
from collections.abc import Callable, Mapping
from dataclasses import replace
from pathlib import Path
from typing import Any

import casadi as ca

from gyro_cosim.component import Variable, parameter

from .. import scene
from ..contact_search import placed_rail
from ..lrt_parameters import WHEEL, rail_and_contact
from ..pairing import Conical, Pairing
from ..profiles import Profile, rail_60e1, read, s1002
from ..tabulated import Tabulated
from ..wheelset_contact import TAPE
from .description import Description
from .draws import Draws
from .measured import Measured
from .rules import overridden
from .sections import Book, Section
from .statics import at_rest

__all__ = ["pairing_of", "sections_of", "wheels_of"]

ON_RAIL = ("rail_crown_radius", "corner_radius", "corner_offset", "corner_depth", "rail_lateral_stiffness")
BY_POINTS = (
    "rolling_radius",
    "contact_half_distance",
    "rail_lateral_stiffness",
    "youngs_modulus",
    "poisson_ratio",
    "contact_damping",
)
KNOWN: dict[str, dict[str, Callable[[], Profile]]] = {"wheels": {"s1002": s1002}, "rails": {"60e1": rail_60e1}}
PLAIN = {"wheels": "conical", "rails": "round"}
INNER_DISTANCE, GAUGE = "1360 mm", "1435 mm"


def wheels_of(book: Book, data: Mapping[str, Any], folder: Path) -> Conical | Measured:
    """Take [wheels], [rails] and [contact]; their parameters go into the book.

    Parameters
    ----------
    book : Book
        Rows and refusals.
    data : mapping
        The whole file.
    folder : Path
        Where the profiles' files are looked for.
    """
    sections: dict[str, Section] = {}
    for kind in ("wheels", "rails"):
        tables = data.get(kind, {})
        if not isinstance(tables, dict) or len(tables) > 1:
            raise book.error(kind, "must be a table of one profile, the same under every wheel", list(tables))
        name, table = next(iter(tables.items()), ("", {}))
        sections[kind] = book.section(f"{kind}.{name}" if name else kind, table)
    wheel, rail = sections["wheels"], sections["rails"]
    shapes = [section.text("profile", PLAIN[kind]) for kind, section in sections.items()]
    side = 1 if wheel.text("flange", "outside", ("inside", "outside")) == "outside" else -1
    plain = [shape == PLAIN[kind] for shape, kind in zip(shapes, sections, strict=True)]
    if plain[0] != plain[1]:
        one, other, kind = ("wheels", "rails", "rail") if plain[1] else ("rails", "wheels", "wheel")
        raise sections[other].error(
            "profile",
            f'must be a {kind} given by points, since that of {one} is: such as "{next(iter(KNOWN[other]))}"',
            PLAIN[other],
        )
    rows = {row.name: row for row in (*WHEEL, *rail_and_contact())}
    if plain[0]:
        for row in rows.values():
            book.add("wheels", row)
        for section, own in ((wheel, [row.name for row in WHEEL]), (rail, ON_RAIL)):
            _starts(section, own)
        _contact(book, data, [name for name in rows if name not in ON_RAIL])
        return Conical(side)
    return _measured(book, data, rows, sections, folder, side)


def _starts(section: Section, names: Any) -> None:
    for key in names:
        if section.has(key):
            overridden(section, key, key)
    section.end()


def _contact(book: Book, data: Mapping[str, Any], names: Any) -> None:
    _starts(book.section("contact", data.get("contact", {})), names)


def _measured(
    book: Book, data: Mapping[str, Any], rows: Mapping[str, Variable], sections: Mapping[str, Section], folder: Path, side: int
) -> Measured:
    wheel, rail = sections["wheels"], sections["rails"]
    profiles = {kind: _both(section, kind, folder, side) for kind, section in sections.items()}
    inner = wheel.measured("inner_distance", wheel.text("inner_distance", INNER_DISTANCE), "m")[0]
    gauge = rail.measured("gauge", rail.text("gauge", GAUGE), "m")[0]
    if not 0.2 < gauge < 2.5:
        raise rail.error("gauge", "must be from 0.2 to 2.5 m", rail.text("gauge"))
    if not gauge - 0.3 < inner < gauge + 0.3:
        raise wheel.error(
            "inner_distance", f"must be within 0.3 m of the gauge, {gauge:g} m", wheel.text("inner_distance", INNER_DISTANCE)
        )
    inclination = _inclination(rail)
    for name, row in rows.items():
        if name in BY_POINTS or name.startswith("friction"):
            book.add("wheels", row)
    half = inner / 2 + TAPE
    book.rows["contact_half_distance"] = parameter(
        "contact_half_distance", half, "m", "half the distance of the tape lines", symbol="b", min=half, max=half,
        source="inner_distance: what the contact tables were made for",
    )  # fmt: skip
    _starts(wheel, ["rolling_radius"])
    _starts(rail, ["rail_lateral_stiffness"])
    _contact(book, data, [name for name in rows if name in book.rows and name not in ("contact_half_distance", "rolling_radius",
                                                                                      "rail_lateral_stiffness")])  # fmt: skip
    nu = book.rows["poisson_ratio"]
    book.rows["poisson_ratio"] = replace(
        nu, min=nu.start, max=nu.start, source=f"{nu.source}: the contact tables are made for it"
    )
    starts = {name: row.start for name, row in book.rows.items()}
    return Measured(
        side, profiles["wheels"], profiles["rails"], starts["rolling_radius"], gauge, inner, inclination, nu.start,
        starts["youngs_modulus"], tuple(section.text("profile") for section in sections.values()),
    )  # fmt: skip


def _inclination(rail: Section) -> float:
    text = rail.text("inclination", "0")
    fraction = re.fullmatch(r"\s*1\s*[/:]\s*(\d+(?:\.\d+)?)\s*", text)
    try:
        value = 1 / float(fraction[1]) if fraction else float(text)
    except (ValueError, ZeroDivisionError):
        raise rail.error("inclination", 'must be a slope such as "1/40" or "0.025"', text) from None
    if not 0.0 <= value <= 0.2:
        raise rail.error("inclination", 'must lie in 0..0.2, such as "1/40"', text)
    return value


def _both(section: Section, kind: str, folder: Path, side: int) -> tuple[Profile, Profile]:
    """Left and right profile, a wheel's flange on its `side`; the same object where the file names one."""
    unit = section.text("unit", "", ("mm", "m", "inch")) or None
    mirror = kind == "rails" and section.flag("mirror", False)
    smoothing = section.measured("smoothing", section.text("smoothing"), "m")[0] if section.has("smoothing") else None

    def one(key: str) -> Profile:
        found = read_one(key)  # its flange inside
        outside = kind == "wheels" and side > 0
        return Profile(-found.y[::-1], found.z[::-1], found.kind, (*found.notes, "flange outside")) if outside else found

    def read_one(key: str) -> Profile:
        name = section.text(key)
        if name.lower() in KNOWN[kind]:
            return KNOWN[kind][name.lower()]()
        place = folder / name
        if not place.is_file():
            raise section.error(
                key, f"must be {', '.join(f'{n!r}' for n in KNOWN[kind])} or a file beside this one that there is", name
            )
        try:
            return read(place, kind=kind.removesuffix("s"), unit=unit, smoothing=smoothing, mirror=mirror)
        except (ValueError, OSError) as error:
            raise section.error(key, f"cannot be used: {error}") from None

    left = one("profile")
    return left, one("right_profile") if section.has("right_profile") else left


def pairing_of(d: Description) -> Pairing:
    """The wheels and rails as the equations take them; contact tables are made once for a vehicle.

    Parameters
    ----------
    d : Description
        The vehicle.

    Raises
    ------
    ValueError
        If the profiles do not fit one another.
    """
    if isinstance(d.wheels, Conical):
        return d.wheels
    numbers = {name: ca.SX(value) for name, value in d.starts().items()}
    loads = [float(load) for pair in at_rest(numbers, d, Draws(d.starts())).wheel_loads.values() for load in pair]
    try:
        return Tabulated(d.wheels.fit(sum(loads) / len(loads)), d.wheels.flange_side)
    except ValueError as error:
        raise ValueError(f"vehicle {d.name!r}: wheels {d.wheels.names[0]} on rails {d.wheels.names[1]}: {error}") from None


def sections_of(d: Description) -> dict[str, Any]:
    """Sections of left wheel and rail for pictures, as vehicle.scene.sections."""
    if isinstance(d.wheels, Conical):
        return scene.sections(d.starts(), d.wheels.flange_side)
    m = d.wheels
    y, z, _, _ = placed_rail(m.rails[0], m.gauge, m.inclination)
    half = m.inner_distance / 2 + TAPE
    pairing = pairing_of(d)
    assert isinstance(pairing, Tabulated)
    return scene.laid((m.wheels[0].y, m.wheels[0].z), (y - half, z), pairing.contacts())
