"""cosim response: what a vehicle does on a wavy track, over the frequency, linearised at rest."""

from pathlib import Path
from typing import Annotated, Any

import numpy as np
import typer
from rich.table import Table

from ..errors import unknown
from ..stability.response import Wave, wave_response
from ..systems import System, catalogue
from . import drawing
from .alone import single
from .common import AsJson, Gyro, Parameters, Swaps, Values, Vehicle, chosen_system, is_system, say
from .modes import ignorable

WAVE = "stretch_"  # what the parameters of a wave begin with
CHANNELS = ("lateral", "vertical", "cross_level", "gauge")
USUAL = {"lateral": "lateral_velocity", "gauge": "lateral_velocity", "vertical": "vertical_velocity", "cross_level": "roll_rate"}
PER_SECOND = {"m/s": "m/s2", "rad/s": "rad/s2"}
SHOWN = 12  # rows of the table


def command(
    name: Annotated[
        str, typer.Argument(metavar="SOURCE", help="a system, a component such as vehicle:lrt, or a vehicle's .toml file")
    ],
    vehicle: Vehicle = None,
    gyro: Gyro = None,
    swap: Swaps = None,
    set_: Values = None,
    params: Parameters = None,
    track: Annotated[str, typer.Option(metavar="CHANNEL", help=f"which irregularity: {', '.join(CHANNELS)}")] = "vertical",
    of: Annotated[
        list[str] | None,
        typer.Option(metavar="COMPONENT.STATE", help="whose response; several times. A velocity of every body otherwise"),
    ] = None,
    rate: Annotated[bool, typer.Option("--rate", help="of their rates of change: of velocities the accelerations")] = False,
    frequencies: Annotated[
        str, typer.Option(metavar="FROM:TO:N", help="in Hz, N of them, evenly over the logarithm")
    ] = "0.2:20:100",
    plot: Annotated[Path | None, typer.Option(metavar="FILE", help="draw gain and phase")] = None,
    as_json: AsJson = False,
) -> int:
    """List the response to a sinusoidal track: gain for a metre of irregularity, and phase, over the frequency.

    Of a vehicle linearised at rest on straight track, at its speed; every axle meets the track in its own time.
    """
    drawing.check(plot)
    if track not in CHANNELS:
        raise unknown("--track:", track, CHANNELS)
    plan = chosen_system(name if is_system(name) else single(name), gyro, set_, vehicle=vehicle, swaps=swap, params=params)
    f = _frequencies(frequencies)
    carrier, wave = _wave(plan, track)
    response = wave_response(plan, wave, f.tolist(), ignorable(plan))
    every, speed = response.states, response.speed
    if rate:
        every = {state: 2j * np.pi * f * values for state, values in every.items()}
    chosen = _chosen(carrier, every, of, track)
    units = {state: PER_SECOND.get(unit, f"{unit}/s") if rate else unit for state in chosen for unit in [_unit(plan, state)]}
    if plot is not None:
        _draw(plan, track, f, {state: every[state] for state in chosen}, units, speed, plot)
    found: dict[str, Any] = {
        "system": plan.name, "channel": track, "speed": speed, "frequencies": f.tolist(), "rate": rate,
        "gain": {state: np.abs(every[state]).tolist() for state in chosen},
        "phase": {state: np.angle(every[state]).tolist() for state in chosen},
        "units": {s: f"{u} per m" for s, u in units.items()},
    }  # fmt: skip
    table = Table("frequency [Hz]", *(f"{state} [{units[state]} per m]" for state in chosen), box=None, pad_edge=False)
    for k in np.unique(np.linspace(0, f.size - 1, min(SHOWN, f.size)).round().astype(int)):
        table.add_row(f"{f[k]:.4g}", *(f"{abs(every[state][k]):.4g}" for state in chosen))
    peaks = [(state, int(np.argmax(np.abs(every[state])))) for state in chosen]
    lines = [f"largest of {state}: {abs(every[state][k]):.4g} {units[state]} per m at {f[k]:.4g} Hz" for state, k in peaks]
    say(as_json, lambda: found, f"{plan.name} at {speed:g} m/s, {track} irregularity", table, "", *lines)
    return 0


def _frequencies(text: str) -> np.ndarray:
    parts = text.split(":")
    try:
        low, high, count = float(parts[0]), float(parts[1]), int(parts[2])
    except (ValueError, IndexError):
        raise ValueError(f"--frequencies must be FROM:TO:N, such as 0.2:20:100, got {text!r}") from None
    if not (0.0 < low < high < np.inf and 2 <= count <= 100_000 and len(parts) == 3):
        raise ValueError(f"--frequencies must rise from above 0 Hz, with 2 to 100000 of them, got {text!r}")
    return np.geomspace(low, high, count)


def _wave(plan: System, track: str) -> tuple[str, Wave]:
    """The component that runs on a track, and the parameters of its wave."""
    for part in plan.components:
        made = catalogue.component(part.source)
        rows = {v.name: v.start for v in made.parameters}
        if f"{WAVE}{track}" in rows and "speed" in rows:
            amplitude, length, start, cycles = (f"{part.name}.{WAVE}{what}" for what in (track, "wavelength", "start", "cycles"))
            return part.name, Wave(amplitude, length, start, cycles, f"{part.name}.speed")
    raise ValueError(f"response requires a component with parameters {WAVE}{track} and speed, {plan.name!r} has none")


def _chosen(carrier: str, every: dict[str, np.ndarray], of: list[str] | None, track: str) -> list[str]:
    if of:
        for state in of:
            if state not in every:
                raise unknown("--of:", state, list(every))
        return list(of)
    return [state for state in every if state.startswith(f"{carrier}.") and state.endswith(USUAL[track])]


def _unit(plan: System, state: str) -> str:
    owner, _, name = state.partition(".")
    source = next(part.source for part in plan.components if part.name == owner)
    return str(next(v.unit for v in catalogue.component(source).states if v.name == name))


def _draw(
    plan: System, track: str, f: np.ndarray, chosen: dict[str, np.ndarray], units: dict[str, str], speed: float, image: Path
) -> None:
    from ..figures import figure, legend_above

    fig, axes = figure(2, 1, (8.0, 6.5), sharex=True)
    for state, values in chosen.items():
        axes[0, 0].loglog(f, np.abs(values), label=state)
        axes[1, 0].semilogx(f, np.degrees(np.angle(values)))
    unit = " or ".join(dict.fromkeys(units.values()))
    axes[0, 0].set_ylabel(f"gain [{unit} per m]")
    axes[1, 0].set(xlabel="frequency [Hz]", ylabel="phase [deg]", ylim=(-185, 185), yticks=range(-180, 181, 90))
    fig.suptitle(f"{plan.name} at {speed:g} m/s: response to {track.replace('_', ' ')} irregularity", fontsize=10)
    legend_above(axes[0, 0])
    drawing.save(fig, image)
