"""How figures look: on a screen, or in one or two columns of a paper; and how lines are told apart, in grey too."""

from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass, field
from typing import Any

COLOURS = ("#0072b2", "#d55e00", "#009e73", "#cc79a7", "#e69f00", "#56b4e9")  # Okabe and Ito: told apart by everyone
DASHES: tuple[Any, ...] = ("-", (0, (5, 1.5)), (0, (1.2, 1.2)), (0, (6, 1.5, 1.2, 1.5)), (0, (9, 2)), (0, (3, 1, 1, 1, 1, 1)))
MARKERS = ("", "o", "s", "^", "D", "v")
LINES = 12  # that one panel can hold and people still tell apart
MILLIMETRE = 1 / 25.4  # inches


@dataclass(frozen=True)
class Style:
    """How a figure looks.

    Parameters
    ----------
    width : float
        Of the figure, inches; 0 leaves it to the figure.
    panel : float
        Height of one panel of a time history, inches.
    line : float
        Width of a line, points.
    titled : bool
        Whether a title stands above the figure; a paper has captions.
    settings : mapping
        Of matplotlib.
    """

    width: float = 0.0
    panel: float = 1.5
    line: float = 1.2
    titled: bool = True
    settings: Mapping[str, Any] = field(default_factory=dict)

    @contextmanager
    def applied(self) -> Iterator[None]:
        """While it lasts, what is drawn and saved has this style."""
        from matplotlib import rc_context

        with rc_context(dict(self.settings)):
            yield

    def size(self, width: float, height: float) -> tuple[float, float]:
        """The size of a figure (inches) that would be `width` by `height` on a screen."""
        return (width, height) if not self.width else (self.width, max(height * self.width / width, 0.62 * self.width))


SCREEN = Style()
SIZES = {1: 88.0, 2: 180.0}  # mm, of one and of two columns of a paper, as most publishers have them
PAPER = {
    "font.size": 8.0, "axes.labelsize": 8.0, "axes.titlesize": 8.0, "figure.titlesize": 8.0, "legend.fontsize": 7.5,
    "xtick.labelsize": 7.5, "ytick.labelsize": 7.5, "axes.linewidth": 0.6, "xtick.major.width": 0.6, "ytick.major.width": 0.6,
    "xtick.major.size": 2.5, "ytick.major.size": 2.5, "grid.linewidth": 0.4,
    "savefig.dpi": 600, "axes.formatter.limits": (-3, 4), "axes.formatter.use_mathtext": True,
}  # fmt: skip


def paper(columns: int) -> Style:
    """The style of a figure as wide as one or two columns of a paper."""
    if columns not in SIZES:
        raise ValueError(f"--columns must be 1 or 2, got {columns}")
    return Style(width=SIZES[columns] * MILLIMETRE, panel=1.05, line=0.9, titled=False, settings=PAPER)


def line_style(k: int, style: Style = SCREEN, *, rows: int = 0) -> dict[str, Any]:
    """How line `k` of a panel is drawn: a colour, and dashes of its own, so that grey suffices.

    rows : of the line, where others lie beside it, so that it needs a marker, too: some six, evenly over its rows.
    """
    n = len(COLOURS)
    drawn = {"color": COLOURS[k % n], "linestyle": DASHES[k % n], "linewidth": style.line}
    marker = MARKERS[(k + k // n) % n]
    if rows and marker:
        apart = max(1, rows // 6)
        drawn |= {"marker": marker, "markevery": (apart * (1 + k % n) // (n + 1), apart), "markersize": 3.0 + style.line}
    return drawn
