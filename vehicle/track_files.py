"""Tracks by points: the line, its irregularity, the speed over it. Read from tables of text, held as tables in the equations.

A file is a table whose first line names its columns, each with its unit in brackets: `distance [m], curvature [1/km], cant [mm]`;
comma, semicolon or tab between them, # before remarks.

    line            distance, curvature (left positive) or radius, cant (right rail over left: of the curvature's sign where the
                    outer rail lies higher), gradient (climbing positive): straight between points, constant beyond the ends
    irregularity    distance, and lateral, vertical, cross_level (left rail over right), gauge; or left_lateral, left_vertical,
                    right_lateral, right_vertical: a cubic spline through the points, whose waves reach down to two steps
    speed           distance, speed, and drive (1: on, 0: coasting; on where it is not given): straight between points

The irregularity fades in and out over a length at either end of its record, and is even up to some metres ahead of where the
vehicle stands: it starts at rest.
"""

import csv
import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import casadi as ca
import numpy as np

from gyro_cosim.component.tables import pieces, table
from gyro_cosim.component.units import quantity

__all__ = ["CHANNELS", "Line", "Record", "Speeds", "columns", "faded", "line", "record", "speeds"]

CHANNELS = ("lateral", "vertical", "cross_level", "gauge")
FAR = 1e3  # m: how far before its first point a line is known
RATIOS = {"permille": 1e-3, "o/oo": 1e-3, "%": 1e-2, "": 1.0, "-": 1.0}
RAILS = ("left_lateral", "left_vertical", "right_lateral", "right_vertical")
GAP = 1.5  # of the usual step
LARGEST = 0.1  # m of irregularity


def columns(path: Path, units: Mapping[str, str]) -> dict[str, np.ndarray]:
    """Read the columns of a file.

    Parameters
    ----------
    path : Path
        The file.
    units : mapping of str to str
        SI unit of each column that may be there.

    Returns
    -------
    dict of str to array, shape (n,)
        In SI, by name; "distance" among them, rising.

    Raises
    ------
    ValueError
        In one line: file, place, rule, value.
    """
    try:
        lines = [line for line in path.read_text(encoding="utf-8-sig").splitlines() if line.strip() and line.lstrip()[0] != "#"]
    except OSError as error:
        raise ValueError(f"{path.name} cannot be read: {error.strerror}") from None
    except UnicodeDecodeError:
        raise ValueError(f"{path.name} must be UTF-8 text") from None
    if len(lines) < 3:
        raise ValueError(f"{path.name} must have a line of names and two lines of numbers or more, got {len(lines)} lines")
    delimiter = next((mark for mark in ("\t", ";", ",") if mark in lines[0]), ",")
    rows = list(csv.reader(lines, delimiter=delimiter))
    names, factors = [], []
    for cell in rows[0]:
        found = re.fullmatch(r"\s*(\w+)\s*(?:[\[(]([^\])]*)[\])])?\s*", cell)
        if found is None or found[1] not in units:
            raise ValueError(f"{path.name}: unknown column {cell.strip()!r}; known: {', '.join(units)}")
        if found[1] in names:
            raise ValueError(f"{path.name}: column {found[1]!r} must be there once")
        names.append(found[1])
        factors.append(_factor(path, found[1], found[2], units[found[1]]))
    if "distance" not in names or len(names) < 2:
        raise ValueError(f"{path.name} must have a column 'distance' and one beside it, got {', '.join(names)}")
    numbers = np.array([_row(path, i, row, names, delimiter) for i, row in enumerate(rows[1:], 2)])
    found_ = {name: numbers[:, k] * factor for k, (name, factor) in enumerate(zip(names, factors, strict=True))}
    falls = np.flatnonzero(np.diff(found_["distance"]) <= 0.0)
    if falls.size:
        a, b = found_["distance"][falls[0] : falls[0] + 2]
        raise ValueError(f"{path.name}: distance must rise, got {a:.9g} m and {b:.9g} m after it")
    return found_


def _factor(path: Path, name: str, given: str | None, wanted: str) -> float:
    if wanted == "1" and (given or "").strip() in RATIOS:
        return RATIOS[(given or "").strip()]
    if given is None:
        raise ValueError(f"{path.name}: column {name!r} must have its unit, such as {name} [{wanted}]")
    try:
        return quantity(f"1 {given.strip()}", wanted)
    except ValueError as error:
        raise ValueError(f"{path.name}: column {name!r}: {error}") from None


