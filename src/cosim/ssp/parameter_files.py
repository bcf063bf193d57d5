"""Parameter files: a .toml file or a parameter set of SSP (.ssv), read for a system and written for people to edit.

A .toml file has a table for each component, as System.addressed() takes its name; a file for a single component has none:

    [vehicle]
    speed = "10 m/s"

    [gyro]
    rotor_speed = "200 rpm"
"""

import datetime
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any

from ..errors import nearest
from ..systems import System
from ..systems.scenario import read_toml
from .documents import load, value_of
from .rules import NAMESPACES

ENDINGS = (".toml", ".ssv")


def read_parameters(file: Path, system: System) -> list[tuple[str, Any]]:
    """What a parameter file sets in a system.

    Parameters
    ----------
    file : Path
        A .toml or .ssv file.
    system : System
        Its components are named in the file; where there is one component only, names of parameters may stand alone.

    Returns
    -------
    list of (str, value)
        `component.parameter` and its value, as System.with_value() takes them. The parameters are looked up when the system
        is opened.

    Raises
    ------
    ValueError
        Names file, key and rule.
    """
    if file.suffix not in ENDINGS:
        raise ValueError(f"parameter file must end in {' or '.join(ENDINGS)}, got {str(file)!r}")
    pairs = _toml(file) if file.suffix == ".toml" else _ssv(file)
    names = [component.name for component in system.components]
    starts = {name.split("_")[0] for name in names if "_" in name}
    found = []
    for key, value in pairs:
        target = key
        owner = system.owner(key) or key.partition(".")[0]
        there = owner in names or any(name.startswith(f"{owner}_") for name in names)
        if not (there and key[len(owner) + 1 :]):
            if len(names) != 1:
                hint = nearest(owner, [*names, *starts])
                rule = f"names must be COMPONENT.PARAMETER with a component of {system.name!r}"
                raise ValueError(f"parameter file {str(file)!r}: {rule}, got {key!r}{hint}")
            target = f"{names[0]}.{key}"
        found.append((target, value))
    return found


def _toml(file: Path) -> Iterator[tuple[str, Any]]:
    document = read_toml(file, f"parameter file {str(file)!r}")
    yield from _flat(file, document, "")


def _flat(file: Path, table: Mapping[str, Any], before: str) -> Iterator[tuple[str, Any]]:
    """Dotted names and values of a table and those in it."""
    for key, value in table.items():
        name = f"{before}{key}"
        if isinstance(value, dict):
            yield from _flat(file, value, f"{name}.")
            continue
        elements = value if isinstance(value, list) else [value]
        if not elements or any(isinstance(e, list | dict | datetime.date | datetime.time) for e in elements):
            raise ValueError(f"parameter file {str(file)!r}: {name} must be a number, text, truth value or a list of them")
        given = ["true" if e is True else "false" if e is False else e for e in elements]
        yield name, tuple(given) if isinstance(value, list) else given[0]


def _ssv(file: Path) -> Iterator[tuple[str, Any]]:
    found = load(str(file), "ssv", "ParameterSet", [])
    for parameter in found.root.iterfind("ssv:Parameters/ssv:Parameter", NAMESPACES):
        yield found.attribute(parameter, "name"), value_of(found, parameter)
