"""A component or an FMU by itself, and the values that --set and --params give it: for check, export, modes, params, serve."""

import re
from collections.abc import Sequence
from pathlib import Path

from ..slaves.described import described_slave
from ..slaves.signal import Value
from ..systems import System, SystemComponent, catalogue
from .settings import applied

__all__ = ["given_alone", "single"]


def single(source: str) -> System:
    """A component or an FMU as a system of its own, called by its package or file."""
    spec = source if source.endswith(".fmu") else catalogue.resolve(source)
    file = spec.rpartition(":")[0] if ".py:" in spec else spec
    name = catalogue.described_by(spec) or (Path(file).stem if file.endswith((".fmu", ".py")) else spec.partition(":")[0])
    return System(spec, (SystemComponent(re.sub(r"\W", "_", name), spec),), ())


def given_alone(source: str, texts: Sequence[str] | None, params: Path | None) -> dict[str, Value]:
    """What --set and --params give the component or FMU `source`, by name and in its own units.

    Raises
    ------
    ValueError
        For a name that it does not have, a value out of bounds or of another unit, or another variant in its place.
    """
    if not texts and params is None:
        return {}
    if Path(source).is_file() and Path(source).suffix not in (".fmu", ".py", ".toml"):
        raise ValueError(f"{source} must end in .fmu, .py or .toml to be given values by --set and --params")
    plan = single(source)
    (part,) = applied(plan, None, texts, params=params).components
    if part.source != plan.components[0].source:
        raise ValueError(f"--set must give {source} values here, not exchange it for {part.source}")
    described = described_slave(part.name, part.source, part.implementation, part.given).description
    return described.start_values(part.name, part.values, part.bound)
