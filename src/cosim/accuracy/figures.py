"""The figure of a convergence ladder."""

from typing import TYPE_CHECKING

import numpy as np

from ..figures import COLOURS, figure
from .convergence import Convergence

if TYPE_CHECKING:
    from matplotlib.figure import Figure


def convergence(result: "Convergence") -> "Figure":
    """Draw errors over macro steps, both logarithmic, with the observed orders of accuracy and slopes to compare with.

    Parameters
    ----------
    result
        Of `converge`.

    Returns
    -------
    Figure
    """
    fig, axes = figure(1, 1, (8.0, 5.5))
    ax = axes[0, 0]
    markers = {"jacobi": "o", "gauss-seidel": "s"}
    for ladder in result.ladders:
        a = ladder.algorithm
        h, e, used = np.array(ladder.steps), np.array(ladder.errors), np.array(ladder.used)
        e[~np.isfinite(e)] = np.nan  # a run that did not get through has no place here
        style = {"color": COLOURS[a.degree], "marker": markers.get(a.name, "^"), "linestyle": "-" if a.name == "jacobi" else "--"}
        ax.loglog(
            h * 1e3,
            e,
            **style,
            markersize=5,
            linewidth=1.2,
            label=f"{a.name}, degree {a.degree}: observed order {ladder.observed_order:.2f}",
        )
        ax.loglog(h[~used] * 1e3, e[~used], "x", color="0.3", markersize=9)
    low, high = min(result.ladders[0].steps) * 1e3, max(result.ladders[0].steps) * 1e3
    for degree in sorted({ladder.algorithm.degree for ladder in result.ladders}):
        top = max(e for x in result.ladders if x.algorithm.degree == degree for e in x.errors if np.isfinite(e))
        ax.loglog([low, high], [3 * top * (low / high) ** (degree + 1), 3 * top], color="0.6", linewidth=0.8, linestyle=":")
        ax.annotate(f"order {degree + 1}", (low, 3 * top * (low / high) ** (degree + 1)), color="0.4", fontsize=8,
                    xytext=(0, 6), textcoords="offset points", rotation=0)  # fmt: skip
    ticks = sorted({h * 1e3 for ladder in result.ladders for h in ladder.steps})
    ax.set_xticks(ticks, [f"{tick:g}" for tick in ticks])
    ax.set_xticks([], minor=True)
    ax.set_xlabel("macro step [ms]")
    ax.set_ylabel("largest relative error of an output")
    ax.set_title(f"{result.system.name} to {result.stop:g} s against the {result.reference}", fontsize=10)
    ax.legend(fontsize=8)
    return fig
