"""Units of measurement: names as FMI writes them, their SI factors and base-unit exponents.

A unit is a product of atoms with integer exponents, `.` for times and at most one `/`: `N.m.s/rad`, `kg.m2`, `1`.
Inside the package every number is SI; another unit appears only at an edge, where `quantity("200rpm", "rad/s")`
turns it into SI.
"""

import math
import re
from dataclasses import dataclass
from functools import lru_cache

__all__ = ["BASE", "Unit", "compatible", "convert", "power_pair", "quantity", "unit"]

BASE = ("kg", "m", "s", "A", "K", "mol", "cd", "rad")  # the base units of FMI 2.0 and 3.0, in their order


@dataclass(frozen=True)
class Unit:
    """A unit of measure: x in it is `factor` x + `offset` in the SI unit of its dimension.

    Attributes
    ----------
    name : str
        As FMI writes it.
    factor, offset : float
        What makes SI of a number.
    dimension : tuple of int
        Exponents of the SI base units, in the order of `BASE`.
    """

    name: str
    factor: float
    dimension: tuple[int, ...]
    offset: float = 0.0


def _atom(factor: float, offset: float = 0.0, **exponents: int) -> tuple[float, float, tuple[int, ...]]:
    return factor, offset, tuple(exponents.get(base, 0) for base in BASE)


_ATOMS = {
    "1": _atom(1.0),
    "%": _atom(0.01),
    "kg": _atom(1.0, kg=1),
    "g": _atom(1e-3, kg=1),
    "t": _atom(1e3, kg=1),
    "m": _atom(1.0, m=1),
    "km": _atom(1e3, m=1),
    "cm": _atom(1e-2, m=1),
    "mm": _atom(1e-3, m=1),
    "um": _atom(1e-6, m=1),
    "s": _atom(1.0, s=1),
    "ms": _atom(1e-3, s=1),
    "us": _atom(1e-6, s=1),
    "min": _atom(60.0, s=1),
    "h": _atom(3600.0, s=1),
    "A": _atom(1.0, A=1),
    "K": _atom(1.0, K=1),
    "degC": _atom(1.0, 273.15, K=1),
    "mol": _atom(1.0, mol=1),
    "cd": _atom(1.0, cd=1),
    "rad": _atom(1.0, rad=1),
    "mrad": _atom(1e-3, rad=1),
    "deg": _atom(math.pi / 180.0, rad=1),
    "rev": _atom(2.0 * math.pi, rad=1),
    "rpm": _atom(2.0 * math.pi / 60.0, rad=1, s=-1),
    "Hz": _atom(1.0, s=-1),
    "kHz": _atom(1e3, s=-1),
    "kmh": _atom(1.0 / 3.6, m=1, s=-1),
    "N": _atom(1.0, kg=1, m=1, s=-2),
    "mN": _atom(1e-3, kg=1, m=1, s=-2),
    "kN": _atom(1e3, kg=1, m=1, s=-2),
    "MN": _atom(1e6, kg=1, m=1, s=-2),
    "Nm": _atom(1.0, kg=1, m=2, s=-2),
    "Pa": _atom(1.0, kg=1, m=-1, s=-2),
    "kPa": _atom(1e3, kg=1, m=-1, s=-2),
    "MPa": _atom(1e6, kg=1, m=-1, s=-2),
    "GPa": _atom(1e9, kg=1, m=-1, s=-2),
    "J": _atom(1.0, kg=1, m=2, s=-2),
    "kJ": _atom(1e3, kg=1, m=2, s=-2),
    "W": _atom(1.0, kg=1, m=2, s=-3),
    "kW": _atom(1e3, kg=1, m=2, s=-3),
    "V": _atom(1.0, kg=1, m=2, s=-3, A=-1),
}
_FACTOR = re.compile(r"([A-Za-z%]+|1)(-?\d+)?")
_QUANTITY = re.compile(r"\s*([-+]?(?:\d+\.?\d*|\.\d+)(?:[eE][-+]?\d+)?|[-+]?inf|[-+]?nan)\s*(\S*)\s*", re.IGNORECASE)


