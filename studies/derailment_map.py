"""Where does the vehicle derail? Maps over speed and spin, speed and curve radius, and lever arm and damping of the gimbal.

Vehicle and two gyro units as FMUs through a curve to the end of its track, as sweeps: one that is stopped goes on where it was.
Runs that hunt in the flanges are chaotic, so each cell is a few runs that start a tenth of a millimetre apart.
Parameter set A has Table 2's wheels, B wheels almost without spin inertia. Run: python studies/derailment_map.py [--short]
"""

import sys
from dataclasses import replace
from pathlib import Path

import numpy as np
from matplotlib.colors import ListedColormap
from matplotlib.patches import Patch

from gyro_cosim import figures, system
from gyro_cosim.railway.assessment import assess
from gyro_cosim.railway.safety import LIMIT
from gyro_cosim.sweeps import Measure, Sweep, load, sweep, write_summary
from gyro_cosim.systems import StopWhen
from gyro_cosim.trajectory import Trajectory
from gyro_cosim.vehicle.parameter_sets import parameter_set

# ---- parameters
SHORT = "--short" in sys.argv
FOLDER = Path("results/studies/short" if SHORT else "results/studies")
SYSTEMS = {"B": "lrt-curve-b"} if SHORT else {"A": "lrt-curve", "B": "lrt-curve-b"}
BEFORE, BEHIND = 20.0, 50.0  # m of straight track before the entry transition and behind the curve
START, SPEED, RADIUS, SPIN = "vehicle.front_lateral_displacement", "vehicle.speed", "vehicle.curve_radius", "gyro.rotor_speed"
ARM, DAMPING = "gyro.spring_arm", "gyro.gimbal_damping"
starts = "0mm" if SHORT else "0mm,0.1mm,-0.1mm"
speeds = "8,9" if SHORT else "3,4,5,6,7,8,9,10,11,12"  # m/s
radii = "50m,100m" if SHORT else "20m,30m,40m,50m,75m,100m,150m"
spins = "0rpm,2000rpm" if SHORT else "0rpm,500rpm,1000rpm,1500rpm,2000rpm,3000rpm,4000rpm"
arms = "0.3m,0.5m" if SHORT else "0.1m,0.2m,0.3m,0.4m,0.5m"
dampings = "21000,84000" if SHORT else "5250,10500,21000,42000,84000"  # N s/m; 21 000 each damper of Table 2
MAPS = {  # name -> title, x, y, what is set beside
    "spin": ("over speed and spin, R = 50 m", SPEED, SPIN, {SPEED: speeds, SPIN: spins}),
    "radius-off": ("gyro off (0 rpm)", SPEED, RADIUS, {SPEED: speeds, RADIUS: radii, SPIN: "0rpm"}),
    "radius-on": ("gyro on (2000 rpm)", SPEED, RADIUS, {SPEED: speeds, RADIUS: radii, SPIN: "2000rpm"}),
    "damper": ("gyro on, 8 m/s, R = 50 m", DAMPING, ARM, {SPEED: "8", SPIN: "2000rpm", ARM: arms, DAMPING: dampings}),
}
LABELS = {SPEED: ("speed [m/s]", 1.0), SPIN: ("spin [rpm]", 30 / np.pi), RADIUS: ("curve radius [m]", 1.0),
          ARM: ("lever arm $d_g$ [m]", 1.0), DAMPING: ("damping $c_g$ [kN s/m]", 1e-3)}  # fmt: skip
KINDS = {f"passes, Y/Q at most {LIMIT:g}": "#56b4e9", f"passes, Y/Q above {LIMIT:g}": "#f0e442",
         "derails from some starts": "#e69f00", "derails from every start": "#d55e00", "no result": "#bbbbbb"}  # fmt: skip


def verdict(trajectory: Trajectory) -> dict[str, float]:
    """Whether a wheel left its rail, and the largest Y/Q of any wheel by EN 14363."""
    (vehicle,) = assess(trajectory)
    return {"derailed": float(vehicle.verdict.derailed), "ratio": vehicle.worst.value if vehicle.worst else np.nan}


