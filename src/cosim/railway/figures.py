"""The figure of railway vehicles' runs along their track: where the curve lies, motion, Y/Q against its limit, gyro, speed."""

from collections.abc import Iterator, Mapping, Sequence
from itertools import zip_longest
from typing import TYPE_CHECKING, Any

import numpy as np

from ..figures import COLOURS, DASHES, SCREEN, Style, as_it_stands, figure, legend_above, legend_outside, paper, thinned_rows
from ..trajectory import Trajectory
from .assessment import COEFFICIENT, DISTANCE, LATERAL, YAW, Assessment
from .filters import en14363
from .safety import LIMIT

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

CURVATURE, GIMBAL = "curvature", ".gimbal_angle"  # 1/m of a vehicle's track; rad, of a gyro unit
STRAIGHT = 1e-6  # 1/m: what is less is no curve
Runs = Mapping[str, tuple[Assessment, Trajectory]]


def along_track(runs: Runs, title: str = "", style: Style = SCREEN) -> "Figure":
    """Draw railway vehicles' runs over the distance along the track, over one another.

    Lateral displacement and yaw angle of the wheel pairs, Y/Q as EN 14363 filters it against its limit (unfiltered where the
    filter cannot be used), the gimbals' lean where gyro units were recorded, the speed; shaded, where the curves lie.

    Parameters
    ----------
    runs
        Label -> what was found in a run, and the run.
    title
        Above the figure.
    style
        Of the figure.

    Returns
    -------
    Figure

    Raises
    ------
    ValueError
        More runs than colours: within a run dashes tell its wheel pairs apart.
    """
    if len(runs) > len(COLOURS):
        raise ValueError(f"along the track at most {len(COLOURS)} runs can be told apart, got {len(runs)}: name signals")
    leaning = any(_gimbals(trajectory) for _, trajectory in runs.values())
    rows, several = 5 if leaning else 4, len(runs) > 1
    fig, axes = figure(rows, 1, (9.0, 1.2 + 2.0 * rows), sharex=True, style=style)
    if style.width:
        fig.set_figheight(0.7 + style.panel * rows)
    panels = list(axes[:, 0])
    for k, (found, trajectory) in enumerate(runs.values()):
        for ax, lines in zip(panels, _panels(found, trajectory, leaning=leaning, together=several), strict=True):
            for n, (words, line) in enumerate(lines.items()):
                x, y = _drawn(trajectory[f"{found.vehicle}.{DISTANCE}"], line)
                ax.plot(x, y, color=COLOURS[(k if several else n) % len(COLOURS)], label=words, **_look(n, style, dashed=several))
    ratio = f"{'largest |Y/Q|' if several else 'Y/Q'},\n{_filtered(runs)} [1]"
    motion = "lateral\ndisplacement\ny [mm]" if style.width else "lateral displacement\ny [mm]"
    labels = [motion, "yaw angle\n$\\psi$ [mrad]", ratio, "gimbal angle\n$\\eta$ [deg]"]
    for ax, words in zip(panels, [*labels[: rows - 1], "speed\nv [m/s]"], strict=True):
        ax.set_ylabel(words)
        ax.margins(x=0)
    _limit(panels[2])
    _room(panels[-1], 2.0)
    longest = max(runs.values(), key=lambda one: float(one[1][f"{one[0].vehicle}.{DISTANCE}"][-1]))
    _curves(panels, *longest)
    panels[-1].set_xlabel("distance along the track s [m]")
    fig.align_ylabels()
    verdicts = [f"{label}: {found.verdict.text}" if several else found.verdict.text for label, (found, _) in runs.items()]
    title = as_it_stands("\n".join(filter(None, [title, *verdicts]))) if style.titled else ""
    if several:
        _legend_of_runs(fig, panels, runs, style, title)
        return fig
    fig.suptitle(title, fontsize=10)
    for ax in panels[:-1]:
        legend_above(ax, 5 if style.width != paper(1).width else 3, fontsize="small", handlelength=1.4, columnspacing=1.2)
    return fig


def _panels(found: Assessment, trajectory: Trajectory, *, leaning: bool, together: bool) -> Iterator[dict[str, np.ndarray]]:
    """Of each panel the lines by name: y in mm, psi in mrad, Y/Q, eta in deg where one run has it, v in m/s."""
    for suffix in (LATERAL, YAW):
        yield {_said(pair): trajectory[f"{found.vehicle}.{pair}{suffix}"] * 1e3 for pair in found.pairs}
    ratios = _ratios(found, trajectory)
    if together:
        yield {"": np.max(np.abs(list(ratios.values())), axis=0)}
    else:
        yield {_said(wheel): ratio for wheel, ratio in ratios.items()}
    if leaning:
        yield {_said(name.removesuffix(GIMBAL)): np.degrees(trajectory[name]) for name in _gimbals(trajectory)}
    yield {"": np.gradient(trajectory[f"{found.vehicle}.{DISTANCE}"], trajectory.t)}


