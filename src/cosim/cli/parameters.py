"""cosim params: the parameters of a system, a component or an FMU, as a table or as a file to edit."""

import json
import re
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, Any

import typer
from rich.table import Table

from ..slaves import Signal
from ..slaves.described import described_slave
from ..systems import System, catalogue
from .alone import single
from .common import AsJson, Gyro, Parameters, Swaps, Values, Vehicle, chosen_system, is_system, say, writable


@dataclass(frozen=True)
class Row:
    """A value that can be set.

    Parameters
    ----------
    component, name : str
        Of which component; empty where it is the only one.
    signal : Signal
        Kind, unit, bounds and meaning.
    value : number, str or tuple
        What it has now, in its unit; None where that is not stated.
    given : bool
        Whether the system or the user has set it.
    source : str
        Where the component's value comes from, as its author states it.
    """

    component: str
    name: str
    signal: Signal
    value: Any
    given: bool
    source: str

    @property
    def label(self) -> str:
        """As --set takes it."""
        return f"{self.component}.{self.name}" if self.component else self.name


def command(
    name: Annotated[
        str,
        typer.Argument(
            metavar="SOURCE", help="a system, a component such as vehicle:lrt, an .fmu, a .py or a vehicle's .toml file"
        ),
    ],
    vehicle: Vehicle = None,
    gyro: Gyro = None,
    swap: Swaps = None,
    set_: Values = None,
    params: Parameters = None,
    every: Annotated[bool, typer.Option("--all", help="start values of states and inputs too")] = False,
    toml: Annotated[Path | None, typer.Option(metavar="FILE", help="write a file to edit, for --params elsewhere")] = None,
    as_json: AsJson = False,
) -> int:
    """Print every parameter of SOURCE: value, unit, bounds, where the value comes from, what it is.

    --toml FILE writes them into a file; edit it and give it to run, compare, converge, sweep, delay or pack as --params FILE.
    """
    if is_system(name):
        plan, alone = chosen_system(name, gyro, set_, vehicle=vehicle, swaps=swap, params=params), False
    else:
        plan, alone = chosen_system(single(name), gyro, set_, vehicle=vehicle, swaps=swap, params=params), True
    writable(toml, lambda file: _check_ending(file))
    found = rows(plan, alone=alone)
    if toml is not None:
        toml.write_text(toml_text(plan, found), encoding="utf-8")
    shown = [row for row in found if every or row.signal.kind == "parameter" or row.given]
    left = len(found) - len(shown)
    words = [f"and {left} start values of states and inputs; --all shows them"] if left else []
    say(as_json, lambda: document(plan, shown), _table(shown), *words, *([f"wrote {toml}"] if toml else []))
    return 0


def _check_ending(file: Path) -> None:
    if file.suffix != ".toml":
        raise ValueError(f"--toml must name a file that ends in .toml, got {str(file)!r}")


def rows(plan: System, *, alone: bool = False) -> list[Row]:
    """Everything that can be set in a system, parameters first; arrays as a whole."""
    found = []
    for part in plan.components:
        settable = described_slave(part.name, part.source, part.implementation, part.given).description.settable
        arrays = {name for name, signal in settable.items() if signal.shape}
        sources = _sources(part.source)
        given = {**{n: v for n, v in part.bound.items() if n in settable}, **part.values}
        for name, signal in settable.items():
            if name.endswith("]") and name[: name.rindex("[")] in arrays:
                continue
            value = signal.value(given[name]) if name in given else _own(settable, name)
            found.append(Row("" if alone else part.name, name, signal, value, name in given, sources.get(name, "")))
        for name in part.values:
            if name not in settable:
                described_slave(part.name, part.source, part.implementation, part.given).description.start_values(
                    part.name, part.values
                )
    return sorted(found, key=lambda row: row.signal.kind != "parameter")


def _own(settable: Any, name: str) -> Any:
    """The component's own value; of an array those of its elements."""
    signal = settable[name]
    if not signal.shape:
        return signal.start
    elements = [s.start for n, s in settable.items() if n.startswith(f"{name}[")]
    return tuple(elements) if elements and None not in elements else None


