"""Structural parameters of FMI 3.0: given before a component is opened, since the sizes of its arrays depend on them."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from itertools import product
from math import prod
from typing import Any

from ..signal import Given, Value
from .description import Description
from .library import POINTER, Library
from .rows import LARGEST, Row
from .signals import signal_of

STRUCTURAL = "structuralParameter"


def structural(model: Description, component: str, given: Mapping[str, Given]) -> dict[str, float]:
    """The values of structural parameters among those given to a component; ValueError names one that does not fit."""
    values = {}
    for row in model.rows:
        if row.causality == STRUCTURAL and row.name in given and row.settable:
            try:
                values[row.name] = float(signal_of(row).value(given[row.name]))  # type: ignore[arg-type]
            except ValueError as error:
                raise ValueError(f"{component}.{row.name}: {error}") from None
    return values


def configured(model: Description, component: str, given: Mapping[str, Given]) -> Description:
    """The description as it is after configuration mode: start values of structural parameters, sizes and starts of arrays.

    An array that shrinks keeps the start values that are left. One that grows has none, but an input, whose new elements begin
    at 0, or all of them where they were alike.
    """
    values = structural(model, component, given)
    if not values:
        return model
    sizes = {row.reference: int(values[row.name]) for row in model.rows if row.name in values}
    return replace(model, rows=tuple(_resized(row, values, sizes) for row in model.rows))


def _resized(row: Row, values: Mapping[str, float], sizes: Mapping[int, int]) -> Row:
    if row.name in values and row.causality == STRUCTURAL:
        return replace(row, start=(str(int(values[row.name])),))
    shape = tuple(n if by is None else sizes.get(by, n) for n, by in zip(row.shape, row.sized_by, strict=True))
    if shape == row.shape:
        return row
    if prod(shape) > LARGEST:
        raise ValueError(f"variable {row.name!r} must have at most {LARGEST} elements, has {prod(shape)}")
    before = dict(zip(product(*map(range, row.shape)), row.start, strict=False))
    alike = set(row.start)
    fill = alike.pop() if len(alike) == 1 else "0" if row.causality == "input" and row.start else None
    start = [before.get(place, fill) for place in product(*map(range, shape))]
    return replace(row, shape=shape, start=() if None in start or not row.start else tuple(str(text) for text in start))


def refuse_other_sizes(component: str, rows: Sequence[tuple[Row, list[Value]]]) -> None:
    """ValueError where a structural parameter is given another value at the start than its arrays were made for."""
    for row, values in rows:
        if values != [float(row.start[0])]:
            what = f"structural parameter {component}.{row.name} must be given before the FMU is opened"
            raise ValueError(f"{what}: it is {row.start[0]} there, not {values[0]!r}")


def in_configuration_mode(
    library: Library, instance: Any, check: Callable[[int, str, float, float], None], t: float, change: Callable[[], None]
) -> None:
    """Do what `change` does there; `check` raises for a bad status."""
    for name in ("fmi3EnterConfigurationMode", "fmi3ExitConfigurationMode"):
        check(library.function(name, POINTER)(instance), name, t, 0.0)
        if name == "fmi3EnterConfigurationMode":
            change()
