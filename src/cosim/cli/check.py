"""cosim check: whether FMUs keep the standard."""

from pathlib import Path
from typing import Annotated

import typer

from .common import AsJson, say


def command(
    files: Annotated[list[Path], typer.Argument(metavar="FILE.fmu...", help="FMUs of FMI 2.0 or 3.0, anyone's")],
    timeout: Annotated[float, typer.Option(metavar="SECONDS", help="how long one probe of the binary may take")] = 60.0,
    as_json: AsJson = False,
) -> int:
    """Check FMUs: schema and validation, and what validators miss. Exit code 1 if there is a fault."""
    from ..check import check_fmu

    found = {str(file): check_fmu(file, timeout=timeout) for file in files}
    words = [f"{file}: {fault}" for file, faults in found.items() for fault in faults]
    words += [f"{file}: no fault found" for file, faults in found.items() if not faults]
    document = {file: [{"rule": f.rule, "message": f.message} for f in faults] for file, faults in found.items()}
    say(as_json, lambda: {"faults": document}, *words)
    return 1 if any(found.values()) else 0
