"""What a study has found, as JSON: numbers that are not finite become null, which JSON has no other word for."""

import json
import math
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from gyro_cosim.component.whole_files import write_whole


def write_summary(file: str | Path, summary: Mapping[str, Any]) -> Path:
    """Write a study's results as JSON.

    Parameters
    ----------
    file
        Where to; its folder must exist.
    summary
        Texts, numbers, lists and mappings; NaN and infinity are written as null.

    Returns
    -------
    Path
        Of the file.
    """
    file = Path(file)
    write_whole(file, json.dumps(_finite(summary), indent=1, allow_nan=False) + "\n")
    return file


def _finite(value: Any) -> Any:
    """The same with None for every number that is not finite."""
    if isinstance(value, Mapping):
        return {key: _finite(item) for key, item in value.items()}
    if isinstance(value, list | tuple):
        return [_finite(item) for item in value]
    return None if isinstance(value, float) and not math.isfinite(value) else value