@lru_cache(maxsize=1024)
def unit(name: str) -> Unit:
    """Read the name of a unit.

    Parameters
    ----------
    name : str
        Such as "N.m.s/rad", "rpm" or "1".

    Returns
    -------
    Unit
        Its factor and dimension.

    Raises
    ------
    ValueError
        If an atom is unknown, has an offset inside a product, or there is more than one "/".

    Examples
    --------
    >>> unit("kN.m").factor
    1000.0
    """
    if name in _ATOMS:
        factor, offset, dimension = _ATOMS[name]
        return Unit(name, factor, dimension, offset)
    factor, exponents = 1.0, [0] * len(BASE)
    over, *under = name.split("/")
    if len(under) > 1:
        raise ValueError(f"unit must have at most one '/', got {name!r}")
    for sign, product in ((1, over), *((-1, product) for product in under)):
        for text in product.split("."):
            match = _FACTOR.fullmatch(text)
            if match is None or match[1] not in _ATOMS or _ATOMS[match[1]][1] != 0.0:
                raise ValueError(f"unknown unit {text!r}" + (f" in {name!r}" if text != name else ""))
            if len(match[2] or "") > 3:
                raise ValueError(f"exponents of units must have at most two digits, got {text!r}")
            power = sign * int(match[2] or 1)
            factor *= _ATOMS[match[1]][0] ** power
            exponents = [e + power * d for e, d in zip(exponents, _ATOMS[match[1]][2], strict=True)]
    return Unit(name, factor, tuple(exponents))


def compatible(a: str, b: str) -> bool:
    """Tell whether a number in unit `a` can be expressed in unit `b`.

    Parameters
    ----------
    a, b : str
        Names of units.

    Returns
    -------
    bool
        Whether their dimensions are the same. Angles are kept apart from pure numbers.

    Raises
    ------
    ValueError
        If one of them is unknown.
    """
    return unit(a).dimension == unit(b).dimension


def convert(value: float, source: str, target: str) -> float:
    """Express a number in another unit.

    Parameters
    ----------
    value : float
        In `source`.
    source, target : str
        Names of units.

    Returns
    -------
    float
        The same quantity in `target`; `value` itself, to the last bit, where both units are the same.

    Raises
    ------
    ValueError
        If a unit is unknown or the dimensions differ.
    """
    a, b = unit(source), unit(target)
    if a.dimension != b.dimension:
        raise ValueError(f"unit {source!r} cannot be expressed in {target!r}")
    return value if a == b else (value * a.factor + a.offset - b.offset) / b.factor


def quantity(text: str, target: str) -> float:
    """Read a number with a unit, or without.

    Parameters
    ----------
    text : str
        Such as "200rpm", "1 ms" or "0.3"; a bare number is in `target` already.
    target : str
        Name of the unit of the result.

    Returns
    -------
    float
        The number in `target`.

    Raises
    ------
    ValueError
        If it is no number, or its unit is unknown or of another dimension.

    Examples
    --------
    >>> quantity("36 kmh", "m/s")
    10.0
    """
    match = _QUANTITY.fullmatch(text)
    if match is None:
        raise ValueError(f"must be a number, perhaps with a unit, got {text!r}")
    return convert(float(match[1]), match[2] or target, target)


def power_pair(a: str, b: str) -> bool:
    """Tell whether two signals multiply to a power.

    Parameters
    ----------
    a, b : str
        Units of a motion and an effort, in either order.

    Returns
    -------
    bool
        Whether the product is in W times a number; angles count as pure numbers here.

    Raises
    ------
    ValueError
        If one of them is unknown.
    """
    watt = unit("W").dimension[:-1]
    return tuple(i + j for i, j in zip(unit(a).dimension, unit(b).dimension, strict=True))[:-1] == watt