def _sources(source: str) -> dict[str, str]:
    """Where each value of a component of the catalogue comes from, or in which range it is assumed."""
    if source.endswith(".fmu"):
        return {}
    made = catalogue.component(source)
    variables = (*made.variables, *made.integration_parameters)
    ranges = {v.name: f"assumed, {v.assumed[0]:g} to {v.assumed[1]:g}" for v in variables if v.assumed is not None}
    return {v.name: ", ".join(filter(None, (v.source, ranges.get(v.name, "")))) for v in variables}


def document(plan: System, found: Sequence[Row]) -> dict[str, Any]:
    """The table as JSON holds it."""
    return {
        "system": plan.name,
        "notes": list(plan.notes),
        "parameters": [
            {
                "name": row.label, "kind": row.signal.kind, "type": row.signal.type, "value": _plain(row.value),
                "given": row.given, "unit": row.signal.unit, "min": row.signal.min, "max": row.signal.max,
                "source": row.source, "meaning": row.signal.meaning,
            }
            for row in found
        ],
    }  # fmt: skip


def _plain(value: Any) -> Any:
    return list(map(_plain, value)) if isinstance(value, tuple) else value.hex() if isinstance(value, bytes) else value


def _table(found: Sequence[Row]) -> Table:
    table = Table("name", "value", "unit", "bounds", "source", "meaning", box=None, pad_edge=False)
    table.columns[0].overflow = "fold"
    table.columns[1].justify = "right"
    for row in found:
        unit = "" if row.signal.unit == "1" else row.signal.unit
        mark = "*" if row.given else ""
        table.add_row(row.label, mark + _shown(row.value), unit, bounds(row.signal), row.source, row.signal.meaning)
    if any(row.given for row in found):
        table.caption, table.caption_justify = "* set by the system or by you", "left"
    return table


def _shown(value: Any) -> str:
    if value is None:
        return ""
    if isinstance(value, tuple):
        text = " ".join(map(_shown, value))
        return text if len(text) <= 24 else f"{text[:21]}..."
    return f"{value:.6g}" if isinstance(value, float) else str(_plain(value))


def bounds(signal: Signal) -> str:
    """The range of a signal in words; empty where it has none."""
    low, high = signal.min, signal.max
    if low is None and high is None:
        return ""
    return f"at most {high:g}" if low is None else f"at least {low:g}" if high is None else f"{low:g} to {high:g}"


def toml_text(plan: System, found: Sequence[Row]) -> str:
    """A parameter file with every parameter, and with start values of states and inputs as remarks.

    A number in a unit is written as text with it, so that it can be changed to another unit.
    """
    lines = [
        f"# Parameters of {plan.name}, to be read by --params. Change numbers and units; lines that begin with # do nothing."
    ]
    component: str | None = None if any(row.component for row in found) else ""
    for row in sorted(found, key=lambda row: row.component):
        if row.component != component:
            component = row.component
            lines += ["", f"[{_key(component)}]"]
        if row.value is None or (isinstance(row.value, bytes) and not row.value):
            continue
        more = "; ".join(filter(None, (bounds(row.signal), row.source, row.signal.meaning)))
        active = "" if row.signal.kind == "parameter" or row.given else "# "
        lines.append(
            f"{active}{_key(row.name)} = {_toml_value(row.signal, row.value)}" + (f"  # {' '.join(more.split())}" if more else "")
        )
    return "\n".join(lines) + "\n"


def _key(name: str) -> str:
    return name if re.fullmatch(r"[A-Za-z0-9_-]+", name) else json.dumps(name, ensure_ascii=False)


def _toml_value(signal: Signal, value: Any) -> str:
    if isinstance(value, tuple):
        return f"[{', '.join(_toml_value(signal, element) for element in value)}]"
    if isinstance(value, bytes):
        return json.dumps(value.hex())
    if isinstance(value, str):
        return json.dumps(value, ensure_ascii=False).replace("\x7f", "\\u007f")
    if signal.type == "boolean":
        return str(bool(value)).lower()
    if signal.type != "real":
        return str(int(value))
    unit = "" if signal.unit == "1" or re.search(r"\s", signal.unit) else signal.unit
    return json.dumps(f"{value!r} {unit}", ensure_ascii=False) if unit else repr(float(value))
