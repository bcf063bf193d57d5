"""A part of a system in another's place: which signals it takes over, and which values were meant for the old one."""

import re
from collections.abc import Collection, Iterable, Mapping
from dataclasses import replace
from typing import Any

from ..errors import unknown
from . import catalogue
from .elements import Connection, PowerBond, StopWhen, SystemComponent
from .quantities import Quantity

_NAME = re.compile(r"[A-Za-z_][\w.]*(\[[\d,]+\])?")


def package(source: str) -> str:
    """What a source is a variant of: "vehicle" for "vehicle:lrt", "vehicle.lrt.fmu", a vehicle file; another is itself."""
    if source.endswith(".fmu"):
        spec = catalogue.spec_of_fmu(source.replace("\\", "/").replace("#", "/").rpartition("/")[2])
        return source if spec is None else spec.partition(":")[0]
    if source.endswith(".toml"):
        return catalogue.described_by(source) or source
    return source if ".py" in source else source.partition(":")[0]


def dropped(parts: Iterable[SystemComponent], source: str) -> list[str]:
    """What is to be told where `source` takes the place of `parts`, and values that were bound for these do not fit it."""
    notes = []
    for part in parts:
        if part.bound and package(part.source) != package(source):
            values = ", ".join(f"{name} = {_shown(value)}" for name, value in part.bound.items())
            notes.append(f"{part.name} is {source} now: what the system had bound for {part.source} is dropped: {values}")
    return notes


def _shown(value: Any) -> str:
    if isinstance(value, Quantity):
        return f"{value.value:g}" + (f" {value.unit.name}" if value.unit is not None else "")
    return " ".join(map(_shown, value)) if isinstance(value, tuple) else f"{value:g}" if isinstance(value, float) else str(value)


def joined_signals(names: Collection[str], connections: Iterable[Connection], stops: Iterable[StopWhen]) -> set[str]:
    """The signals of components that the system uses: in connections, and in what ends a run."""
    ends = [end for wire in connections for end in (wire.start, wire.end)] + [stop.signal for stop in stops]
    return {variable for component, variable in ends if component in names}


def told_apart(pairs: Iterable[str], signals: Collection[str]) -> tuple[dict[str, str], list[str]]:
    """The words behind a source: renamings FOREIGN=OURS, where OURS is a signal that the system uses, and values.

    Raises
    ------
    ValueError
        Where a value reads like the misspelt name of a signal.
    """
    renamed, values = {}, []
    for pair in pairs:
        name, equals, word = (text.strip() for text in pair.partition("="))
        if equals and word in signals:
            renamed[name] = word
        elif equals and _NAME.fullmatch(word) and "did you mean" in str(unknown("", word, signals)):
            raise unknown("signal, in the place of which another is meant,", word, signals)
        else:
            values.append(pair)
    return renamed, values


def check_renaming(name: str, renamed: Mapping[str, str], signals: Collection[str]) -> None:
    """ValueError unless each of `renamed`, FOREIGN -> OURS, stands for another signal that the system uses of `name`."""
    for foreign, ours in renamed.items():
        if ours in signals:
            continue
        if foreign in signals:
            raise ValueError(f"a renaming is FOREIGN=OURS, the part's own name first, got {foreign}={ours} of {name!r}")
        raise unknown(f"signal of {name!r} that the system uses:", ours, signals)
    for ours in renamed.values():
        if list(renamed.values()).count(ours) > 1:
            raise ValueError(f"signal {ours!r} of {name!r} must be renamed once, got it twice")


def renaming(
    names: Collection[str], renamed: Mapping[str, str], connections: Iterable[Connection], bonds: Iterable[PowerBond],
    stops: Iterable[StopWhen],
) -> tuple[tuple[Connection, ...], tuple[PowerBond, ...], tuple[StopWhen, ...]]:  # fmt: skip
    """Connections, bonds and stops with the signals of components called as `renamed`, FOREIGN -> OURS, says."""
    foreign = {ours: theirs for theirs, ours in renamed.items()}

    def new(end: tuple[str, str]) -> tuple[str, str]:
        return (end[0], foreign.get(end[1], end[1])) if end[0] in names else end

    return (
        tuple(replace(wire, start=new(wire.start), end=new(wire.end)) for wire in connections),
        tuple(PowerBond(new(bond.motion), new(bond.effort)) for bond in bonds),
        tuple(replace(stop, signal=new(stop.signal)) for stop in stops),
    )
