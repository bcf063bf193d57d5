"""Results in .csv files: a header with `time` and the names, then a row a point, each number to its last bit."""

import csv
import io
from collections.abc import Sequence
from pathlib import Path

import numpy as np

from .signals import Trajectory

CSV_ROWS = 10_000  # that are turned into text at once


def csv_header(names: Sequence[str]) -> bytes:
    """The first line of a results file: `time`, then the names, quoted where they hold a comma, a quote or a line's end."""
    line = io.StringIO()
    csv.writer(line, lineterminator="\n").writerow(["time", *names])
    return line.getvalue().encode()


def csv_rows(t: np.ndarray, values: np.ndarray) -> bytes:
    """Rows of a results file: times, shape (n,), and values, shape (n, m), so that they are read back to the last bit."""
    rows = zip(t.tolist(), values.tolist(), strict=True)
    return "".join(f"{','.join(map(repr, (ti, *row)))}\n" for ti, row in rows).encode()


def write_csv(trajectory: Trajectory, file: Path) -> None:
    """Write a .csv file."""
    with file.open("wb") as stream:
        stream.write(csv_header(trajectory.names))
        for k in range(0, len(trajectory), CSV_ROWS):
            stream.write(csv_rows(trajectory.t[k : k + CSV_ROWS], trajectory.values[k : k + CSV_ROWS]))


def read_csv(file: str | Path) -> Trajectory:
    """The trajectory in a .csv file that Trajectory.save or a streamed run wrote.

    Parameters
    ----------
    file : str or Path
        The file.

    Returns
    -------
    Trajectory
        Units are not kept in such a file and come back empty; read_results() takes them from what lies beside it.
    """
    with Path(file).open(newline="", encoding="utf-8") as stream:
        header = next(csv.reader(stream))
        rest = stream.read()
    if header[:1] != ["time"]:
        raise ValueError("its first column must be time")
    values = np.loadtxt(io.StringIO(rest), delimiter=",", ndmin=2) if rest.strip() else np.empty((0, len(header)))
    if values.shape[1] != len(header):
        raise ValueError(f"its rows must have {len(header)} numbers as its first line has names, got {values.shape[1]}")
    return Trajectory(values[:, 0], tuple(header[1:]), ("",) * (len(header) - 1), values[:, 1:])
