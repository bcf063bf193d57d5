"""The result of a run: time, names, units and values."""

import re
from collections.abc import Iterable
from dataclasses import dataclass
from importlib import import_module
from pathlib import Path
from typing import Any

import numpy as np

from .origin import Origin


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

    def save(self, file: str | Path, origin: Origin | None = None) -> None:
        """Write the signals to a file.

        Parameters
        ----------
        file : str or Path
            .csv (header `time`, then `component.variable`), .mat (the layout that Modelica tools read, names in UTF-8), .parquet
            or .mf4 (MDF 4.1, as ASAM has it), the last two with units and with an extra of the same name.
        origin : Origin, optional
            Where the results come from, which is written into the file or beside it.

        Raises
        ------
        ValueError
            Another ending, or a format that is not installed.
        """
        from .files import save

        save(self, Path(file), origin)


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
