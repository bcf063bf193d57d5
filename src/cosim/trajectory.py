"""The result of a run: time, names, units and values, and the files it is kept in."""

import csv
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np


@dataclass(frozen=True, eq=False)
class Trajectory:
    """Signals at communication points. `t` (s), shape (n,); `values`, shape (n, len(names)); `names` as `component.variable`."""

    t: np.ndarray
    names: tuple[str, ...]
    units: tuple[str, ...]
    values: np.ndarray

    def __getitem__(self, name: str) -> np.ndarray:
        """The signal called `name`, shape (n,)."""
        if name not in self.names:
            raise ValueError(f"unknown signal {name!r}; known: {', '.join(self.names)}")
        return self.values[:, self.names.index(name)]

    def __len__(self) -> int:
        return self.t.size

    def unit(self, name: str) -> str:
        """The unit of the signal called `name`."""
        return self.units[self.names.index(name)]

    def end(self) -> dict[str, float]:
        """The values at the last point."""
        return dict(zip(self.names, self.values[-1].tolist(), strict=True)) if len(self) else {}

    def to_pandas(self) -> Any:
        """A pandas DataFrame over `time`, one column a signal, units in its `attrs`; needs pandas installed."""
        import pandas

        frame = pandas.DataFrame(self.values, index=pandas.Index(self.t, name="time"), columns=list(self.names))
        frame.attrs["units"] = dict(zip(self.names, self.units, strict=True))
        return frame

    def to_xarray(self) -> Any:
        """An xarray Dataset over `time`, one variable a signal, each with its `units`; needs xarray installed."""
        import xarray

        signals = {name: ("time", self.values[:, k], {"units": self.units[k]}) for k, name in enumerate(self.names)}
        return xarray.Dataset(signals, coords={"time": ("time", self.t, {"units": "s"})})

    def save(self, file: str | Path) -> None:
        """Write a .csv (header `time`, then `component.variable`) or a .mat (the layout that Modelica tools read)."""
        file = Path(file)
        check_format(file)
        if file.suffix == ".csv":
            self._save_csv(file)
        else:
            self._save_mat(file)

    def _save_csv(self, file: Path) -> None:
        with file.open("w", newline="") as stream:
            writer = csv.writer(stream)
            writer.writerow(["time", *self.names])
            writer.writerows(np.column_stack([self.t, self.values]).tolist())

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
    """Lines as a character matrix padded with blanks, one line a row, as MATLAB 4 files hold text."""
    width = max(map(len, lines))
    return np.array([list(line.ljust(width)) for line in lines])


def check_format(file: Path) -> None:
    """Refuse a file name whose ending says no format that can be written."""
    if file.suffix not in (".csv", ".mat"):
        raise ValueError(f"output file must end in .csv or .mat, got {str(file)!r}")


def read_csv(file: str | Path) -> Trajectory:
    """The trajectory in a .csv that `save` wrote; units are not kept there and come back empty."""
    with Path(file).open(newline="") as stream:
        header = next(csv.reader(stream))
        values = np.loadtxt(stream, delimiter=",", ndmin=2)
    return Trajectory(values[:, 0], tuple(header[1:]), ("",) * (len(header) - 1), values[:, 1:])
