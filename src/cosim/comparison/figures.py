"""The figure of a comparison of units."""

from typing import TYPE_CHECKING, Any

import numpy as np

from ..figures import COLOURS, figure, worth_drawing
from .candidates import Candidate, Comparison

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

SIGNALS = 3  # panels of time histories


def comparison(result: Comparison) -> "Figure":
    """Left the signals that move, angles and displacements first, over time; right the frequency response and the energy."""
    made, axes = figure(SIGNALS, 2, (11.0, 8.0))
    candidates = [c for c in result.candidates if c.run is not None]
    for ax, name in zip(axes[:, 0], _drawn(result), strict=False):
        for k, c in enumerate(candidates):
            assert c.run is not None
            trajectory = c.run.trajectory
            if name in trajectory.names:
                ax.plot(trajectory.t, trajectory[name], **_style(k), label=c.label)
                ax.set_ylabel(f"{name.partition('.')[2].replace('_', ' ')}\n[{trajectory.unit(name)}]")
        ax.set_title(name, loc="right", fontsize=8, color="0.4")
        ax.margins(x=0)
    axes[-1, 0].set_xlabel("time [s]")
    _responses(axes[0, 1], axes[1, 1], candidates)
    _energies(axes[2, 1], candidates)
    axes[0, 0].legend(fontsize=8)
    for ax in axes.flat:
        if not ax.has_data():
            ax.set_axis_off()
    made.suptitle(f"{result.system.name}: " + " against ".join([", ".join(c.label for c in result.candidates[1:]),
                                                               result.candidates[0].label]))  # fmt: skip
    return made


def _style(k: int) -> dict[str, Any]:
    """The reference is wide and grey, so that what lies on it can be seen."""
    if k == 0:
        return {"color": "0.75", "linewidth": 4.0}
    return {"color": COLOURS[(k - 1) % len(COLOURS)], "linewidth": 1.1, "linestyle": ("-", "--", "-.", ":")[(k - 1) % 4]}


def _drawn(result: Comparison) -> list[str]:
    """Signals of the other components that move, then those of the units."""
    first = result.candidates[0].run
    assert first is not None
    trajectory, exchanged = first.trajectory, result.system.addressed(result.component)
    rank = {"rad": 0, "m": 1}
    return worth_drawing(
        trajectory, SIGNALS, lambda name: (result.system.owner(name) in exchanged, rank.get(trajectory.unit(name), 2))
    )


def _responses(size: "Axes", phase: "Axes", candidates: list[Candidate]) -> None:
    for k, c in enumerate(candidates):
        for response in c.responses[:1]:
            size.loglog(response.frequency, np.abs(response.value), **_style(k))
            degrees = np.degrees(np.unwrap(np.angle(response.value)))
            phase.semilogx(response.frequency, degrees - 360 * np.floor(degrees[0] / 360), **_style(k))
            size.set_title(response.name, loc="right", fontsize=8, color="0.4")
    size.set_ylabel("effort over motion")
    phase.set_ylabel("phase [deg]\n180: pure damping")
    phase.axhline(180.0, color="0.3", linewidth=0.8)
    phase.set_yticks(range(-720, 721, 90))
    phase.set_ylim(-280, 370)
    phase.set_xlabel("frequency [Hz]")


def _energies(ax: "Axes", candidates: list[Candidate]) -> None:
    """What the first unit has absorbed, over time."""
    for k, c in enumerate(candidates):
        assert c.run is not None
        for energy in c.energies[:1]:
            ax.plot(c.run.trajectory.t, energy.course, **_style(k))
    ax.axhline(0.0, color="0.3", linewidth=0.8)
    ax.set_ylabel("energy absorbed\nby the unit [J]")
    ax.set_xlabel("time [s]")
    ax.margins(x=0)
