"""The empty figure in this package's style, and what every figure has: labels with units, legends that cover no data."""

import re
from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from .styles import SCREEN, Style

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

RAISED = str.maketrans("-0123456789", "⁻⁰¹²³⁴⁵⁶⁷⁸⁹")


def figure(
    rows: int = 1,
    columns: int = 1,
    size: tuple[float, float] = (8.0, 5.0),
    *,
    sharex: bool = False,
    style: Style = SCREEN,
) -> tuple["Figure", np.ndarray]:
    """A figure in this package's style.

    Parameters
    ----------
    rows, columns
        Of panels.
    size
        Width and height on a screen, inches.
    sharex
        Whether the panels share their x axis.
    style
        Which may have a width of its own.

    Returns
    -------
    figure, axes
        The axes in an array of shape (rows, columns).
    """
    from matplotlib.figure import Figure

    fig = Figure(figsize=style.size(*size), layout="constrained")
    axes = fig.subplots(rows, columns, squeeze=False, sharex=sharex)
    for ax in axes.flat:
        ax.grid(alpha=0.3, linewidth=0.6)
        ax.spines[["top", "right"]].set_visible(False)
    return fig, axes


def unit_text(unit: str) -> str:
    """A unit as people write it: N·m·s²/rad for N.m.s2/rad."""
    return re.sub(r"(?<=[A-Za-z])-?\d+", lambda power: power[0].translate(RAISED), unit).replace(".", "·")


def with_unit(name: str, unit: str, between: str = " ") -> str:
    """A label for an axis; a pure number has no unit."""
    return f"{name}{between}[{unit_text(unit)}]" if unit not in ("", "1") else name


def as_it_stands(words: str) -> str:
    """Words that matplotlib shows as they are: dollars would begin a formula, a first underscore would hide a line's label."""
    words = words.replace("$", r"\$")
    return f" {words}" if words.startswith("_") else words


def legend_outside(fig: "Figure", ax: "Axes | Sequence[Axes]", title: str = "", **words: Any) -> None:
    """Put a title and the legend of panels above them all, where they cover no data; what has one label stands there once."""
    from matplotlib import rcParams

    found: dict[str, Any] = {}
    for one in [ax] if not isinstance(ax, Sequence) else ax:
        handles, labels = one.get_legend_handles_labels()
        for handle, label in zip(handles, labels, strict=True):
            found.setdefault(label, handle)
    if found:
        size = words.pop("fontsize", rcParams["legend.fontsize"])
        points = size if isinstance(size, float | int) else 0.85 * rcParams["font.size"]
        width = 0.085 * points / 10.0 * (max(map(len, found)) + 7)  # inches that one entry takes
        columns = int(np.clip(fig.get_figwidth() // width, 1, min(4, len(found))))
        fig.legend(found.values(), found.keys(), loc="outside upper center", ncols=columns, frameon=False, fontsize=size,
                   title=title or None, title_fontsize="medium", **words)  # fmt: skip
    elif title:
        fig.suptitle(title, fontsize="medium")


def legend_above(ax: "Axes", columns: int = 4, **words: Any) -> None:
    """Put the legend of one panel above it, flush right, where it covers no data."""
    ax.legend(loc="lower right", bbox_to_anchor=(1.0, 1.0), ncols=columns, frameon=False, borderaxespad=0.1, **words)
