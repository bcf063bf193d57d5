"""What a run says of railway vehicles, for the command line: its summary, its JSON and its figure.

The entry point `railway` of the group `gyro_cosim.assessments` names RAILWAY; what it must have stands in cli/assessments.py.
"""

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

from ..trajectory import Trajectory
from .assessment import Assessment, assess

if TYPE_CHECKING:
    from matplotlib.figure import Figure


class Railway:
    """Railway vehicles, by the names of their outputs; see assessment.py."""

    key = "vehicles"

    def assess(self, trajectory: Trajectory) -> Sequence[Assessment]:
        """One assessment for each vehicle."""
        return assess(trajectory)

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
        return ["", f"{finding.vehicle} {finding.verdict.text}", f"largest Y/Q by EN 14363: {coefficient}", f"largest {motion}"]

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
        }

    def figure(self, finding: Assessment, trajectory: Trajectory, title: str) -> "Figure":
        """Displacements, forces and Y/Q over the distance along the track."""
        from .figures import along_track

        return along_track(trajectory, finding, title)


RAILWAY = Railway()
