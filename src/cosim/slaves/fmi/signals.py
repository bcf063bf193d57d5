"""From an FMU's description to the signals that the master sees."""

from collections.abc import Iterator, Mapping, Set
from itertools import product
from typing import Any

import numpy as np

from ..description import SlaveDescription
from ..signal import Signal, Type, Value
from .clocks import announced, clocked, is_given, time_based, triggered
from .description import Description
from .events import ticks, used
from .intermediate_update import asked_for
from .rows import REAL, TEXTS, Row

SHORTEST = 1e-12  # s, interval of a clock that may be given
_KINDS: dict[str, Type] = {"Boolean": "boolean", "String": "string", "Binary": "binary", "Enumeration": "enumeration"}


def carried(description: Description, causality: str) -> list[Row]:
    """The inputs or outputs that are numbers."""
    return [row for row in description.rows if row.causality == causality and row.type not in (*TEXTS, "Clock")]


def texts(description: Description, causality: str) -> list[Row]:
    """The inputs or outputs that are strings or binaries."""
    return [row for row in description.rows if row.causality == causality and row.type in TEXTS]


def described(description: Description) -> SlaveDescription:
    """The FMU as a slave; an array is one signal per element, and one more among what can be set."""
    inputs, outputs = carried(description, "input"), carried(description, "output")
    settable = {}
    for row in description.rows:
        if row.settable:
            kind = _kind(row)
            settable[row.name] = signal_of(row)
            if row.shape:
                settable |= {s.name: s for s in _elements(row, kind)}
    ticking = ticks(description)
    clock_inputs, clock_outputs = (tuple(r.name for r in rows) for rows in (triggered(description), announced(description)))
    if ticking:
        settable |= {row.name: _interval(row) for row in time_based(description) if is_given(row)}
    own = dict.fromkeys((r.name for r in time_based(description)), "Clock with an interval of its own")
    silent = {} if ticking else dict.fromkeys((*own, *clock_inputs, *clock_outputs), "Clock of an FMU without event mode")
    by_clock = clocked(description) if ticking else {}
    follows = description.can("canInterpolateInputs") if description.version != "3" else bool(asked_for(description))
    restores, serializes = (
        description.can(f"can{verb}FMUstate") or description.can(f"can{verb}FMUState") for verb in ("GetAndSet", "Serialize")
    )
    return SlaveDescription(
        inputs=tuple(s for row in inputs for s in _elements(row, "input")),
        outputs=tuple(s for row in outputs for s in _elements(row, "output")),
        settable=settable,
        feedthrough=_feedthrough(description.dependencies, inputs, outputs, by_clock.keys()),
        initial_feedthrough=_feedthrough(
            {row.name: _at_start(description, row) for row in outputs}, inputs, outputs, by_clock.keys()
        ),
        excluded={**own, **silent},
        input_degree=2 if follows else 0,
        can_restore=restores,
        can_serialize=restores and serializes,
        counts_events=description.version == "3" and used(description),
        clock_inputs=clock_inputs if ticking else (),
        clock_outputs=(*clock_outputs, *own) if ticking else (),
        clocked={name: by_clock[row.name] for row in description.rows if row.name in by_clock for name in names(row)},
        tunable=frozenset(n for row in description.rows if _is_tunable(row) for n in names(row) if n in settable),
        text_inputs=tuple(s for row in texts(description, "input") for s in _elements(row, "input")),
        text_outputs=tuple(s for row in texts(description, "output") for s in _elements(row, "output")),
        variable_steps="CoSimulation" not in description.interfaces or description.can("canHandleVariableCommunicationStepSize"),
        fixed_step=float(description.interfaces.get("CoSimulation", {}).get("fixedInternalStepSize", 0.0)),
    )


def _is_tunable(row: Row) -> bool:
    if is_given(row):
        return row.timing["intervalVariability"] == "tunable"
    return row.causality == "parameter" and row.variability == "tunable" and row.type not in (*TEXTS, "Clock")


