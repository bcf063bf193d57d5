"""Figures: each function draws one and returns it; save() writes it."""

from .canvas import as_it_stands, figure, legend_above, legend_outside, with_unit
from .histories import drawn_overlay, histories_in_columns, time_histories, worth_drawing
from .overlays import TIME, Overlay, thinned_rows
from .saving import check_format, made_here, save
from .scenes import Shape, mode_shapes, views
from .styles import COLOURS, DASHES, LINES, SCREEN, Style, line_style, paper

__all__ = [
    "COLOURS",
    "DASHES",
    "LINES",
    "SCREEN",
    "TIME",
    "Overlay",
    "Shape",
    "Style",
    "as_it_stands",
    "check_format",
    "drawn_overlay",
    "figure",
    "histories_in_columns",
    "legend_above",
    "legend_outside",
    "line_style",
    "made_here",
    "mode_shapes",
    "paper",
    "save",
    "thinned_rows",
    "time_histories",
    "views",
    "with_unit",
    "worth_drawing",
]
