"""How far does each claim hold? From the rows of a study of draws: shares, what decides them, the middle, and a ranking.

A claim holds in a draw where all its parts do; its margin is that of its worst part. What decides it is what its truth
correlates with. Where nearly all draws agree, truth tells nothing, and the margin says at least what moves it: among draws that
fail, though, it may be a matter of size only (the amplitude of a hunting vehicle grows with the clearance of its flanges).
The ranking orders draws by how many parts of all claims hold at once: the rule by which a parameter set can be chosen from
the open ranges and found again.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from ...sweeps.table import Table
from .draws import DRAW, MARGIN, MIDDLE, Study
from .open_parameters import TIED, coordinates
from .statistics import Influence, Share, influences, wilson

MOST = 3  # parameters that a sentence names
EITHER = 10  # draws at least in which a claim holds, and does not, for its truth to be correlated with anything


@dataclass(frozen=True)
class Finding:
    """How far a claim, or a part of it, holds for one kind of wheels. middle : whether it does at the middle of all ranges.

    influences : on its truth where `mixed`, else on its margin.
    """

    claim: str
    part: str  # "" for the whole claim
    wheels: str
    share: Share
    influences: tuple[Influence, ...]
    middle: bool | None

    @property
    def mixed(self) -> bool:
        """Whether it holds in enough draws, and fails in enough, to ask what decides."""
        return min(self.share.count, self.share.judged - self.share.count) >= EITHER

    @property
    def deciding(self) -> tuple[Influence, ...]:
        """The strongest influences that are more than chance."""
        return tuple(i for i in self.influences if i.counts)[:MOST]

    @property
    def text(self) -> str:
        """For people."""
        words = f"holds {self.share.text}"
        moved = ", ".join(f"{shown(i.target)} ({i.rho:+.2f})" for i in self.deciding)
        if moved:
            words += f"; decided by {moved}" if self.mixed else f"; its margin moves with {moved}"
        elif self.mixed:
            words += "; no parameter decides it beyond chance"
        if self.middle is not None:
            words += f"; at the middle of all ranges it {'holds' if self.middle else 'does not'}"
        return words


@dataclass(frozen=True)
class Ranked:
    """A row by its score: how many parts of all claims hold, and how many whole claims."""

    kind: str
    draw: int
    wheels: str
    parts: int
    claims: int
    row: int

    @property
    def name(self) -> str:
        """For people."""
        return f"draw {self.draw}" if self.kind == DRAW else "middle of all ranges" if self.kind == MIDDLE else self.kind


def all_findings(study: Study, table: Table) -> list[Finding]:
    """Of every claim and every part, for each kind of wheels: the whole claim first."""
    found = []
    for claim, parts in study.subject.claims.items():
        for part in ("", *parts):
            found += [_finding(study, table, claim, part, wheels) for wheels in study.subject.wheels]
    return found


def margin_of(study: Study, table: Table, claim: str, part: str = "") -> np.ndarray:
    """The margin of a part, or of a claim's worst part, shape (rows,); nan where it could not be judged."""
    parts = (part,) if part else tuple(study.subject.claims[claim])
    return np.asarray(np.min([table[f"{claim}: {p}{MARGIN}"] for p in parts], axis=0))  # nan wherever any part is


def _finding(study: Study, table: Table, claim: str, part: str, wheels: str) -> Finding:
    margin = margin_of(study, table, claim, part)
    of_wheels = table["wheels"] == wheels
    drawn, centre = of_wheels & (table["kind"] == DRAW), of_wheels & (table["kind"] == MIDDLE)
    here = margin[drawn]
    columns = {group[0]: table[group[0]][drawn] for group in coordinates(study.subject.parameters)}
    at_middle = margin[centre]
    middle = None if not at_middle.size or np.isnan(at_middle[0]) else bool(at_middle[0] > 0.0)
    share = wilson(int((here > 0.0).sum()), int((~np.isnan(here)).sum()))
    found = Finding(claim, part, wheels, share, (), middle)
    truth = np.where(np.isnan(here), np.nan, here > 0.0)
    return replace(found, influences=influences(columns, truth if found.mixed else here))


def ranking(study: Study, table: Table) -> list[Ranked]:
    """All rows, those where most parts hold first; among equals where most claims do, then in the table's order."""
    claims = study.subject.claims
    margins = {claim: np.array([margin_of(study, table, claim, p) for p in parts]) for claim, parts in claims.items()}
    parts = np.sum([(m > 0.0).sum(axis=0) for m in margins.values()], axis=0)
    whole = np.sum([(m > 0.0).all(axis=0) for m in margins.values()], axis=0)
    order = sorted(range(len(table)), key=lambda row: (-parts[row], -whole[row], row))
    return [
        Ranked(str(table["kind"][r]), int(table["draw"][r]), str(table["wheels"][r]), int(parts[r]), int(whole[r]), r)
        for r in order
    ]


def sentences(found: Sequence[Finding], wheels: Sequence[str]) -> dict[str, str]:
    """Claim -> what the ledger says of its sensitivity."""
    whole = [finding for finding in found if not finding.part]
    lines: Mapping[str, list[Finding]] = {f.claim: [g for g in whole if g.claim == f.claim] for f in whole}
    several = len(wheels) > 1
    return {claim: ". ".join((f"{f.wheels}: " if several else "") + f.text for f in of) for claim, of in lines.items()}


def shown(target: str) -> str:
    """A parameter's name for people; those that are drawn together are named together."""
    together = next((group for group in TIED if target in group), (target,))
    return " and ".join(name.partition(".")[2].replace("_", " ") for name in together)