def _row(path: Path, number: int, row: Sequence[str], names: Sequence[str], delimiter: str) -> list[float]:
    if len(row) != len(names):
        raise ValueError(f"{path.name}: row {number} must have {len(names)} numbers, got {len(row)}")
    values = []
    for name, cell in zip(names, row, strict=True):
        text = cell.strip().replace(",", ".") if delimiter != "," else cell.strip()
        try:
            value = float(text)
        except ValueError:
            raise ValueError(f"{path.name}: row {number}: {name} must be a number, got {cell.strip()!r}") from None
        if not np.isfinite(value):
            raise ValueError(f"{path.name}: row {number}: {name} must be finite, got {cell.strip()!r}")
        values.append(value)
    return values


@dataclass(frozen=True, eq=False)
class Line:
    """A line, straight between points.

    Attributes
    ----------
    distance, curvature, cant, gradient : array, shape (n,)
        m, 1/m, and angles in rad: curvature to the left, the left rail lifted, climbing.
    """

    distance: np.ndarray
    curvature: np.ndarray
    cant: np.ndarray
    gradient: np.ndarray

    def at(self, s: Any) -> dict[str, Any]:
        """The fields of alignment.TrackPoint at s (m), as expressions, heading and integrals from the first point on."""
        x = np.concatenate([[self.distance[0] - FAR], self.distance, [self.distance[-1] + FAR]])
        k, c, g = (np.concatenate([[v[0]], v, [v[-1]]]) for v in (self.curvature, self.cant, self.gradient))
        w = np.diff(x)
        slopes = [np.diff(v) / w for v in (k, c, g)]
        heading, height = np.zeros(x.size), np.zeros(x.size)
        place = np.zeros(x.size)
        for i in range(1, x.size - 1):  # from the first point of the file on
            heading[i + 1] = heading[i] + w[i] * (k[i] + k[i + 1]) / 2
            height[i + 1] = height[i] + w[i] * (g[i] + g[i + 1]) / 2
            place[i + 1] = place[i] + w[i] * heading[i] + w[i] ** 2 * (k[i] / 2 + w[i] * slopes[0][i] / 6)
        heading[0], height[0] = -w[0] * k[0], -w[0] * g[0]
        place[0] = -w[0] * heading[0] - w[0] ** 2 * k[0] / 2
        rows = np.column_stack([k[:-1], slopes[0], heading[:-1], place[:-1], c[:-1], slopes[1], g[:-1], slopes[2], height[:-1]])
        r, (k0, k1, h0, p0, c0, c1, g0, g1, z0) = _split(pieces(x.tolist(), rows, name="distance")(s))
        return {
            "curvature": k0 + k1 * r, "heading": h0 + r * (k0 + r * k1 / 2),
            "heading_integral": p0 + r * (h0 + r * (k0 / 2 + r * k1 / 6)), "cant": c0 + c1 * r, "cant_slope": c1,
            "gradient": g0 + g1 * r, "gradient_slope": g1, "gradient_integral": z0 + r * (g0 + r * g1 / 2),
        }  # fmt: skip


def _split(found: tuple[ca.SX, ca.SX]) -> tuple[ca.SX, list[ca.SX]]:
    return found[0], [found[1][i] for i in range(found[1].numel())]


def line(path: Path, half_distance: float) -> Line:
    """Read a line.

    Parameters
    ----------
    path : Path
        The file.
    half_distance : float
        Half the distance of the contact points, which turns cant into an angle (m).
    """
    units = {"distance": "m", "curvature": "1/m", "radius": "m", "cant": "m", "gradient": "1"}
    found = columns(path, units)
    n = found["distance"].size
    if "curvature" in found and "radius" in found:
        raise ValueError(f"{path.name} must have a column 'curvature' or 'radius', not both")
    if "radius" in found:
        R = found["radius"]
        found["curvature"] = np.divide(1.0, R, out=np.zeros(n), where=R != 0.0)  # 0 stands for straight track
    curvature, cant, gradient = (found.get(name, np.zeros(n)) for name in ("curvature", "cant", "gradient"))
    for name, values, largest, unit in (
        ("curvature", curvature, 0.1, "1/m"),
        ("cant", cant, 0.2, "m"),
        ("gradient", gradient, 0.2, ""),
    ):
        worst = int(np.argmax(np.abs(values)))
        if abs(values[worst]) > largest:
            raise ValueError(
                f"{path.name}: {name} must lie within {largest:g} {unit}".rstrip()
                + f", got {values[worst]:g} at {found['distance'][worst]:g} m"
            )
    return Line(found["distance"], curvature, -np.arcsin(cant / (2 * half_distance)), np.arctan(gradient))


