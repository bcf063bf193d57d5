"""Figures: each function draws one and returns it; save() writes it."""

import textwrap
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from gyro_cosim.component.whole_files import whole_file

from .trajectory import Trajectory

if TYPE_CHECKING:
    from matplotlib.figure import Figure


COLOURS = ("#0072b2", "#d55e00", "#009e73", "#cc79a7", "#e69f00", "#56b4e9")  # Okabe and Ito: told apart by everyone


def figure(
    rows: int = 1, columns: int = 1, size: tuple[float, float] = (8.0, 5.0), *, sharex: bool = False
) -> tuple["Figure", np.ndarray]:
    """A figure in this package's style.

    Parameters
    ----------
    rows, columns
        Of panels.
    size
        Width and height, inches.
    sharex
        Whether the panels share their x axis.

    Returns
    -------
    figure, axes
        The axes in an array of shape (rows, columns).
    """
    from matplotlib.figure import Figure

    fig = Figure(figsize=size, layout="constrained")
    axes = fig.subplots(rows, columns, squeeze=False, sharex=sharex)
    for ax in axes.flat:
        ax.grid(alpha=0.3, linewidth=0.6)
        ax.spines[["top", "right"]].set_visible(False)
    return fig, axes


def with_unit(name: str, unit: str) -> str:
    """A label for an axis; a pure number has no unit."""
    return f"{name} [{unit}]" if unit not in ("", "1") else name


def save(fig: "Figure", file: str | Path) -> Path:
    """Write a figure in the format that the file's ending names.

    Parameters
    ----------
    fig
        The figure.
    file
        Where to; its folder is made.

    Returns
    -------
    Path
        Of the file.
    """
    file = Path(file)
    file.parent.mkdir(parents=True, exist_ok=True)
    with whole_file(file) as beside:
        fig.savefig(beside, dpi=150)
    return file


def check_format(file: Path) -> None:
    """Refuse a file name whose ending is no format matplotlib writes."""
    from matplotlib.backend_bases import FigureCanvasBase

    known = FigureCanvasBase.get_supported_filetypes()
    if file.suffix.removeprefix(".").lower() not in known:
        raise ValueError(f"plot file must end in one of {', '.join(sorted('.' + k for k in known))}, got {str(file)!r}")


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
    """Draw signals over time, one panel each.

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
    fig, axes = figure(len(names), 1, (8.0, 1.2 + 1.5 * len(names)), sharex=True)
    for ax, name, colour in zip(axes[:, 0], names, COLOURS * len(names), strict=False):
        unit = trajectory.unit(name)
        ax.plot(trajectory.t, trajectory[name], color=colour, linewidth=1.2)
        words = textwrap.fill(name.partition(".")[2].replace("_", " ") or name, 18)
        ax.set_ylabel(f"{words}\n[{unit}]" if unit not in ("", "1") else words, fontsize=9)
        ax.set_title(name, loc="right", fontsize=8, color="0.4")
        ax.margins(x=0)
    axes[-1, 0].set_xlabel("time [s]")
    fig.align_ylabels()
    if title:
        fig.suptitle(title)
    return fig


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
