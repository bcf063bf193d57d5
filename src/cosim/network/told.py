"""What a run tells before it begins: of values that nothing takes, and of numbers that look as if another unit was meant."""

from collections.abc import Sequence

from ..errors import nearest
from ..slaves import Slave
from ..slaves.signal import told_unit
from ..systems import System

LISTED = 8  # names that a note shows


def unused_values(system: System, slaves: Sequence[Slave]) -> list[str]:
    """Of each component the values of parameter files for which it has no variable, in words."""
    notes = []
    for part, slave in zip(system.components, slaves, strict=True):
        names = [name for name in part.bound if name not in slave.description.settable]
        if names:
            more = f" and {len(names) - LISTED} more" if len(names) > LISTED else ""
            near = nearest(names[0], slave.description.settable)
            shown = ", ".join(names[:LISTED])
            notes.append(f"not used, for {part.name!r} has nothing to be set by that name: {shown}{more}{near}")
    return notes


def bare_numbers(system: System, slaves: Sequence[Slave]) -> list[str]:
    """Of each component the numbers that were given without a unit and look as if another one was meant, in words."""
    notes = []
    for part, slave in zip(system.components, slaves, strict=True):
        for name, given in part.values.items():
            signal = slave.description.settable.get(name)
            told = told_unit(signal, given) if signal is not None else ""
            if told and signal is not None:
                notes.append(f"{part.name}.{name}={given}: {told} (a number without a unit is in {signal.unit})")
    return notes


def notes_of(system: System, slaves: Sequence[Slave]) -> tuple[str, ...]:
    """All that is to be told: the system's own notes first."""
    return (*system.notes, *unused_values(system, slaves), *bare_numbers(system, slaves))
