"""Maps of a sweep: a measure over two axes as colours, or over one as a curve; one panel for each value of the others."""

from collections.abc import Sequence
from itertools import product
from typing import TYPE_CHECKING, Any

import numpy as np

from .. import figures
from .table import Table

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

MOST_PANELS = 9
MOST_CURVES = len(figures.COLOURS)


def selected(table: Table, column: str, text: str) -> Table:
    """The rows with one value in a column.

    Parameters
    ----------
    table
        Of a sweep.
    column
        By name.
    text
        The value, with a unit where wanted.

    Returns
    -------
    Table

    Raises
    ------
    ValueError
        Where no row has the value.
    """
    from gyro_cosim.component.units import quantity

    known = table[column]
    if known.dtype.kind == "U":
        chosen = known == text
    else:
        value = quantity(text, table.unit(column) or "1")
        chosen = np.isclose(known, value, rtol=1e-6, atol=0.0)
    if not chosen.any():
        values = np.unique(known)
        said = ", ".join(map(str, values.tolist())) if values.size <= 12 else f"{values.size} values, {values[0]} to {values[-1]}"
        raise ValueError(f"{column!r} must have a value of the sweep, which are {said}; got {text!r}")
    return table.where(chosen)


def map_of(table: Table, x: str, y: str, measure: str, style: figures.Style = figures.SCREEN) -> "Figure":
    """Draw a measure as colour over two columns: cells where both are listed axes, points where they were sampled.

    Parameters
    ----------
    table
        Of a sweep.
    x, y, measure
        Columns that hold numbers.
    style
        Of the figure.

    Returns
    -------
    Figure

    Raises
    ------
    ValueError
        For a column that holds text, and where there would be too many panels.
    """
    _numeric(table, x, y, measure)
    panels = _panels(table, {x, y}, MOST_PANELS, "panel")
    columns = min(3 if style.width != figures.paper(1).width else 1, len(panels))
    rows = -(-len(panels) // columns)
    fig, axes = figures.figure(rows, columns, (1.5 + 5.0 * columns, 0.5 + 4.0 * rows), style=style)
    seen = table[measure][np.isfinite(table[measure])]
    span = {"vmin": seen.min(), "vmax": seen.max()} if seen.size else {}
    listed = _listed(table)
    drawn: Any = None
    for ax, (label, part) in zip(axes.flat, panels, strict=False):
        draw = _cells if x in listed and y in listed else _dots
        drawn = draw(ax, part, x, y, measure, span)
        bad = part.where(part["status"] == "failed")
        if len(bad):
            ax.plot(bad[x], bad[y], "x", color="0.2", markersize=5, label="failed")
        for axis, scale, name in (("x", ax.set_xscale, x), ("y", ax.set_yscale, y)):
            if _logarithmic(table, name):
                scale("log")
            getattr(ax, f"set_{axis}label")(_label(table, name))
        ax.set_title(label, fontsize="medium" if style.width else 9)
    for ax in axes.flat[len(panels) :]:
        ax.set_visible(False)
    fig.colorbar(drawn, ax=axes.ravel().tolist(), label=_label(table, measure))
    figures.legend_outside(fig, list(axes.flat), _title(table) if style.titled else "")
    return fig


def curves_of(table: Table, x: str, measure: str, style: figures.Style = figures.SCREEN) -> "Figure":
    """Draw a measure over a column: a curve for each value of the other axes, dots where the column was sampled.

    Parameters
    ----------
    table
        Of a sweep.
    x, measure
        Columns that hold numbers.
    style
        Of the figure.

    Returns
    -------
    Figure

    Raises
    ------
    ValueError
        For a column that holds text, and where there would be too many curves.
    """
    _numeric(table, x, measure)
    fig, axes = figures.figure(1, 1, (8.0, 5.0), style=style)
    ax = axes[0, 0]
    parts = _panels(table, {x}, MOST_CURVES, "curve")
    for k, (label, part) in enumerate(parts):
        order = np.argsort(part[x])
        look = figures.line_style(k, style) | {"marker": ".", "label": label}
        if x not in _listed(table):
            look |= {"linestyle": "none", "markersize": 4}
        ax.plot(part[x][order], part[measure][order], **look)
    figures.legend_outside(fig, [ax] if len(parts) > 1 else [], _title(table) if style.titled else "")
    if _logarithmic(table, x):
        ax.set_xscale("log")
    ax.set_xlabel(_label(table, x))
    ax.set_ylabel(_label(table, measure))
    return fig


def _cells(ax: "Axes", part: Table, x: str, y: str, measure: str, span: dict[str, Any]) -> Any:
    """A grid of cells; where runs are missing, a hole."""
    across, i = np.unique(part[x], return_inverse=True)
    along, j = np.unique(part[y], return_inverse=True)
    values = np.full((along.size, across.size), np.nan)
    values[j, i] = part[measure]
    ax.grid(False)
    return ax.pcolormesh(_edges(across), _edges(along), values, cmap="viridis", **span)


def _edges(centres: np.ndarray) -> np.ndarray:
    """Cell borders half-way between the centres, shape (n + 1,); half-way in the logarithm where the spacing is so."""
    if centres.size == 1:
        return np.array([centres[0] - 0.5, centres[0] + 0.5])
    if _geometric(centres):
        return np.asarray(np.exp(_edges_of(np.log(centres))))
    return _edges_of(centres)


def _edges_of(centres: np.ndarray) -> np.ndarray:
    middle = (centres[1:] + centres[:-1]) / 2
    return np.concatenate([[2 * centres[0] - middle[0]], middle, [2 * centres[-1] - middle[-1]]])


def _dots(ax: "Axes", part: Table, x: str, y: str, measure: str, span: dict[str, Any]) -> Any:
    return ax.scatter(part[x], part[y], c=part[measure], cmap="viridis", s=14, linewidths=0, **span)


def _panels(table: Table, used: set[str], most: int, what: str) -> list[tuple[str, Table]]:
    """The table for each combination of values of the listed axes that are not among `used`, with a label."""
    others = {a: np.unique(table[a]) for a in _listed(table) if a not in used}
    others = {a: values for a, values in others.items() if values.size > 1}
    count = int(np.prod([values.size for values in others.values()]))
    if count > most:
        named = " and ".join(f"{a} ({values.size} values)" for a, values in others.items())
        raise ValueError(f"there must be at most {most} {what}s, one for each value of {named}: choose with --where NAME=VALUE")
    panels = []
    for values in product(*others.values()):
        chosen = (
            np.all([table[a] == v for a, v in zip(others, values, strict=True)], axis=0) if others else np.ones(len(table), bool)
        )
        if chosen.any():
            label = ", ".join(f"{a} = {_said(table, a, v)}" for a, v in zip(others, values, strict=True))
            panels.append((label, table.where(chosen)))
    return panels


def _numeric(table: Table, *names: str) -> None:
    for name in names:
        if table[name].dtype.kind == "U":
            raise ValueError(f"column {name!r} must hold numbers to be drawn, holds text")


def _listed(table: Table) -> list[str]:
    return [name for name, values in table.head["definition"]["axes"] if isinstance(values, list)]


def _logarithmic(table: Table, name: str) -> bool:
    """Whether an axis was spaced, or sampled, evenly in the logarithm."""
    axes: dict[str, Any] = dict(table.head["definition"]["axes"])
    how = axes.get(name)
    return bool(how["log"]) if isinstance(how, dict) else _geometric(np.unique(table[name])) if name in axes else False


def _geometric(values: np.ndarray) -> bool:
    if values.size < 3 or values[0] <= 0.0:
        return False
    ratios, steps = values[1:] / values[:-1], np.diff(values)
    return bool(np.ptp(ratios) < 1e-6 * ratios[0] and np.ptp(steps) > 1e-6 * steps[0])


def _said(table: Table, name: str, value: Any) -> str:
    return str(value) if isinstance(value, str) else f"{value:.4g} {table.unit(name)}".strip()


def _label(table: Table, name: str) -> str:
    unit = table.unit(name)
    words = {".end": ", at the end", ".max": ", largest size", ".rms": ", root mean square"}
    for ending, meaning in words.items():
        if name.endswith(ending):
            name = name.removesuffix(ending) + meaning
    return figures.with_unit(name, unit)


def _title(table: Table) -> str:
    definition = table.head["definition"]
    return f"{definition['system']}, {len(table)} runs to t = {definition['stop']:g} s"


def draw(table: Table, names: Sequence[str], style: figures.Style = figures.SCREEN) -> "Figure":
    """Draw a map of (x, y, measure), or curves of (x, measure).

    Parameters
    ----------
    table
        Of a sweep.
    names
        Two or three columns.
    style
        Of the figure.

    Returns
    -------
    Figure

    Raises
    ------
    ValueError
        For columns that cannot be drawn so.
    """
    if len(names) == 3:
        return map_of(table, names[0], names[1], names[2], style)
    if len(names) == 2:
        return curves_of(table, names[0], names[1], style)
    raise ValueError(
        f"a sweep is drawn over X Y MEASURE, or X MEASURE, got {len(names)} name(s); it has {', '.join(table.values)}"
    )
