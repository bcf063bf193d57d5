"""How fast may the vehicle run through a curve, with the gyro and without it?

Two criteria: no start ends in a derailment; and none exceeds Y/Q = 0.8 by EN 14363 either. Speeds are scanned in steps of 2 m/s,
then the first step from safe to unsafe is bisected; safe speeds above it are noted. Vehicle and two gyro units as FMUs, by
gyro_cosim.sweeps. Parameter set A has Table 2's wheels, B wheels almost without spin inertia.
Run: python studies/safe_speed.py [--short]
"""

import sys
from dataclasses import replace
from pathlib import Path

import numpy as np

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
GYRO = {"on": "2000rpm"} if SHORT else {"off": "0rpm", "on": "2000rpm"}
CRITERIA = {"stays on the rails": np.inf, f"Y/Q at most {LIMIT:g} too": LIMIT}
starts = "0mm" if SHORT else "0mm,0.1mm,-0.1mm"
radii = (50.0,) if SHORT else (30.0, 50.0, 100.0)  # m
scanned = (5.0, 8.0, 14.0) if SHORT else tuple(np.arange(3.0, 18.0, 2.0))  # m/s
ROUNDS = 1 if SHORT else 3  # halvings of the step of the scan


def verdict(trajectory: Trajectory) -> dict[str, float]:
    """Whether a wheel left its rail, and the largest Y/Q of any wheel by EN 14363."""
    (vehicle,) = assess(trajectory)
    return {"derailed": float(vehicle.verdict.derailed), "ratio": vehicle.worst.value if vehicle.worst else np.nan}


if __name__ == "__main__":
    FOLDER.mkdir(parents=True, exist_ok=True)
    summary: dict[str, dict[str, dict[str, object]]] = {}
    fig, axes = figures.figure(1, len(SYSTEMS), (6.5 * len(SYSTEMS), 5.5))
    for ax, (name, file) in zip(axes[0], SYSTEMS.items(), strict=True):
        # ---- system: the run ends where its track does, at whatever speed
        layout = parameter_set(name).vehicle
        length = BEFORE + 2 * layout["transition_length"] + layout["curve_length"] + BEHIND
        plan = system(file).with_value("vehicle.curve_start", BEFORE)
        end = StopWhen(("vehicle", "body_distance"), length, "end of the track")
        plan = replace(plan, stop_when=(*plan.stop_when, end))

        # ---- run and analysis: first the scan, then a speed between the highest safe and the lowest unsafe one, and again
        lines = [(radius, gyro, criterion) for radius in radii for gyro in GYRO for criterion in CRITERIA]
        safe: dict[tuple[float, str, str], dict[float, bool]] = {line: {} for line in lines}
        between: dict[tuple[float, str, str], tuple[float, float]] = {}  # highest safe, lowest unsafe speed
        for halving in range(ROUNDS + 1):
            wanted = [(line, v) for line in lines for v in (scanned if halving == 0 else (np.mean(between[line]),))]
            cases = {f"R = {radius:g} m, gyro {gyro}, {v:.6g} m/s": (radius, gyro, float(v))
                     for (radius, gyro, _), v in wanted if np.isfinite(v)}  # fmt: skip
            if not cases:
                break
            values = {case: {"vehicle.curve_radius": radius, "gyro.rotor_speed": GYRO[gyro], "vehicle.speed": v}
                      for case, (radius, gyro, v) in cases.items()}  # fmt: skip
            what = Sweep(plan, {"vehicle.front_lateral_displacement": starts}, cases=values, signals=("vehicle.body_distance",),
                         stop=1.2 * length / min(scanned), measure=Measure(verdict, {"derailed": "1", "ratio": "1"}))  # fmt: skip
            outcome = sweep(what, FOLDER / f"safe-speed-{name}.npz", extend=True)
            print(f"set {name}: {outcome.done} runs now, {outcome.before} before, {outcome.seconds:.0f} s")
            table = load(FOLDER / f"safe-speed-{name}.npz")
            for case, (radius, gyro, v) in cases.items():
                chosen = table["case"] == case
                came_through = (table["derailed"][chosen] == 0.0) & (table["status"][chosen] == "ended")
                for criterion, limit in CRITERIA.items():
                    passed = came_through & (table["ratio"][chosen] <= limit)
                    safe[radius, gyro, criterion][v] = bool(passed.all())
            for line in lines:
                unsafe = min((v for v, good in safe[line].items() if not good), default=np.inf)
                below = max((v for v, good in safe[line].items() if good and v < unsafe), default=-np.inf)
                between[line] = (below, unsafe)
        for line, (below, unsafe) in between.items():
            above = sorted(v for v, good in safe[line].items() if good and v > unsafe)
            summary.setdefault(name, {})["; ".join((f"R = {line[0]:g} m", f"gyro {line[1]}", line[2]))] = {
                "highest_safe": below if np.isfinite(below) else None, "lowest_unsafe": unsafe if np.isfinite(unsafe) else None,
                "safe_above_it": above,
            }  # fmt: skip
            words = f"safe up to {below:.2f} m/s" if np.isfinite(below) else f"not safe at {min(scanned):g} m/s, the slowest"
            words = words if np.isfinite(unsafe) else f"safe at all speeds to {max(scanned):g} m/s"
            also = f"; safe again at {', '.join(f'{v:g}' for v in above)} m/s" if above else ""
            print(f"set {name}, R = {line[0]:g} m, gyro {line[1]}, {line[2]}: {words}{also}")

        # ---- figure: lines are the highest safe speeds, rings the safe ones above, an arrow where even the slowest is unsafe
        for gyro, colour in zip(GYRO, figures.COLOURS[1::-1] if len(GYRO) == 2 else figures.COLOURS, strict=False):
            for criterion, style, side in zip(CRITERIA, ("-", "--"), (-1.0, 1.0), strict=True):
                limits = np.array([between[radius, gyro, criterion] for radius in radii])
                top = np.where(np.isfinite(limits[:, 1]), limits[:, 0], max(scanned))
                top[top == -np.inf] = min(scanned)
                ax.plot(radii, top, style, color=colour, marker="o", markersize=4, label=f"gyro {gyro}: {criterion}")
                for radius, (below, unsafe) in zip(radii, limits, strict=True):
                    if below == -np.inf:
                        ax.annotate("", (radius, 2.1), (radius, 2.9), arrowprops={"arrowstyle": "->", "color": colour})
                    above = [v for v, good in safe[radius, gyro, criterion].items() if good and v > unsafe]
                    ax.plot([radius + side] * len(above), above, "o", color=colour, fillstyle="none" if side < 0 else "left",
                            markersize=5)  # fmt: skip
        ax.set_xlabel("curve radius R [m]")
        ax.set_ylabel("highest safe speed [m/s]")
        ax.set_ylim(2.0, max(scanned) + 1)
        ax.set_title(f"set {name}", fontsize=10)
        ax.legend(fontsize=8)
    fig.suptitle("arrow: unsafe at the slowest speed already; ring: safe again above an unsafe speed", fontsize=10)
    figures.save(fig, FOLDER / "safe_speed.png")
    write_summary(FOLDER / "safe_speed.json", summary)
