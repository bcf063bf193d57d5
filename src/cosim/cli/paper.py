"""cosim paper: the paper's figures and the ledger of its claims."""

from pathlib import Path
from typing import Annotated

import typer
from rich.table import Table

from cosim.cli.common import AsJson, progress, say


def command(
    directory: Annotated[Path, typer.Option("-o", "--output", metavar="DIR", help="where to write")] = Path("results/paper"),
    only_wheel_pair: Annotated[
        bool, typer.Option("--only-wheel-pair", help="figures 2 to 4 and claims C1 to C4 only, in seconds")
    ] = False,
    as_json: AsJson = False,
) -> int:
    """Redraw the paper's figures and say, claim by claim, what comes out."""
    from cosim import report
    from cosim.paper import reproduce

    with progress("the paper") as show:
        claims, files = reproduce(directory, full_vehicle=not only_wheel_pair, progress=show)
    table = Table("id", "claim", "measured", "verdict", show_lines=True)
    for claim in claims:
        note = f"\n({claim.note})" if claim.note else ""
        table.add_row(claim.id, f"{claim.claim} [{claim.where}]".replace("[", "\\["), claim.measured + note, claim.verdict)
    document = {"claims": report.document(claims), "files": [str(file) for file in files]}
    say(as_json, lambda: document, table, *(f"wrote {file}" for file in files))
    return 0
