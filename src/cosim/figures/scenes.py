"""A component drawn from its scene document (component.scene): from the side, from above, its wheel on its rail; mode shapes."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from .canvas import figure
from .styles import COLOURS

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

__all__ = ["Shape", "mode_shapes", "views"]

MOTIONS = ("lateral", "vertical", "yaw", "roll", "pitch")
GREY, SPRING, MOUNT = "0.55", COLOURS[2], COLOURS[3]
PLANES = ((0, 1), (0, 2), (1, 2))  # axes across and up, from above, from the side, from behind
MOST = 0.035  # of the length of all: the largest displacement of a corner in a picture of a mode


def views(scene: Mapping[str, Any], title: str) -> "Figure":
    """Draw bodies, wheels, joints and mounts from the side and from above, and the contact of wheel and rail.

    Parameters
    ----------
    scene : mapping
        A scene with bodies.
    title : str
        Over all.

    Returns
    -------
    Figure
        Two panels, or four where the scene has profiles.
    """
    from matplotlib.figure import Figure

    contact = bool(scene.get("profiles", {}).get("wheel"))
    fig = Figure(figsize=(10.0, 9.0 if contact else 5.5), layout="constrained")
    grid = fig.add_gridspec(3 if contact else 2, 2, height_ratios=(1.0, 1.0, 1.2) if contact else None)
    fig.suptitle(title, fontsize=11)
    for row, (across, label) in enumerate(((2, "z [m]"), (1, "y [m]"))):
        ax = fig.add_subplot(grid[row, :])
        _view(ax, scene, across)
        ax.set(aspect="equal", xlabel="x [m]", ylabel=label)
        ax.margins(0.03)
        ax.spines[["top", "right"]].set_visible(False)
    handles, labels = fig.axes[0].get_legend_handles_labels()
    if handles:
        by_label = dict(zip(labels, handles, strict=True))
        fig.axes[0].legend(by_label.values(), by_label.keys(), loc="lower left", bbox_to_anchor=(0.0, 1.0), ncols=4, fontsize=8)
    if contact:
        lower = grid[2, :].subgridspec(1, 3, width_ratios=(1.25, 1.0, 1.0))
        _section(fig.add_subplot(lower[0]), scene["profiles"])
        _angles(fig.add_subplot(lower[1]), scene["profiles"])
        _radii(fig.add_subplot(lower[2]), scene["profiles"])
    return fig


def _at(body: Mapping[str, Any]) -> np.ndarray:
    return np.array([float(body.get("offset", 0.0)), 0.0, float(body.get("height", 0.0))])


def _boxes(body: Mapping[str, Any]) -> list[tuple[np.ndarray, np.ndarray]]:
    """(middle, size) of the boxes on a body, in its axes."""
    return [(np.array(shape["at"], float), np.array(shape["size"], float)) for shape in body["shapes"] if "size" in shape]


def _view(ax: "Axes", scene: Mapping[str, Any], across: int) -> None:
    """x over y (`across` 1) or over z (2)."""
    from matplotlib.patches import Circle, Rectangle

    half = float(scene["track"]["half_gauge"])
    for y in (half, -half) if across == 1 else (0.0,):
        ax.axhline(y, color=GREY, linewidth=0.8, zorder=0)
    for body in scene["bodies"]:
        centre = _at(body)
        for middle, size in _boxes(body):
            low = centre + middle - size / 2
            ax.add_patch(Rectangle((low[0], low[across]), size[0], size[across], fill=False, edgecolor=COLOURS[0], linewidth=1.2))
        ax.plot(centre[0], centre[across], "+", color=COLOURS[0], markersize=6)
        if across == 2:
            wheels = any(shape["role"] == "wheel" for part in body.get("parts", ()) for shape in part["shapes"])
            place, shift = ((centre[0], 0.0), (0, -9)) if wheels else ((centre[0], centre[2]), (0, 8))
            ax.annotate(body["name"], place, shift, textcoords="offset points", fontsize=7, color=COLOURS[0], ha="center")
        for part in body.get("parts", ()):
            place = centre + np.array(part["at"], float)
            for shape in part["shapes"]:
                if shape["role"] != "wheel":
                    continue
                r, w = float(shape["radius"]), float(shape["width"])
                if across == 2:
                    ax.add_patch(Circle((place[0], place[2]), r, fill=False, edgecolor="0.2", linewidth=1.2))
                else:
                    ax.add_patch(Rectangle((place[0] - r, place[1] - w / 2), 2 * r, w, facecolor="0.85", edgecolor="0.2"))
    for joint in scene.get("joints", ()):
        for start, end in joint["lines"]:
            line = np.array([start, end], float)
            ax.plot(line[:, 0], line[:, across], "-o", color=SPRING, markersize=3.5, linewidth=1.2, label=joint["kind"])
    for mount in scene.get("mounts", ()):
        body = next((one for one in scene["bodies"] if one["name"] == mount["body"]), None)
        if body is not None:
            place = _at(body) + np.array(mount["at"], float)
            ax.plot(place[0], place[across], "s", color=MOUNT, markersize=6, label="mount of a gyro unit")


def _section(ax: "Axes", profiles: Mapping[str, Any]) -> None:
    """Left wheel on its rail, at true scale, with the places where they touch."""
    wheel, rail = (1e3 * np.array(profiles[name]) for name in ("wheel", "rail"))
    ax.plot(wheel[:, 0], wheel[:, 1], color=COLOURS[0], label="wheel, centred")
    ax.plot(rail[:, 0], rail[:, 1], color="0.2", label="rail")
    for name, points in _contacts(profiles).items():
        ax.plot(1e3 * points[:, 1], 1e3 * points[:, 2], ".", color=COLOURS[1] if name == "tread" else COLOURS[3], markersize=4,
                label=f"contact, {name}")  # fmt: skip
    ax.set(aspect="equal", xlabel="outwards [mm]", ylabel="up [mm]", title="left wheel and rail")
    ax.title.set_fontsize(9)
    ax.grid(alpha=0.3, linewidth=0.6)
    ax.legend(fontsize=7, loc="best")


def _contacts(profiles: Mapping[str, Any]) -> dict[str, np.ndarray]:
    """By part: shift towards the flange, place outwards and up (m), angle (rad), radius (m); where that part touches."""
    rows = profiles.get("contacts", ())
    return {name: np.array([row[1:] for row in rows if row[0] == name], float) for name in dict.fromkeys(row[0] for row in rows)}


def _angles(ax: "Axes", profiles: Mapping[str, Any]) -> None:
    contacts = _contacts(profiles)
    if not contacts:
        ax.axis("off")
        ax.text(0.5, 0.5, "A cone on a knife edge: contact under the\nrunning line, at the angle of the conicity.", ha="center",
                va="center", fontsize=8, transform=ax.transAxes)  # fmt: skip
        return
    for name, points in contacts.items():
        colour = COLOURS[1] if name == "tread" else COLOURS[3]
        ax.plot(1e3 * points[:, 0], np.degrees(points[:, 3]), ".", color=colour, markersize=4, label=name)
    ax.set_yscale("symlog", linthresh=5.0)
    ax.set_yticks([0, 1, 2, 3, 4, 5, 10, 20, 40, 70], labels=["0", "1", "2", "3", "4", "5", "10", "20", "40", "70"])
    ax.set(xlabel="shift towards the flange [mm]", ylabel="contact angle [deg]", title="where it carries its load, no yaw")
    ax.title.set_fontsize(9)
    ax.grid(alpha=0.3, linewidth=0.6)
    ax.legend(fontsize=8)


def _radii(ax: "Axes", profiles: Mapping[str, Any]) -> None:
    """Rolling radii left less right of a pair whose sides are alike, over its shift."""
    rows = sorted([*row[1:]] for row in profiles.get("contacts", ()))
    if not rows:
        ax.axis("off")
        return
    shift, radius = np.array([[row[0], row[4]] for row in rows], float).T
    ax.plot(1e3 * shift, 1e3 * (radius - np.interp(-shift, shift, radius)), color=COLOURS[0])
    ax.set(xlabel="shift to the left [mm]", ylabel="radius, left less right [mm]", title="rolling radius difference, sides alike")
    ax.title.set_fontsize(9)
    ax.grid(alpha=0.3, linewidth=0.6)


@dataclass(frozen=True)
class Shape:
    """How a mode moves.

    Attributes
    ----------
    words : str
        What stands over its pictures.
    motion : mapping of str to complex
        By signal of the scene: m or rad.
    """

    words: str
    motion: Mapping[str, complex]


def mode_shapes(scene: Mapping[str, Any], shapes: Sequence[Shape], title: str) -> "Figure":
    """Draw the bodies of a scene as modes move them, from above, from the side and from behind.

    Each mode is drawn where its motion is largest, and a quarter of a period later (thin), all bodies enlarged alike.

    Parameters
    ----------
    scene : mapping
        A scene with bodies.
    shapes : sequence of Shape
        The modes, a row for each.
    title : str
        Over all.
    """
    fig, axes = figure(len(shapes), 3, (13.0, 0.8 + 1.7 * len(shapes)))
    axes[0, 0].get_gridspec().set_width_ratios((1.0, 1.0, 0.24))
    fig.suptitle(f"{title}\nat their largest (blue) and a quarter of a period later (thin)", fontsize=11)
    ends = [_at(body)[0] + side * size[0] / 2 for body in scene["bodies"] for _, size in _boxes(body) for side in (-1, 1)]
    most = MOST * (max(ends) - min(ends))
    for row, shape in zip(axes, shapes, strict=True):
        factor = most / max(_largest(scene, shape), 1e-300)
        for ax, (first, second), words in zip(row, PLANES, (shape.words, "from the side", "from behind"), strict=True):
            for body in scene["bodies"]:
                for middle, size in _boxes(body):
                    corners = _corners(middle, size, first, second)
                    _outline(ax, _at(body) + corners, first, second, GREY, 0.7)
                    for turn, width in ((1.0, 1.6), (-1j, 0.7)):
                        moved = np.array([_moved(body, shape, corner, factor, turn) for corner in corners])
                        _outline(ax, moved, first, second, COLOURS[0] if turn == 1.0 else COLOURS[1], width)
            if first == 1:
                ax.invert_xaxis()  # seen from behind, left is on the left
            ax.set(aspect="equal")
            ax.tick_params(labelsize=7)
            ax.set_title(words, fontsize=8, loc="left")
    return fig


def _corners(middle: np.ndarray, size: np.ndarray, first: int, second: int) -> np.ndarray:
    corners = np.tile(middle, (4, 1))
    for corner, (a, b) in zip(corners, ((-1, -1), (1, -1), (1, 1), (-1, 1)), strict=True):
        corner[first] += a * size[first] / 2
        corner[second] += b * size[second] / 2
    return corners


def _outline(ax: "Axes", corners: np.ndarray, first: int, second: int, colour: str, width: float) -> None:
    closed = np.vstack([corners, corners[:1]])
    ax.plot(closed[:, first], closed[:, second], color=colour, linewidth=width)


def _displacement(body: Mapping[str, Any], shape: Shape, corner: np.ndarray) -> np.ndarray:
    """Complex displacement of a place on a body (m), small angles."""
    y, z, yaw, roll, pitch = (complex(shape.motion.get(str(body.get(name)), 0.0)) for name in MOTIONS)
    x_, y_, z_ = corner
    along = complex(shape.motion.get(str(body.get("along")), 0.0))
    return np.array([along + pitch * z_ - yaw * y_, y + yaw * x_ - roll * z_, z + roll * y_ - pitch * x_])


def _moved(body: Mapping[str, Any], shape: Shape, corner: np.ndarray, factor: float, turn: complex) -> np.ndarray:
    moved: np.ndarray = _at(body) + corner + factor * np.real(turn * _displacement(body, shape, corner))
    return moved


def _largest(scene: Mapping[str, Any], shape: Shape) -> float:
    places = [
        np.abs(_displacement(body, shape, middle + np.array([a, b, c]) * size / 2)).max()
        for body in scene["bodies"] for middle, size in _boxes(body) for a in (-1, 1) for b in (-1, 1) for c in (-1, 1)
    ]  # fmt: skip
    return float(max(places, default=0.0))
