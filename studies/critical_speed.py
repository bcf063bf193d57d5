"""From which speed does a vehicle hunt, with the gyro and without: on solid axles, and on free wheels?

Solid axles: the vehicle with conventional wheelsets in bogies that turn freely, and the textbook's single wheelset on springs.
Free wheels: the vehicle with parameter set B. The critical speed is the root of the largest real part over speed; co-simulation
of the FMUs just under and just over it, begun in the mode, must decay and grow as the eigenvalue says.
Run: python studies/critical_speed.py [--short]
"""

import sys
from pathlib import Path
from typing import Any

import numpy as np
from scipy.optimize import brentq

from gyro_cosim import Connection, Jacobi, System, SystemComponent, figures, simulate, system
from gyro_cosim.master import Options
from gyro_cosim.master.recording import Recording
from gyro_cosim.stability import AtRest, measured_root
from gyro_cosim.sweeps import write_summary

# ---- parameters
SHORT = "--short" in sys.argv
FOLDER = Path("results/studies/short" if SHORT else "results/studies")
RPM = np.pi / 30  # rad/s
spins = np.array([0.0, 1000.0, 2000.0, 4000.0]) if SHORT else np.arange(0.0, 4001.0, 100.0)  # rpm
NEAR = 0.08  # the runs in time are this part under and over the critical speed
AMPLITUDE = 1e-6  # m, of the lateral motion the runs begin with: small enough to be linear
BOUND = 0.5  # m/s, the lowest speed of the full vehicle; curves go below it to be complete

# ---- systems: name, plan, states that nothing depends on, signal, spins run in time, range of speeds, length of the runs (s)
wheelset = System(
    "wheelset", (SystemComponent("vehicle", "vehicle:wheelset"), SystemComponent("gyro", "gyro_unit:linear_full")),
    (Connection(("vehicle", "yaw_rate"), ("gyro", "yaw_rate")), Connection(("gyro", "yaw_moment"), ("vehicle", "yaw_moment"))),
)  # fmt: skip
solid, free = system("lrt-straight").with_source("vehicle", "lrt_solid_axle"), system("lrt-straight-b")
CASES: tuple[tuple[str, System, str, str, tuple[int, ...], tuple[float, float], float], ...] = (
    ("vehicle on solid axles", solid, "*_distance", "front_lateral_displacement", (0, 2000), (0.1, 5.0), 60.0),
    ("sprung wheelset", wheelset, "distance", "lateral_displacement", (0, 2000), (1.0, 120.0), 3.0),
    ("vehicle on free wheels (set B)", free, "*_distance", "front_lateral_displacement", (1000, 2000), (0.1, 120.0), 10.0),
)

