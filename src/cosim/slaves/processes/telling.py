"""What a slave is, as a JSON document that another process or machine tells: nothing in it is believed unchecked."""

import math
from collections.abc import Callable, Mapping
from dataclasses import replace
from types import MappingProxyType
from typing import Any, get_args

import numpy as np

from gyro_cosim.component.units import BASE, Unit

from ..base import Slave, restorable
from ..description import SlaveDescription
from ..signal import Signal, Type, Value
from .protocol import ProtocolError

__all__ = ["carried_values", "described", "introduction", "read_values", "told_notes"]

KINDS = ("input", "output", "parameter", "state")
MOST = 100_000  # signals, and elements of a value
LONGEST_TEXT = 100_000  # characters
MOST_NOTES, LONGEST_NOTE = 20, 2000
_MISSING = object()


def introduction(slave: Slave, values: Mapping[str, Value] = MappingProxyType({})) -> dict[str, Any]:
    """What HELLO is answered with, of a slave that has an initialization mode. values : in the place of its start values."""
    d = slave.description
    starts = {name: float(value) for name, value in values.items() if isinstance(value, int | float)}
    settable = [replace(s, start=starts.get(s.name, s.start)) for s in d.settable.values()]
    return {
        "inputs": [_carried(s) for s in d.inputs], "outputs": [_carried(s) for s in d.outputs],
        "settable": [_carried(s) for s in settable], "feedthrough": d.feedthrough.astype(int).tolist(),
        "initial_feedthrough": d.initial_feedthrough.astype(int).tolist(), "excluded": dict(d.excluded),
        "input_degree": d.input_degree, "can_restore": restorable(slave) is not None, "can_serialize": d.can_serialize,
        "counts_events": d.counts_events, "initialization": True, "tunable": sorted(d.tunable),
        "clock_inputs": list(d.clock_inputs), "clock_outputs": list(d.clock_outputs),
        "clocked": {name: list(clocks) for name, clocks in d.clocked.items()},
        "text_inputs": [_carried(s) for s in d.text_inputs], "text_outputs": [_carried(s) for s in d.text_outputs],
        "variable_steps": d.variable_steps, "fixed_step": d.fixed_step,
    }  # fmt: skip


def described(told: Mapping[str, Any]) -> SlaveDescription:
    """The description in what introduction() has told, or another unit in its own way.

    Raises
    ------
    ProtocolError
        Names the field, the rule and the value.
    """
    inputs, outputs, settable = (_signals(told, field) for field in ("inputs", "outputs", "settable"))
    shape = len(outputs), len(inputs)
    feedthrough = _matrix(told, "feedthrough", shape, None)
    degree = _field(told, "input_degree", "0, 1 or 2", lambda x: type(x) is int and 0 <= x <= 2)
    excluded = _field(told, "excluded", "texts by name", _is_texts, {})
    clocked = _field(told, "clocked", "names of clocks by name", _is_names_by_name, {})
    return SlaveDescription(
        inputs=inputs, outputs=outputs, settable={s.name: s for s in settable}, feedthrough=feedthrough,
        initial_feedthrough=_matrix(told, "initial_feedthrough", shape, feedthrough), excluded=excluded, input_degree=degree,
        can_restore=truth(told, "can_restore", None), can_serialize=truth(told, "can_serialize", False),
        counts_events=truth(told, "counts_events", False), tunable=frozenset(_field(told, "tunable", "names", _is_names, [])),
        clock_inputs=tuple(_field(told, "clock_inputs", "names", _is_names, [])),
        clock_outputs=tuple(_field(told, "clock_outputs", "names", _is_names, [])),
        clocked={name: tuple(clocks) for name, clocks in clocked.items()},
        text_inputs=_signals(told, "text_inputs", []), text_outputs=_signals(told, "text_outputs", []),
        variable_steps=truth(told, "variable_steps", True),
        fixed_step=float(_field(told, "fixed_step", "a number of 0 or more", lambda x: _is_number(x) and x >= 0.0, 0.0)),
    )  # fmt: skip


def truth(told: Mapping[str, Any], field: str, default: bool | None) -> bool:
    """A field that is true or false; one that is missing is `default`, refused where that is None."""
    default_ = _MISSING if default is None else default
    return bool(_field(told, field, "true or false", lambda x: isinstance(x, bool), default_))


def told_notes(told: Mapping[str, Any]) -> tuple[str, ...]:
    """The notes beside an introduction; ProtocolError where they are no list of texts."""
    notes = _field(told, "notes", "a list of texts", lambda x: isinstance(x, list) and all(isinstance(n, str) for n in x))
    return tuple(note[:LONGEST_NOTE] for note in notes[:MOST_NOTES])


def carried_values(values: Mapping[str, Value]) -> dict[str, Any]:
    """Start values for JSON: bytes as hexadecimal digits in an object of their own."""
    return {name: [_scalar(v) for v in value] if isinstance(value, tuple) else _scalar(value) for name, value in values.items()}


def read_values(told: Any) -> dict[str, Value]:
    """The start values in what carried_values() gave; ProtocolError names the one that is none."""
    if not isinstance(told, dict):
        raise ProtocolError(f"values must be an object, got {_short(told)}")
    values: dict[str, Value] = {}
    for name, value in told.items():
        if isinstance(value, list) and len(value) > MOST:
            raise ProtocolError(f"value {name!r} must have at most {MOST} elements, has {len(value)}")
        values[name] = tuple(_read(name, v) for v in value) if isinstance(value, list) else _read(name, value)
    return values


def number(told: Mapping[str, Any], field: str) -> float:
    """A field that must be a finite number."""
    return float(_field(told, field, "a finite number", _is_number))