def _gimbals(trajectory: Trajectory) -> list[str]:
    return [name for name in trajectory.names if name.endswith(GIMBAL)]


def _said(name: str) -> str:
    return as_it_stands(name.replace("_", " "))


def _look(n: int, style: Style, *, dashed: bool) -> dict[str, Any]:
    """Of the n-th line of a panel; dashes tell the pairs of one run apart where colours tell the runs apart."""
    return {"linestyle": DASHES[n % len(DASHES)] if dashed else "-", "linewidth": 0.8 * style.line}


def _drawn(x: np.ndarray, y: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    kept = thinned_rows(x, y)
    return x[kept], np.where(np.isfinite(y), y, np.nan)[kept]


def _ratios(found: Assessment, trajectory: Trajectory) -> dict[str, np.ndarray]:
    """Y/Q of each wheel in the rows of the run, as the run was assessed: filtered where the filter can be used."""
    x, t = trajectory[f"{found.vehicle}.{DISTANCE}"], trajectory.t
    ratios = {wheel: trajectory[f"{found.vehicle}.{wheel}{COEFFICIENT}"] for wheel in found.wheels}
    if found.worst is None:
        return ratios
    even = np.linspace(t[0], t[-1], t.size)
    along = np.interp(even, t, x)
    return {wheel: np.interp(t, even, en14363(np.interp(even, t, ratio), even, along)) for wheel, ratio in ratios.items()}


def _filtered(runs: Runs) -> str:
    filtered = [found.worst is not None for found, _ in runs.values()]
    return "EN 14363" if all(filtered) else "partly unfiltered" if any(filtered) else "unfiltered"


def _limit(ax: "Axes") -> None:
    """The limit of the filtered Y/Q, and a range in which it can be seen."""
    low, high = (float(np.clip(edge, -3.0, 3.0)) for edge in ax.get_ylim())
    ax.set_ylim(low, max(high, 1.1))
    for sign in (-1, 1):
        if low < sign * LIMIT:
            ax.axhline(sign * LIMIT, color="0.2", linewidth=0.8, linestyle=":", label=f"limit {LIMIT:g}" if sign > 0 else "")


def _room(ax: "Axes", least: float) -> None:
    """At least so much from bottom to top, so that rounding does not look like a change."""
    low, high = ax.get_ylim()
    if high - low < least:
        ax.set_ylim((low + high - least) / 2, (low + high + least) / 2)


def _curves(panels: "Sequence[Axes]", found: Assessment, trajectory: Trajectory) -> None:
    """Shade where the track of a run curves; the legend of the first panel says how tightly."""
    name = f"{found.vehicle}.{CURVATURE}"
    if name not in trajectory.names:
        return
    x, bend = trajectory[f"{found.vehicle}.{DISTANCE}"], np.abs(trajectory[name])
    edges = np.flatnonzero(np.diff(np.concatenate([[False], bend > STRAIGHT, [False]]).astype(int))).reshape(-1, 2)
    radii = dict.fromkeys(f"{1.0 / bend[begin:end].max():.4g}" for begin, end in edges)
    for k, (begin, end) in enumerate(edges):
        for ax in panels:
            words = f"curve, R = {', '.join(radii)} m" if k == 0 and ax is panels[0] and len(radii) < 4 else ""
            ax.axvspan(x[begin], x[end - 1], color="0.9", linewidth=0, zorder=0, label=words)


def _legend_of_runs(fig: "Figure", panels: "Sequence[Axes]", runs: Runs, style: Style, title: str) -> None:
    """Title and legend: a colour a run, dashes a wheel pair and its gyro unit, the limit, the curve."""
    for k, label in enumerate(runs):
        panels[-1].plot([], [], color=COLOURS[k], label=as_it_stands(label))
    found, trajectory = next(iter(runs.values()))
    named = zip_longest(map(_said, found.pairs), (_said(name.removesuffix(GIMBAL)) for name in _gimbals(trajectory)))
    for n, words in enumerate(named):
        panels[-1].plot([], [], color="0.4", label=" / ".join(filter(None, words)), **_look(n, style, dashed=True))
    for ax in panels[:-1]:
        for line in ax.get_lines():
            if not line.get_label().startswith("limit"):
                line.set_label("")
    legend_outside(fig, [panels[-1], panels[2], panels[0]], title, fontsize="small")
