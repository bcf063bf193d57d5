"""A vehicle file that says only in what it differs from another one: `extends` in its table [vehicle].

Tables are merged key by key, at any depth; what is no table is replaced, lists too. Of [wheels] and [rails], which hold one
profile, a profile of another name takes the place of the one before.
"""

import re
import tomllib
from collections.abc import Mapping
from importlib.resources import files
from pathlib import Path
from typing import Any

__all__ = ["document", "extended"]

LIBRARY = "vehicle:"
DEEPEST = 8
ONE_OF = ("wheels", "rails")


def document(text: str, file: str) -> dict[str, Any]:
    """The tables of a text, called `file` in messages; ValueError in one line."""
    try:
        return tomllib.loads(text)
    except tomllib.TOMLDecodeError as error:
        raise ValueError(f"{file}: must be TOML: {error}") from None
    except RecursionError:
        raise ValueError(f"{file}: must be TOML that is nested less deeply") from None


def extended(data: dict[str, Any], file: str, folder: Path, depth: int = 0) -> dict[str, Any]:
    """A document with what it takes over from the one it extends, and so on.

    Parameters
    ----------
    data : dict
        The document.
    file : str
        What it is called, for messages.
    folder : Path
        Where the file that it extends is looked for.
    depth : int
        How many files extend this one.

    Raises
    ------
    ValueError
        Where there is no such file, or files extend one another in a circle.
    """
    head = data.get("vehicle")
    if not isinstance(head, dict) or "extends" not in head:
        return data
    name = head["extends"]
    if depth >= DEEPEST:
        raise ValueError(f"{file}: vehicle.extends must lead to a file that extends none, within {DEEPEST} files, got {name!r}")
    base = extended(document(_text(name, file, folder), str(name)), str(name), folder, depth + 1)
    own = {**data, "vehicle": {key: value for key, value in head.items() if key != "extends"}}
    whole = _merged(base, own)
    for kind in ONE_OF:
        if isinstance(own.get(kind), dict) and isinstance(base.get(kind), dict) and own[kind].keys().isdisjoint(base[kind]):
            whole[kind] = own[kind]
    return whole


def _text(name: Any, file: str, folder: Path) -> str:
    known = files(__package__.rpartition(".")[0]).joinpath("library")
    if isinstance(name, str) and name.startswith(LIBRARY):
        here = known.joinpath(f"{name.removeprefix(LIBRARY)}.toml")
        if re.fullmatch(r"\w+", name.removeprefix(LIBRARY)) and here.is_file():
            return here.read_text(encoding="utf-8")
        names = sorted(f"{LIBRARY}{one.name.removesuffix('.toml')}" for one in known.iterdir() if one.name.endswith(".toml"))
        raise ValueError(f"{file}: vehicle.extends must be one of {', '.join(names)}, or a file beside this one, got {name!r}")
    if not isinstance(name, str) or Path(name).name != name or not (folder / name).is_file():
        raise ValueError(
            f"{file}: vehicle.extends must be a file beside this one that there is, or such as 'vehicle:lrt', got {name!r}"
        )
    try:
        return (folder / name).read_text(encoding="utf-8")
    except (OSError, UnicodeDecodeError) as error:
        raise ValueError(f"{file}: vehicle.extends: {name} cannot be read: {error}") from None


def _merged(base: Mapping[str, Any], own: Mapping[str, Any]) -> dict[str, Any]:
    found = dict(base)
    for key, value in own.items():
        there = found.get(key)
        found[key] = _merged(there, value) if isinstance(there, dict) and isinstance(value, dict) else value
    return found
