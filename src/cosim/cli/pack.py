"""cosim pack: a system as an .ssp file, or as one FMU."""

import json
from pathlib import Path
from typing import Annotated, Any

import typer

from ..coupling import Algorithm, algorithm
from ..ssp.packing import pack
from ..systems import System
from .common import (
    AsJson,
    Exchanged,
    Gyro,
    Parameters,
    Swaps,
    SystemName,
    Values,
    Vehicle,
    chosen_system,
    needs,
    say,
    seconds,
    tell,
    writable,
)
from .export import VERSIONS
from .settings import words

AS_FMU = "--as-fmu"


def command(
    system: SystemName,
    vehicle: Vehicle = None,
    gyro: Gyro = None,
    swap: Swaps = None,
    set_: Values = None,
    params: Parameters = None,
    model_exchange: Exchanged = None,
    output: Annotated[
        Path | None, typer.Option("-o", "--output", metavar="FILE", help="an .ssp file, else SYSTEM.ssp; of an FMU also a folder")
    ] = None,
    ssp: Annotated[str | None, typer.Option(metavar="1.0|2.0", help="version of SSP, else 1.0")] = None,
    results: Annotated[
        Path | None, typer.Option("--run", metavar="FILE", help="what `cosim run SYSTEM --json` printed, to be packed with it")
    ] = None,
    as_fmu: Annotated[bool, typer.Option(AS_FMU, help="one FMU for Co-Simulation that couples the components itself")] = False,
    fmi: Annotated[str | None, typer.Option(metavar="2|3|both", help="FMI version of that FMU, else 2")] = None,
    platform: Annotated[
        str | None, typer.Option(metavar="host|all|NAMES", help="platforms that it runs on, else this machine's")
    ] = None,
    algorithm_: Annotated[
        str | None, typer.Option("--algorithm", metavar="NAME", help="algorithm that it starts with, else jacobi")
    ] = None,
    degree: Annotated[
        int | None, typer.Option("--degree", "--order", metavar="K", help="degree of the extrapolation, else 1")
    ] = None,
    sequence: Annotated[str | None, typer.Option(metavar="NAME,...", help="order of the components under gauss-seidel")] = None,
    step: Annotated[str | None, typer.Option(metavar="TIME", help="macro step, else the system's")] = None,
    sources: Annotated[
        bool | None, typer.Option("--with-sources/--without-sources", help="ship the C sources inside, else they are")
    ] = None,
    as_json: AsJson = False,
) -> int:
    """Write a system with its FMUs and values as an .ssp file (SSP 1.0 or 2.0) that other tools run, or as one FMU."""
    of_fmu = {
        "--fmi": fmi, "--platform": platform, "--algorithm": algorithm_, "--degree": degree, "--sequence": sequence,
        "--step": step, "--with-sources": sources,
    }  # fmt: skip
    for option, given in of_fmu.items():
        needs(option, given, AS_FMU, as_fmu)
    for option, of_ssp in (("--ssp", ssp), ("--run", results)):
        if of_ssp is not None and as_fmu:
            raise ValueError(f"{option} has no effect with {AS_FMU}, got {str(of_ssp)!r}")
    plan = chosen_system(system, gyro, set_, vehicle=vehicle, swaps=swap, params=params, exchanged=model_exchange)
    tell(plan.notes)
    if as_fmu:
        chosen = algorithm(algorithm_ or "jacobi", 1 if degree is None else degree, words(sequence or ""))
        files = _as_fmus(plan, output, fmi or "2", platform or "host", chosen, seconds(step, "--step"), sources is not False)
    else:
        files = [output if output is not None else Path(f"{plan.name}.ssp")]
        if files[0].suffix != ".ssp":
            raise ValueError(f"packed system must end in .ssp, got {str(files[0])!r}")
        writable(files[0], lambda _: None)
        pack(plan, files[0], version=ssp or "1.0", run=None if results is None else _run(results))
    document = {"file": str(files[0]), "files": [str(f) for f in files], "components": [c.name for c in plan.components]}
    say(as_json, lambda: document, *(f"wrote {file}" for file in files))
    return 0


def _run(file: Path) -> dict[str, Any]:
    """The document of a run."""
    try:
        document = json.loads(file.read_text(encoding="utf-8"))
    except OSError as error:
        raise ValueError(f"--run file {str(file)!r} cannot be read: {error.strerror or error}") from None
    except ValueError as error:
        raise ValueError(f"--run file {str(file)!r} must be JSON: {error}") from None
    if not isinstance(document, dict):
        raise ValueError(f"--run file {str(file)!r} must be what `cosim run --json` prints")
    return document


def _as_fmus(
    plan: System, output: Path | None, fmi: str, platform: str, chosen: Algorithm, step: float | None, sources: bool
) -> list[Path]:
    from ..export import pack_fmu  # late: it loads the master

    if fmi not in VERSIONS:
        raise ValueError(f"--fmi must be 2, 3 or both, got {fmi!r}")
    if output is not None and output.suffix == ".fmu":
        writable(output, lambda _: None)
    return pack_fmu(
        plan, Path() if output is None else output, algorithm=chosen, step=step, fmi=VERSIONS[fmi],
        platforms=words(platform), sources=sources,
    )  # fmt: skip
