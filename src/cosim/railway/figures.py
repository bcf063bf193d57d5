"""The figure of a railway vehicle's run."""

from typing import TYPE_CHECKING

import numpy as np

from ..figures import COLOURS, figure
from ..trajectory import Trajectory
from .assessment import COEFFICIENT, DISTANCE, FORCE, LATERAL, YAW, Assessment
from .safety import LIMIT

if TYPE_CHECKING:
    from matplotlib.figure import Figure


def along_track(trajectory: Trajectory, assessment: "Assessment", title: str = "") -> "Figure":
    """Draw lateral displacement, yaw angle, Y and Y/Q of a railway vehicle over the distance along the track.

    Parameters
    ----------
    trajectory
        Of the run.
    assessment
        Of the vehicle to draw.
    title
        Above the figure.

    Returns
    -------
    Figure
    """
    fig, axes = figure(4, 1, (9.0, 9.0), sharex=True)
    distance = trajectory[f"{assessment.vehicle}.{DISTANCE}"]
    panels = (
        (assessment.pairs, LATERAL, "lateral displacement y\n[mm]", 1e3),
        (assessment.pairs, YAW, "yaw angle $\\psi$\n[mrad]", 1e3),
        (assessment.wheels, FORCE, "lateral force Y\n[kN]", 1e-3),
        (assessment.wheels, COEFFICIENT, "Y/Q\n[1]", 1.0),
    )
    for ax, (wheels, suffix, label, factor) in zip(axes[:, 0], panels, strict=True):
        for wheel, colour in zip(wheels, COLOURS * len(wheels), strict=False):
            name = f"{assessment.vehicle}.{wheel}{suffix}"
            if name in trajectory.names:
                ax.plot(distance, trajectory[name] * factor, color=colour, linewidth=0.9, label=wheel.replace("_", " "))
        ax.set_ylabel(label)
        ax.legend(fontsize=7, ncols=4, loc="upper right")
        ax.margins(x=0)
    ratio = axes[-1, 0]
    low, high = (np.clip(limit, -3.0, 3.0) for limit in ratio.get_ylim())
    ratio.set_ylim(low, max(high, 1.1))
    for sign in (-1, 1):
        if low < sign * LIMIT:
            ratio.axhline(sign * LIMIT, color="0.3", linewidth=0.8, linestyle=":")
    words = {"fontsize": 7, "color": "0.3", "va": "bottom", "ha": "right", "backgroundcolor": (1, 1, 1, 0.6)}
    ratio.annotate(f"EN 14363 limit of the filtered value: {LIMIT:g}", (distance[-1], LIMIT), **words)
    ratio.set_xlabel("distance along the track [m]")
    fig.align_ylabels()
    fig.suptitle(f"{title}\n{assessment.verdict.text}", fontsize=10)
    return fig
