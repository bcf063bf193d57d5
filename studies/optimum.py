"""Which spring, damper, lever arm and spin bring the yaw motion to rest best? Gradient-based, through the CasADi monolith.

Criterion: the integral of squared signals after a release, from Lyapunov equations, with exact gradients (stability/release.py
says why not the slowest root itself). Set A, which nothing brings to rest, is made to grow as slowly as it can instead. Every
optimum is run again as co-simulation of the FMUs, beside the default parameters. Run: python studies/optimum.py [--short]
"""

import json
import sys
from pathlib import Path
from typing import Any

import numpy as np
from scipy.integrate import simpson

from gyro_cosim import Jacobi, figures, simulate, system
from gyro_cosim.master import Options
from gyro_cosim.master.recording import Recording
from gyro_cosim.stability import AtRest, Release, optimum
from gyro_cosim.sweeps import write_summary

# ---- parameters: q = (spin, k_g, c_g, d_g); bounds: 1 to 4 of the tables' springs and dampers, d_g and spin as docs/vehicle.md
SHORT = "--short" in sys.argv
FOLDER = Path("results/studies/short" if SHORT else "results/studies")
RPM = np.pi / 30  # rad/s
FREE = ("gyro.rotor_speed", "gyro.gimbal_stiffness", "gyro.gimbal_damping", "gyro.spring_arm")
SMALL = np.array([(1.0 * RPM, 1000.0 * RPM), (0.0045, 4 * 0.0045), (6.3e-4, 4 * 6.3e-4), (0.03, 1.0)])  # Table 1
FULL = np.array([(100.0 * RPM, 4000.0 * RPM), (86700.0, 4 * 86700.0), (21000.0, 4 * 21000.0), (0.3, 0.5)])  # Table 2
SPEED = 8.0  # m/s, of the full vehicle; the wheel pair runs at its own 10 m/s
ELSEWHERE = (5.0, 20.0, 50.0)  # m/s, where the optimum is looked at too
TURNED = ASIDE = 1e-5  # rad and m: the full vehicle's pairs are let go from TURNED, and ASIDE counts as much; small: linear
AT_REST = 0.02  # at rest: below this part of the largest value, to the end of the run

vehicle = {name: system(f"lrt-straight{end}").with_value("vehicle.stretch_lateral", 0.0).with_value("vehicle.speed", SPEED)
           for name, end in (("set A", ""), ("set B", "-b"))}  # fmt: skip
ends, along = ("front", "rear"), ("vehicle.*_distance",)
turned = [{f"vehicle.{end}_yaw_angle": TURNED, f"vehicle.{end}_bogie_angle": TURNED} for end in ends]
seen = {f"vehicle.{end}_yaw_angle": TURNED for end in ends} | {f"vehicle.{end}_lateral_displacement": ASIDE for end in ends}
small = [{"vehicle.yaw_angle": 0.314}], {"vehicle.yaw_angle": 0.314}
CASES = (  # name, plan, releases, what counts as 1 of each signal, bounds, ignorable states, level (s), length of the runs (s)
    ("wheel pair", system("wheel-pair"), *small, SMALL, (), None, 4.0 if SHORT else 60.0),
    ("set B", vehicle["set B"], turned, seen, FULL, along, None, 0.5 if SHORT else 30.0),
    ("set A", vehicle["set A"], turned, seen, FULL, along, 100.0, 0.0),
)

