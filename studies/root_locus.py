"""How do the roots of the full vehicle move with speed and with the spin of its gyros, and from which speed is it unstable?

28 degrees of freedom through the monolith: vehicle and two gyro units, linearised at rest on straight track. Parameter set A
has Table 2's wheels, B wheels almost without spin inertia. Run: python studies/root_locus.py [--short]
"""

import sys
from pathlib import Path
from typing import Any

import numpy as np
from scipy.optimize import brentq

from gyro_cosim import figures, system
from gyro_cosim.stability import AtRest
from gyro_cosim.stability.figures import root_locus
from gyro_cosim.sweeps import write_summary

# ---- parameters
SHORT = "--short" in sys.argv
FOLDER = Path("results/studies/short" if SHORT else "results/studies")
RPM = np.pi / 30  # rad/s
SYSTEMS = {"A": "lrt-straight", "B": "lrt-straight-b"}
LOWEST, HIGHEST = 0.5, 120.0  # m/s, the bounds of the vehicle's speed
speeds = np.linspace(1.0, 60.0, 60 if SHORT else 591)  # m/s
spins = np.linspace(0.0, 4000.0, 41 if SHORT else 401)  # rpm
shown_spins = (0, 500, 1000, 2000, 4000)  # rpm
critical_spins = np.array([0.0, 500.0, 1000.0, 2000.0, 4000.0]) if SHORT else np.arange(0.0, 4001.0, 100.0)  # rpm
SPEED, SPIN = 8.0, 2000.0  # m/s and rpm, where the other one is varied
WINDOWS = {"A": ((-2.5, 9.0), (-2.5, 2.2), (-0.05, 1.1)), "B": ((-0.8, 0.1), (-0.8, 0.1), (-0.15, 3.4))}  # what the figure shows

