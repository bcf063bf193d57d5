"""What a check finds: the thing, the rule and how bad it is."""

from collections.abc import Iterable
from dataclasses import dataclass
from typing import Literal, Protocol

Severity = Literal["fault", "warning", "note"]
LONGEST = 400  # characters of a message
SEVERITIES: tuple[Severity, ...] = ("fault", "warning", "note")


@dataclass(frozen=True)
class Finding:
    """One thing that a check has found.

    Parameters
    ----------
    rule
        Which check says so.
    message
        Names the thing, what must hold and what is, in one line.
    severity
        "fault": the FMU breaks the standard. "warning": it keeps to the standard, or breaks it harmlessly, but is likely to go
        wrong somewhere. "note": good to know.
    """

    rule: str
    message: str
    severity: Severity = "fault"

    def __str__(self) -> str:
        return f"{self.severity}: {self.rule}: {self.message}"


Findings = list[Finding]


class Say(Protocol):
    """How a probe tells what it finds."""

    def __call__(self, message: str, severity: Severity = "fault") -> None: ...


def in_order(findings: Iterable[Finding]) -> Findings:
    """Each finding once and in one line that can be read, the worst first."""
    lines = dict.fromkeys(Finding(f.rule, _line(f.message), f.severity) for f in findings)
    return sorted(lines, key=lambda f: SEVERITIES.index(f.severity))


def _line(text: str) -> str:
    line = " ".join(text.split())
    return line if len(line) <= LONGEST else f"{line[:LONGEST]} ..."
