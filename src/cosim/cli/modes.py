"""cosim modes: the eigenvalues of a vehicle, or of a system, linearised at rest: frequency, damping, what moves."""

from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, Any

import numpy as np
import typer
from rich.table import Table

from gyro_cosim.component.units import quantity

from ..errors import unknown
from ..stability.at_rest import AtRest
from ..stability.modes import Mode, crossings, modes_at
from ..systems import System, catalogue
from . import drawing
from .alone import single
from .common import AsJson, Gyro, Parameters, Swaps, Values, Vehicle, chosen_system, is_system, needs, say

SHOWN = 6  # modes in a picture
RATES = ("_rate", "_velocity", "speed_deviation", "spin_deviation")


def command(
    name: Annotated[
        str, typer.Argument(metavar="SOURCE", help="a system, a component such as vehicle:lrt, or a vehicle's .toml file")
    ],
    vehicle: Vehicle = None,
    gyro: Gyro = None,
    swap: Swaps = None,
    set_: Values = None,
    params: Parameters = None,
    over: Annotated[
        list[str] | None,
        typer.Option(
            metavar="COMPONENT.PARAMETER=FROM:TO:N",
            help="the largest growth over a parameter, or over two: vehicle.speed=5:50:10",
        ),
    ] = None,
    damping: Annotated[
        bool, typer.Option("--damping", help="with two --over: the least damping ratio instead of the largest growth")
    ] = False,
    plot: Annotated[
        Path | None, typer.Option(metavar="FILE", help="draw the root locus over one parameter, or a map over two")
    ] = None,
    shapes: Annotated[
        Path | None, typer.Option(metavar="FILE", help="draw how the bodies move in the oscillating modes that are damped least")
    ] = None,
    as_json: AsJson = False,
) -> int:
    """List the modes of a system at rest on straight track: growth, frequency, damping ratio, and which state takes part most.

    With --over the largest growth is listed for each value, and where it changes sign, by bisection, with the mode that does.
    Given twice it is a map over both parameters.
    """
    needs("--plot", plot, "--over", bool(over))
    if damping and len(over or ()) != 2:
        raise ValueError(f"--damping requires two --over, got {len(over or ())}")
    if shapes is not None and over:
        raise ValueError("--shapes must be left out with --over: it draws the modes of one vehicle")
    drawing.check(shapes)
    if over and len(over) > 2:
        raise ValueError(f"--over must be given once or twice, got {len(over)} times")
    drawing.check(plot)
    plan = chosen_system(name if is_system(name) else single(name), gyro, set_, vehicle=vehicle, swaps=swap, params=params)
    ranges = [range_of(plan, text) for text in over or ()]
    if len({one.key for one in ranges}) < len(ranges):
        raise ValueError(f"--over must name two parameters, got {ranges[0].key} twice")
    rest = AtRest(plan, [one.key for one in ranges], ignorable(plan))
    if not ranges:
        if shapes is not None:
            _draw_shapes(rest, shapes)
        found: dict[str, Any] = {"system": plan.name, "velocities": velocities(rest.states), "modes": modes_of(rest)}
        say(as_json, lambda: found, *mode_words(found))
    elif len(ranges) == 1:
        _over_one(rest, ranges[0], plot, as_json)
    else:
        _over_two(rest, ranges[0], ranges[1], damping, plot, as_json)
    return 0


def _draw_shapes(rest: AtRest, image: Path) -> None:
    """The SHOWN oscillating modes that are damped least."""
    from ..figures import Shape, mode_shapes

    scenes = [(part.name, catalogue.component(part.source).scene) for part in rest.system.components]
    name, scene = next(((name, scene) for name, scene in scenes if scene and scene.get("bodies")), ("", None))
    if scene is None:
        raise ValueError(f"--shapes requires a component with a scene of bodies, {rest.system.name!r} has none")
    oscillating = [mode for mode in modes_at(rest, ()) if mode.root.imag > 0.0]
    chosen = sorted(oscillating, key=lambda mode: mode.damping)[:SHOWN]
    if not chosen:
        raise ValueError(f"--shapes requires a mode that oscillates, {rest.system.name!r} has none")
    drawn = []
    for mode in chosen:
        states = [state.partition(" - ")[0].removeprefix(f"{name}.") for state in rest.states]  # distances: from the first one
        motion = dict(zip(states, map(complex, mode.shape), strict=True))
        moves = mode.moves.removeprefix(f"{name}.")
        words = f"{mode.frequency:.3g} Hz, damping ratio {mode.damping:.3g}: mostly {moves}"
        drawn.append(Shape(words, {key: v / motion[moves] for key, v in motion.items()}))
    drawing.save(mode_shapes(scene, drawn, f"{rest.system.name}: the modes that are damped least"), image)


@dataclass(frozen=True)
class Range:
    """A parameter as `component.parameter`, its values in SI, its unit."""

    key: str
    values: np.ndarray
    unit: str

    @property
    def label(self) -> str:
        return f"{self.key} [{self.unit}]"


