"""What a run says about its vehicle or plant: each field of engineering registers what it finds in a run.

The master is general, so the command line asks whoever is installed. A package offers its field through the entry point group
`gyro_cosim.assessments`, as `railway` does in pyproject.toml: the entry point names an object that is a Field.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from importlib import metadata
from typing import TYPE_CHECKING, Any, Protocol, runtime_checkable

from rich.table import Table

from ..systems import System
from ..trajectory import Trajectory

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from ..figures import Style

GROUP = "gyro_cosim.assessments"


class Field(Protocol):
    """A field of engineering, which knows its own things by the names of their signals.

    Attributes
    ----------
    key : str
        Under which its findings stand in `cosim run --json`, a list with one entry a thing, such as "vehicles".
    """

    key: str

    def assess(self, trajectory: Trajectory) -> Sequence[Any]:
        """One finding for each thing of this field whose signals were recorded; empty where there is none."""

    def lines(self, finding: Any) -> Sequence[str]:
        """A finding in words, as the summary of a run shows it."""

    def document(self, finding: Any) -> Mapping[str, Any]:
        """A finding as JSON holds it, SI units in the names of what is not in SI."""

    def figure(self, finding: Any, trajectory: Trajectory, title: str) -> "Figure":
        """The figure that `cosim run --plot` draws of it, in the place of plain time histories."""


@runtime_checkable
class Deciding(Protocol):
    """What a field has besides, where its findings hold verdicts that `--robust` of `cosim run` and `compare` can ask again."""

    def questions(self, names: Sequence[str]) -> Sequence[str]:
        """What it decides in a run that records these signals, such as "vehicle: derailed"; empty where it is nothing."""

    def answers(self, finding: Any) -> Mapping[str, str]:
        """The answers that a finding gives, by question; a question that it cannot answer is left out."""

    def starts(self, names: Sequence[str]) -> Mapping[str, str]:
        """The start values that nobody knows exactly, `component.variable`, and how far away they may be: "1mm"."""

    def forms(self, system: System) -> Mapping[str, System]:
        """Other forms of the same model, in words ("with the creep law of ...") and as the system to run."""


@runtime_checkable
class Measuring(Protocol):
    """What a field has besides, where its findings hold figures that `cosim run --robust` can give error bars."""

    def measures(self, finding: Any) -> Mapping[str, tuple[float, str]]:
        """Name -> value and unit, "1" for a pure number; NaN for a value that this run does not have."""


@runtime_checkable
class Overlaying(Protocol):
    """What a field has besides, where it can draw several runs over one another, in any style."""

    def overlay(self, runs: Mapping[str, tuple[Any, Trajectory]], title: str, style: "Style") -> "Figure":
        """The figure of `cosim plot` without names: label -> what was found in a run, and the run."""


class Tabled(Protocol):
    """A table of a finding.

    Attributes
    ----------
    title : str
        What it says, in a line.
    head : tuple of str
        Of its columns.
    cells : list of tuple of str
        Its rows.
    """

    @property
    def title(self) -> str: ...
    @property
    def head(self) -> tuple[str, ...]: ...
    @property
    def cells(self) -> list[tuple[str, ...]]: ...


@runtime_checkable
class Tabulating(Protocol):
    """What a field has besides, where its findings hold a table, which `cosim run --assess` and the page of a run show."""

    def table(self, finding: Any) -> Tabled | None:
        """The table; None where a finding has none."""


@dataclass(frozen=True)
class Assessed:
    """What one field found in a run."""

    field: Field
    findings: tuple[Any, ...]


def fields() -> list[Field]:
    """Every registered field, by name. RuntimeError names one that cannot be loaded."""
    return [_loaded(entry) for entry in sorted(metadata.entry_points(group=GROUP), key=lambda entry: entry.name)]


def _loaded(entry: metadata.EntryPoint) -> Field:
    try:
        field: Field = entry.load()
    except Exception as error:  # another package's code can fail in any way; people need one line
        raise RuntimeError(f"assessment {entry.name!r} ({entry.value}) cannot be loaded: {error}") from error
    for name in ("key", "assess", "lines", "document", "figure"):
        if not hasattr(field, name):
            raise RuntimeError(f"assessment {entry.name!r} ({entry.value}) must have {name!r}, {type(field).__name__} has none")
    return field


def assessed(trajectory: Trajectory) -> list[Assessed]:
    """What every registered field finds in a run."""
    return [Assessed(field, tuple(field.assess(trajectory))) for field in fields()]


def documents(found: Sequence[Assessed], taken: Mapping[str, Any]) -> dict[str, Any]:
    """The findings by their fields' keys, none of which may be among those that are taken."""
    made: dict[str, Any] = {}
    for one in found:
        if one.field.key in taken or one.field.key in made:
            raise RuntimeError(f"the key of an assessment must be its own, {one.field.key!r} is taken")
        made[one.field.key] = [one.field.document(finding) for finding in one.findings]
    return made


def lines(found: Sequence[Assessed]) -> list[str]:
    """All findings in words."""
    return [line for one in found for finding in one.findings for line in one.field.lines(finding)]


def figure(found: Sequence[Assessed], trajectory: Trajectory, title: str) -> "Figure | None":
    """The figure of the first finding; None where nobody has found anything."""
    for one in found:
        for finding in one.findings:
            return one.field.figure(finding, trajectory, title)
    return None


def overlay(runs: Mapping[str, Trajectory], title: str, style: "Style") -> "Figure | None":
    """The figure of several runs by the first field that finds something in each; None where there is no such field."""
    for field in fields():
        if isinstance(field, Overlaying):
            found = {label: field.assess(run) for label, run in runs.items()}
            if all(found.values()):
                return field.overlay({label: (found[label][0], run) for label, run in runs.items()}, title, style)
    return None


def tables(found: Sequence[Assessed]) -> list[Tabled]:
    """The tables of all findings that have one."""
    kept = [(one.field, finding) for one in found for finding in one.findings if isinstance(one.field, Tabulating)]
    return [table for field, finding in kept if (table := field.table(finding)) is not None]


def drawn(table: Tabled) -> Table:
    """A table as a terminal shows it."""
    made = Table(box=None, pad_edge=False)
    for words in table.head:
        made.add_column(words, no_wrap=True)
    for row in table.cells:
        made.add_row(*row)
    return made


def tabulated(found: Sequence[Assessed]) -> list[str | Table]:
    """What `cosim run --assess` prints."""
    shown = [part for table in tables(found) for part in ("", table.title, drawn(table))]
    return shown or ["nothing here is assessed in a table: a railway vehicle is, by the names of its outputs"]
