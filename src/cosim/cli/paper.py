"""cosim paper: the paper's figures, the ledger of its claims, and how far each claim holds."""

from pathlib import Path
from typing import Annotated

import typer
from rich.table import Table

from .common import AsJson, needs, progress, say


def command(
    directory: Annotated[Path, typer.Option("-o", "--output", metavar="DIR", help="where to write")] = Path("results/paper"),
    only_wheel_pair: Annotated[
        bool, typer.Option("--only-wheel-pair", help="figures 2 to 4 and claims C1 to C4 only, in seconds")
    ] = False,
    draws: Annotated[
        int | None,
        typer.Option(metavar="N", help="draws from the ranges of parameters not given in the paper; 0: none"),
    ] = None,
    seed: Annotated[int | None, typer.Option(metavar="S", help="seed of the draws")] = None,
    robust: Annotated[
        int | None,
        typer.Option(metavar="N", help="ask C6 to C10 again: N starts, four creep laws, half the internal step"),
    ] = None,
    as_json: AsJson = False,
) -> int:
    """Redraw the paper's figures and say of each claim whether it holds.

    Parameters that the paper does not give have a range. With draws from these ranges the table also says how far each claim
    holds. Rows of draws, and of the runs of --robust, are kept in DIR: the same study is not run again, and one that was stopped
    goes on.
    """
    from ..paper import DRAWS, SEED, ledger, reproduce, studied, subjects

    count = DRAWS if draws is None else draws
    if count < 0:
        raise ValueError(f"--draws must not be negative, got {count}")
    needs("--seed", seed, "draws (--draws N)", count > 0)
    if robust is not None and robust < 1:
        raise ValueError(f"--robust must be at least 1, got {robust}")
    needs("--robust", robust, "the full vehicle (not --only-wheel-pair)", not only_wheel_pair)
    known: dict[str, str] = {}
    drawn: list[Path] = []
    if count:
        with progress(f"{count} draws") as show:
            of = subjects(full_vehicle=not only_wheel_pair)
            known, drawn = studied(directory, count, SEED if seed is None else seed, of, progress=show)
    with progress("the paper") as show:
        claims, files = reproduce(
            directory, full_vehicle=not only_wheel_pair, sensitivity=known, starts=robust or 0, progress=show
        )
    table = Table("id", "claim", "measured", "verdict", "asked again", "sensitivity", show_lines=True)
    for claim in claims:
        note = f"\n({claim.note})" if claim.note else ""
        table.add_row(
            claim.id, f"{claim.claim} [{claim.where}]", claim.measured + note, claim.verdict, claim.survives, claim.sensitivity
        )
    document = {"claims": ledger.document(claims), "files": [str(file) for file in (*files, *drawn)]}
    say(as_json, lambda: document, table, *(f"wrote {file}" for file in (*files, *drawn)))
    return 0