def _over_one(rest: AtRest, over: Range, plot: Path | None, as_json: bool) -> None:
    growth = [rest.growth((value,)) for value in over.values]
    changes = crossings(rest, over.values)
    if plot is not None:
        from ..figures import figure
        from ..stability.figures import root_locus

        fig, axes = figure(1, 1, (8.0, 5.0))
        root_locus(axes[0, 0], rest.paths(over.values[:, None]), over.values, over.label)
        # fast and slow roots lie decades apart; pairs are symmetric
        axes[0, 0].set(xscale="symlog", yscale="symlog", ylim=(0.0, None))
        axes[0, 0].set_title(f"{rest.system.name}: roots, rings at {over.values[0]:g} {over.unit}", fontsize=10)
        drawing.save(fig, plot)
    series = {
        "system": rest.system.name, "parameter": over.key, "unit": over.unit, "values": list(over.values), "growth": growth,
        "crossings": [value for value, _ in changes], "crossing_modes": [_row(mode) for _, mode in changes],
    }  # fmt: skip
    table = Table(over.label, "largest growth [1/s]", box=None, pad_edge=False)
    for value, rate in zip(over.values, growth, strict=True):
        table.add_row(f"{value:g}", f"{rate:.4g}")
    lines = [
        f"stability changes at {over.key} = {value:.6g} {over.unit}: {mode.frequency:.4g} Hz, mostly {mode.moves}"
        for value, mode in changes
    ]
    say(as_json, lambda: series, table, *(lines or [f"the largest growth has one sign at all {over.values.size} values"]))


def _over_two(rest: AtRest, across: Range, along: Range, damping: bool, plot: Path | None, as_json: bool) -> None:
    of = rest.damping if damping else rest.growth
    found = np.array([[of((a, b)) for a in across.values] for b in along.values])
    words = "least damping ratio" if damping else "largest growth [1/s]"
    if plot is not None:
        from ..stability.figures import stability_map

        fig = stability_map((across.label, across.values), (along.label, along.values), found, words, stable_above=damping)
        fig.axes[0].set_title(f"{rest.system.name}: stable where blue", fontsize=10)
        drawing.save(fig, plot)
    series = {
        "system": rest.system.name, "parameters": [across.key, along.key], "units": [across.unit, along.unit],
        "values": [list(across.values), list(along.values)], "damping" if damping else "growth": found.tolist(),
    }  # fmt: skip
    table = Table(f"{along.label}, across {across.label}", *(f"{a:g}" for a in across.values), box=None, pad_edge=False)
    for b, row in zip(along.values, found, strict=True):
        table.add_row(f"{b:g}", *(f"{value:.4g}" for value in row))
    say(as_json, lambda: series, words, table)


def ignorable(plan: System) -> tuple[str, ...]:
    """Distances run, of each component that has any: a vehicle may stand anywhere on straight track."""
    return tuple(
        f"{part.name}.*distance"
        for part in plan.components
        if any(v.name.endswith("distance") for v in catalogue.component(part.source).states)
    )


def range_of(plan: System, text: str) -> Range:
    """What --over says, checked."""
    key, _, ends = text.partition("=")
    parts = ends.split(":")
    if len(parts) != 3 or not parts[2].isdecimal() or int(parts[2]) < 2:
        raise ValueError(f"--over must be COMPONENT.PARAMETER=FROM:TO:N with N of 2 or more, got {text!r}")
    owner, _, parameter = key.partition(".")
    source = next(part.source for part in plan.components if part.name == plan.addressed(owner)[0])
    rows = {v.name: v for v in catalogue.component(source).parameters}
    if parameter not in rows:
        raise unknown(f"parameter of {owner!r}", parameter, rows)
    unit = rows[parameter].unit
    try:
        low, high = (rows[parameter].check(quantity(end, unit)) for end in parts[:2])
    except ValueError as error:
        raise ValueError(f"--over {error}") from None
    if low == high:
        raise ValueError(f"--over must lead from one value to another, got {text!r}")
    return Range(key, np.linspace(low, high, int(parts[2])), unit)


def velocities(states: tuple[str, ...]) -> int:
    """Degrees of freedom that have a velocity among the states."""
    return sum(state.partition(" - ")[0].endswith(RATES) for state in states)


def modes_of(rest: AtRest) -> list[dict[str, Any]]:
    """One row for each real root and each pair, in order of falling growth."""
    return [_row(mode) for mode in modes_at(rest, rest.q0)]


def _row(mode: Mode) -> dict[str, Any]:
    return {"growth": mode.root.real, "frequency": mode.frequency, "damping": mode.damping, "moves": mode.moves}


def mode_words(found: dict[str, Any]) -> list[str | Table]:
    table = Table("growth [1/s]", "frequency [Hz]", "damping", "takes part most", box=None, pad_edge=False)
    for mode in found["modes"]:
        table.add_row(f"{mode['growth']:.4g}", f"{mode['frequency']:.4g}", f"{mode['damping']:.3f}", mode["moves"])
    return [f"{found['system']}: {found['velocities']} degrees of freedom", table]
