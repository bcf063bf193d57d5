"""Reads measured profiles: SIMPACK .prr and .prw, MiniProf .ban, .rai and .whl, plain text. Returns metres, y outwards, z up.

    what is read            SIMPACK's block point.begin .. point.end with its own shift, turn, bounds and mirror; MiniProf's
                            columns X and Y; the first two columns of other text (space, comma, semicolon; # ! % begin remarks)
    unit                    SIMPACK's units.len.f; MiniProf is in mm; else `unit`, or mm, inch or m in a remark, or the width:
                            30 to 250 is mm, 0.03 to 0.25 is m; a width that would be inches is refused until it is stated
    order                   either; turned so that y grows
    up                      the flange and the sides of a rail point down, whichever sign they have in the file
    across                  a wheel's flange comes to the gauge side, y < 0; a rail keeps its y, but MiniProf counts towards the
                            gauge side and is mirrored
    origin                  a wheel counted from its inner face is moved by 70 mm to its tape line; its z is 0 there, a rail's at
                            its top
    ends                    the inner face of a wheel and its rim, and the sides of a rail deeper than 3 mm, are cut off where
                            the curve turns back: nothing touches there

What was done stands in `Profile.notes`. Noise is smoothed as vehicle.section tells: the wavelength is the one given, or by the
noise found: the standard deviation of the third differences over root 20, 0 below 0.5 um and 6 mm above.
"""

import re
from pathlib import Path

import numpy as np

from .section import Profile, smoothed

__all__ = ["LEAST_POINTS", "read"]

UNITS = {"mm": 1e-3, "m": 1.0, "inch": 0.0254}
WIDTHS = ((30.0, 250.0, "mm"), (1.2, 9.8, "inch"), (0.03, 0.25, "m"))  # of a wheel or a rail's head, in that unit
LEAST_POINTS = 25
BACK = 0.07  # m from the inner face to the tape line
DEEP = 0.003  # m under the top, from where on a rail's side may turn back
RIM = 0.085  # m from the flange's tip, from where on a wheel may turn back
SUMMIT = 0.003  # m, half the width of the summit of a flange, where two scans may be joined
NOISE, SMOOTHING = 5e-7, 6e-3  # m: noise that is smoothed, and its default wavelength
KINDS = {".prr": "rail", ".prw": "wheel", ".ban": "rail", ".rai": "rail", ".whl": "wheel"}
NUMBER = r"[-+]?(?:\d+\.?\d*|\.\d+)(?:[eEdD][-+]?\d+)?"


def read(
    path: str | Path, *, kind: str | None = None, unit: str | None = None, smoothing: float | None = None, mirror: bool = False
) -> Profile:
    """Read a measured profile.

    Parameters
    ----------
    path : str or Path
        The file; its ending tells the format.
    kind : str, optional
        "wheel" or "rail" where neither ending nor shape tells.
    unit : str, optional
        "mm", "m" or "inch", if the file does not say it.
    smoothing : float, optional
        Wavelength (m) that loses half of its height; 0 smooths nothing. By the noise if it is not given.
    mirror : bool
        Turn field and gauge side round, for a file that has them the other way.

    Returns
    -------
    Profile
        Its y (outwards) and z (up) in m, its kind, and what was done.

    Raises
    ------
    ValueError
        In one line with the file, the rule and the value: no points, fewer than 25, a number that is not finite, a unit that is
        not stated, a width that is none, a curve that folds back, a wheel without a tape line.
    OSError
        If the file cannot be read.
    """
    path = Path(path)
    for name, value, allowed in (("kind", kind, ("wheel", "rail")), ("unit", unit, tuple(UNITS))):
        if value is not None and value not in allowed:
            raise ValueError(f"{name} must be one of {', '.join(allowed)}, got {value!r}")
    if smoothing is not None and not 0.0 <= smoothing < 0.1:
        raise ValueError(f"smoothing must be a wavelength from 0 to 0.1 m, got {smoothing:g}")
    try:
        return _read(path, kind, unit, smoothing, mirror)
    except ValueError as error:
        raise ValueError(f"{path}: {error}") from None


