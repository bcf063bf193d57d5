"""What commands share: options, units on the command line, progress, where words and documents go."""

import io
import json
import os
import sys
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import replace
from pathlib import Path
from typing import Annotated, Any, overload

import typer
from rich.console import Console
from rich.table import Table

from gyro_cosim.component.units import quantity

from ..coupling import ALGORITHMS
from ..master import Progress
from ..ssp import system as named_system
from ..systems import System
from ..systems.catalogue import described_by, systems
from ..systems.riding import settled
from .kept import voice
from .log import shown_plainly
from .settings import applied, words

SystemName = Annotated[str, typer.Argument(metavar="SYSTEM", help="a built-in system (cosim list), an .ssp, .ssd, .toml or .fmu")]
Gyro = Annotated[
    str | None,
    typer.Option("--gyro", metavar="VARIANT", help="the gyro unit: a variant, PACKAGE:VARIANT, a .py file or an .fmu file"),
]
Vehicle = Annotated[
    str | None,
    typer.Option("--vehicle", metavar="VARIANT", help="the vehicle, or a .toml file of one; short for --swap vehicle=VARIANT"),
]
Swaps = Annotated[
    list[str] | None,
    typer.Option(
        "--swap",
        metavar="NAME=SOURCE[,FOREIGN=OURS...]",
        help="a component from elsewhere: a variant, PACKAGE:VARIANT, a .py or .fmu file; FOREIGN is what that calls a signal, "
        "OURS what the system calls it",
    ),
]
Parameters = Annotated[
    Path | None, typer.Option("--params", metavar="FILE", help="parameters from a .toml file (cosim params) or an .ssv file")
]
Exchanged = Annotated[
    list[str] | None,
    typer.Option(
        "--model-exchange", metavar="COMPONENT", help="run this FMU by Model Exchange, integrated here, not by Co-Simulation"
    ),
]
Values = Annotated[
    list[str] | None,
    typer.Option(
        "--set",
        metavar="COMPONENT.PARAMETER=VALUE",
        help="a parameter or start value, with a unit if you like: gyro.rotor_speed=200rpm; or COMPONENT=VARIANT",
    ),
]
AlgorithmName = Annotated[str, typer.Option("--algorithm", metavar="NAME", help=f"coupling algorithm: {', '.join(ALGORITHMS)}")]
Degree = Annotated[int, typer.Option("--degree", "--order", metavar="K", help="degree of the input extrapolation: 0, 1 or 2")]
Degrees = Annotated[str, typer.Option("--degree", "--order", metavar="K,...", help="degrees of the input extrapolation")]
InProcess = Annotated[bool, typer.Option("--in-process", help="run the components in this process instead of as FMUs")]
Tolerance = Annotated[
    float | None,
    typer.Option("--tolerance", metavar="TOL", help="relative tolerance that every FMU is told; its own description's otherwise"),
]
InputFiles = Annotated[
    list[Path] | None, typer.Option("--input", metavar="FILE", help="time series that open inputs follow: a .csv, or results")
]
ScenarioFile = Annotated[
    Path | None,
    typer.Option("--scenario", metavar="FILE", help="a .toml file of what happens when: values set, connections that fail"),
]
AsJson = Annotated[bool, typer.Option("--json", help="print one JSON document on standard output")]


def is_system(name: str) -> bool:
    """Whether `name` is that of a system, and not of a component or an FMU."""
    return name in systems() or (name.endswith((".ssd", ".ssp", ".toml")) and described_by(name) is None)


def chosen_system(
    name: str | System, gyro: str | None = None, values: Sequence[str] | None = None, *, vehicle: str | None = None,
    swaps: Sequence[str] | None = None, params: Path | None = None, exchanged: Sequence[str] | None = None,
    tolerance: float | None = None,
) -> System:  # fmt: skip
    """The system called `name` with --vehicle, --gyro, --swap, --params, --set and the others applied, in this order."""
    plan = named_system(name) if isinstance(name, str) else name
    plan = applied(plan, gyro, values, vehicle=vehicle, swaps=swaps or (), params=params)
    chosen = bool(gyro or vehicle or swaps or params)
    if chosen or any("inertia" in text or "=" in text.partition("=")[2] for text in values or ()):  # NAME=VARIANT,NAME=VALUE
        plan = settled(plan)  # it loads the components' equations, which takes longer than a short run: not for any --set
    for component in exchanged or ():
        plan = plan.with_implementation(component, "ModelExchange")
    if tolerance is None:
        return plan
    if not 0.0 < tolerance < float("inf"):
        raise ValueError(f"--tolerance must be positive, got {tolerance:g}")
    return replace(plan, tolerance=tolerance)


