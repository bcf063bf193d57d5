"""The Reference-FMUs of the Modelica Association, each alone, by Co-Simulation and by Model Exchange, beside their own results.

    python benchmarks/reference_fmus.py FMUS SOURCES

FMUS holds the compiled FMUs, FMI 2.0 and 3.0, in folders of any name; SOURCES is a checkout of their repository, in which each
model has a file `MODEL_out.csv`. Their results are those of explicit Euler with the steps of the Co-Simulation FMUs; these must
be met to rounding. Model Exchange integrates with error control, so it is judged by the solution of the model itself, by formula
or computed here to 1e-12, and the distance from their results is told beside it.

Exit code 1 if an FMU does not run, or is further away than LARGEST.
"""

import argparse
import csv
import sys
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from rich.console import Console
from rich.table import Table
from scipy.integrate import solve_ivp

from gyro_cosim import System, SystemComponent, simulate
from gyro_cosim.slaves.fmi.description import Description, load

LARGEST = {"CoSimulation": 1e-12, "ModelExchange": 1e-4}  # share of the largest value of a signal
OTHER_MODEL = {"Roberts": "their file holds the results of BouncingBall"}
Solution = Callable[[np.ndarray], Mapping[str, np.ndarray]]


@dataclass(frozen=True)
class Row:
    """An FMU by one interface: how far it is from its reference and from the solution, None where there is none; what is to be
    said of it."""

    model: str
    version: str
    way: str
    from_reference: float | None = None
    from_solution: float | None = None
    words: str = ""
    tolerance: float = 0.0

    @property
    def right(self) -> bool:
        """Whether it ran, and is near enough to what it is judged by: ten times its own tolerance, where that is larger."""
        if self.way == "CoSimulation" and self.from_reference is not None:
            return self.from_reference <= LARGEST[self.way]
        return self.from_solution is not None and self.from_solution <= max(LARGEST["ModelExchange"], 10 * self.tolerance)


# ---- their results, and the solutions of the models


def reference(file: Path) -> tuple[np.ndarray, dict[str, np.ndarray]]:
    """t (s), and the columns by the names that our results have; arrays are taken apart."""
    with file.open(newline="") as lines:
        head, *rows = list(csv.reader(lines))
    columns: dict[str, np.ndarray] = {}
    for name, *cells in zip(head, *rows, strict=True):
        words = [cell.split(" ") for cell in cells]
        n = len(words[0]) if not np.isnan([_number(word) for word in words[0]]).any() else 1
        for k in range(n):
            columns[name if n == 1 else f"{name}[{k + 1}]"] = np.array([_number(word[k]) for word in words])
    return columns.pop("time"), columns


def _number(word: str) -> float:
    try:
        return {"false": 0.0, "true": 1.0}.get(word) if word in ("false", "true") else float(word)
    except ValueError:
        return np.nan  # a text, which results do not have


def ball(t: np.ndarray) -> dict[str, np.ndarray]:
    """Free flight from 1 m, with 0.7 of the speed after each impact, at rest below 0.1 m/s."""
    g, impact, v = 9.81, np.sqrt(2.0 / 9.81), np.sqrt(2.0 * 9.81)
    h, speed = 1.0 - g * t**2 / 2, -g * t
    while True:
        v *= 0.7
        after = t >= impact
        if v < 0.1:
            h[after] = speed[after] = 0.0
            return {"h": h, "v": speed}
        since = t[after] - impact
        h[after], speed[after] = v * since - g * since**2 / 2, v - g * since
        impact += 2 * v / g


def integrated(names: tuple[str, ...], x0: list[float], rates: Callable[[float, np.ndarray], list[float]]) -> Solution:
    """By an implicit method of high order, far closer than anything that is compared with it."""

    def at(t: np.ndarray) -> dict[str, np.ndarray]:
        found = solve_ivp(rates, (t[0], t[-1]), x0, "Radau", t, rtol=1e-12, atol=1e-14)
        return dict(zip(names, found.y, strict=True))

    return at


