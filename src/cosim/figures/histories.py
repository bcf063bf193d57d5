"""Time histories: one panel a signal, one line a run."""

import textwrap
from collections.abc import Callable, Mapping, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from ..trajectory import Trajectory
from .canvas import as_it_stands, figure, legend_outside, with_unit
from .overlays import TIME, Overlay
from .styles import COLOURS, SCREEN, Style, line_style

if TYPE_CHECKING:
    from matplotlib.figure import Figure

MOST_IN_A_COLUMN = 3  # panels of a figure over two columns of a paper, above one another


def worth_drawing(trajectory: Trajectory, most: int, rank: Callable[[str], Any]) -> list[str]:
    """Which signals a figure shows that has room for a few.

    Parameters
    ----------
    trajectory
        Of a run.
    most
        How many signals.
    rank
        Name -> what to sort by; the lowest come first, equal ones in the trajectory's order.

    Returns
    -------
    names
        Signals that change; the first signals where none does.
    """
    moving = [name for name in trajectory.names if trajectory[name].min() < trajectory[name].max()]
    return sorted(moving, key=rank)[:most] or list(trajectory.names[:most])


def time_histories(trajectory: Trajectory, names: Sequence[str], title: str = "") -> "Figure":
    """Draw signals of one run over time, one panel each.

    Parameters
    ----------
    trajectory
        Of a run.
    names
        Of the signals.
    title
        Above the figure.

    Returns
    -------
    Figure
    """
    return drawn_overlay(Overlay.of({"": trajectory}, names), title)


def drawn_overlay(overlay: Overlay, title: str = "", style: Style = SCREEN) -> "Figure":
    """Draw signals of several runs over one another, one panel a signal, with the legend above all of them.

    Parameters
    ----------
    overlay
        What is drawn.
    title
        Above the figure, where the style has titles.
    style
        Of the figure.

    Returns
    -------
    Figure
    """
    panels, several = overlay.panels, len(overlay.labels) > 1
    columns = 2 if style.width > 6.0 and len(panels) > MOST_IN_A_COLUMN else 1
    rows = -(-len(panels) // columns)
    fig, axes = figure(rows, columns, (8.0, 1.2 + 1.5 * rows), sharex=True, style=style)
    if style.width:
        fig.set_figheight(0.5 + 0.16 * several + max(style.panel * rows, 1.6))
    for k, (ax, panel) in enumerate(zip(axes.T.flat, panels, strict=False)):
        for n, line in enumerate(panel.lines):
            place = overlay.labels.index(line.label) if several else n
            look = line_style(place, style, rows=line.x.size if several else 0)
            if not several and not style.width:
                look["color"] = COLOURS[k % len(COLOURS)]
            ax.plot(line.x, line.y, label=as_it_stands(line.label), **look)
            ax.plot(*_alone(line.x, line.y), "o", color=look["color"], markersize=3.0 + style.line)
        ax.set_ylabel(_label(panel.name, panel.unit, [p.name for p in panels], style), fontsize="medium" if style.width else 9)
        if not style.width:
            ax.set_title(as_it_stands(panel.name), loc="right", fontsize=8, color="0.4")
        ax.margins(x=0 if overlay.over == TIME else 0.03)
    for ax in axes.T.flat[len(panels) :]:
        ax.set_visible(False)
    for column in axes.T:
        last = [ax for ax in column if ax.get_visible()][-1]
        last.set_xlabel(with_unit(_words(overlay.over), overlay.unit))
        last.tick_params(labelbottom=True)
    fig.align_ylabels()
    legend_outside(fig, list(axes.flat) if several else [], as_it_stands(title) if style.titled else "")
    return fig


def _alone(x: np.ndarray, y: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """The points between two gaps, of which a line shows nothing."""
    there = np.concatenate([[False], np.isfinite(y), [False]])
    alone = there[1:-1] & ~there[:-2] & ~there[2:]
    return x[alone], y[alone]


def _words(name: str) -> str:
    """A signal's name as people say it, without its component."""
    return as_it_stands((name.partition(".")[2] or name).replace("_", " "))


def _label(name: str, unit: str, all_names: Sequence[str], style: Style) -> str:
    """Of an axis; with the component where another signal is called alike and no name stands above the panel."""
    words = _words(name)
    if style.width and sum(_words(other) == words for other in all_names) > 1:
        words = as_it_stands(name.replace(".", " ", 1).replace("_", " "))
    return with_unit(textwrap.fill(words, 14 if style.width else 18), unit, "\n")


def histories_in_columns(cases: Mapping[str, Trajectory], signals: Mapping[str, tuple[str, str, float]]) -> "Figure":
    """Draw signals of several runs over time: one row a case, one column a signal.

    Parameters
    ----------
    cases
        Title -> trajectory.
    signals
        Name -> label, unit shown, and factor to it.

    Returns
    -------
    Figure
    """
    fig, axes = figure(len(cases), len(signals), (4.2 * len(signals), 2.8 * len(cases)), sharex=True)
    for row, (case, trajectory) in zip(axes, cases.items(), strict=True):
        for ax, (name, (label, unit, factor)), colour in zip(row, signals.items(), COLOURS, strict=False):
            ax.plot(trajectory.t, trajectory[name] * factor, color=colour, linewidth=1.0)
            ax.axhline(0.0, color="0.3", linewidth=0.6)
            ax.set_ylabel(f"{label} [{unit}]")
            ax.set_title(case, fontsize=9)
            ax.margins(x=0)
    for ax in axes[-1]:
        ax.set_xlabel("time [s]")
    return fig
