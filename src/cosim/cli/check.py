"""cosim check: whether FMUs keep the standard."""

from pathlib import Path
from typing import Annotated

import typer

from .alone import given_alone
from .common import AsJson, Parameters, Values, say


def command(
    files: Annotated[list[Path], typer.Argument(metavar="FILE.fmu...", help="FMUs of FMI 2.0 or 3.0, anyone's")],
    set_: Values = None,
    params: Parameters = None,
    timeout: Annotated[float, typer.Option(metavar="SECONDS", help="how long one probe of the binary may take")] = 60.0,
    as_json: AsJson = False,
) -> int:
    """Check FMUs: schema and validation, and what validators miss. Exit code 1 if there is a fault.

    A fault breaks the standard; a warning is likely to go wrong somewhere; a note is good to know. The binary is tried with the
    values of --set and --params, for FMUs that need some.
    """
    from ..check import check_fmu

    found = {
        str(file): check_fmu(file, timeout=timeout, values=given_alone(str(file), set_, params) if file.is_file() else None)
        for file in files
    }
    words = []
    for file, findings in found.items():
        words += [f"{file}: {finding}" for finding in findings]
        if not any(finding.severity == "fault" for finding in findings):
            words.append(f"{file}: no fault found")
    document = {
        file: [{"severity": f.severity, "rule": f.rule, "message": f.message} for f in findings]
        for file, findings in found.items()
    }
    say(as_json, lambda: {"findings": document}, *words)
    return 1 if any(f.severity == "fault" for findings in found.values() for f in findings) else 0
