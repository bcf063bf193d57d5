"""Results in .mat files: the trajectory layout of Dymola, which Modelica tools read and write, with names in UTF-8."""

import re
from pathlib import Path
from typing import Any

import numpy as np

from .signals import Trajectory

_UNIT = re.compile(r"\[([^\[\]]*)\]\s*$")


def write_mat(trajectory: Trajectory, file: Path) -> None:
    """Write a .mat file, transposed ("binTrans"): one variable a column, `time` first.

    scipy writes characters in memory order, hence the contiguous copies of what is transposed.
    """
    from scipy.io import savemat

    t, names = trajectory.t, ["time", *trajectory.names]
    texts = ["time [s]", *(f"{name} [{unit}]" for name, unit in zip(trajectory.names, trajectory.units, strict=True))]
    info = np.array([[0 if i == 0 else 2, i + 1, 0, -1] for i in range(len(names))], dtype=np.int32).T
    span = np.zeros((1, 2)) if not t.size else np.array([[t[0], t[-1]]])
    savemat(
        file,
        {
            "Aclass": _characters(["Atrajectory", "1.1", "", "binTrans"]),
            "name": np.ascontiguousarray(_characters(names).T),
            "description": np.ascontiguousarray(_characters(texts).T),
            "dataInfo": info,
            "data_1": span.T,
            "data_2": np.column_stack([t, trajectory.values]).T,
        },
        format="4",
    )


def read_mat(file: Path) -> Trajectory:
    """The trajectory in a .mat file of that layout, anyone's: aliases and constants are spread over all points."""
    from scipy.io import loadmat

    data = loadmat(file, chars_as_strings=False)
    turned = "binNormal" not in "".join(np.ravel(data["Aclass"]))
    names, texts = (_lines(data[key].T if turned else data[key]) for key in ("name", "description"))
    info = data["dataInfo"].T if turned else data["dataInfo"]
    series, constants = (data[key].T if turned else data[key] for key in ("data_2", "data_1"))
    columns = []
    for matrix, place, *_ in info[1:].tolist():
        values = np.full(len(series), constants[0, abs(place) - 1]) if matrix == 1 else series[:, abs(place) - 1]
        columns.append(-values if place < 0 else values)
    units = tuple(_unit(name, text) for name, text in zip(names, texts, strict=True))
    return Trajectory(series[:, 0].copy(), tuple(names[1:]), units[1:], np.array(columns).T.reshape(len(series), len(columns)))


def _unit(name: str, text: str) -> str:
    """The unit at the end of a description; a name of ours may itself end in brackets."""
    if text.startswith(f"{name} [") and text.endswith("]"):
        return text[len(name) + 2 : -1]
    match = _UNIT.search(text)
    return match[1] if match else ""


def _characters(lines: list[str]) -> np.ndarray:
    """Lines as a character matrix padded with blanks, one line a row, as MATLAB 4 files hold text: one byte of UTF-8 a place."""
    encoded = [line.encode() for line in lines]
    width = max(map(len, encoded))
    return np.array([list(line.ljust(width).decode("latin-1")) for line in encoded])


def _lines(characters: Any) -> list[str]:
    """The other way round; padding goes, of blanks or of zeros."""
    return ["".join(row).encode("latin-1").decode().rstrip(" \0") for row in characters]
