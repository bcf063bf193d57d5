"""The ledger: what a source claims, what we measured, a verdict that is computed, and how far it holds."""

from collections.abc import Sequence
from dataclasses import asdict, dataclass, field
from typing import Any


@dataclass(frozen=True)
class Claim:
    """One row of the ledger.

    Parameters
    ----------
    id, where, claim
        Its number, where the paper makes it, and what it says.
    paper, measured
        What the paper shows, and what was computed, in words with numbers.
    parts
        For each part of the claim, whether it holds.
    note
        Anything else.
    sensitivity
        For what share of the parameters not given in the paper the claim holds; empty where that was not studied.
    undecided
        Part -> why it cannot be decided: what of the model's form, its steps or its start turns it. Such a part counts neither
        way.
    survives
        Of what was asked again and what came of it, in words; empty where nothing was.
    """

    id: str
    where: str
    claim: str
    paper: str
    measured: str
    parts: dict[str, bool]
    note: str = ""
    sensitivity: str = ""
    undecided: dict[str, str] = field(default_factory=dict)
    survives: str = ""

    @property
    def verdict(self) -> str:
        """ "reproduced" if every part of the claim holds, "not reproduced" if none does, else "partly" with what does not.

        What cannot be decided is said behind it, or alone where nothing else is left.
        """
        decided = {name: holds for name, holds in self.parts.items() if name not in self.undecided}
        missing = [name for name, holds in decided.items() if not holds]
        open_ = "not decidable: " + "; ".join(f"{name} ({why})" for name, why in self.undecided.items())
        if self.undecided and not decided:
            return open_
        words = "partly: all but " + "; ".join(missing)
        if not missing:
            words = "reproduced"
        elif len(missing) == len(decided):
            words = "not reproduced: " + "; ".join(missing)
        return words if not self.undecided else f"{words}; {open_}"


def document(claims: Sequence[Claim]) -> list[dict[str, Any]]:
    """The ledger as JSON holds it."""
    return [asdict(claim) | {"verdict": claim.verdict} for claim in claims]


def markdown(claims: Sequence[Claim], title: str) -> str:
    """The ledger as a Markdown page."""
    columns = ("id", "where", "claim", "the paper shows", "measured", "verdict", "asked again", "sensitivity", "note")
    head = f"| {' | '.join(columns)} |\n|{'---|' * len(columns)}\n"
    cells = ((c.id, c.where, c.claim, c.paper, c.measured, c.verdict, c.survives, c.sensitivity, c.note) for c in claims)
    rows = (f"| {' | '.join(row)} |".replace("\n", " ") for row in cells)
    return f"# {title}\n\n{head}" + "\n".join(rows) + "\n"