def _scalar(value: Any) -> Any:
    return {"hex": value.hex()} if isinstance(value, bytes) else value


def _read(name: str, value: Any) -> float | str | bytes:
    if isinstance(value, str) and len(value) <= LONGEST_TEXT:
        return value
    if _is_number(value):
        return float(value)
    if isinstance(value, dict) and list(value) == ["hex"] and isinstance(value["hex"], str):
        try:
            return bytes.fromhex(value["hex"])
        except ValueError:
            pass
    raise ProtocolError(f"value {name!r} must be a finite number, text or hexadecimal digits, got {_short(value)}")


def _is_number(value: Any) -> bool:
    try:
        return isinstance(value, int | float) and not isinstance(value, bool) and math.isfinite(value)
    except OverflowError:  # a whole number beyond all floats
        return False


def _is_texts(value: Any) -> bool:
    return isinstance(value, dict) and all(isinstance(text, str) for text in value.values()) and len(value) <= MOST


def _is_names(value: Any) -> bool:
    return isinstance(value, list) and len(value) <= MOST and all(isinstance(name, str) for name in value)


def _is_names_by_name(value: Any) -> bool:
    return isinstance(value, dict) and len(value) <= MOST and all(map(_is_names, value.values()))


def _short(value: Any) -> str:
    text = repr(value)
    return text if len(text) <= 60 else f"{text[:57]}..."


def _field(told: Mapping[str, Any], field: str, rule: str, holds: Callable[[Any], bool], default: Any = _MISSING) -> Any:
    value = told.get(field, default)
    if value is _MISSING:
        raise ProtocolError(f"{field} must be there")
    if not holds(value):
        raise ProtocolError(f"{field} must be {rule}, got {_short(value)}")
    return value


def _carried(signal: Signal) -> dict[str, Any]:
    """A signal as HELLO tells it; what is usual is left out."""
    unit = signal.definition
    full = {
        "name": signal.name, "kind": signal.kind, "unit": signal.unit, "start": signal.start, "min": signal.min,
        "max": signal.max, "meaning": signal.meaning, "smooth": signal.smooth, "type": signal.type,
        "definition": None if unit is None else [unit.name, unit.factor, list(unit.dimension), unit.offset],
        "items": [list(item) for item in signal.items], "shape": list(signal.shape),
        "display": signal.display, "nominal": signal.nominal,
    }  # fmt: skip
    return {name: value for name, value in full.items() if value not in (None, [], "") or name in ("name", "kind", "unit")}


def _signals(told: Mapping[str, Any], field: str, default: Any = _MISSING) -> tuple[Signal, ...]:
    rows = _field(told, field, "a list of signals", lambda x: isinstance(x, list) and len(x) <= MOST, default)
    signals = tuple(_signal(field, row) for row in rows)
    if len({s.name for s in signals}) < len(signals):
        raise ProtocolError(f"{field} must have names of their own")
    return signals


def _signal(where: str, row: Any) -> Signal:
    if not isinstance(row, dict):
        raise ProtocolError(f"{where} must hold objects, got {_short(row)}")

    def text(field: str, default: Any = "") -> str:
        known = _field(row, field, "a text", lambda x: isinstance(x, str) and len(x) <= LONGEST_TEXT, default)
        return str(known)

    def bound(field: str) -> float | None:
        value = _field(row, field, "a number", lambda x: x is None or _is_limit(x), None)
        return None if value is None else float(value)

    definition = _field(row, "definition", "name, factor, dimension, offset", _is_definition, None)
    items = _field(row, "items", "pairs of a name and a number", _is_items, [])
    return Signal(
        text("name", _MISSING), _field(row, "kind", f"one of {', '.join(KINDS)}", lambda x: x in KINDS), text("unit"),
        bound("start"), bound("min"), bound("max"), text("meaning"), truth(row, "smooth", True),
        _field(row, "type", f"one of {', '.join(get_args(Type))}", lambda x: x in get_args(Type), "real"),
        None if definition is None else Unit(definition[0], definition[1], tuple(definition[2]), definition[3]),
        tuple((name, k) for name, k in items), tuple(_field(row, "shape", "whole numbers", _is_shape, [])),
        text("display"), bound("nominal"),
    )  # fmt: skip


def _is_limit(value: Any) -> bool:
    return _is_number(value) or (isinstance(value, float) and math.isinf(value))


def _is_items(value: Any) -> bool:
    return isinstance(value, list) and all(
        isinstance(i, list) and len(i) == 2 and isinstance(i[0], str) and type(i[1]) is int for i in value
    )


def _is_shape(value: Any) -> bool:
    whole = isinstance(value, list) and len(value) <= 8 and all(type(n) is int and 0 <= n <= MOST for n in value)
    return whole and math.prod(value) <= MOST * 10


def _is_definition(value: Any) -> bool:
    if value is None:
        return True
    if not isinstance(value, list) or len(value) != 4:
        return False
    name, factor, dimension, offset = value
    exponents = isinstance(dimension, list) and len(dimension) == len(BASE) and all(type(n) is int for n in dimension)
    return isinstance(name, str) and _is_number(factor) and factor != 0 and exponents and _is_number(offset)


def _matrix(told: Mapping[str, Any], field: str, shape: tuple[int, int], default: np.ndarray | None) -> np.ndarray:
    if default is not None and field not in told:
        return default
    n_y, n_u = shape
    rule = f"{n_y} rows of {n_u} times 0 or 1"

    def holds(rows: Any) -> bool:
        if not isinstance(rows, list) or len(rows) != n_y:
            return False
        return all(isinstance(row, list) and len(row) == n_u and all(x in (0, 1) for x in row) for row in rows)

    return np.array(_field(told, field, rule, holds), dtype=bool).reshape(shape)
