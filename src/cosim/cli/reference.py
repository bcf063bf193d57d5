"""What `cosim run` compares its results with, and what drives the run from files: --reference, --input, --scenario."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

from ..errors import unknown
from ..master import Run
from ..systems import System
from ..systems.scenario import read_scenario
from ..systems.series import read_inputs
from .common import finite, needs

if TYPE_CHECKING:
    from ..comparison.reference import Judgement


def driven(system: System, inputs: Sequence[Path] | None, scenario: Path | None) -> System:
    """The system with the series of --input and the events of --scenario."""
    series = tuple(one for file in inputs or () for one in read_inputs(file))
    return replace(system, inputs=series, scenario=None if scenario is None else read_scenario(scenario))


@dataclass(frozen=True)
class Reference:
    """The reference of --reference, read before the run.

    Parameters
    ----------
    file : str
        For messages.
    signals : mapping
        See comparison.reference.
    band : Band
        What --tolerance-band says.
    """

    file: str
    signals: Any
    band: Any

    def ask(self, run: Run) -> "Judgement":
        """The run against it."""
        from ..comparison.reference import judged

        return judged(run.trajectory, self.signals, self.band)

    def document(self, judgement: "Judgement") -> dict[str, Any]:
        """As JSON holds it."""
        return {
            "file": self.file, "share": self.band.share, "time_s": self.band.time, "verdict": judgement.verdict,
            "undecided": judgement.undecided or None, "from_s": judgement.span[0], "to_s": judgement.span[1],
            "missing": list(judgement.missing),
            "signals": {s.name: {"distance": finite(s.distance), "at_s": s.at, "inside": s.inside} for s in judgement.signals},
        }  # fmt: skip

    def words(self, judgement: "Judgement") -> list[str]:
        """In words."""
        from ..comparison.reference import in_words

        return ["", *in_words(judgement, self.file, self.band)]


def read_reference_option(file: Path | None, band: str | None, system: System, names: Sequence[str]) -> Reference | None:
    """What --reference and --tolerance-band ask for; ValueError where the run has none of the reference's signals.

    names : of the signals that are recorded.
    """
    needs("--tolerance-band", band, "--reference", file is not None)
    if file is None:
        return None
    from ..comparison.reference import Band, read_reference

    try:
        wide = Band() if band is None else Band.of(band)
    except ValueError as error:
        raise ValueError(f"--tolerance-band {error}") from None
    signals = read_reference(file, system)
    if not set(signals) & set(names):
        raise ValueError(f"reference {str(file)!r}: {unknown('signal', next(iter(signals)), names)}")
    return Reference(str(file), signals, wide)
