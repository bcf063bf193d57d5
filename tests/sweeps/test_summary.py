"""A study's results as JSON that every reader takes."""

import json
import zipfile
from pathlib import Path

import numpy as np
import pytest

from gyro_cosim.sweeps import write_summary
from gyro_cosim.sweeps.table import MARK, VERSION, Table, read, write


def test_numbers_that_are_not_finite_become_null_and_texts_stay(tmp_path: Path) -> None:
    summary = {"NaN of B": [np.float64("nan"), 1.5], "unsafe": {"from": float("inf"), "says": "NaN"}, "none": (), "n": 3}
    file = write_summary(tmp_path / "s.json", summary)

    def refuse(constant: str) -> None:
        raise AssertionError(constant)

    held = json.loads(file.read_text(), parse_constant=refuse)
    assert held == {"NaN of B": [None, 1.5], "unsafe": {"from": None, "says": "NaN"}, "none": [], "n": 3}


def test_a_sweep_file_passes_the_door_of_all_archives(tmp_path: Path) -> None:
    """A member that would land elsewhere makes it no sweep, although numpy would pass it over."""
    head = {MARK: VERSION, "columns": ["run", "x"], "text": ["run"], "definition": {"units": {}}}
    write(Table.of_rows(head, [("a", 1.0)]), tmp_path / "s.npz")
    assert read(tmp_path / "s.npz")["x"].tolist() == [1.0]
    with zipfile.ZipFile(tmp_path / "s.npz", "a") as archive:
        archive.writestr("../elsewhere.npy", b"")
    with pytest.raises(ValueError, match="must be the file of a sweep"):
        read(tmp_path / "s.npz")
