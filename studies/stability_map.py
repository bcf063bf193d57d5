"""Where is the full vehicle with its gyros stable: over speed and spin, and over lever arm and damper of the gimbal?

The decay rate of the slowest root that oscillates or grows (one that only creeps back is no danger): positive where the
vehicle comes to rest, with the line of zero drawn. Roots that say nothing, as of the distance run, are not left out by their
size: their coordinates are not in the equations (gyro_cosim.stability.AtRest). Run: python studies/stability_map.py [--short]
"""

import sys
from pathlib import Path

import numpy as np
from matplotlib.patches import Rectangle
from matplotlib.ticker import MaxNLocator

from gyro_cosim import figures, system
from gyro_cosim.stability import AtRest
from gyro_cosim.sweeps import write_summary

# ---- parameters
SHORT = "--short" in sys.argv
FOLDER = Path("results/studies/short" if SHORT else "results/studies")
RPM = np.pi / 30  # rad/s
SYSTEMS = {"A": "lrt-straight", "B": "lrt-straight-b"}
ONE_DAMPER = 21000.0  # N s/m, Table 2's c_z
ASSUMED = ((1.0, 4.0), (0.3, 0.5))  # number of dampers, d_g (m): not given in the paper
fine = 15 if SHORT else 101
speeds, spins = np.linspace(1.0, 100.0, fine), np.linspace(0.0, 4000.0, fine)  # m/s, rpm
arms, dampers = np.linspace(0.1, 0.6, fine), np.geomspace(0.25, 8.0, fine)  # m, number of dampers in parallel
SPEED, SPIN = 8.0, 2000.0  # m/s, rpm: where lever arm and damper are varied

summary: dict[str, dict[str, object]] = {}
fig, axes = figures.figure(2, 2, (12.0, 9.0))
for row, (name, file) in zip(axes, SYSTEMS.items(), strict=True):
    # ---- system
    plan = system(file).with_value("vehicle.stretch_lateral", 0.0)
    free = ("vehicle.speed", "gyro.rotor_speed", "gyro.spring_arm", "gyro.gimbal_damping")
    rest = AtRest(plan, free, ignorable=("vehicle.*_distance",))
    _, _, arm, damper = rest.q0

    # ---- run
    over_speed = np.array([[-rest.growth((v, n * RPM, arm, damper), creeping=False) for v in speeds] for n in spins])
    over_arm = np.array(
        [[-rest.growth((SPEED, SPIN * RPM, d, c * ONE_DAMPER), creeping=False) for d in arms] for c in dampers]
    )  # fmt: skip
    away = max(rest.rest_error((v, SPIN * RPM, arm, damper)) for v in speeds)

    # ---- analysis
    best = np.unravel_index(over_arm.argmax(), over_arm.shape)
    inside = (dampers >= ASSUMED[0][0]) & (dampers <= ASSUMED[0][1]), (arms >= ASSUMED[1][0]) & (arms <= ASSUMED[1][1])
    summary[name] = {
        "furthest_from_rest": away,
        "stable_share_of_speed_and_spin": float((over_speed > 0.0).mean()),
        "decay_over_speed_and_spin": [float(over_speed.min()), float(over_speed.max())],
        "best_spin_rpm_at_speed": {
            f"{v:.4g} m/s": float(spins[over_speed[:, np.abs(speeds - v).argmin()].argmax()]) for v in (5.0, 8.0, 20.0, 50.0)
        },
        "decay_over_arm_and_damper": [float(over_arm.min()), float(over_arm.max())],
        "best_arm_and_number_of_dampers": [float(arms[best[1]]), float(dampers[best[0]])],
        "decay_at_the_set": -rest.growth((SPEED, SPIN * RPM, arm, damper), creeping=False),
        "decay_in_the_assumed_range": [float(over_arm[np.ix_(*inside)].min()), float(over_arm[np.ix_(*inside)].max())],
    }

    # ---- figure: red unstable, white zero, blue stable, both sides on the same scale
    for ax, x, y, decay in ((row[0], speeds, spins, over_speed), (row[1], arms, dampers, over_arm)):
        most = np.abs(decay).max()
        drawn = ax.contourf(x, y, decay, levels=np.linspace(-most, most, 31), cmap="RdBu")
        ax.contour(x, y, decay, levels=[0.0], colors="k", linewidths=2.0)
        lines = ax.contour(x, y, decay, levels=7, colors="0.35", linewidths=0.5)
        ax.clabel(lines, fontsize=7, fmt="%.2g")
        ax.grid(False)
        bar = fig.colorbar(drawn, ax=ax, label="decay rate of the slowest root [1/s]", ticks=MaxNLocator(8))
        bar.ax.axhline(0.0, color="k", linewidth=2.0)
    row[0].set_xlabel("forward speed v [m/s]")
    row[0].set_ylabel("rotor speed [rpm]")
    where = f"$d_g$ {arm:g} m, {damper / ONE_DAMPER:g} dampers"
    row[0].set_title(f"set {name}: {where}" + ("" if over_speed.max() > 0.0 else "; stable nowhere"), fontsize=10)
    row[1].set_xlabel("lever arm $d_g$ [m]")
    row[1].set_ylabel(f"damping $c_g$ [{ONE_DAMPER:g} N s/m]")
    row[1].set_yscale("log")
    ticks = (0.25, 0.5, 1, 2, 4, 8)
    row[1].set_yticks(ticks, [f"{tick:g}" for tick in ticks])
    row[1].minorticks_off()
    row[1].set_title(
        f"set {name}: {SPEED:g} m/s, {SPIN:g} rpm" + ("" if over_arm.max() > 0.0 else "; stable nowhere"), fontsize=10
    )
    (low_c, high_c), (low_d, high_d) = ASSUMED
    row[1].add_patch(Rectangle((low_d, low_c), high_d - low_d, high_c - low_c, fill=False, color="k", linestyle="--"))
    row[1].plot(arm, damper / ONE_DAMPER, "o", color="k", label=f"set {name}; dashed: the assumed range")
    row[1].legend(fontsize=8, loc="lower right")
figures.save(fig, FOLDER / "stability_map.png")
command = " ".join(["python studies/stability_map.py", *sys.argv[1:]])
write_summary(FOLDER / "stability_map.json", {"command": command} | summary)
for name, results in summary.items():
    print(f"set {name}: " + "; ".join(f"{key.replace('_', ' ')} {value}" for key, value in results.items()))
