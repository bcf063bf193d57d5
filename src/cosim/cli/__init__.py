"""The command line: `cosim COMMAND`. One file a command; this one puts them together and turns errors into one line.

Exit codes: 0 done, 1 a run or a check that failed, 2 wrong use.
"""

import sys
from collections.abc import Sequence
from importlib import import_module, metadata
from typing import Annotated, Any

import typer

from ..errors import RunError
from .given import of_command
from .kept import COMMANDS as FOREIGN
from .kept import diverted, kept_process, voice
from .log import shown, shown_plainly, verbosity

# Command -> its file in this folder. Only what is called is loaded: start-up is part of every command. Other commands are
# registered under the entry point group below, as `paper` is in pyproject.toml; a name of this list stays ours.
GROUP = "gyro_cosim.commands"
COMMANDS = {
    "list": "listing",
    "run": "run",
    "export": "export",
    "check": "check",
    "converge": "converge",
    "compare": "compare",
    "delay": "delay",
    "sweep": "sweep",
    "plot": "plot",
    "report": "report",
    "info": "info",
    "params": "parameters",
    "modes": "modes",
    "response": "response",
    "limit-cycles": "limit_cycles",
    "vehicle": "vehicle",
    "pack": "pack",
    "serve": "serve",
    "reproduce": "reproduce",
}


def registered() -> dict[str, metadata.EntryPoint]:
    """Name -> entry point of every command that comes with a field."""
    entries = sorted(metadata.entry_points(group=GROUP), key=lambda entry: entry.name)
    return {entry.name: entry for entry in entries if entry.name not in COMMANDS}


def application(wanted: str = "") -> typer.Typer:
    """The command line with one command, or with all of them."""
    app = typer.Typer(
        name="cosim",
        help="Co-simulation of a railway vehicle and its gyroscopic damper, and of FMUs in general. Every command takes -v "
        "for its log, in which FMUs speak, too, and -vv for all of it.",
        add_completion=False,
        pretty_exceptions_enable=False,
        rich_markup_mode=None,
        context_settings={"help_option_names": ["-h", "--help"], "max_content_width": 110},
    )
    app.callback(invoke_without_command=True)(_top)  # with this a single command keeps its name
    for name, file in COMMANDS.items():
        if wanted in ("", name):
            app.command(name)(import_module(f"gyro_cosim.cli.{file}").command)
    for name, entry in {} if wanted in COMMANDS else registered().items():
        if wanted in ("", name):
            app.command(name)(_loaded(entry))
    return app


def _loaded(entry: metadata.EntryPoint) -> Any:
    try:
        return entry.load()
    except Exception as error:  # another package's code can fail in any way; people need one line
        raise RuntimeError(f"command {entry.name!r} ({entry.value}) cannot be loaded: {error}") from error


def _top(version: Annotated[bool, typer.Option("--version", help="print the version and leave")] = False) -> None:
    if version:
        print(f"gyro-cosim {metadata.version('gyro-cosim')}")
        raise typer.Exit


# The base of all complaints about the command line; typer keeps its module private.
Misuse: type[Exception] = next(base for base in typer.BadParameter.__mro__ if base.__name__ == "ClickException")


def main(arguments: Sequence[str] | None = None) -> int:
    """Run the command line; returns the exit code. Called by the system, it keeps what may run foreign code in a fork."""
    times, given = verbosity(sys.argv[1:] if arguments is None else arguments)
    if arguments is None and given and given[0] in FOREIGN and not {"-h", "--help"} & set(given):
        return kept_process(lambda: _guarded(times, given))
    return _guarded(times, given)


def _guarded(times: int, given: list[str]) -> int:
    """The exit code of a command; whatever goes wrong is one line."""
    try:
        with shown(times), diverted("--json" in given), of_command(given):
            return _run(given)
    except Misuse as error:
        return _complain(error.format_message() if isinstance(error, typer.BadParameter) else str(error), 2)
    except (typer.Abort, KeyboardInterrupt):
        return _complain("interrupted", 1)
    except RunError as error:
        return _complain(str(error), 1)
    except ValueError as error:
        return _complain(str(error), 2)
    except OSError as error:
        return _complain(f"{error.filename}: {error.strerror}" if error.filename else str(error), 1)
    except RuntimeError as error:
        return _complain(str(error), 1)


def _run(arguments: list[str]) -> int:
    """The exit code of a command without -v."""
    wanted = arguments[0] if arguments and (arguments[0] in COMMANDS or arguments[0] in registered()) else ""
    code = application(wanted)(args=arguments or ["--help"], prog_name="cosim", standalone_mode=False)
    return code if isinstance(code, int) else 0


def _complain(message: str, code: int) -> int:
    """Say what went wrong in one line, in which control characters are shown, not obeyed."""
    print("cosim: " + shown_plainly(message), file=sys.stderr, flush=True)
    voice().told()
    return code
