"""Figures: each function draws one and returns it; save() writes it."""

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from gyro_cosim.trajectory import Trajectory

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.collections import PathCollection
    from matplotlib.figure import Figure

    from gyro_cosim.accuracy.convergence import Convergence
    from gyro_cosim.assessment import Assessment

COLOURS = ("#0072b2", "#d55e00", "#009e73", "#cc79a7", "#e69f00", "#56b4e9")  # Okabe and Ito: told apart by everyone


def figure(
    rows: int = 1, columns: int = 1, size: tuple[float, float] = (8.0, 5.0), *, sharex: bool = False
) -> tuple["Figure", np.ndarray]:
    """A figure with its axes, shape (rows, columns), in this package's style."""
    from matplotlib.figure import Figure

    made = Figure(figsize=size, layout="constrained")
    axes = made.subplots(rows, columns, squeeze=False, sharex=sharex)
    for ax in axes.flat:
        ax.grid(alpha=0.3, linewidth=0.6)
        ax.spines[["top", "right"]].set_visible(False)
    return made, axes


def with_unit(name: str, unit: str) -> str:
    """A label for an axis; a pure number has no unit."""
    return f"{name} [{unit}]" if unit not in ("", "1") else name


def save(made: "Figure", file: str | Path) -> Path:
    """Write the figure in the format that the file's ending names."""
    file = Path(file)
    file.parent.mkdir(parents=True, exist_ok=True)
    made.savefig(file, dpi=150)
    return file


def check_format(file: Path) -> None:
    """Refuse a file name whose ending is no format matplotlib writes."""
    from matplotlib.backend_bases import FigureCanvasBase

    known = FigureCanvasBase.get_supported_filetypes()
    if file.suffix.removeprefix(".").lower() not in known:
        raise ValueError(f"plot file must end in one of {', '.join(sorted('.' + k for k in known))}, got {str(file)!r}")


def time_histories(trajectory: Trajectory, names: Sequence[str], title: str = "") -> "Figure":
    """One panel a signal over time."""
    made, axes = figure(len(names), 1, (8.0, 1.2 + 1.5 * len(names)), sharex=True)
    for ax, name, colour in zip(axes[:, 0], names, COLOURS * len(names), strict=False):
        unit = trajectory.unit(name)
        ax.plot(trajectory.t, trajectory[name], color=colour, linewidth=1.2)
        ax.set_ylabel(f"{name.partition('.')[2].replace('_', ' ')}\n[{unit}]" if unit not in ("", "1") else name)
        ax.set_title(name, loc="right", fontsize=8, color="0.4")
        ax.margins(x=0)
    axes[-1, 0].set_xlabel("time [s]")
    made.align_ylabels()
    if title:
        made.suptitle(title)
    return made


def along_track(trajectory: Trajectory, assessment: "Assessment", title: str = "") -> "Figure":
    """Lateral displacement, yaw angle, Y and Y/Q of a railway vehicle over the distance along the track."""
    from gyro_cosim.assessment import COEFFICIENT, DISTANCE, FORCE, LATERAL, YAW
    from gyro_cosim.safety import LIMIT

    made, axes = figure(4, 1, (9.0, 9.0), sharex=True)
    distance = trajectory[f"{assessment.vehicle}.{DISTANCE}"]
    panels = (
        (assessment.pairs, LATERAL, "lateral displacement y\n[mm]", 1e3),
        (assessment.pairs, YAW, "yaw angle $\\psi$\n[mrad]", 1e3),
        (assessment.wheels, FORCE, "lateral force Y\n[kN]", 1e-3),
        (assessment.wheels, COEFFICIENT, "Y/Q\n[1]", 1.0),
    )
    for ax, (parts, suffix, label, factor) in zip(axes[:, 0], panels, strict=True):
        for part, colour in zip(parts, COLOURS * len(parts), strict=False):
            name = f"{assessment.vehicle}.{part}{suffix}"
            if name in trajectory.names:
                ax.plot(distance, trajectory[name] * factor, color=colour, linewidth=0.9, label=part.replace("_", " "))
        ax.set_ylabel(label)
        ax.legend(fontsize=7, ncols=4, loc="upper right")
        ax.margins(x=0)
    ratio = axes[-1, 0]
    low, high = (np.clip(limit, -3.0, 3.0) for limit in ratio.get_ylim())
    ratio.set_ylim(low, max(high, 1.1))
    for sign in (-1, 1):
        if low < sign * LIMIT:
            ratio.axhline(sign * LIMIT, color="0.3", linewidth=0.8, linestyle=":")
    words = {"fontsize": 7, "color": "0.3", "va": "bottom", "ha": "right", "backgroundcolor": (1, 1, 1, 0.6)}
    ratio.annotate(f"EN 14363 limit of the filtered value: {LIMIT:g}", (distance[-1], LIMIT), **words)
    ratio.set_xlabel("distance along the track [m]")
    made.align_ylabels()
    made.suptitle(f"{title}\n{assessment.verdict.text}", fontsize=10)
    return made