summary: dict[str, Any] = {}
fig, axes = figures.figure(2, 3, (15.0, 8.5))
for column, (name, plan, pattern, lateral, timed, bounds, length) in zip(axes.T, CASES, strict=True):
    if name != "sprung wheelset":
        plan = plan.with_value("vehicle.stretch_lateral", 0.0)
    rest = AtRest(plan, ("vehicle.speed", "gyro.rotor_speed"), ignorable=(f"vehicle.{pattern}",))
    signal = f"vehicle.{lateral}"

    # ---- run: critical speed over spin; where a vehicle is never stable, or always, there is none
    where = np.geomspace(*bounds, 25)
    critical = np.full(spins.size, np.nan)
    for i, spin in enumerate(spins):
        at = np.array([rest.growth((v, spin * RPM)) for v in where])
        for k in np.flatnonzero(np.diff(np.sign(at)) > 0.0)[:1]:
            critical[i] = brentq(lambda v, r, n: r.growth((v, n * RPM)), where[k], where[k + 1], args=(rest, spin), xtol=1e-9)
    by_spin = {f"{n:g} rpm": v for n, v in zip(spins, critical, strict=True) if np.isfinite(v)}

    # ---- check in time: begin in the mode, measure its root
    checks = []
    for spin in timed if name == "sprung wheelset" or not SHORT else ():
        v_c = float(critical[np.abs(spins - spin).argmin()])
        for v in (v_c * (1 - NEAR), v_c * (1 + NEAR)):
            q = (v, spin * RPM)
            root, mode, _ = rest.mode(q, rest.roots(q)[0])
            begin = (mode / mode[rest.states.index(signal)] * AMPLITUDE).real
            run = plan.with_value("vehicle.speed", v).with_value("gyro.rotor_speed", spin * RPM)
            for state, value in rest.starts(begin).items():
                run = run.with_value(state, value)
            options = Options(record=Recording(select=(signal,), every=10))
            history = simulate(
                run, algorithm=Jacobi(1), step=1e-3, stop=length, in_process=SHORT, options=options
            ).trajectory  # fmt: skip
            seen = measured_root(history.t, history[signal])
            checks.append({"rpm": spin, "speed": v, "growth": root.real, "measured": seen.real,
                           "frequency": abs(root.imag), "measured_frequency": seen.imag})  # fmt: skip
    growth_fast = {f"{n} rpm": rest.growth((50.0, n * RPM)) for n in (0, 2000, 4000)}
    summary[name] = {"critical_speeds": by_spin, "growth_at_50": growth_fast, "in_time": checks}

    # ---- figure: critical speed over spin; growth over speed near it, with what the runs measured
    column[0].plot(spins, critical, color=figures.COLOURS[0], marker="." if SHORT else None)
    column[0].set_ylim(0.0, 1.1 * np.nanmax(critical))
    column[0].set_xlim(0.0, spins[-1])
    if bounds[1] < 10.0:
        column[0].axhline(BOUND, color="0.4", linestyle=":", label="lowest speed of the model's range")
        column[0].legend(fontsize=8)
    if np.isnan(critical[-1]):
        column[0].axvspan(spins[np.isfinite(critical)][-1], spins[-1], color=figures.COLOURS[2], alpha=0.12)
        words = f"stable to\n{bounds[1]:g} m/s"
        column[0].text(0.78, 0.5, words, transform=column[0].transAxes, ha="center", color="0.3", fontsize=9)
    column[0].set_xlabel("rotor speed [rpm]")
    column[0].set_ylabel("critical speed [m/s]")
    column[0].set_title(name, fontsize=10)
    for spin, colour in zip(timed, figures.COLOURS, strict=False):
        v_c = critical[np.abs(spins - spin).argmin()]
        near = np.linspace(0.85 * v_c, 1.15 * v_c, 60)
        column[1].plot(near, [rest.growth((v, spin * RPM)) for v in near], color=colour, label=f"{spin} rpm, eigenvalue")
        measured = [(c["speed"], c["measured"]) for c in checks if c["rpm"] == spin]
        if measured:
            column[1].plot(*zip(*measured, strict=True), "o", color=colour, fillstyle="none", label=f"{spin} rpm, co-simulation")
    column[1].axhline(0.0, color="0.3", linewidth=0.8)
    column[1].ticklabel_format(axis="y", scilimits=(-2, 2))
    column[1].set_xlabel("forward speed v [m/s]")
    column[1].set_ylabel("growth of the hunting mode [1/s]")
    column[1].legend(fontsize=8)
figures.save(fig, FOLDER / "critical_speed.png")
command = " ".join(["python studies/critical_speed.py", *sys.argv[1:]])
write_summary(FOLDER / "critical_speed.json", {"command": command} | summary)
for name, results in summary.items():
    print(f"{name}:", ", ".join(f"{spin} {v:.3f} m/s" for spin, v in results["critical_speeds"].items()))
    print("    growth of the least damped root at 50 m/s [1/s]:", results["growth_at_50"])
    for check in results["in_time"]:
        print("    {rpm} rpm, {speed:.3f} m/s: eigenvalue {growth:.5g} 1/s, co-simulation {measured:.5g} 1/s".format(**check))
