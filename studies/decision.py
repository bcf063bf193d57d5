"""Is the unit worth its mass? The vehicle without it, with the unit at rest, with it spinning, and with a yaw damper instead.

For both kinds of wheels, three creep laws, and curves of three radii at three speeds: from how many starts does a wheel leave its
rail? "No unit" is the vehicle without the 1200 kg: what somebody builds who does not believe in the unit. Starts are drawn evenly
within 1 mm of lateral displacement of each wheel pair; a share has Wilson's interval at 95 %. Runs go on for 250 m of straight
track behind the curve. Stopped, the study goes on; --starts N adds to the starts that are done. It prints the table of README.md.
Some 10 minutes for four starts. Run: python studies/decision.py [--starts N] [--short]
"""

import sys
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from gyro_cosim import System, figures, system
from gyro_cosim.comparison.error_bars import error_bar
from gyro_cosim.comparison.robustness import interval
from gyro_cosim.railway.assessment import assess
from gyro_cosim.sweeps import Measure, Sweep, load, sweep, write_summary
from gyro_cosim.systems import StopWhen
from gyro_cosim.trajectory import Trajectory
from gyro_cosim.vehicle.parameter_sets import parameter_set

# ---- parameters
SHORT = "--short" in sys.argv
STARTS = int(sys.argv[sys.argv.index("--starts") + 1]) if "--starts" in sys.argv else 4
FOLDER = Path("results/studies/short" if SHORT else "results/studies")
SYSTEMS = {"B": "lrt-curve-b"} if SHORT else {"A": "lrt-curve", "B": "lrt-curve-b"}
LAWS = {"Polach": "lrt", "Shen-Hedrick-Elkins": "lrt_shen_hedrick_elkins", "FASTSIM": "lrt_fastsim"}
LAWS = {"Polach": "lrt"} if SHORT else LAWS
speeds = "5,8" if SHORT else "5,8,11"  # m/s
radii = "50m,100m" if SHORT else "30m,50m,100m"
BEFORE, BEHIND = 20.0, 250.0  # m of straight track before the entry transition and behind the curve
TOLERANCE, SEED = 1e-3, 1  # m, of a wheel pair's place at the start, as `cosim run --robust` assumes it
BARE = {f"vehicle.{part}_gimbal_{what}": 0.0 for part in ("inner", "outer") for what in ("mass", "ixx", "izz")}
BARE |= {"vehicle.outer_gimbal_iyy": 0.0}
DAMPER = {"vehicle.pivot_damping": 5e3, "vehicle.bogie_mass": 540.0, "vehicle.bogie_izz": 444.7}  # 40 kg at 1 m: rivals.py
ALONE = {"no unit": BARE, "yaw damper": BARE | DAMPER}
WITH_UNIT = {"at rest": {"gyro.rotor_speed": 0.0}, "spinning": {"gyro.rotor_speed": "2000rpm"}}
UNITS = ("no unit", "at rest", "spinning", "yaw damper")
COLUMNS = {"derailed": "1", "at": "m", "ratio": "1", "climb": "1", "late": "m"}


def verdict(trajectory: Trajectory) -> dict[str, float]:
    """Derailed, where the run ended, largest Y/Q by EN 14363, farthest climb of a flange, largest |y| over the last 50 m."""
    (vehicle,) = assess(trajectory)
    s = trajectory["vehicle.body_distance"]
    y = [np.abs(trajectory[f"vehicle.{pair}_lateral_displacement"][s > s[-1] - 50.0]).max() for pair in ("front", "rear")]
    return {
        "derailed": float(vehicle.verdict.derailed), "at": float(s[-1]),
        "ratio": vehicle.worst.value if vehicle.worst else np.nan,
        "climb": max(float(trajectory[f"vehicle.{wheel}_climb"].max()) for wheel in vehicle.wheels), "late": max(y),
    }  # fmt: skip