def _read(path: Path, kind: str | None, unit: str | None, smoothing: float | None, mirror: bool) -> Profile:
    text = path.read_text(encoding="utf-8", errors="replace")
    ending = path.suffix.lower()
    kind = kind or KINDS.get(ending)
    notes: list[str] = []
    if ending in (".prr", ".prw"):
        points, scale = _simpack(text, notes)
    else:
        points, scale = _columns(text, "mm" if ending in KINDS else None, notes)
    if points.shape[0] < LEAST_POINTS:
        raise ValueError(f"a profile must have {LEAST_POINTS} points or more, got {points.shape[0]}")
    if not np.all(np.isfinite(points)):
        raise ValueError(f"a profile must hold finite numbers only, got {points[~np.isfinite(points).all(axis=1)][0]}")
    width = float(np.ptp(points[:, 0]))
    points = points * (UNITS[unit] if unit else scale or UNITS[_unit_of(width)])
    if not 0.03 <= np.ptp(points[:, 0]) <= 0.25:
        raise ValueError(
            f"a profile must be 30 to 250 mm wide, got {1e3 * np.ptp(points[:, 0]):.4g} mm: state its unit, unit='mm'"
        )
    y, z = points.T
    if y[-1] < y[0]:
        y, z = y[::-1], z[::-1]
    kept = np.concatenate([[True], np.hypot(np.diff(y), np.diff(z)) > 1e-6])
    y, z = y[kept], z[kept]
    z = _upwards(y, z)
    kind = kind or _kind_of(y, z)
    if kind == "wheel":
        y, z = _flange_inwards(y, z, notes)
    elif ending in (".ban", ".rai"):
        y, z = -y[::-1], z[::-1]
        notes.append("mirrored: MiniProf counts a rail's y towards the gauge side")
    if mirror:
        y, z = -y[::-1], z[::-1]
        notes.append("mirrored as asked")
    noise = float(np.median(np.abs(np.diff(z, 3))) / 0.6745 / np.sqrt(20))
    wavelength = smoothing if smoothing is not None else (SMOOTHING if noise > NOISE else 0.0)
    y, z = smoothed(y, z, wavelength)
    notes.append(f"smoothed over {1e3 * wavelength:g} mm" if wavelength else "not smoothed")
    y, z = _ends_cut(y, z, kind, notes)
    if kind == "wheel":
        if not y[0] < 0.0 < y[-1]:
            raise ValueError(f"a wheel must reach over its tape line, y = 0, got y from {1e3 * y[0]:.4g} to {1e3 * y[-1]:.4g} mm")
        z = z - np.interp(0.0, y, z)
    else:
        z = z - z.max()
    return Profile(y, z, kind, tuple(notes))


def _unit_of(width: float) -> str:
    for low, high, unit in WIDTHS:
        if low <= width <= high and unit != "inch":
            return unit
        if low <= width <= high:
            raise ValueError(f"the unit must be stated where a profile is {width:.4g} wide, that of one in inches: unit='inch'")
    raise ValueError(f"a profile must be 30 to 250 mm or 0.03 to 0.25 m wide, got {width:.4g}: state its unit, unit='mm'")


def _numbers(line: str) -> list[float] | None:
    """The numbers that a line begins with, None for a line of text."""
    line = line.strip().strip('"').replace("\t", " ")
    if ";" in line and re.search(r"\d,\d", line):
        line = line.replace(",", ".")
    fields = [f for f in re.split(r"[\s,;]+", line.strip()) if f]
    values: list[float] = []
    for field in fields:
        if re.fullmatch(NUMBER, field):
            values.append(float(re.sub("[dD]", "e", field)))
        elif field.lower() in ("nan", "inf", "-inf"):
            values.append(float(field))
        else:
            break
    return values if len(values) >= 2 else None


def _columns(text: str, unit: str | None, notes: list[str]) -> tuple[np.ndarray, float | None]:
    """Points of MiniProf or plain text, and the unit's factor where a remark states it."""
    rows: list[list[float]] = []
    pick, said = (0, 1), None
    for line in text.splitlines():
        definition = re.match(r'\s*"?ColumnDef\s*=\s*([\w,]+)', line)
        if definition:
            names = definition[1].upper().split(",")
            if "X" in names and "Y" in names:
                pick = (names.index("X"), names.index("Y"))
            continue
        if unit and len(rows) < LEAST_POINTS and not line.strip():
            rows = []  # MiniProf's points begin after an empty line; numbers before it are the header's
        values = None if re.match(r"\s*[#!%]|.*=", line) else _numbers(line)
        if values is not None and len(values) > max(pick):
            rows.append([values[pick[0]], values[pick[1]]])
        elif unit is None and said is None and not rows:
            stated = re.search(r"\b(mm|millimet\w+|inch|inches|metres?|meters?|m)\b", line.lower())
            if stated:
                word = stated[1]
                said = "inch" if word.startswith("inch") else "mm" if word.startswith(("mm", "milli")) else "m"
                notes.append(f"in {said}, as the file says")
    if not rows:
        raise ValueError("a profile must hold two columns of numbers, got none")
    return np.array(rows), UNITS.get(unit or said or "")


