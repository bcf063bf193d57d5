"""Time series of a file as the inputs of a system: of a .csv, or of results in another format.

    time,vehicle.speed [km/h],brake.on
    0,36,0
    5,36,0
    5,72,1            a time that stands twice is a jump

The first column is time, in seconds or `time [ms]`; each other one is named by the input that it drives, `component.variable`, or
in a system of one component `variable`, perhaps with a unit in brackets after a blank. The input's own unit counts otherwise.
"""

import csv
import io
import re
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from gyro_cosim.component.units import unit

from ..trajectory import FORMATS, read_results

__all__ = ["InputSeries", "read_table"]

_WITH_UNIT = re.compile(r"(.*\S)\s+\[([^\[\]]*)\]\s*")


@dataclass(frozen=True, eq=False)
class InputSeries:
    """What an open input follows.

    Parameters
    ----------
    target : str
        `component.variable`, or `variable` in a system of one component.
    unit : str
        Of the values; empty: the input's own.
    t, values : ndarray, shape (n,)
        Times (s), which never fall; one that stands twice is a jump.
    where : str
        Where it comes from, for messages.
    """

    target: str
    unit: str
    t: np.ndarray
    values: np.ndarray
    where: str = "input series"

    def __post_init__(self) -> None:
        if self.t.ndim != 1 or self.t.shape != self.values.shape or not self.t.size:
            raise ValueError(f"{self.where}: {self.target} must have as many values as times, at least one")
        for what, numbers in (("time", self.t), (self.target, self.values)):
            if not np.isfinite(numbers).all():
                k = int(np.flatnonzero(~np.isfinite(numbers))[0])
                raise ValueError(f"{self.where}: {what} must be finite, got {numbers[k]} in row {k + 1}")
        falls = np.flatnonzero(np.diff(self.t) < 0.0)
        if falls.size:
            k = int(falls[0])
            raise ValueError(f"{self.where}: time must never fall, got {self.t[k]:g} s and then {self.t[k + 1]:g} s")


def read_inputs(file: str | Path) -> tuple[InputSeries, ...]:
    """The series in a file; ValueError names file, line and rule."""
    where = f"input file {str(file)!r}"
    t, names, units, values = read_table(file, where)
    if not names:
        raise ValueError(f"{where} must have a column for an input besides time")
    return tuple(InputSeries(n, u, t, values[:, k], where) for k, (n, u) in enumerate(zip(names, units, strict=True)))


def read_table(file: str | Path, where: str) -> tuple[np.ndarray, list[str], list[str], np.ndarray]:
    """Times (s), names, units (empty where none is stated) and values, shape (n, m), of a .csv file whose first column is time.

    where : what the file is, for messages. Commas separate, or semicolons. A .mat, .parquet or .mf4 is read as results are.
    """
    if Path(file).suffix in FORMATS[1:]:
        try:
            told = read_results(file)
        except (ValueError, OSError) as error:
            raise ValueError(f"{where} cannot be read: {getattr(error, 'strerror', None) or error}") from None
        return told.t, list(told.names), list(told.units), told.values
    try:
        text = Path(file).read_text(encoding="utf-8-sig")
    except (OSError, UnicodeDecodeError) as error:
        raise ValueError(f"{where} cannot be read: {getattr(error, 'strerror', None) or error}") from None
    for delimiter in ",;":
        stream = io.StringIO(text, newline="")
        header = next(csv.reader(stream, delimiter=delimiter, skipinitialspace=True), [])
        if header and split_unit(header[0])[0].lower() == "time":
            break
    else:
        raise ValueError(f"{where} must begin with a column 'time', got {text.partition(chr(10))[0][:40]!r}")
    named = [split_unit(name) for name in header[1:]]
    for k, (name, _) in enumerate(named):
        if name in [other for other, _ in named[:k]]:
            raise ValueError(f"{where}: columns must differ, got {name!r} twice")
    rest = stream.read()
    if not rest.strip():
        raise ValueError(f"{where} must have a row of numbers at least")
    try:
        table = np.loadtxt(io.StringIO(rest), delimiter=delimiter, ndmin=2)
    except ValueError:
        table = _row_by_row(rest, delimiter, where, text[: len(text) - len(rest)].count("\n"))
    if table.shape[1] != len(header):
        raise ValueError(f"{where} must have {len(header)} numbers in a row as its first line has names, got {table.shape[1]}")
    try:
        scale = unit(split_unit(header[0])[1] or "s")
    except ValueError as error:
        raise ValueError(f"{where}: time: {error}") from None
    if scale.dimension != unit("s").dimension:
        raise ValueError(f"{where}: time must be in a unit of time, got {scale.name!r}")
    return table[:, 0] * scale.factor, [name for name, _ in named], [of for _, of in named], table[:, 1:]


def _row_by_row(text: str, delimiter: str, where: str, before: int) -> np.ndarray:
    """The same with true and false; the error names the line."""
    rows: list[list[float]] = []
    for k, words in enumerate(csv.reader(io.StringIO(text), delimiter=delimiter), before + 1):
        if not words:
            continue
        try:
            rows.append([float({"true": "1", "false": "0"}.get(word.strip().lower(), word)) for word in words])
        except ValueError:
            raise ValueError(f"{where}, line {k} must hold numbers, got {delimiter.join(words)!r}") from None
        if len(rows[-1]) != len(rows[0]):
            raise ValueError(f"{where}, line {k} must have {len(rows[0])} numbers as the one before, got {len(rows[-1])}")
    return np.array(rows, ndmin=2)


def split_unit(label: str) -> tuple[str, str]:
    """Name and unit in "speed [km/h]"; no unit in "y[1,2]", whose bracket follows without a blank."""
    match = _WITH_UNIT.fullmatch(label.strip())
    return (match[1], match[2].strip()) if match else (label.strip(), "")