def runs(name: str, law: str, units: dict[str, dict[str, Any]], alone: bool) -> tuple[Any, float]:
    """The rows of all starts, speeds and radii of some units, and the length of their track (m)."""
    values = parameter_set(name).vehicle
    length = BEFORE + 2 * values["transition_length"] + values["curve_length"] + BEHIND
    base = system(SYSTEMS[name]).with_source("vehicle", LAWS[law])
    for key, value in {**values, "curve_turn": 1.0, "curve_start": BEFORE}.items():
        base = base.with_value(f"vehicle.{key}", value)
    if alone:
        (vehicle,) = (c for c in base.components if c.name == "vehicle")
        base = System("alone", (vehicle,), (), stop_when=base.stop_when)
    end = StopWhen(("vehicle", "body_distance"), length, "end of the track")
    plan = replace(base, stop_when=(*base.stop_when, end))
    places = np.random.default_rng(SEED).uniform(-TOLERANCE, TOLERANCE, (STARTS, 2))
    cases = {f"{unit}, {k}": set_to | {"vehicle.front_lateral_displacement": y[0], "vehicle.rear_lateral_displacement": y[1]}
             for k, y in enumerate(places.tolist()) for unit, set_to in units.items()}  # fmt: skip
    what = Sweep(plan, {"vehicle.speed": speeds, "vehicle.curve_radius": radii}, cases=cases,
                 stop=1.2 * length / min(map(float, speeds.split(","))), signals=("vehicle.body_distance",),
                 measure=Measure(verdict, COLUMNS))  # fmt: skip
    file = FOLDER / f"decision-{name}-{LAWS[law]}-{'alone' if alone else 'unit'}.npz"
    outcome = sweep(what, file, extend=True)
    print(f"set {name}, {law}: {outcome.done} runs now, {outcome.before} before, {outcome.seconds:.0f} s", flush=True)
    return load(file), length


