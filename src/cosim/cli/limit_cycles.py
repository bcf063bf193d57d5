"""cosim limit-cycles: the oscillations into which a vehicle, or a system, runs where its rest becomes unstable."""

from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, Any

import numpy as np
import typer
from rich.table import Table

from ..errors import unknown
from ..stability.at_rest import AtRest
from ..stability.limit_cycles import FEWEST, INTERVALS, Branch, branch
from ..stability.modes import Mode, crossings
from . import drawing
from .alone import single
from .common import AsJson, Gyro, Parameters, Swaps, Values, Vehicle, chosen_system, is_system, say
from .modes import Range, ignorable, range_of

FIRST = 1e-3  # m or rad: the size that counts as one on the branch
STEPS = 25  # changes of the parameter over the whole range that each count as much
SHOWN = 20  # rows of the table
MILLI = {"m": "mm", "rad": "mrad"}


def command(
    name: Annotated[
        str, typer.Argument(metavar="SOURCE", help="a system, a component such as vehicle:lrt, or a vehicle's .toml file")
    ],
    over: Annotated[
        str,
        typer.Option(
            metavar="COMPONENT.PARAMETER=FROM:TO:N",
            help="the parameter and its range, with N values among which rest becomes unstable: vehicle.speed=5:50:20",
        ),
    ],
    vehicle: Vehicle = None,
    gyro: Gyro = None,
    swap: Swaps = None,
    set_: Values = None,
    params: Parameters = None,
    of: Annotated[
        str | None,
        typer.Option(metavar="COMPONENT.STATE", help="whose amplitude, a length or an angle; the one that moves most otherwise"),
    ] = None,
    intervals: Annotated[
        int, typer.Option(metavar="N", help="of a period, each with three places at which the equations hold")
    ] = INTERVALS,
    most: Annotated[int, typer.Option(metavar="N", help="cycles on a branch")] = 80,
    plot: Annotated[Path | None, typer.Option(metavar="FILE", help="draw amplitude over the parameter")] = None,
    as_json: AsJson = False,
) -> int:
    """Follow the limit cycles of a system on straight track over a parameter: amplitude, frequency, stability, folds.

    A branch begins where the equilibrium becomes unstable in an oscillation. Where it leads back to lower speeds, the vehicle
    hunts there after a large enough disturbance although its rest is stable: the fold is the lowest speed at which it does.
    """
    drawing.check(plot)
    if intervals < FEWEST:
        raise ValueError(f"--intervals must be {FEWEST} or more, got {intervals}")
    if most < 1:
        raise ValueError(f"--most must be 1 or more, got {most}")
    plan = chosen_system(name if is_system(name) else single(name), gyro, set_, vehicle=vehicle, swaps=swap, params=params)
    along = range_of(plan, over)
    rest = AtRest(plan, (along.key,), ignorable(plan))
    units = {f"{v.part}.{v.name}": v.unit for v in _states(plan)}
    if of is not None and units.get(of) not in MILLI:
        raise unknown("--of: state that is a length or an angle", of, [s for s, unit in units.items() if unit in MILLI])
    starts = [(v, mode) for v, mode in crossings(rest, along.values) if mode.root.imag > 0.0]
    found = [_follow(rest, along, start, of, units, intervals, most) for start in starts]
    if plot is not None and found:
        _draw(rest.system.name, along, found, plot)
    series: dict[str, Any] = {
        "system": rest.system.name, "parameter": along.key, "unit": along.unit, "branches": [one.series() for one in found],
    }  # fmt: skip
    lines = [words for one in found for words in one.words(along)] or [
        f"no pair of roots crosses the imaginary axis between {along.values[0]:g} and {along.values[-1]:g} {along.unit}: "
        "no branch of limit cycles begins there"
    ]
    say(as_json, lambda: series, *lines)
    return 0


@dataclass(frozen=True)
class _State:
    part: str
    name: str
    unit: str


def _states(plan: Any) -> list[_State]:
    from ..systems import catalogue

    return [_State(p.name, v.name, v.unit) for p in plan.components for v in catalogue.component(p.source).states]


