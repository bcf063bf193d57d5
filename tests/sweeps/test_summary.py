"""A study's results as JSON that every reader takes."""

import json
from pathlib import Path

import numpy as np

from gyro_cosim.sweeps import write_summary


def test_numbers_that_are_not_finite_become_null_and_texts_stay(tmp_path: Path) -> None:
    summary = {"NaN of B": [np.float64("nan"), 1.5], "unsafe": {"from": float("inf"), "says": "NaN"}, "none": (), "n": 3}
    file = write_summary(tmp_path / "s.json", summary)

    def refuse(constant: str) -> None:
        raise AssertionError(constant)

    read = json.loads(file.read_text(), parse_constant=refuse)
    assert read == {"NaN of B": [None, 1.5], "unsafe": {"from": None, "says": "NaN"}, "none": [], "n": 3}
