"""The result of a run: time, names, units and values, and the files it is kept in."""

import csv
import io
import re
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from importlib import import_module
from importlib.util import find_spec
from pathlib import Path
from typing import Any

import numpy as np

FORMATS = (".csv", ".mat", ".parquet")
CSV_ROWS = 10_000  # that are turned into text at once


@dataclass(frozen=True, eq=False)
class Trajectory:
    """Signals at communication points.

    Parameters
    ----------
    t : ndarray, shape (n,)
        Time, s.
    names : tuple of str
        `component.variable`, m of them.
    units : tuple of str
        Of each signal; empty where none is known.
    values : ndarray, shape (n, m)
        One column a signal.
    """

    t: np.ndarray
    names: tuple[str, ...]
    units: tuple[str, ...]
    values: np.ndarray

    def __getitem__(self, name: str) -> np.ndarray:
        """The signal called `name`, shape (n,); ValueError where there is none."""
        return self.values[:, self._place(name)]

    def _place(self, name: str) -> int:
        if name not in self.names:
            raise ValueError(f"unknown signal {name!r}; known: {', '.join(self.names)}")
        return self.names.index(name)

    def __len__(self) -> int:
        return self.t.size

    def unit(self, name: str) -> str:
        """The unit of the signal called `name`; ValueError where there is none."""
        return self.units[self._place(name)]

    def end(self) -> dict[str, float]:
        """The values at the last point."""
        return dict(zip(self.names, self.values[-1].tolist(), strict=True)) if len(self) else {}

    def to_pandas(self) -> Any:
        """A pandas DataFrame over `time`, one column a signal, units in its `attrs`; needs pandas installed."""
        pandas = _optional("pandas", "to_pandas")
        frame = pandas.DataFrame(self.values, index=pandas.Index(self.t, name="time"), columns=list(self.names))
        frame.attrs["units"] = dict(zip(self.names, self.units, strict=True))
        return frame

    def to_xarray(self) -> Any:
        """An xarray Dataset over `time`, one variable a signal, each with its `units`; needs xarray installed."""
        xarray = _optional("xarray", "to_xarray")
        signals = {name: ("time", self.values[:, k], {"units": self.units[k]}) for k, name in enumerate(self.names)}
        return xarray.Dataset(signals, coords={"time": ("time", self.t, {"units": "s"})})

    def save(self, file: str | Path) -> None:
        """Write a .csv (header `time`, then `component.variable`), a .mat (the layout that Modelica tools read, names in UTF-8)
        or, with the extra `parquet`, a .parquet (the unit of each column in its metadata)."""
        file = Path(file)
        check_format(file)
        if file.suffix == ".csv":
            with file.open("wb") as stream:
                stream.write(csv_header(self.names))
                for k in range(0, len(self), CSV_ROWS):
                    stream.write(csv_rows(self.t[k : k + CSV_ROWS], self.values[k : k + CSV_ROWS]))
        elif file.suffix == ".parquet":
            self._save_parquet(file)
        else:
            self._save_mat(file)

    def _save_parquet(self, file: Path) -> None:
        import pyarrow
        from pyarrow import parquet

        kind = pyarrow.float64()
        columns = [("time", "s", self.t), *zip(self.names, self.units, self.values.T, strict=True)]
        fields = [pyarrow.field(name, kind, nullable=False, metadata={"unit": unit}) for name, unit, _ in columns]
        arrays = [pyarrow.array(np.ascontiguousarray(values)) for _, _, values in columns]
        parquet.write_table(pyarrow.Table.from_arrays(arrays, schema=pyarrow.schema(fields)), file)

    def _save_mat(self, file: Path) -> None:
        """The Dymola trajectory layout, transposed ("binTrans"): one variable a column, `time` first.

        scipy writes characters in memory order, hence the contiguous copies of what is transposed.
        """
        from scipy.io import savemat

        names = ["time", *self.names]
        texts = ["time [s]", *(f"{name} [{unit}]" for name, unit in zip(self.names, self.units, strict=True))]
        n = len(names)
        info = np.array([[0 if i == 0 else 2, i + 1, 0, -1] for i in range(n)], dtype=np.int32).T
        span = np.zeros((1, 2)) if not len(self) else np.array([[self.t[0], self.t[-1]]])
        savemat(
            file,
            {
                "Aclass": _characters(["Atrajectory", "1.1", "", "binTrans"]),
                "name": np.ascontiguousarray(_characters(names).T),
                "description": np.ascontiguousarray(_characters(texts).T),
                "dataInfo": info,
                "data_1": span.T,
                "data_2": np.column_stack([self.t, self.values]).T,
            },
            format="4",
        )