def _at_start(description: Description, row: Row) -> tuple[str, ...] | None:
    """What an output depends on in initialization mode; where the description does not list it there, as at other times."""
    if row.name in description.initial:
        return description.initial[row.name]
    return () if row.initial == "exact" else description.dependencies.get(row.name)


def _feedthrough(
    stated_of: Mapping[str, tuple[str, ...] | None], inputs: list[Row], outputs: list[Row], by_clock: Set[str]
) -> np.ndarray:
    """Which element of an output depends on which of an input; none on those that are set where a clock ticks alone."""
    place, n_u = {}, 0
    for row in inputs:
        place[row.name] = slice(n_u, n_u + row.size)
        n_u += row.size
    matrix = np.zeros((sum(row.size for row in outputs), n_u), dtype=bool)
    i = 0
    for row in outputs:
        stated = stated_of.get(row.name)
        if stated is None:
            matrix[i : i + row.size] = True  # the standard: not stated means on everything
        for known in stated or ():
            if known in place:
                matrix[i : i + row.size, place[known]] = True
        i += row.size
    for name in place.keys() & by_clock:
        matrix[:, place[name]] = False
    return matrix


def _kind(row: Row) -> Any:
    """What a variable that can be set is to the master."""
    return {"structuralParameter": "parameter", "parameter": "parameter", "input": "input"}.get(row.causality, "state")


def signal_of(row: Row) -> Signal:
    """A variable that can be set, as a whole."""
    return _signal(row, _kind(row), row.name, 0 if not row.shape else None)


def _signal(row: Row, kind: Any, name: str, element: int | None) -> Signal:
    """The signal of a variable, or of one of its elements."""
    type_: Type = "real" if row.type in REAL else _KINDS.get(row.type, "integer")
    start = None if element is None or not row.start or type_ in ("string", "binary") else float(read(row, row.start[element]))
    smooth = type_ == "real" and row.variability == "continuous" and not row.clocks
    low, high = row.min, row.max
    if type_ == "integer":
        bits = np.iinfo(row.type.lower() if row.type != "Integer" else "int32")
        low, high = float(bits.min) if low is None else low, float(bits.max) if high is None else high
    return Signal(
        name, kind, row.unit, start, low, high, row.description, smooth, type_, row.definition, row.items,
        row.shape if element is None else (), row.display, row.nominal,
    )  # fmt: skip


def _interval(row: Row) -> Signal:
    """What a clock's interval is to the master: a parameter called as the clock is."""
    start = float(row.timing["intervalDecimal"])
    return Signal(row.name, "parameter", "s", start, SHORTEST, None, row.description or "interval of the clock")


def _elements(row: Row, kind: Any) -> list[Signal]:
    """The scalar signals of a variable: itself, or its elements, named `name[1]`, `name[1,2]`, the last index fastest."""
    return [_signal(row, kind, name, i) for i, name in enumerate(names(row))]


def names(row: Row) -> list[str]:
    if not row.shape:
        return [row.name]
    return [f"{row.name}[{','.join(map(str, index))}]" for index in product(*(range(1, n + 1) for n in row.shape))]


def by_variable(rows: Mapping[str, Row], values: Mapping[str, Value]) -> Iterator[tuple[Row, list[Value]]]:
    """Variables with the values of all their elements, from values for them as a whole and for single elements."""
    whole: dict[str, list[Value]] = {}
    for name, value in values.items():
        if name in rows:
            whole[name] = list(value) if isinstance(value, tuple) else [value]
    for name, value in values.items():
        if name not in rows:
            row = rows[name[: name.rindex("[")]]
            if row.name not in whole and any(row.sized_by) and not row.start:
                raise ValueError(f"{row.name} must be given as a whole, since its size is not that of its start values")
            elements = whole.setdefault(row.name, [read(row, text) for text in row.start] or [0.0] * row.size)
            elements[names(row).index(name)] = value
    return ((rows[name], elements) for name, elements in whole.items())


def read(row: Row, text: str) -> Any:
    """A start value as the description writes it."""
    if row.type == "String":
        return text
    if row.type == "Binary":
        return bytes.fromhex(text)
    return float({"true": 1.0, "false": 0.0}.get(text, text))
