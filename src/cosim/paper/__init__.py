"""The paper's figures and claims, recomputed.

Prateek et al., Running performance improvement of a railway vehicle with independently rotating wheels by using
gyroscopic dampers. What it states is quoted in the claims; every verdict is computed from our own numbers.

    cases, measures, pair_measures              the runs; what is measured of them, and verdicts
    wheel_pair, vehicle                         figures 2 to 4 and 6 to 10, claims C1 to C10
    ledger                                      claims with computed verdicts
    robust                                      the same with four creep laws, half the internal step, and many starts
    sensitivity                                 how far each claim holds: draws from what the paper does not give
"""

import json
from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path

from gyro_cosim.component.whole_files import write_whole

from ..master import Progress, stage
from . import ledger, robust, vehicle, wheel_pair
from .cases import Extent
from .ledger import Claim
from .sensitivity.study import DRAWS, SEED, studied, subjects

__all__ = ["DRAWS", "SEED", "reproduce", "studied", "subjects"]

PAIR = 0.1  # of the time goes into the wheel pair, the rest into the vehicle
AGAIN = 0.3  # of the time is over when claims begin to be asked again
NOT_STUDIED = "not studied (--draws 0)"


def reproduce(
    folder: Path,
    *,
    full_vehicle: bool = True,
    sensitivity: Mapping[str, str] | None = None,
    extent: Extent | None = None,
    starts: int = 0,
    progress: Progress | None = None,
) -> tuple[list[Claim], list[Path]]:
    """Draw the paper's figures and judge its claims.

    Parameters
    ----------
    folder
        Where figures, ledger.md and ledger.json are written.
    full_vehicle
        Whether to draw figures 6 to 10 too, which take a minute or two.
    sensitivity
        Claim -> how far it holds, as `studied` says it.
    extent
        How much is run for figures 6 to 10.
    starts
        From how many starts claims C6 to C10 are asked again, with four creep laws and half the internal step; 0 for none.
    progress
        Called with the work done and the work in all.

    Returns
    -------
    claims, files
        The claims with their verdicts, and everything written.
    """
    folder.mkdir(parents=True, exist_ok=True)
    claims, files = wheel_pair.reproduce(folder, progress=stage(progress, 0.0, PAIR if full_vehicle else 1.0))
    if full_vehicle:
        again = AGAIN if starts else 1.0
        more, others = vehicle.reproduce(folder, extent=extent, progress=stage(progress, PAIR, again))
        if starts:
            parts = robust.survived(folder, starts, extent, stage(progress, again, 1.0))
            more = [robust.judged(claim, parts) for claim in more]
            others.append(folder / "robust.md")
            others[-1].write_text(robust.page(parts), encoding="utf-8")
        claims, files = claims + more, files + others
    claims = [replace(claim, sensitivity=(sensitivity or {}).get(claim.id, NOT_STUDIED)) for claim in claims]
    page = folder / "ledger.md"
    write_whole(page, ledger.markdown(claims, "Claims of the paper, recomputed"))
    data = folder / "ledger.json"
    write_whole(data, json.dumps({"claims": ledger.document(claims)}, indent=1) + "\n")
    return claims, [*files, page, data]