def _characters(lines: list[str]) -> np.ndarray:
    """Lines as a character matrix padded with blanks, one line a row, as MATLAB 4 files hold text: one byte of UTF-8 a place."""
    encoded = [line.encode() for line in lines]
    width = max(map(len, encoded))
    return np.array([list(line.ljust(width).decode("latin-1")) for line in encoded])


def _optional(package: str, what: str) -> Any:
    """A package that is not always there."""
    try:
        return import_module(package)
    except ModuleNotFoundError:
        raise ModuleNotFoundError(
            f"Trajectory.{what}() needs the package {package}: python -m pip install {package}", name=package
        ) from None


def matching(pattern: str, names: Iterable[str]) -> list[str]:
    """The names that a pattern means, in their own order.

    Parameters
    ----------
    pattern : str
        An exact name always means that one alone. Otherwise * stands for any text and ? for one character; everything else,
        brackets too, stands for itself.
    names : iterable of str
        Names of signals, `component.variable`.
    """
    known = list(names)
    if pattern in known:
        return [pattern]
    parts = ({"*": ".*", "?": "."}.get(character) or re.escape(character) for character in pattern)
    wanted = re.compile("".join(parts), re.DOTALL)
    return [name for name in known if wanted.fullmatch(name)]


def csv_header(names: Sequence[str]) -> bytes:
    """The first line of a results file: `time`, then the names, quoted where they hold a comma, a quote or a line's end."""
    line = io.StringIO()
    csv.writer(line, lineterminator="\n").writerow(["time", *names])
    return line.getvalue().encode()


def csv_rows(t: np.ndarray, values: np.ndarray) -> bytes:
    """Rows of a results file: times, shape (n,), and values, shape (n, m), so that they are read back to the last bit."""
    rows = zip(t.tolist(), values.tolist(), strict=True)
    return "".join(f"{','.join(map(repr, (ti, *row)))}\n" for ti, row in rows).encode()


def check_format(file: Path) -> None:
    """Refuse a file name whose ending says no format that can be written."""
    if file.suffix not in FORMATS:
        raise ValueError(f"output file must end in {', '.join(FORMATS[:-1])} or {FORMATS[-1]}, got {str(file)!r}")
    if file.suffix == ".parquet" and find_spec("pyarrow") is None:
        raise ValueError(f"{str(file)!r} needs the package pyarrow: python -m pip install 'gyro-cosim[parquet]'")


def read_results(file: str | Path) -> Trajectory:
    """The trajectory in a .csv, .mat or .parquet file that Trajectory.save wrote.

    Parameters
    ----------
    file : str or Path
        The file.

    Returns
    -------
    Trajectory
        Units of a .csv come back empty.

    Raises
    ------
    ValueError
        Another ending, or a file that holds no such results.
    """
    file = Path(file)
    check_format(file)
    try:
        return {".csv": read_csv, ".mat": _read_mat, ".parquet": _read_parquet}[file.suffix](file)
    except (ValueError, KeyError, StopIteration, UnicodeDecodeError) as error:
        raise ValueError(f"{str(file)!r} must be a {file.suffix} that cosim run wrote: {error}") from None


def _read_mat(file: Path) -> Trajectory:
    from scipy.io import loadmat

    data = loadmat(file, chars_as_strings=False)
    names, texts = (
        ["".join(column).encode("latin-1").decode().rstrip(" ") for column in data[key].T] for key in ("name", "description")
    )
    units = tuple(text[len(name) + 2 : -1] for name, text in zip(names, texts, strict=True))
    values = data["data_2"].T
    return Trajectory(values[:, 0].copy(), tuple(names[1:]), units[1:], values[:, 1:].copy())


def _read_parquet(file: Path) -> Trajectory:
    from pyarrow import parquet

    table = parquet.read_table(file)
    names = table.column_names
    if names[:1] != ["time"]:
        raise ValueError("its first column must be time")
    units = tuple((field.metadata or {}).get(b"unit", b"").decode() for field in table.schema)
    columns = [column.to_numpy() for column in table.columns]
    return Trajectory(columns[0].copy(), tuple(names[1:]), units[1:], np.array(columns[1:]).T.reshape(len(columns[0]), -1))


def read_csv(file: str | Path) -> Trajectory:
    """The trajectory in a .csv file that Trajectory.save or a streamed run wrote.

    Parameters
    ----------
    file : str or Path
        The file.

    Returns
    -------
    Trajectory
        Units are not kept in such a file and come back empty.
    """
    with Path(file).open(newline="", encoding="utf-8") as stream:
        header = next(csv.reader(stream))
        values = np.loadtxt(stream, delimiter=",", ndmin=2)
    return Trajectory(values[:, 0], tuple(header[1:]), ("",) * (len(header) - 1), values[:, 1:])
