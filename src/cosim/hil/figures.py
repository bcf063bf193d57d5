"""Figures about a test rig in the gyro unit's place: delay margins, the timing of a real-time run."""

from typing import TYPE_CHECKING

import numpy as np

from ..figures import COLOURS, figure, with_unit
from .delay_margin import DelayMap
from .realtime import Report

if TYPE_CHECKING:
    from matplotlib.figure import Figure


def delay_margins(result: "DelayMap", title: str) -> "Figure":
    """Draw the largest stable delay over a parameter, one line a macro step.

    Parameters
    ----------
    result
        Delays over the parameter and the macro step.
    title
        Above the figure.

    Returns
    -------
    Figure
    """
    fig, axes = figure(1, 1, (8.0, 5.0))
    ax = axes[0, 0]
    for k, (step, row) in enumerate(zip(result.steps, result.delay, strict=True)):
        ax.semilogy(result.values, row * 1e3, color=COLOURS[k % len(COLOURS)], marker="o", markersize=3, linewidth=1.1,
                    label=f"macro step {step * 1e3:g} ms")  # fmt: skip
    ax.axhline(result.longest * 1e3, color="0.3", linewidth=0.8, linestyle=":")
    ax.annotate("longest looked at", (result.values[-1], result.longest * 1e3), ha="right", va="bottom", fontsize=8, color="0.4")
    ax.set_xlabel(with_unit(result.parameter, result.unit))
    ax.set_ylabel("largest stable delay [ms]")
    ax.set_title(title, fontsize=10)
    ax.legend(fontsize=8)
    return fig


def timing(report: "Report") -> "Figure":
    """Draw how far the periods of a real-time run were off, and the latency step by step.

    Parameters
    ----------
    report
        Of the run's pacer.

    Returns
    -------
    Figure
    """
    fig, axes = figure(1, 2, (11.0, 4.0))
    counts, edges = report.histogram()
    axes[0, 0].bar(edges[:-1] * 1e6, counts, np.diff(edges) * 1e6, align="edge", color=COLOURS[0])
    axes[0, 0].set_yscale("symlog")
    axes[0, 0].set_xlabel("period less the wanted one [us]")
    axes[0, 0].set_ylabel("steps")
    axes[0, 1].plot(np.arange(report.steps), report.latency * 1e6, color=COLOURS[1], linewidth=0.6)
    axes[0, 1].set_xlabel("macro step")
    axes[0, 1].set_ylabel("latency [us]")
    fig.suptitle(f"{report.wanted * 1e3:g} ms: {report.steps} steps, {report.overruns} overruns")
    return fig