def tell(notes: Sequence[str]) -> None:
    """Notes on standard error, for commands whose result has no place for them."""
    for note in notes:
        console().print(f"cosim: note: {note}", soft_wrap=True)


@overload
def seconds(text: str, option: str) -> float: ...
@overload
def seconds(text: None, option: str) -> None: ...
@overload
def seconds(text: str | None, option: str) -> float | None: ...
@overload
def seconds(text: str | None, option: str, default: float) -> float: ...
def seconds(text: str | None, option: str, default: float | None = None) -> float | None:
    """The time (s) in `text` ("1ms", "60", "1 min"), where the option was not given `default`; 0 is a time as any other."""
    if text is None:
        return default
    try:
        return quantity(text, "s")
    except ValueError as error:
        raise ValueError(f"{option} {error}") from None


def degrees(text: str) -> list[int]:
    """The degrees in "0,1,2"."""
    if not words(text) or not all(word.isdecimal() for word in words(text)):
        raise ValueError(f"--degree must be degrees such as 0,1,2, got {text!r}")
    return [int(word) for word in words(text)]


def needs(option: str, given: object, other: str, there: bool) -> None:
    """Refuse an option that has no effect without another one."""
    if given is not None and not there:
        raise ValueError(f"{option} has no effect without {other}, got {str(given) if isinstance(given, Path) else given!r}")


def console() -> Console:
    """Where people's words go: standard error, so that standard output can hold a document."""
    return Console(stderr=True, highlight=False, markup=False, emoji=False)


def complain(message: str, code: int) -> int:
    """Say what went wrong in one line, in which control characters are shown, not obeyed; the exit code."""
    print("cosim: " + shown_plainly(message), file=sys.stderr, flush=True)
    voice().told()
    return code


def say(as_json: bool, document: Callable[[], dict[str, Any]], *words: str | Table) -> None:
    """The result of a command: `words` for people on standard output, or with --json the document there instead.

    Names and messages are printed as they are: nothing in them is markup. JSON has no NaN and no Infinity: null stands for both.
    """
    if as_json:
        json.dump(nulled(document()), sys.stdout, indent=1, allow_nan=False)
        sys.stdout.write("\n")
    else:
        out = Console(highlight=False, markup=False, emoji=False, width=None if sys.stdout.isatty() else 130)
        for word in words:
            out.print(word, soft_wrap=isinstance(word, str))  # a line stays one line


def plain(words: Sequence[str | Table]) -> list[str]:
    """Words and tables as lines of text without colours."""
    text = io.StringIO()
    to = Console(file=text, width=140, highlight=False, color_system=None)
    for part in words:
        to.print(part, soft_wrap=isinstance(part, str), markup=False)
    return [line.rstrip() for line in text.getvalue().splitlines()]


def nulled(value: Any) -> Any:
    """`value` with None in the place of every number that is NaN or infinite; texts stay as they are."""
    if isinstance(value, float):
        return finite(value)
    if isinstance(value, Mapping):
        return {key: nulled(element) for key, element in value.items()}
    if isinstance(value, list | tuple):
        return [nulled(element) for element in value]
    return value


@contextmanager
def progress(what: str) -> Iterator[Progress]:
    """A progress bar for work longer than a second, where a person watches; called with (done, total)."""
    from rich.progress import BarColumn, TextColumn, TimeRemainingColumn
    from rich.progress import Progress as Bar

    bar = Bar(TextColumn("{task.description}", markup=False), BarColumn(), TextColumn("{task.percentage:3.0f} %"),
              TimeRemainingColumn(), console=console(), transient=True, disable=not sys.stderr.isatty())  # fmt: skip
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
    plain = file.is_file() or not file.exists()
    if not os.access(folder if plain else file, os.W_OK):  # a plain file is written beside and put in place
        raise ValueError(f"{str(file)!r} must be writable{', and its folder' if plain else ''}")
    if file.is_file() and not os.access(file, os.W_OK):
        raise ValueError(f"{str(file)!r} must be writable")


def finite(value: float) -> float | None:
    """`value` for JSON, which has no NaN."""
    return value if value == value and abs(value) != float("inf") else None