@dataclass(frozen=True)
class _Found:
    """A branch with what it begins with, and the state whose amplitude is told: its name, row and unit."""

    v: float
    mode: Mode
    branch: Branch
    state: str
    row: int
    unit: str

    def amplitudes(self) -> list[float]:
        return [float(cycle.amplitudes()[self.row]) for cycle in self.branch.cycles]

    def series(self) -> dict[str, Any]:
        cycles = self.branch.cycles
        return {
            "begins": self.v, "frequency_there": self.mode.frequency, "moves": self.mode.moves, "amplitude_of": self.state,
            "amplitude_unit": self.unit, "values": [c.v for c in cycles], "amplitudes": self.amplitudes(),
            "frequencies": [c.frequency for c in cycles], "multipliers": [c.multiplier for c in cycles],
            "multiplier_errors": [c.error for c in cycles], "stable": [c.is_stable for c in cycles],
            "folds": [{"value": c.v, "amplitude": float(c.amplitudes()[self.row])} for c in self.branch.folds],
            "ended": self.branch.ended,
        }  # fmt: skip

    def words(self, along: Range) -> list[str | Table]:
        cycles, sizes = self.branch.cycles, self.amplitudes()
        table = Table(
            along.label, f"amplitude of {self.state} [{MILLI[self.unit]}]", "frequency [Hz]", "Floquet multiplier", "", box=None,
            pad_edge=False,
        )  # fmt: skip
        for k in np.unique(np.linspace(0, len(cycles) - 1, min(SHOWN, len(cycles))).round().astype(int)):
            c = cycles[k]
            stable = "stable" if c.is_stable else "unstable" if c.is_unstable else "neutral"
            table.add_row(f"{c.v:.6g}", f"{1e3 * sizes[k]:.4g}", f"{c.frequency:.4g}", f"{c.multiplier:.4g}", stable)
        begins = f"rest becomes unstable at {along.key} = {self.v:.6g} {along.unit}: {self.mode.frequency:.4g} Hz, mostly"
        lines: list[str | Table] = [f"{begins} {self.mode.moves}", table]
        for c in self.branch.folds:
            size = 1e3 * c.amplitudes()[self.row]
            lines.append(f"fold at {along.key} = {c.v:.6g} {along.unit}, amplitude {size:.4g} {MILLI[self.unit]}")
        settled = [(c.v, size) for c, size in zip(cycles, sizes, strict=True) if c.is_stable]
        if settled:
            low, high = min(settled), max(settled)
            lines.append(f"stable cycles from {low[0]:.6g} to {high[0]:.6g} {along.unit}")
        return [*lines, f"{len(cycles)} cycles; {self.branch.ended}"]


def _follow(
    rest: AtRest, along: Range, start: tuple[float, Mode], of: str | None, units: dict[str, str], intervals: int, most: int
) -> _Found:
    v, mode = start
    names = [label.partition(" - ")[0] for label in rest.states]
    sized = [k for k, name in enumerate(names) if units[name] in MILLI and " - " not in rest.states[k]]
    chosen = [k for k in sized if names[k] == of] if of is not None else sized
    if not chosen:
        raise ValueError(f"--of: the amplitude of {of or 'a state'} does not exist, it may be shifted without change")
    size = np.abs(mode.shape)
    lengths = [k for k in chosen if units[names[k]] == "m" and size[k] > 0.0] or chosen
    row = max(lengths, key=lambda k: size[k])
    if not size[row] > 1e-9 * size.max():
        raise ValueError(f"--of: {names[row]} must move in the mode that becomes unstable, it does not")
    values = float(along.values.min()), float(along.values.max())
    scale = (values[1] - values[0]) / STEPS / abs(v) if v else 1.0
    made = branch(
        rest.flow(),
        (v, 1j * mode.root.imag, mode.shape * (FIRST / size[row])),
        values,
        intervals=intervals,
        most=most,
        scale=scale,
    )
    return _Found(v, mode, made, names[row], row, units[names[row]])


def _draw(name: str, along: Range, found: list[_Found], image: Path) -> None:
    from ..figures import COLOURS, figure, legend_above

    fig, axes = figure(1, 1, (8.0, 5.0))
    ax = axes[0, 0]
    for one, colour in zip(found, COLOURS, strict=False):
        v = np.array([one.v, *(c.v for c in one.branch.cycles)])
        size = 1e3 * np.array([0.0, *one.amplitudes()])
        stable = np.array([False, *(c.is_stable for c in one.branch.cycles)])
        ax.plot(v, size, "--", color=colour, linewidth=1.0, label="unstable or neutral")
        pieces = np.flatnonzero(np.diff(np.concatenate([[0], stable.view(np.int8), [0]])))
        for k, (a, b) in enumerate(zip(pieces[::2], pieces[1::2], strict=True)):
            ax.plot(v[a:b], size[a:b], "-", color=colour, linewidth=2.2, label="stable" if k == 0 else None)
        ax.plot(one.v, 0.0, "o", color=colour, label=f"rest unstable from {one.v:.4g} {along.unit}")
        for c in one.branch.folds:
            ax.plot(c.v, 1e3 * c.amplitudes()[one.row], "D", color=colour, label=f"fold at {c.v:.4g} {along.unit}")
    of, unit = (" or ".join(sorted(words)) for words in ({one.state for one in found}, {MILLI[one.unit] for one in found}))
    ax.set(xlabel=along.label, ylabel=f"amplitude of {of} [{unit}]", ylim=(0.0, None))
    fig.suptitle(f"{name}: limit cycles", fontsize=10)
    legend_above(ax)
    drawing.save(fig, image)