summary: dict[str, dict[str, Any]] = {}
fig, axes = figures.figure(2, 3, (15.0, 9.0))
for row, (name, file) in zip(axes, SYSTEMS.items(), strict=True):
    # ---- system: at rest on straight, even track, anywhere along it
    plan = system(file).with_value("vehicle.stretch_lateral", 0.0)
    rest = AtRest(plan, ("vehicle.speed", "gyro.rotor_speed"), ignorable=("vehicle.*_distance",))
    where = np.geomspace(LOWEST, HIGHEST, 41)
    away = max(rest.rest_error((v, spin * RPM)) for v in where for spin in (0.0, SPIN))

    # ---- run: roots along speed, along spin; growth of the least damped one over both
    over_speed = rest.paths(np.column_stack([speeds, np.full(speeds.size, SPIN * RPM)]))
    over_spin = rest.paths(np.column_stack([np.full(spins.size, SPEED), spins * RPM]))
    growth = {spin: np.array([rest.growth((v, spin * RPM)) for v in speeds[::2]]) for spin in shown_spins}

    # ---- analysis: every speed at which the least damped root crosses the axis
    critical: dict[float, list[float]] = {}
    unstable: set[int] = set()
    oscillating: set[int] = set()
    never: dict[str, list[float]] = {"stable": [], "unstable": []}
    for spin in critical_spins:
        at_speeds = [rest.roots((v, spin * RPM)) for v in where]
        at = np.array([roots.real.max() for roots in at_speeds])
        critical[spin] = [
            brentq(lambda v, spin, rest: rest.growth((v, spin * RPM)), where[k], where[k + 1], args=(spin, rest), xtol=1e-6)
            for k in np.flatnonzero(np.diff(np.sign(at)))
        ]
        unstable |= {int((roots.real > 0.0).sum()) for roots in at_speeds}
        oscillating |= {int(((roots.real > 0.0) & (roots.imag != 0.0)).sum()) for roots in at_speeds}
        if not critical[spin]:
            never["stable" if at[0] > 0.0 else "unstable"].append(spin)
    slow = rest.mode((SPEED, SPIN * RPM), rest.roots((SPEED, SPIN * RPM))[0])[0]
    summary[name] = {
        "states": len(rest.states),
        "furthest_from_rest": away,
        "roots_that_grow_least_and_most": [min(unstable), max(unstable)],
        "of_them_off_the_real_axis": [min(oscillating), max(oscillating)],
        "critical_speeds": {f"{spin:g} rpm": crossings for spin, crossings in critical.items() if crossings},
        "never_stable_rpm": never["stable"],
        "never_unstable_rpm": never["unstable"],
        "growth_at_8": {f"{spin} rpm": rest.growth((SPEED, spin * RPM)) for spin in shown_spins},
        "least_damped_at_8_and_2000rpm": [slow.real, abs(slow.imag)],
    }

    # ---- figure
    slowest = np.abs(over_speed).min(axis=0) < 10.0
    root_locus(row[0], over_speed[:, slowest], speeds, "forward speed v [m/s]")
    row[0].set_title(f"set {name}: {SPIN:g} rpm, v = {speeds[0]:g} to {speeds[-1]:g} m/s", fontsize=10)
    slowest = np.abs(over_spin).min(axis=0) < 10.0
    root_locus(row[1], over_spin[:, slowest], spins, "rotor speed [rpm]")
    row[1].set_title(f"set {name}: v = {SPEED:g} m/s, 0 to {spins[-1]:g} rpm", fontsize=10)
    for ax, window in zip(row[:2], WINDOWS[name], strict=False):
        ax.axvspan(0.0, 20.0, color=figures.COLOURS[1], alpha=0.08)
        ax.set_xlim(window)
        ax.set_ylim(WINDOWS[name][2])
    for (spin, values), colour in zip(growth.items(), figures.COLOURS, strict=False):
        row[2].plot(speeds[::2], values, color=colour, label=f"{spin} rpm")
    for spin, colour in zip(shown_spins, figures.COLOURS, strict=False):
        row[2].plot(critical[spin], [0.0] * len(critical[spin]), "o", color=colour, markersize=5)
    row[2].axhline(0.0, color="0.3", linewidth=0.8)
    row[2].axhspan(0.0, 20.0, color=figures.COLOURS[1], alpha=0.08)
    row[2].set_ylim(min(-0.3, 0.0), 1.05 * max(map(max, growth.values())))
    row[2].set_xlim(0.0, speeds[-1])
    row[2].set_xlabel("forward speed v [m/s]")
    row[2].set_ylabel("real part of the least damped root [1/s]")
    row[2].set_title(
        f"set {name}: unstable above 0"
        + ("; dots are critical speeds" if any(critical.values()) else " at every speed and spin"),
        fontsize=10,
    )
    row[2].legend(fontsize=8)
figures.save(fig, FOLDER / "root_locus.png")
command = " ".join(["python studies/root_locus.py", *sys.argv[1:]])
write_summary(FOLDER / "root_locus.json", {"command": command} | summary)
for name, results in summary.items():
    print(f"set {name}: least damped root at {SPEED:g} m/s [1/s]:", {n: round(g, 4) for n, g in results["growth_at_8"].items()})
    print("    critical speeds [m/s]:", {spin: [round(v, 2) for v in at] for spin, at in results["critical_speeds"].items()})
    stable, unstable = results["never_unstable_rpm"], results["never_stable_rpm"]
    lowest = f", from {min(stable):g} rpm on" if stable else ""
    grow, off = (results[n] for n in ("roots_that_grow_least_and_most", "of_them_off_the_real_axis"))
    looked = f"at {where.size} speeds and {critical_spins.size} spins"
    print(f"    {looked} {grow[0]} to {grow[1]} roots grow, {off[0]} to {off[1]} of them off the real axis")
    print(f"    of {critical_spins.size} spins {len(stable)} never unstable{lowest}, {len(unstable)} never stable")