def convergence(result: "Convergence") -> "Figure":
    """Errors over macro steps, both logarithmic, with the observed orders in the legend and slopes to compare with."""
    made, axes = figure(1, 1, (8.0, 5.5))
    ax = axes[0, 0]
    markers = {"jacobi": "o", "gauss-seidel": "s"}
    for ladder in result.ladders:
        a = ladder.algorithm
        h, e, used = np.array(ladder.steps), np.array(ladder.errors), np.array(ladder.used)
        e[~np.isfinite(e)] = np.nan  # a run that did not get through has no place here
        style = {"color": COLOURS[a.degree], "marker": markers.get(a.name, "^"), "linestyle": "-" if a.name == "jacobi" else "--"}
        ax.loglog(
            h * 1e3,
            e,
            **style,
            markersize=5,
            linewidth=1.2,
            label=f"{a.name}, degree {a.degree}: order {ladder.observed_order:.2f}",
        )
        ax.loglog(h[~used] * 1e3, e[~used], "x", color="0.3", markersize=9)
    low, high = min(result.ladders[0].steps) * 1e3, max(result.ladders[0].steps) * 1e3
    for degree in sorted({ladder.algorithm.degree for ladder in result.ladders}):
        top = max(e for x in result.ladders if x.algorithm.degree == degree for e in x.errors if np.isfinite(e))
        ax.loglog([low, high], [3 * top * (low / high) ** (degree + 1), 3 * top], color="0.6", linewidth=0.8, linestyle=":")
        ax.annotate(f"slope {degree + 1}", (low, 3 * top * (low / high) ** (degree + 1)), color="0.4", fontsize=8,
                    xytext=(0, 6), textcoords="offset points", rotation=0)  # fmt: skip
    ticks = sorted({h * 1e3 for ladder in result.ladders for h in ladder.steps})
    ax.set_xticks(ticks, [f"{tick:g}" for tick in ticks])
    ax.set_xticks([], minor=True)
    ax.set_xlabel("macro step [ms]")
    ax.set_ylabel("largest relative error of an output")
    ax.set_title(f"{result.system.name} to {result.stop:g} s against the {result.reference}", fontsize=10)
    ax.legend(fontsize=8)
    return made


Box = tuple[tuple[float, float], tuple[float, float]]


def root_locus(ax: "Axes", roots: np.ndarray, values: np.ndarray, label: str, detail: Box | None = None) -> None:
    """Roots, shape (n, n_x), as paths in the complex plane, coloured by the parameter's values, shape (n,).

    A ring marks where each path begins. `detail`: ranges of real and imaginary part to show enlarged in a corner.
    """
    drawn = _paths(ax, roots, values)
    if detail is not None:
        inset = ax.inset_axes((0.1, 0.6, 0.42, 0.37), xlim=detail[0], ylim=detail[1])
        _paths(inset, roots, values)
        inset.tick_params(labelsize=7)
        inset.locator_params(nbins=4)
        inset.set_title("detail", fontsize=8)
    ax.set_xlabel("real part [1/s]")
    ax.set_ylabel("imaginary part [rad/s]")
    ax.figure.colorbar(drawn, ax=ax, label=label)


def _paths(ax: "Axes", roots: np.ndarray, values: np.ndarray) -> "PathCollection":
    for path in roots.T:
        drawn = ax.scatter(path.real, path.imag, c=values, cmap="viridis", s=5, linewidths=0)
        ax.plot(path[0].real, path[0].imag, "o", color="0.2", markersize=4, fillstyle="none")
    ax.axvline(0.0, color="0.3", linewidth=0.8)
    ax.axhline(0.0, color="0.3", linewidth=0.8)
    return drawn


def histories_in_columns(cases: Mapping[str, Trajectory], signals: Mapping[str, tuple[str, str, float]]) -> "Figure":
    """One row a case, one column a signal. `signals`: name -> (label, unit shown, factor to it)."""
    made, axes = figure(len(cases), len(signals), (4.2 * len(signals), 2.8 * len(cases)), sharex=True)
    for row, (case, trajectory) in zip(axes, cases.items(), strict=True):
        for ax, (name, (label, unit, factor)), colour in zip(row, signals.items(), COLOURS, strict=False):
            ax.plot(trajectory.t, trajectory[name] * factor, color=colour, linewidth=1.0)
            ax.axhline(0.0, color="0.3", linewidth=0.6)
            ax.set_ylabel(f"{label} [{unit}]")
            ax.set_title(case, fontsize=9)
            ax.margins(x=0)
    for ax in axes[-1]:
        ax.set_xlabel("time [s]")
    return made


def damping_map(spin_rpm: np.ndarray, speed: np.ndarray, decay: np.ndarray, best_rpm: np.ndarray) -> "Figure":
    """Decay rate of the slowest root, shape (len(speed), len(spin_rpm)), over spin and speed, with the best spin per speed."""
    made, axes = figure(1, 1, (8.0, 5.0))
    ax = axes[0, 0]
    drawn = ax.contourf(spin_rpm, speed, decay, levels=24, cmap="viridis")
    ax.plot(best_rpm, speed, color="w", linewidth=2.0, linestyle="--", label="spin of strongest damping")
    if np.isnan(best_rpm).any():
        low = np.geomspace(speed[0], speed[np.isnan(best_rpm)][-1], 3)[1]
        words = "lateral motion slowest, whatever the spin"
        ax.text(spin_rpm.mean(), low, words, color="w", fontsize=8, ha="center", va="center")
    ax.set_yscale("log")
    ax.set_xlabel("rotor speed [rpm]")
    ax.set_ylabel("forward speed v [m/s]")
    ax.legend(loc="upper right")
    made.colorbar(drawn, ax=ax, label="decay rate of the slowest root [1/s]")
    return made
