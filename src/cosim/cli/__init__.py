"""The command line: `cosim COMMAND`. One file a command; this one puts them together and turns errors into one line.

Exit codes: 0 done, 1 a run or a check that failed, 2 wrong use.
"""

import sys
from collections.abc import Sequence
from importlib import import_module

import typer

from ..errors import RunError

# Command -> its file in this folder. Only what is called is loaded: start-up is part of every command.
COMMANDS = {
    "list": "listing",
    "run": "run",
    "export": "export",
    "check": "check",
    "converge": "converge",
    "compare": "compare",
    "delay": "delay",
    "paper": "paper",
    "sweep": "sweep",
    "plot": "plot",
    "info": "info",
    "pack": "pack",
    "serve": "serve",
}


def application(commands: Sequence[str]) -> typer.Typer:
    """The command line with these commands."""
    app = typer.Typer(
        name="cosim",
        help="Co-simulation of a railway vehicle and its gyroscopic damper, and of FMUs in general.",
        add_completion=False,
        pretty_exceptions_enable=False,
        rich_markup_mode=None,
        context_settings={"help_option_names": ["-h", "--help"], "max_content_width": 110},
    )
    app.callback()(lambda: None)  # with this a single command keeps its name
    for name in commands:
        app.command(name)(import_module(f"gyro_cosim.cli.{COMMANDS[name]}").command)
    return app


# The base of all complaints about the command line; typer keeps its module private.
Misuse: type[Exception] = next(base for base in typer.BadParameter.__mro__ if base.__name__ == "ClickException")


def main(arguments: Sequence[str] | None = None) -> int:
    """Run the command line; returns the exit code."""
    given = list(sys.argv[1:] if arguments is None else arguments)
    wanted = [name for name in given[:1] if name in COMMANDS]
    try:
        code = application(wanted or list(COMMANDS))(args=given or ["--help"], prog_name="cosim", standalone_mode=False)
        return code if isinstance(code, int) else 0
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


def _complain(message: str, code: int) -> int:
    print("cosim: " + " ".join(message.split()), file=sys.stderr)
    return code
