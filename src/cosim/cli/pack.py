"""cosim pack: a system as an .ssp file."""

from pathlib import Path
from typing import Annotated

import typer

from ..ssp.packing import pack
from .common import AsJson, Gyro, SystemName, Values, chosen_system, say, writable


def command(
    system: SystemName,
    gyro: Gyro = None,
    set_: Values = None,
    output: Annotated[Path | None, typer.Option("-o", "--output", metavar="FILE", help="an .ssp file; else SYSTEM.ssp")] = None,
    as_json: AsJson = False,
) -> int:
    """Write a system with its FMUs and values as an .ssp file (SSP 1.0) that other tools run."""
    plan = chosen_system(system, gyro, set_)
    file = output if output is not None else Path(f"{plan.name}.ssp")
    if file.suffix != ".ssp":
        raise ValueError(f"packed system must end in .ssp, got {str(file)!r}")
    writable(file, lambda _: None)
    pack(plan, file)
    say(as_json, lambda: {"file": str(file), "components": [component.name for component in plan.components]}, f"wrote {file}")
    return 0