@dataclass(frozen=True, eq=False)
class Record:
    """An irregularity, by points.

    Attributes
    ----------
    distance : array, shape (n,)
        m.
    displacement : dict of str to array, shape (n,)
        m, by channel of vehicle.irregularity, faded at both ends.
    """

    distance: np.ndarray
    displacement: dict[str, np.ndarray]

    def at(self, s: Any) -> tuple[dict[str, Any], dict[str, Any]]:
        """Displacement (m) and slope (1) by channel at s (m), as expressions."""
        names = list(self.displacement)
        x = ca.SX.sym("x")
        value = table(self.distance.tolist(), np.column_stack([self.displacement[name] for name in names]), name="distance")(x)
        both = ca.substitute(ca.vertcat(value, ca.jacobian(value, x)), x, ca.SX(s))
        zero = dict.fromkeys(CHANNELS, ca.SX(0))
        n = len(names)
        return zero | {name: both[i] for i, name in enumerate(names)}, zero | {name: both[n + i] for i, name in enumerate(names)}


def faded(distance: np.ndarray, displacement: Mapping[str, np.ndarray], fade: float, start: float = -np.inf) -> Record:
    """A record that fades in and out over `fade` metres at either end, and is even before `start` (m)."""
    inside = np.minimum(distance - max(float(distance[0]), start), distance[-1] - distance)
    u = np.clip(inside / fade, 0.0, 1.0) if fade > 0.0 else 1.0 * (inside >= 0.0)
    ramp = u * u * (3 - 2 * u)
    return Record(distance, {name: values * ramp for name, values in displacement.items()})


def record(path: Path, fade: float, start: float = -np.inf) -> Record:
    """Read an irregularity; `fade` and `start` (m) as in `faded`."""
    found = columns(path, dict.fromkeys(("distance", *CHANNELS, *RAILS), "m"))
    distance = found.pop("distance")
    if distance.size < 8:
        raise ValueError(f"{path.name} must have 8 rows or more, got {distance.size}")
    steps = np.diff(distance)
    wide = int(np.argmax(steps))
    if steps[wide] > GAP * float(np.median(steps)):
        raise ValueError(
            f"{path.name}: a record must have no gaps, got one of {steps[wide]:g} m after {distance[wide]:g} m,"
            f" its steps are {np.median(steps):g} m"
        )
    rails = [name for name in RAILS if name in found]
    if rails and (len(rails) < len(RAILS) or len(found) > len(RAILS)):
        raise ValueError(
            f"{path.name} must have all of {', '.join(RAILS)} and nothing beside them, or none, got {', '.join(found)}"
        )
    for name, values in found.items():
        worst = int(np.argmax(np.abs(values)))
        if abs(values[worst]) > LARGEST:
            raise ValueError(
                f"{path.name}: {name} must lie within {LARGEST:g} m, got {values[worst]:g} m at {distance[worst]:g} m"
            )
    if rails:
        ll, lv, rl, rv = (found[name] for name in RAILS)
        found = {"lateral": (ll + rl) / 2, "vertical": (lv + rv) / 2, "cross_level": lv - rv, "gauge": ll - rl}
    return faded(distance, found, fade, start)


@dataclass(frozen=True, eq=False)
class Speeds:
    """A speed over the distance, straight between points.

    Attributes
    ----------
    distance, speed, drive : array, shape (n,)
        m, m/s, and whether the drive is on (1) or the vehicle coasts (0).
    """

    distance: np.ndarray
    speed: np.ndarray
    drive: np.ndarray

    def at(self, s: Any) -> tuple[ca.SX, ca.SX]:
        """Speed (m/s) and share of the drive (1) at s (m), as expressions."""
        values = np.column_stack([self.speed, self.drive])
        found = table(self.distance.tolist(), values, kind="linear", name="distance")(s)
        return found[0], found[1]


def speeds(path: Path) -> Speeds:
    """Read a speed profile."""
    found = columns(path, {"distance": "m", "speed": "m/s", "drive": "1"})
    if "speed" not in found:
        raise ValueError(f"{path.name} must have a column 'speed'")
    slow = np.flatnonzero(found["speed"] <= 0.0)
    if slow.size:
        at = found["distance"][slow[0]]
        raise ValueError(f"{path.name}: speed must be positive all the way, got {found['speed'][slow[0]]:g} m/s at {at:g} m")
    drive = found.get("drive", np.ones(found["speed"].size))
    odd = np.flatnonzero((drive < 0.0) | (drive > 1.0))
    if odd.size:
        raise ValueError(f"{path.name}: drive must lie in 0..1, got {drive[odd[0]]:g} at {found['distance'][odd[0]]:g} m")
    return Speeds(found["distance"], found["speed"], drive)
