"""Figures of roots over parameters."""

from typing import TYPE_CHECKING

import numpy as np

from ..figures import figure

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.collections import PathCollection
    from matplotlib.figure import Figure


Box = tuple[tuple[float, float], tuple[float, float]]


def root_locus(ax: "Axes", roots: np.ndarray, values: np.ndarray, label: str, detail: Box | None = None) -> None:
    """Draw roots as paths in the complex plane; a ring marks where each path begins.

    Parameters
    ----------
    ax
        Where to.
    roots
        1/s, complex, shape (n, n_x).
    values
        Of the parameter, which colours the paths, shape (n,).
    label
        Of the colours.
    detail
        Ranges of the real and of the imaginary part that are shown enlarged in a corner.
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


def damping_map(spin_rpm: np.ndarray, speed: np.ndarray, decay: np.ndarray, best_rpm: np.ndarray) -> "Figure":
    """Draw the decay rate of the slowest root over spin and speed, with the best spin for each speed.

    Parameters
    ----------
    spin_rpm, speed
        Rotor speeds in rpm, shape (m,), and forward speeds in m/s, shape (n,).
    decay
        1/s, shape (n, m).
    best_rpm
        Shape (n,); NaN where no spin is best.

    Returns
    -------
    Figure
    """
    fig, axes = figure(1, 1, (8.0, 5.0))
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
    fig.colorbar(drawn, ax=ax, label="decay rate of the slowest root [1/s]")
    return fig


def stability_map(
    across: tuple[str, np.ndarray], along: tuple[str, np.ndarray], values: np.ndarray, label: str, *, stable_above: bool
) -> "Figure":
    """Draw what says whether a system is stable over two parameters; a line where it is zero.

    Parameters
    ----------
    across, along
        Label of an axis and the values on it, shapes (m,) and (n,).
    values
        Shape (n, m); they change their sign where stability does.
    label
        Of the values.
    stable_above
        Whether the system is stable where they are positive, as a damping ratio is, and not where they are negative.

    Returns
    -------
    Figure
    """
    fig, axes = figure(1, 1, (8.0, 5.0))
    ax = axes[0, 0]
    most = float(np.abs(values).max()) or 1.0  # colours change at zero
    drawn = ax.contourf(
        across[1], along[1], values, levels=np.linspace(-most, most, 25), cmap="RdBu" if stable_above else "RdBu_r"
    )
    if values.min() < 0.0 < values.max():
        ax.contour(across[1], along[1], values, levels=[0.0], colors="k", linewidths=1.5)
    ax.set_xlabel(across[0])
    ax.set_ylabel(along[0])
    side = "above" if stable_above else "below"
    fig.colorbar(drawn, ax=ax, label=f"{label}, stable {side} 0")
    return fig
