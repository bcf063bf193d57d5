"""What a run says of railway vehicles, for the command line: its summary, its JSON and its figure.

The entry point `railway` of the group `gyro_cosim.assessments` names RAILWAY; what it must have stands in cli/assessments.py.
"""

import math
from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import TYPE_CHECKING, Any

from ..systems import System
from ..trajectory import Trajectory
from .acceptance import Acceptance, judge
from .assessment import LATERAL, Assessment, assess, vehicles_in
from .forms import CREEP_LAWS, creep_laws, with_creep_law

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from ..figures import Style

START = "1mm"  # how exactly a vehicle stands on its track, as we assume: the ledger's starts lie ten times as near


class Railway:
    """Railway vehicles, by the names of their outputs; see assessment.py."""

    key = "vehicles"

    def assess(self, trajectory: Trajectory) -> Sequence[Assessment]:
        """One assessment for each vehicle, with its table by EN 14363."""
        return [replace(found, acceptance=judge(trajectory, found)) for found in assess(trajectory)]

    def lines(self, finding: Assessment) -> list[str]:
        """Derailed or not, Y/Q, and how far each wheel pair has moved, in mm and mrad."""
        worst = finding.worst
        motion = "; ".join(
            f"{pair}: y {finding.lateral[pair][0] * 1e3:.3g} mm ({finding.lateral[pair][1] * 1e3:.2g} at the end), "
            f"psi {finding.yaw[pair][0] * 1e3:.3g} mrad ({finding.yaw[pair][1] * 1e3:.2g})"
            for pair in finding.pairs
        )
        coefficient = "recorded too coarsely for the filter of EN 14363"
        if worst is not None:
            limit = "above" if worst.exceeded else "within"
            coefficient = f"{worst.value:.3f} ({limit} its limit {worst.limit:g}), {worst.wheel}, s = {worst.distance:.1f} m"
        lines = ["", f"{finding.vehicle} {finding.verdict.text}", f"largest Y/Q by EN 14363: {coefficient}", f"largest {motion}"]
        return [*lines, *(finding.acceptance.lines if finding.acceptance else ())]

    def table(self, finding: Assessment) -> Acceptance | None:
        """The table by EN 14363 and EN 12299."""
        return finding.acceptance

    def document(self, finding: Assessment) -> dict[str, Any]:
        """The same as JSON holds it, in SI."""
        worst = finding.worst
        return {
            "vehicle": finding.vehicle,
            "derailed": finding.verdict.derailed,
            "verdict": finding.verdict.text,
            "worst_derailment_coefficient": None
            if worst is None
            else {"wheel": worst.wheel, "value": worst.value, "distance": worst.distance},
            "lateral": finding.lateral,
            "yaw": finding.yaw,
            "cause": finding.verdict.cause,
            "acceptance": None if finding.acceptance is None else finding.acceptance.document()["rows"],
        }

    def figure(self, finding: Assessment, trajectory: Trajectory, title: str) -> "Figure":
        """Motion, Y/Q, gimbals and speed over the distance along the track."""
        from .figures import along_track

        return along_track({"": (finding, trajectory)}, title)

    def overlay(self, runs: Mapping[str, tuple[Assessment, Trajectory]], title: str, style: "Style") -> "Figure":
        """The same of several runs, over one another."""
        from .figures import along_track

        return along_track(runs, title, style)

    def questions(self, names: Sequence[str]) -> list[str]:
        """Whether each vehicle derails and keeps the limit of Y/Q."""
        return [question for vehicle, _, _ in vehicles_in(names) for question in (_derailed(vehicle), _within(vehicle))]

    def answers(self, finding: Assessment) -> dict[str, str]:
        """Yes or no; nothing of Y/Q where the filter of EN 14363 cannot be used."""
        made = {_derailed(finding.vehicle): "yes" if finding.verdict.derailed else "no"}
        if finding.verdict.unfinished:
            made = {}  # it may derail farther on
        if finding.worst is not None:
            made[_within(finding.vehicle)] = "no" if finding.worst.exceeded else "yes"
        return made

    def measures(self, finding: Assessment) -> dict[str, tuple[float, str]]:
        """The largest Y/Q, NaN without the filter, and how far the farthest flange stayed below the top of its rail."""
        return {
            f"{finding.vehicle}: largest Y/Q": (math.nan if finding.worst is None else finding.worst.value, "1"),
            f"{finding.vehicle}: distance to derailment, of the flange's way over the rail": (1.0 - finding.climb, "1"),
        }

    def starts(self, names: Sequence[str]) -> dict[str, str]:
        """The lateral displacement of the first wheel pair of each vehicle, within START."""
        return {f"{vehicle}.{pairs[0]}{LATERAL}": START for vehicle, _, pairs in vehicles_in(names) if pairs}

    def forms(self, system: System) -> Mapping[str, System]:
        """The system with each other creep law that its vehicle comes with."""
        made = {}
        for component in system.components:
            for law in creep_laws(component.source)[1:]:
                words = f"with {CREEP_LAWS[law][1]} ({component.name} = {CREEP_LAWS[law][0]})"
                made[words] = with_creep_law(system, component.name, law)
        return made


def _derailed(vehicle: str) -> str:
    return f"{vehicle}: derailed"


def _within(vehicle: str) -> str:
    return f"{vehicle}: Y/Q within its limit"


RAILWAY = Railway()