if __name__ == "__main__":
    FOLDER.mkdir(parents=True, exist_ok=True)
    count = len(starts.split(","))
    summary: dict[str, dict[str, dict[str, object]]] = {}
    fig, axes = figures.figure(len(MAPS), len(SYSTEMS), (6.0 * len(SYSTEMS), 3.6 * len(MAPS)))
    for column, (name, file) in zip(axes.T, SYSTEMS.items(), strict=True):
        # ---- system: the run ends where its track does, at whatever speed
        layout = parameter_set(name).vehicle
        length = BEFORE + 2 * layout["transition_length"] + layout["curve_length"] + BEHIND
        plan = system(file).with_value("vehicle.curve_start", BEFORE)
        end = StopWhen(("vehicle", "body_distance"), length, "end of the track")
        plan = replace(plan, stop_when=(*plan.stop_when, end))
        for ax, (kind, (title, x, y, values)) in zip(column, MAPS.items(), strict=True):
            # ---- run
            what = Sweep(plan, {**values, START: starts}, signals=("vehicle.body_distance",),
                         stop=1.2 * length / min(float(v) for v in values[SPEED].split(",")),
                         measure=Measure(verdict, {"derailed": "1", "ratio": "1"}))  # fmt: skip
            stored = FOLDER / f"derailment-{kind}-{name}.npz"
            outcome = sweep(what, stored)
            table = load(stored)

            # ---- analysis: in each cell the share that derails, and the median Y/Q of those that pass
            xs, ys = np.unique(table[x]), np.unique(table[y])
            share, ratio = np.empty((2, ys.size, xs.size))
            for j, i in np.ndindex(share.shape):
                cell = table.where((table[x] == xs[i]) & (table[y] == ys[j]))
                lost, ended = cell["derailed"] == 1.0, cell["status"] == "ended"
                share[j, i] = lost.mean() if ended.all() else np.nan
                ratio[j, i] = np.median(cell["ratio"][~lost]) if not lost.all() else np.nan
            state = np.select([np.isnan(share), share == 1.0, share > 0.0, ratio > LIMIT], [4, 3, 2, 1], 0)
            summary.setdefault(name, {})[kind] = {
                x: xs.tolist(), y: ys.tolist(), "share_derailed": share.tolist(), "ratio": ratio.tolist(),
                "starts": count, "cells": dict(zip(KINDS, np.bincount(state.ravel(), minlength=5).tolist(), strict=True)),
            }  # fmt: skip
            print(f"set {name}, {kind}: {outcome.done} runs now, {outcome.before} before, {outcome.seconds:.0f} s; cells "
                  f"{summary[name][kind]['cells']}")  # fmt: skip

            # ---- figure: colour says what happens, the number is Y/Q, or how many of the starts derail
            ax.grid(False)
            ax.imshow(state, origin="lower", aspect="auto", vmin=-0.5, vmax=4.5, cmap=ListedColormap(list(KINDS.values())))
            for j, i in np.ndindex(share.shape):
                words = (
                    f"{ratio[j, i]:.2f}" if state[j, i] < 2 else f"{share[j, i] * count:.0f}/{count}" if state[j, i] < 4 else "?"
                )
                ax.text(i, j, words, ha="center", va="center", fontsize=7.5)
            ax.set_xticks(range(xs.size), [f"{value * LABELS[x][1]:.4g}" for value in xs])
            ax.set_yticks(range(ys.size), [f"{value * LABELS[y][1]:.4g}" for value in ys])
            ax.set_xlabel(LABELS[x][0])
            ax.set_ylabel(LABELS[y][0])
            ax.set_title(f"set {name}: {title}", fontsize=10)
    fig.legend(handles=[Patch(color=colour, label=word) for word, colour in KINDS.items()], loc="outside lower center", ncols=3)
    fig.suptitle("Curve of 60 m. In the cells: median of the largest Y/Q by EN 14363, or how many of the starts derail")
    figures.save(fig, FOLDER / "derailment_map.png")
    write_summary(FOLDER / "derailment_map.json", summary)
