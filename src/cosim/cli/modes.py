"""cosim modes: the eigenvalues of a vehicle, or of a system, linearised at rest: frequency, damping, what moves."""

from typing import Annotated, Any

import numpy as np
import typer
from rich.table import Table

from gyro_cosim.component.units import quantity

from ..errors import unknown
from ..stability.at_rest import AtRest
from ..systems import System, catalogue
from .common import AsJson, Gyro, Parameters, Swaps, Values, Vehicle, chosen_system, is_system, say
from .parameters import single

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
        str | None,
        typer.Option(
            metavar="COMPONENT.PARAMETER=FROM:TO:N", help="the least stable root over a parameter: vehicle.speed=5:50:10"
        ),
    ] = None,
    as_json: AsJson = False,
) -> int:
    """List the modes of a system at rest on straight track: growth, frequency, damping ratio, and which state moves most.

    With --over the largest growth is listed for each value, and where it changes sign between two of them.
    """
    plan = chosen_system(name if is_system(name) else single(name), gyro, set_, vehicle=vehicle, swaps=swap, params=params)
    free, values, unit = ((), np.zeros(0), "") if over is None else _range(plan, over)
    rest = AtRest(plan, free, ignorable(plan))
    if over is None:
        found: dict[str, Any] = {"system": plan.name, "velocities": velocities(rest.states), "modes": modes_of(rest)}
        say(as_json, lambda: found, *mode_words(found))
        return 0
    growth = [rest.growth((value,)) for value in values]
    crossings = [
        float(a + (b - a) * g / (g - h))
        for a, b, g, h in zip(values, values[1:], growth, growth[1:], strict=False)
        if (g > 0.0) != (h > 0.0)
    ]
    series = {
        "system": plan.name,
        "parameter": free[0],
        "unit": unit,
        "values": list(values),
        "growth": growth,
        "crossings": crossings,
    }
    table = Table(f"{free[0]} [{unit}]", "largest growth [1/s]", box=None, pad_edge=False)
    for value, rate in zip(values, growth, strict=True):
        table.add_row(f"{value:g}", f"{rate:.4g}")
    lines = [f"stability changes near {free[0]} = {value:.4g} {unit}" for value in crossings] or ["stability does not change"]
    say(as_json, lambda: series, table, *lines)
    return 0


def ignorable(plan: System) -> tuple[str, ...]:
    """Distances run, of each component that has any: a vehicle may stand anywhere on straight track."""
    return tuple(
        f"{part.name}.*distance"
        for part in plan.components
        if any(v.name.endswith("distance") for v in catalogue.component(part.source).states)
    )


def _range(plan: System, text: str) -> tuple[tuple[str, ...], np.ndarray, str]:
    """Parameter, its values in SI, its unit."""
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
    return (key,), np.linspace(low, high, int(parts[2])), unit


def velocities(states: tuple[str, ...]) -> int:
    """Degrees of freedom that have a velocity among the states."""
    return sum(state.partition(" - ")[0].endswith(RATES) for state in states)


def modes_of(rest: AtRest) -> list[dict[str, Any]]:
    """One row for each real root and each pair, in order of falling growth."""
    values, vectors = np.linalg.eig(rest.matrix(rest.q0))
    rows = []
    for k in np.lexsort((values.imag, -values.real)):
        s, shape = complex(values[k]), np.abs(vectors[:, k])
        if s.imag < 0.0:
            continue
        damping = -s.real / abs(s) if s else 0.0
        moves = rest.states[int(shape.argmax())].partition(" - ")[0]
        rows.append({"growth": s.real, "frequency": s.imag / (2 * np.pi), "damping": float(damping), "moves": moves})
    return rows


def mode_words(found: dict[str, Any]) -> list[str | Table]:
    table = Table("growth [1/s]", "frequency [Hz]", "damping", "moves most", box=None, pad_edge=False)
    for mode in found["modes"]:
        table.add_row(f"{mode['growth']:.4g}", f"{mode['frequency']:.4g}", f"{mode['damping']:.3f}", mode["moves"])
    return [f"{found['system']}: {found['velocities']} degrees of freedom", table]
