"""What commands share: options, units on the command line, progress, where words and documents go."""

import json
import os
import sys
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import Annotated, Any

import typer
from rich.console import Console
from rich.table import Table

from gyro_cosim.component.units import quantity

from ..ssp import system as named_system
from ..systems import System

SystemName = Annotated[str, typer.Argument(metavar="SYSTEM", help="a built-in system (cosim list), or an .ssp or .ssd file")]
Gyro = Annotated[
    str | None,
    typer.Option("--gyro", metavar="VARIANT", help="the gyro unit: a variant, PACKAGE:VARIANT, a .py file or an .fmu file"),
]
Values = Annotated[
    list[str] | None,
    typer.Option(
        "--set", metavar="COMPONENT.PARAMETER=VALUE", help="a parameter or start value, with a unit if you like: 200rpm"
    ),
]
InProcess = Annotated[bool, typer.Option("--in-process", help="run the components in this process instead of as FMUs")]
AsJson = Annotated[bool, typer.Option("--json", help="print one JSON document on standard output")]


def chosen_system(name: str, gyro: str | None, values: Sequence[str] | None) -> System:
    """The system called `name` with the options --gyro and --set applied."""
    system = named_system(name)
    if gyro is not None:
        system = system.with_source("gyro", gyro)
    for text in values or ():
        target, equals, value = text.partition("=")
        if not equals:
            raise ValueError(f"--set must be COMPONENT.PARAMETER=VALUE, got {text!r}")
        system = system.with_value(target.strip(), value.strip())
    return system


def seconds(text: str | None, option: str) -> float | None:
    """The time in `text` ("1ms", "60", "1 min") in s; None stays None."""
    if text is None:
        return None
    try:
        return quantity(text, "s")
    except ValueError as error:
        raise ValueError(f"{option} {error}") from None


def console() -> Console:
    """Where people's words go: standard error, so that standard output can hold a document."""
    return Console(stderr=True, highlight=False)


def say(as_json: bool, document: Callable[[], dict[str, Any]], *words: str | Table) -> None:
    """The result of a command: `words` for people on standard output, or with --json the document there instead."""
    if as_json:
        json.dump(document(), sys.stdout, indent=1, allow_nan=False)
        sys.stdout.write("\n")
    else:
        out = Console(highlight=False, width=None if sys.stdout.isatty() else 130)
        for part in words:
            out.print(part, markup=False) if isinstance(part, str) else out.print(part)


@contextmanager
def progress(what: str) -> Iterator[Callable[[float, float], None]]:
    """A progress bar for work longer than a second, where a person watches; called with (done, total)."""
    from rich.progress import BarColumn, Progress, TextColumn, TimeRemainingColumn

    bar = Progress(TextColumn(what), BarColumn(), TextColumn("{task.percentage:3.0f} %"), TimeRemainingColumn(),
                   console=console(), transient=True, disable=not sys.stderr.isatty())  # fmt: skip
    task = bar.add_task(what, total=None)
    with bar:
        yield lambda done, total: bar.update(task, completed=done, total=total)


def writable(file: Path | None, check: Callable[[Path], None]) -> None:
    """Refuse, before any work, a file that cannot be written afterwards: wrong format, no folder, no permission."""
    if file is None:
        return
    check(file)
    folder = file.parent
    if not folder.is_dir():
        raise ValueError(f"the folder of {str(file)!r} must exist")
    if file.is_dir():
        raise ValueError(f"{str(file)!r} must be a file, is a folder")
    if not os.access(file if file.exists() else folder, os.W_OK):
        raise ValueError(f"{str(file)!r} must be writable")


def finite(value: float) -> float | None:
    """`value` for JSON, which has no NaN."""
    return value if value == value and abs(value) != float("inf") else None
