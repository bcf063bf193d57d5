"""A run as people see it in a console or a notebook: five lines, or a small table with a plot."""

from __future__ import annotations

import base64
import html
import io
from typing import TYPE_CHECKING

from .. import figures

if TYPE_CHECKING:
    from .simulation import Run

ROWS = 8  # of the table
PANELS = 3  # of the plot


def lines(run: Run) -> tuple[str, str, str, str, str]:
    """What ran, how, between which components, what is kept, and what the coupling made."""
    trajectory, energy = run.trajectory, run.energy
    names = [f"{c.name} ({c.source.rpartition('/')[2]})" for c in run.system.components]
    more = f" and {len(names) - 4} more" if len(names) > 4 else ""
    end = f"t = {trajectory.t[-1]:g} s" if len(trajectory) else "its start"
    why = f" ({run.ended_by})" if run.ended_by else ""
    exchanged = sum(bond.exchanged for bond in energy)
    coupling = (
        f"{run.energy_residual:.3g} J of {exchanged:.3g} J exchanged over {len(energy)} power bonds"
        if energy
        else "no power bond"
    )
    return (
        f"Run of {run.system.name!r}: {run.status} at {end}{why}",
        f"  {run.algorithm.name}, degree {run.algorithm.degree}, {run.steps} macro steps of {run.step:g} s",
        f"  components: {', '.join(names[:4])}{more}",
        f"  results: {len(trajectory)} points of {len(trajectory.names)} signals",
        f"  coupling energy: {coupling}{'; DO NOT TRUST THIS RESULT' if run.coupling_warning else ''}",
    )


def page(run: Run) -> str:
    """The same for a notebook: names are escaped, the plot is a picture in the text."""
    head, *rest = lines(run)
    trajectory = run.trajectory
    chosen: list[str] = []
    if len(trajectory):  # places and angles first
        chosen = figures.worth_drawing(trajectory, ROWS, lambda name: trajectory.unit(name) not in ("m", "rad"))
    rows = "".join(
        f"<tr><td style='text-align:left'>{html.escape(name)}</td><td>{trajectory[name][-1]:.6g}</td>"
        f"<td style='text-align:left'>{html.escape(trajectory.unit(name))}</td></tr>"
        for name in chosen
    )
    table = f"<table><thead><tr><th>at the end</th><th>value</th><th>unit</th></tr></thead><tbody>{rows}</tbody></table>"
    words = "<br>".join(html.escape(line.strip()) for line in rest)
    return f"<div><b>{html.escape(head)}</b><br>{words}{table if rows else ''}{_picture(run, chosen[:PANELS])}</div>"


def _picture(run: Run, names: list[str]) -> str:
    """The signals over time as an <img>; empty where there is nothing to draw."""
    if not names or len(run.trajectory) < 2:
        return ""
    data = io.BytesIO()
    figures.time_histories(run.trajectory, names).savefig(data, format="png", dpi=80)
    text = html.escape(f"{', '.join(names)} over time", quote=True)
    return f"<img alt='{text}' src='data:image/png;base64,{base64.b64encode(data.getvalue()).decode()}'>"