summary: dict[str, dict[str, Any]] = {}
fig, grid_of_axes = figures.figure(2, 2, (12.0, 8.0))
axes = grid_of_axes.ravel()
for name, plan, releases, scales, bounds, ignorable, level, length in CASES:
    # ---- system
    rest = AtRest(plan, FREE, ignorable=ignorable)
    release = Release(rest, releases, scales)
    wide = AtRest(plan, ("vehicle.speed", *FREE), along) if ignorable else None  # what a design is worth at other speeds

    # ---- run
    best = optimum(release, bounds, starts=1 if SHORT else 3, level=level)
    designs = {"default": rest.q0, "optimum": best.q}
    results = summary[name] = {
        "at_bound": best.at_bound, "criteria": best.criteria, "evaluations": best.evaluations,
        "not_converged": best.not_converged,
    }  # fmt: skip
    for label, q in designs.items():
        spin, k, c, d = q
        results[label] = {"spin_rpm": spin / RPM, "springs": k / bounds[1, 0], "dampers": c / bounds[2, 0], "d_g": d,
                        "k": k * d**2, "c": c * d**2, "growth": rest.growth(q, creeping=False)}  # fmt: skip
        results[label] |= {"cost": release.cost(q)} if level is None else {}
        if wide is not None:
            results[label]["growth_at"] = {f"{v:g} m/s": wide.growth((v, *q), creeping=False) for v in ELSEWHERE}

    # ---- check: the same releases as co-simulation; the cost over the length of the run
    histories: dict[str, Any] = {}
    for label, q in designs.items() if length else ():
        cost = 0.0
        for start in releases:
            run = plan
            for target, value in (*rest.starts(np.zeros(len(rest.states))).items(), *start.items(), *zip(FREE, q, strict=True)):
                run = run.with_value(target, float(value))
            options = Options(record=Recording(select=tuple(scales)))
            done = simulate(run, algorithm=Jacobi(2), step=1e-3, stop=length, in_process=SHORT, options=options).trajectory
            cost += sum(simpson((done[s] / size) ** 2, x=done.t) for s, size in scales.items())
            histories.setdefault(label, done)
        yaw = np.abs(histories[label][next(iter(scales))])
        settled = float(done.t[np.flatnonzero(yaw > AT_REST * yaw.max())[-1]])
        results[label] |= {"cost_of_run": cost, "cost_by_monolith": release.cost(q, until=length), "settled_after": settled}

    # ---- brute force, where the system is small: no point of a grid over all bounds is better
    if name == "wheel pair":
        grid = [np.geomspace(a, b, n) for (a, b), n in zip(bounds, (5, 2, 2, 5) if SHORT else (25, 5, 5, 25), strict=True)]
        costs = np.array([[[[release.cost((n, k, c, d)) for d in grid[3]] for c in grid[2]] for k in grid[1]] for n in grid[0]])
        where = np.unravel_index(costs.argmin(), costs.shape)
        results["brute_force"] = {"cost": float(costs.min()), "q": [float(g[i]) for g, i in zip(grid, where, strict=True)]}

    # ---- figure: the release in time; for set A its growth over spin
    panels = {"wheel pair": ((axes[0], "vehicle.yaw_angle", "yaw angle [rad]", 1.0),),
              "set B": ((axes[1], "vehicle.front_yaw_angle", "yaw angle over that at release [1]", 1 / TURNED),
                        (axes[2], "vehicle.front_lateral_displacement", "lateral displacement [mm per mrad at release]",
                         1 / TURNED))}  # fmt: skip
    for ax, signal, label, factor in panels.get(name, ()):
        for (design, history), colour in zip(histories.items(), figures.COLOURS[1::-1], strict=True):
            text = f"{design}: {results[design]['spin_rpm']:.0f} rpm, cost {results[design]['cost']:.3g} s"
            ax.plot(history.t, history[signal] * factor, color=colour, label=text)
        ax.set_xlim(0.0, min(length, 30.0))
        ax.set_xlabel("time [s]")
        ax.set_ylabel(label)
        ax.set_title(f"{name}, released from a yaw angle", fontsize=10)
    if level is not None:
        spins = np.linspace(100.0, 4000.0, 40)
        for (design, q), colour in zip(designs.items(), figures.COLOURS[1::-1], strict=True):
            axes[3].plot(spins, [rest.growth((n * RPM, *q[1:])) for n in spins], color=colour, label=f"{design}'s gimbal")
            axes[3].plot(q[0] / RPM, rest.growth(q), "o", color=colour)
        axes[3].set_ylim(0.0, None)
        axes[3].set_xlabel("rotor speed [rpm]")
        axes[3].set_ylabel("growth of the least stable root [1/s]")
        axes[3].set_title(f"{name}: diverges; slowest where all parameters lie on bounds", fontsize=10)
for ax in axes:
    ax.axhline(0.0, color="0.3", linewidth=0.8)
    ax.legend(fontsize=8)
figures.save(fig, FOLDER / "optimum.png")
command = " ".join(["python studies/optimum.py", *sys.argv[1:]])
write_summary(FOLDER / "optimum.json", {"command": command} | summary)
for name, entry in summary.items():
    for label, value in entry.items():
        print(f"{name}, {label}:", json.dumps(value))