if __name__ == "__main__":
    FOLDER.mkdir(parents=True, exist_ok=True)
    cells: dict[tuple[str, str, float, float], dict[str, dict[str, Any]]] = {}  # wheels, law, radius, speed -> unit -> found
    R, V = ([float(text.rstrip("m")) for text in listed.split(",")] for listed in (radii, speeds))
    for name, law, (units, alone) in ((n, w, of) for n in SYSTEMS for w in LAWS for of in ((ALONE, True), (WITH_UNIT, False))):
        table, length = runs(name, law, units, alone)
        chosen = np.array([case.rpartition(", ") for case in table["case"].tolist()])
        wanted = (chosen[:, 2].astype(int) < STARTS) & (table["status"] == "ended")
        for radius, v, unit in ((r, v, u) for r in R for v in V for u in units):
            rows = table.where(
                wanted & (chosen[:, 0] == unit) & (table["vehicle.curve_radius"] == radius) & (table["vehicle.speed"] == v)
            )
            lost = rows["derailed"] == 1.0
            cells.setdefault((name, law, radius, v), {})[unit] = {
                "starts": len(lost), "derailed": int(lost.sum()), "share": interval(int(lost.sum()), len(lost)),
                "derailed_in_the_last_50_m": int((lost & (rows["at"] > length - 50.0)).sum()),
                "ratio": rows["ratio"].tolist(), "distance": (1.0 - rows["climb"]).tolist(),
                "late_mm": float(np.median(rows["late"][~lost])) * 1e3 if not lost.all() else None,
            }  # fmt: skip

    # ---- the table: how many starts derail with each unit, in the order of UNITS
    columns = [(name, law) for name in SYSTEMS for law in LAWS]
    head = ["R, m", "v, m/s", *(f"{name}, {law}" for name, law in columns)]
    lines = [head, ["---"] * len(head)]
    lines += [[f"{r:g}", f"{v:g}", *(" · ".join(str(cells[name, law, r, v][unit]["derailed"]) for unit in UNITS)
                                     for name, law in columns)] for r in R for v in V]  # fmt: skip
    page = "\n".join(f"| {' | '.join(line)} |" for line in lines) + "\n"
    (FOLDER / "decision.md").write_text(page, encoding="utf-8")
    print(f"starts that derail, of {STARTS}: {' · '.join(UNITS)}\n\n{page}")
    counts = sorted({cell[unit]["derailed"] for cell in cells.values() for unit in UNITS})
    print("95 %:", "; ".join("{}: {:.0f}..{:.0f} %".format(n, *(100 * x for x in interval(n, STARTS))) for n in counts))

    # ---- what it says, in counts
    worth: dict[str, dict[str, int]] = {}
    for (name, law, *_), cell in cells.items():
        (_, high), (low, _) = cell["spinning"]["share"], cell["no unit"]["share"]
        better, worse = high < low, cell["spinning"]["share"][0] > cell["no unit"]["share"][1]
        found = worth.setdefault(f"{name}, {law}", dict.fromkeys(("unit keeps it on the rails", "unit harms", "not decided"), 0))
        found["unit keeps it on the rails" if better else "unit harms" if worse else "not decided"] += 1
    for where, found in worth.items():
        print(f"{where}: of {len(R) * len(V)} curves " + ", ".join(f"{what} {n}" for what, n in found.items()))
    late = sum(cell[unit]["derailed_in_the_last_50_m"] for cell in cells.values() for unit in UNITS)
    every = sum(cell[unit]["derailed"] for cell in cells.values() for unit in UNITS)
    print(f"of {every} derailments {late} happen in the last 50 m of the track")

    # ---- error bars from the first half of the starts, asked of the other half
    half, asked = STARTS // 2, {}
    for what in ("ratio", "distance"):
        bars = [(error_bar(cell[unit][what][:half]), cell[unit][what][half:]) for cell in cells.values() for unit in UNITS]
        held = np.mean([bar.low <= value <= bar.high for bar, fresh in bars for value in fresh])
        asked[what] = {"said": bars[0][0].share, "held": float(held), "fresh": sum(len(fresh) for _, fresh in bars)}
        print("error bars of {}: said {said:.3f}, hold in {held:.3f} of {fresh} fresh runs".format(what, **asked[what]))

    # ---- figure: shares with their intervals, a panel for each kind of wheels and law
    fig, axes = figures.figure(len(SYSTEMS), len(LAWS), (6.0 * len(LAWS), 3.6 * len(SYSTEMS)))
    for ax, (name, law) in zip(axes.flat, columns, strict=True):
        for k, (unit, colour) in enumerate(zip(UNITS, ("0.6", "0.2", *figures.COLOURS[:2]), strict=True)):
            found = [cells[name, law, r, v][unit] for r in R for v in V]
            share = np.array([one["derailed"] / one["starts"] for one in found])
            ends = np.abs(np.array([one["share"] for one in found]).T - share)
            ax.bar(np.arange(share.size) + 0.2 * (k - 1.5), share, 0.18, yerr=ends, color=colour, ecolor="0.45",
                   error_kw={"linewidth": 0.8}, label=unit)  # fmt: skip
        ax.set_xticks(range(len(R) * len(V)), [f"R {r:g} m\n{v:g} m/s" for r in R for v in V], fontsize=7)
        ax.set(ylim=(0.0, 1.05), ylabel="share of starts that derail", title=f"set {name}, {law}")
    handles, labels = axes.flat[0].get_legend_handles_labels()
    fig.legend(handles, labels, loc="outside lower center", ncols=len(UNITS))
    figures.save(fig, FOLDER / "decision.png")
    write_summary(FOLDER / "decision.json", {
        "command": " ".join(["python studies/decision.py", *sys.argv[1:]]), "starts": STARTS, "worth": worth,
        "derailments": {"all": every, "in_the_last_50_m": late}, "error_bars": asked,
        "cells": {f"{n}, {law}, R = {r:g} m, {v:g} m/s": cell for (n, law, r, v), cell in cells.items()},
    })  # fmt: skip
