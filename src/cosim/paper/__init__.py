"""The paper's figures and claims, recomputed.

Prateek et al., Running performance improvement of a railway vehicle with independently rotating wheels by using
gyroscopic dampers. What it states is quoted in the claims; every verdict is computed from our own numbers.
"""

import json
from collections.abc import Callable
from pathlib import Path

from cosim import report
from cosim.paper import vehicle, wheel_pair
from cosim.report import Claim

__all__ = ["reproduce"]


def reproduce(
    folder: Path, *, full_vehicle: bool = True, progress: Callable[[float, float], None] | None = None
) -> tuple[list[Claim], list[Path]]:
    """Draw the figures into `folder`, write ledger.md and ledger.json there; returns the claims and the files.

    full_vehicle : also figures 6 to 10, which take a minute or two.
    """
    folder.mkdir(parents=True, exist_ok=True)
    claims, files = wheel_pair.reproduce(folder, progress=progress)
    if full_vehicle:
        more, drawn = vehicle.reproduce(folder, progress=progress)
        claims, files = claims + more, files + drawn
    ledger = folder / "ledger.md"
    ledger.write_text(report.markdown(claims, "Claims of the paper, recomputed"), encoding="utf-8")
    data = folder / "ledger.json"
    data.write_text(json.dumps({"claims": report.document(claims)}, indent=1) + "\n", encoding="utf-8")
    return claims, [*files, ledger, data]
