"""The studies of draws behind the ledger's column `sensitivity`: of the wheel pair and of the full vehicle, and their files."""

from pathlib import Path
from typing import Any

from gyro_cosim.component.whole_files import write_whole

from ... import figures
from ...master import Progress, stage
from ...sweeps import write_summary
from . import figures as sensitivity_figures
from . import pair_draws, vehicle_draws
from .draws import Study, Subject, carry_out
from .findings import Finding, all_findings, sentences
from .page import document, study_page

EVERYWHERE = {"C5": "holds in every draw: no open parameter enters"}
DRAWS, SEED = 8, 1  # a look in passing; docs/claims.md has the study that claims rest on


def subjects(*, full_vehicle: bool = True) -> list[Subject]:
    """What the paper's claims are about."""
    pair: Subject = pair_draws.subject()
    return [pair, vehicle_draws.subject()] if full_vehicle else [pair]


def studied(
    folder: Path, draws: int, seed: int, of: list[Subject], *, workers: int | None = None, progress: Progress | None = None
) -> tuple[dict[str, str], list[Path]]:
    """Study how far each claim holds, by draws from what the paper does not give.

    Parameters
    ----------
    folder
        Where pages, figures and rows are written; rows that are in draws_SUBJECT_DRAWS_SEED.csv already are not done again.
    draws, seed
        How many draws of each subject, at least 1, and the seed of the Latin hypercube.
    of
        The subjects.
    workers
        Processes, one a core where None.
    progress
        Called with the work done and the work in all.

    Returns
    -------
    texts, files
        Claim -> how far it holds, in words; everything written.
    """
    if draws < 1:
        raise ValueError(f"the number of draws must be at least 1, got {draws}")
    texts = dict(EVERYWHERE)
    pages: list[str] = []
    documents: list[dict[str, Any]] = []
    files: list[Path] = []
    everything: list[Finding] = []
    here: list[Finding] = []
    for place, subject in enumerate(of):
        study = Study(subject, draws, seed)
        files.append(folder / f"draws_{subject.name}_{draws}_{seed}.csv")
        table = carry_out(study, files[-1], workers=workers, progress=stage(progress, place / len(of), (place + 1) / len(of)))
        here = all_findings(study, table)
        texts |= sentences(here, tuple(subject.wheels))
        pages.append(study_page(study, table))
        documents.append(document(study, table))
        everything += here
    words, data = folder / "sensitivity.md", folder / "sensitivity.json"
    write_whole(words, "# How far does each claim hold?\n\n" + "\n".join(pages))
    write_summary(data, {"studies": documents})
    files += [words, data, figures.save(sensitivity_figures.shares(everything), folder / "claims_shares.png")]
    if any(finding.influences for finding in here):  # of what was studied last: the vehicle, whose parameters are many
        files.append(figures.save(sensitivity_figures.correlations(here), folder / "claims_correlations.png"))
    return texts, files