SOLUTIONS: dict[str, Solution] = {
    "BouncingBall": ball,
    "Dahlquist": lambda t: {"x": np.exp(-t)},
    "VanDerPol": integrated(("x0", "x1"), [2.0, 0.0], lambda t, x: [x[1], (1 - x[0] ** 2) * x[1] - x[0]]),
    "StateSpace": lambda t: {f"y[{k}]": k * np.exp(t) for k in (1, 2, 3)},
    "Roberts": integrated(
        ("y1", "y2", "y3"), [1.0, 0.0, 0.0],
        lambda t, y: [
            -0.04 * y[0] + 1e4 * y[1] * y[2], 0.04 * y[0] - 1e4 * y[1] * y[2] - 3e7 * y[1] ** 2, 3e7 * y[1] ** 2,
        ],
    ),
}  # fmt: skip


# ---- ours


def ran(file: Path, model: Description, way: str, sources: Path) -> Row:
    """The FMU alone, at the steps of its reference."""
    name, version = file.stem, model.identity["fmiVersion"]
    told = sources / name / f"{name}_out.csv"
    words = OTHER_MODEL.get(name, "" if told.exists() else "has no results")
    t, columns = reference(told) if not words else (np.linspace(0.0, 1.0, 11), {})
    part = SystemComponent("it", str(file), implementation=way)
    try:
        result = simulate(System("one", (part,), ()), step=float(t[1] - t[0]), start=float(t[0]), stop=float(t[-1])).trajectory
    except Exception as error:  # whatever it is, the other FMUs are to be tried, too
        return Row(name, version, way, words=f"{type(error).__name__}: {error}")
    shown = {one.removeprefix("it."): result[one] for one in result.names}
    compared = [one for one in columns if one in shown]
    if len(compared) < len(columns):
        words = f"{len(compared)} of {len(columns)} columns: it has no others that are numbers"
    exact = SOLUTIONS[name](result.t) if name in SOLUTIONS else {one: columns[one][: len(result.t)] for one in compared}
    common = {one for one in exact if one in shown and len(exact[one]) == len(shown[one])}
    return Row(
        name, version, way, _distance(shown, columns) if compared else None,
        _distance(shown, {one: exact[one] for one in common}) if common else None, words,
        float(model.experiment.get("tolerance", 0.0)),
    )  # fmt: skip


def _distance(ours: Mapping[str, np.ndarray], theirs: Mapping[str, np.ndarray]) -> float:
    """The largest, of all signals, as a share of the largest value of the signal."""
    worst = 0.0
    for name, values in theirs.items():
        if name in ours and not np.isnan(values).any():
            n = min(len(values), len(ours[name]))  # a run that ends by itself
            worst = max(worst, float(np.abs(ours[name][:n] - values[:n]).max() / max(1e-300, np.abs(values).max())))
    return worst


def survey(fmus: Path, sources: Path) -> list[Row]:
    """Every FMU below a folder by every interface that it offers."""
    rows = []
    for file in sorted(fmus.rglob("*.fmu")):
        try:
            model = load(str(file))
        except ValueError as error:
            rows.append(Row(file.stem, "", "", words=str(error).replace(str(file), file.name)))
            continue
        rows += [ran(file, model, way, sources) for way in ("CoSimulation", "ModelExchange") if way in model.interfaces]
    return rows


def main() -> int:
    """See the module."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("fmus", type=Path)
    parser.add_argument("sources", type=Path)
    given = parser.parse_args()
    rows = survey(given.fmus, given.sources)
    table = Table("model", "FMI", "by", "from its results", "from the solution", "")
    for row in rows:
        figures = ("" if one is None else f"{one:.1e}" for one in (row.from_reference, row.from_solution))
        table.add_row(row.model, row.version, row.way, *figures, row.words)
    Console(width=max(110, Console().width)).print(table)
    return 0 if all(row.right or not row.way for row in rows) else 1


if __name__ == "__main__":
    sys.exit(main())