def _simpack(text: str, notes: list[str]) -> tuple[np.ndarray, float | None]:
    """Points of a SIMPACK file after its own processing, and the factor to metres."""
    values: dict[str, float] = {}
    rows: list[list[float]] = []
    inside = False
    for raw in text.splitlines():
        line = raw.split("!")[0].strip()
        key, equals, rest = line.partition("=")
        if line.lower() in ("point.begin", "point.end"):
            inside = line.lower() == "point.begin"
        elif inside and line:
            numbers = _numbers(line)
            if numbers is None:
                raise ValueError(f"a line between point.begin and point.end must hold two numbers, got {line!r}")
            rows.append(numbers[:2])
        elif equals and re.fullmatch(NUMBER, rest.strip()):
            values[key.strip().lower()] = float(re.sub("[dD]", "e", rest.strip()))
    if not rows:
        raise ValueError("a SIMPACK profile must hold points between point.begin and point.end, got none")
    y, z = np.array(rows).T
    y, z = y + values.get("shift.y", 0.0), z + values.get("shift.z", 0.0)
    turn = values.get("rotate", 0.0) / values.get("units.ang.f", 1.0)
    y, z = y * np.cos(turn) - z * np.sin(turn), y * np.sin(turn) + z * np.cos(turn)
    keep = np.ones(y.size, bool)
    for axis, column in (("y", y), ("z", z)):
        low, high = values.get(f"bound.{axis}.min", 1.0), values.get(f"bound.{axis}.max", 0.0)
        if low < high:
            keep &= (column >= low) & (column <= high)
    sign = -1.0 if values.get("mirror.y", 0.0) else 1.0
    if values.get("approx.smooth", 0.0):
        notes.append(f"approx.smooth = {values['approx.smooth']:g} of the file not used")
    factor = values.get("units.len.f")
    return np.column_stack([sign * y[keep], z[keep]]), 1.0 / factor if factor else None


def _flat(y: np.ndarray, z: np.ndarray) -> np.ndarray:
    """Which points lie where the curve is less steep than 75 deg."""
    flat: np.ndarray = np.abs(np.gradient(z)) < 3.7 * np.abs(np.gradient(y))
    return flat if flat.sum() >= 5 else np.ones(y.size, bool)


def _upwards(y: np.ndarray, z: np.ndarray) -> np.ndarray:
    """z with the flange, or a rail's sides, down."""
    flat = _flat(y, z)
    away = z[flat] - np.median(z[flat])
    return -z if away[int(np.argmax(np.abs(away)))] > 0.0 else z


def _kind_of(y: np.ndarray, z: np.ndarray) -> str:
    """A rail falls off on both sides of its middle, a wheel on that of its flange."""
    flat = _flat(y, z)
    y, z = y[flat], z[flat]
    middle = (y[0] + y[-1]) / 2
    falls = [float(np.median(z) - z[half].min()) for half in (y < middle, y >= middle)]
    return "rail" if min(falls) > 0.25 * max(falls) else "wheel"


def _flange_inwards(y: np.ndarray, z: np.ndarray, notes: list[str]) -> tuple[np.ndarray, np.ndarray]:
    """The flange on the gauge side, and y from the tape line."""
    flat = np.flatnonzero(_flat(y, z))
    tip = float(y[flat[int(np.argmin(z[flat]))]])
    if tip > (y[0] + y[-1]) / 2:
        y, z, tip = -y[::-1], z[::-1], -tip
        notes.append("mirrored: the flange comes to the gauge side")
    if tip > -0.03:
        y = y - BACK
        notes.append("moved by 70 mm: y counted from the inner face")
    return y, z


def _ends_cut(y: np.ndarray, z: np.ndarray, kind: str, notes: list[str]) -> tuple[np.ndarray, np.ndarray]:
    """The part whose y increases, cut where the ends turn back; a fold elsewhere is refused."""
    back = np.flatnonzero(np.diff(y) <= 1e-9)
    if kind == "wheel":
        tip = int(np.argmin(np.where(y < y.min() + 0.04, z, np.inf)))
        inner, outer = (back < tip) | (y[back] < y[tip] + SUMMIT), y[back] > y[tip] + RIM
    else:
        top = int(np.argmax(z))
        deep = z[back] < z[top] - DEEP
        inner, outer = deep & (back < top), deep & (back >= top)
    middle = back[~inner & ~outer]
    if middle.size:
        i = int(middle[0])
        raise ValueError(f"a profile must not fold back, got y = {1e3 * y[i + 1]:.4g} mm after {1e3 * y[i]:.4g} mm")
    start = int(back[inner].max()) + 1 if inner.any() else 0
    end = int(back[outer].min()) + 1 if outer.any() else y.size
    if end - start < LEAST_POINTS:
        raise ValueError(f"a profile must have {LEAST_POINTS} points or more between its ends, got {max(0, end - start)}")
    if start or end < y.size:
        notes.append(f"cut to y from {1e3 * y[start]:.4g} to {1e3 * y[end - 1]:.4g} mm, where the ends turn back")
    return y[start:end], z[start:end]
