"""cosim export: write a component as an FMU."""

from pathlib import Path
from typing import Annotated

import typer

from ..systems import catalogue
from .common import AsJson, say

VERSIONS = {"2": ("2",), "3": ("3",), "both": ("2", "3")}


def command(
    component: Annotated[
        str,
        typer.Argument(
            metavar="COMPONENT[:VARIANT]", help="such as gyro_unit:nonlinear, a .py file, or the .toml file of a vehicle"
        ),
    ],
    fmi: Annotated[str, typer.Option(metavar="2|3|both", help="FMI version")] = "2",
    platform: Annotated[str, typer.Option(metavar="host|all|NAMES", help="platforms that the FMUs run on")] = "host",
    directory: Annotated[Path, typer.Option("-o", "--output", metavar="DIR", help="where to write")] = Path(),
    sources: Annotated[bool, typer.Option("--with-sources/--without-sources", help="ship the C sources inside")] = True,
    as_json: AsJson = False,
) -> int:
    """Write a component as FMUs that need no Python."""
    if fmi not in VERSIONS:
        raise ValueError(f"--fmi must be 2, 3 or both, got {fmi!r}")
    names = tuple(name.strip() for name in platform.split(",") if name.strip())
    files = catalogue.export(component, directory, fmi=VERSIONS[fmi], platforms=names, sources=sources)
    say(as_json, lambda: {"files": [str(file) for file in files]}, *(f"wrote {file}" for file in files))
    return 0
