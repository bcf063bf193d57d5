"""What a variant may differ by: limits per signal and on the energy that its interface creates, from a TOML file.

    [signals."vehicle.*"]        # a signal, or a pattern with * and ?; where several fit, the last one counts
    rms = "5 %"                  # rms of the difference over rms of the reference
    peak = 0.05                  # largest difference over largest value of the reference
    shift = "5 ms"               # time shift either way

    [energy]
    created = 0.02               # energy that the interface creates, over the energy that crosses it

A limit that is not stated is none. A pattern that fits no signal is refused: it would never fail.
"""

import tomllib
from collections.abc import Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from gyro_cosim.component.units import quantity

from ..errors import unknown
from ..trajectory import matching

UNITS = {"rms": "1", "peak": "1", "shift": "s"}


@dataclass(frozen=True)
class Tolerances:
    """Limits on what a variant may differ by.

    Parameters
    ----------
    signals : dict of str to dict
        Pattern as trajectory.matching() reads it -> some of `rms`, `peak` (relative) and `shift` (s).
    created : float or None
        Energy that the interface creates, over the energy that crosses it.
    where : str
        Where they come from, for messages.
    """

    signals: dict[str, dict[str, float]] = field(default_factory=dict)
    created: float | None = None
    where: str = "built in"

    def limits(self, signal: str) -> dict[str, float]:
        """The limits on `signal`; empty where it has none."""
        found: dict[str, float] = {}
        for pattern, limits in self.signals.items():
            if matching(pattern, (signal,)):
                found = limits
        return found

    def check(self, signals: Sequence[str]) -> None:
        """ValueError where a pattern fits none of `signals`."""
        for pattern in self.signals:
            if not matching(pattern, signals):
                raise ValueError(f"tolerances ({self.where}): {unknown('signal', pattern, signals)}")


def read(file: Path) -> Tolerances:
    """The tolerances in a TOML file; ValueError names the file, the key and the rule."""
    where = f"tolerance file {str(file)!r}"
    try:
        document = tomllib.loads(file.read_text(encoding="utf-8"))
    except OSError as error:
        raise ValueError(f"{where} cannot be read: {error.strerror or error}") from None
    except (tomllib.TOMLDecodeError, UnicodeDecodeError) as error:
        raise ValueError(f"{where} must be TOML: {error}") from None
    for key in document:
        if key not in ("signals", "energy"):
            raise ValueError(f"{where}: {unknown('table', key, ('signals', 'energy'))}")
    signals = _table(document, "signals", where)
    energy = _limits(_table(document, "energy", where), {"created": "1"}, f"{where}: energy")
    return Tolerances(
        {name: _limits(_table(signals, name, where), UNITS, f"{where}: {name}") for name in signals}, energy.get("created"), where
    )


def _table(document: dict[str, Any], name: str, where: str) -> dict[str, Any]:
    table = document.get(name, {})
    if not isinstance(table, dict):
        raise ValueError(f"{where}: {name!r} must be a table, got {table!r}")
    return table


def _limits(table: dict[str, Any], units: dict[str, str], where: str) -> dict[str, float]:
    """The limits of one table in SI, each positive."""
    limits = {}
    for key, value in table.items():
        if key not in units:
            raise ValueError(f"{where}: {unknown('limit', key, units)}")
        try:
            limits[key] = quantity(value, units[key]) if isinstance(value, str) else float(value)
        except (TypeError, ValueError) as error:
            raise ValueError(f"{where}: {key} must be a number: {error}") from None
        if not 0.0 <= limits[key] < float("inf"):
            raise ValueError(f"{where}: {key} must not be negative, got {value!r}")
    return limits
