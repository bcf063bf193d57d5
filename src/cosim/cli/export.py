"""cosim export: write a component as an FMU."""

from collections.abc import Mapping
from pathlib import Path
from typing import Annotated

import typer

from ..slaves.signal import Value
from ..systems import catalogue
from .alone import given_alone
from .common import AsJson, Parameters, Values, say

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
    set_: Values = None,
    params: Parameters = None,
    as_json: AsJson = False,
) -> int:
    """Write a component as FMUs that need no Python. They start with the values of --set and --params, where these are given."""
    if fmi not in VERSIONS:
        raise ValueError(f"--fmi must be 2, 3 or both, got {fmi!r}")
    names = tuple(name.strip() for name in platform.split(",") if name.strip())
    starts = _starts(given_alone(component, set_, params))
    files = catalogue.export(component, directory, fmi=VERSIONS[fmi], platforms=names, sources=sources, starts=starts)
    say(as_json, lambda: {"files": [str(file) for file in files]}, *(f"wrote {file}" for file in files))
    return 0


def _starts(values: Mapping[str, Value]) -> dict[str, float]:
    """Numbers, as the values of our own components all are."""
    if "tolerance" in values:
        raise ValueError("--set tolerance must be given to a run: an FMU starts with equal internal steps")
    return {name: float(value) for name, value in values.items()}  # type: ignore[arg-type]
