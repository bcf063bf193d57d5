"""How does the ride feel on rough track, and how much does it wear the wheels, with the gyro and without it?

Straight track with random irregularity from the ERRI spectra, waves from 100 m down to 2.1 m, several draws; mean comfort N_MV by
EN 12299 on the floor, in the middle and over the pivots, the worst of the three; wear number T gamma of all wheels. A run on even
track from 1 mm tells whether the vehicle is stable there: where it is not, no N_MV is given but what the ride against the flanges
comes to. Set A has Table 2's wheels, B wheels almost without spin inertia. Run: python studies/comfort.py [--short]
"""

import sys
from itertools import product
from pathlib import Path

import numpy as np

from gyro_cosim import figures, system
from gyro_cosim.railway import comfort
from gyro_cosim.sweeps import Measure, Sweep, load, sweep, write_summary
from gyro_cosim.systems import catalogue
from gyro_cosim.trajectory import Trajectory
from gyro_cosim.vehicle.car_body import masses
from gyro_cosim.vehicle.parameter_sets import parameter_set
from gyro_cosim.vehicle.spectra import random_track

# ---- parameters
SHORT = "--short" in sys.argv
FOLDER = Path("results/studies/short" if SHORT else "results/studies")
SYSTEMS = {"B": "lrt-straight-b"} if SHORT else {"A": "lrt-straight", "B": "lrt-straight-b"}
FLOOR = 0.35  # m over the rails, assumed: a low floor
POINTS = {"front": 3.0, "middle": 0.0, "rear": -3.0}  # m ahead of the middle; the pivots are at 3.0 (set B) and 3.3 m (A)
SETTLED = 1e-5  # m, from 1 mm, in the last 10 s on even track
HARMONICS, BEGIN, WINDOWS = 48, 10.0, 2 if SHORT else 12  # of the vehicle lrt_rough; s until all is in swing; of 5 s each
STOP = BEGIN + WINDOWS * comfort.WINDOW
speeds = "10,15" if SHORT else "6,12,18"  # m/s
GYRO = {"off": 0.0, "on": 2000 * np.pi / 30}  # rad/s
levels, seeds = (("low",), range(1)) if SHORT else (("low", "high"), range(5))
start = {v.name: v.start for v in catalogue.component("vehicle:lrt_rough").parameters}
DROP = FLOOR - masses(start)[1]  # m, the floor from the centre of body and bogies; the same in both sets
RMS = [f"{point}_{axis}_{k}" for point in POINTS for axis in "xyz" for k in range(WINDOWS)]
MOTION = ("speed_deviation", "lateral_velocity", "vertical_velocity", "roll_rate", "pitch_rate", "yaw_rate", "roll_angle")
WHEELS = [f"{end}_{side}" for end in ("front", "rear") for side in ("left", "right")]


def ride(trajectory: Trajectory) -> dict[str, float]:
    """Weighted r.m.s. accelerations of each window, wear, largest y in the last 10 s; nan where the vehicle derails.

    The velocity of a point of the body is v + omega x r; what is felt across is its derivative and the roll's share of gravity.
    """
    t, rms = trajectory.t, dict.fromkeys(RMS, np.nan)
    derailed = bool(trajectory["vehicle.derailed"][-1] > 0.5)
    v_x, v_y, v_z, phi_dot, theta_dot, psi_dot, phi = (trajectory[f"vehicle.body_{name}"] for name in MOTION)
    for point, x in POINTS.items() if not derailed else ():
        a_x = np.gradient(v_x + theta_dot * DROP, t)
        a_y = np.gradient(v_y + psi_dot * x - phi_dot * DROP, t) + start["gravity"] * np.sin(phi)
        a_z = np.gradient(v_z - theta_dot * x, t)
        for axis, a, weighting in (("x", a_x, comfort.W_D), ("y", a_y, comfort.W_D), ("z", a_z, comfort.W_B)):
            felt = comfort.window_rms(comfort.weighted(a, t, weighting)[t >= BEGIN], t[t >= BEGIN])
            rms |= {f"{point}_{axis}_{k}": value for k, value in enumerate(felt)}
    wear = np.sum([trajectory[f"vehicle.{wheel}_wear_number"] for wheel in WHEELS], axis=0)
    late = np.abs(trajectory["vehicle.front_lateral_displacement"][t >= t[-1] - 10.0]).max()
    return rms | {"derailed": derailed, "wear": np.nan if derailed else wear[t >= BEGIN].mean(), "late": late}


if __name__ == "__main__":
    FOLDER.mkdir(parents=True, exist_ok=True)
    tracks = {f"{level} {seed}": {f"vehicle.{name}": value for name, value in random_track(level, seed, HARMONICS).items()}
              for level in levels for seed in seeds}  # fmt: skip
    cases = {"even": {"vehicle.front_lateral_displacement": 1e-3}} | tracks
    columns = dict.fromkeys(RMS, "m/s2") | {"derailed": "1", "wear": "N", "late": "m"}
    summary: dict[str, dict[str, dict[str, object]]] = {}
    fig, axes = figures.figure(2, len(SYSTEMS), (6.5 * len(SYSTEMS), 8.0), sharex=True)
    for column, (name, file) in zip(axes.T, SYSTEMS.items(), strict=True):
        # ---- system: the set's values in the vehicle that has room for irregularity
        plan = system(file).with_source("vehicle", "vehicle:lrt_rough").with_value("vehicle.stretch_lateral", 0.0)
        for target, value in parameter_set(name).vehicle.items():
            plan = plan.with_value(f"vehicle.{target}", value)

        # ---- run
        values = {"vehicle.speed": speeds, "gyro.rotor_speed": ",".join(map(repr, GYRO.values()))}
        what = Sweep(plan, values, cases=cases, signals=("vehicle.body_distance",), stop=STOP, measure=Measure(ride, columns))
        outcome = sweep(what, FOLDER / f"comfort-{name}.npz")
        table = load(FOLDER / f"comfort-{name}.npz")
        print(f"set {name}: {outcome.done} runs now, {outcome.before} before, {outcome.seconds:.0f} s")
        v = np.unique(table["vehicle.speed"])
        for (gyro, spin), level in product(GYRO.items(), levels):
            # ---- analysis: all windows of all draws make one ride; the worst of the three points counts
            n_mv, wear, stable = np.full((3, v.size), np.nan)
            for k in range(v.size):
                here = table.where((table["vehicle.speed"] == v[k]) & np.isclose(table["gyro.rotor_speed"], spin))
                even, drawn = here.where(here["case"] == "even"), here.where(np.char.startswith(here["case"], level))
                stable[k] = even["derailed"][0] == 0.0 and even["late"][0] < SETTLED
                lost = int(drawn["derailed"].sum())
                if not lost:
                    rms = {point: [np.concatenate([drawn[f"{point}_{axis}_{window}"] for window in range(WINDOWS)])
                                   for axis in "xyz"] for point in POINTS}  # fmt: skip
                    n_mv[k], wear[k] = max(comfort.mean_comfort(*of) for of in rms.values()), drawn["wear"].mean()
                state = f"derails in {lost} of {len(drawn)} draws" if lost else "stable" if stable[k] else "unstable"
                summary.setdefault(name, {})[f"{v[k]:g} m/s, {level}, gyro {gyro}"] = {
                    "state": state, "N_MV": n_mv[k] if stable[k] else np.nan, "wear_number_N": wear[k],
                    "N_MV_against_the_flanges": np.nan if stable[k] else n_mv[k], "late_y_on_even_track_m": even["late"][0],
                }  # fmt: skip
                said = f"; N_MV {n_mv[k]:.2f}, {comfort.verdict(n_mv[k])}" if stable[k] and not lost else ""
                print(f"  {v[k]:g} m/s, {level}, gyro {gyro}: {state}{said}" + ("" if lost else f"; T gamma {wear[k]:.0f} N"))

            # ---- figure: filled where stable, hollow where the vehicle runs against its flanges, a cross where it derails
            style = {"color": figures.COLOURS[gyro == "off"], "linestyle": "-" if level == "low" else "--", "marker": "o"}
            for ax, size, top in zip(column, (n_mv, wear), (27.0, 1750.0), strict=True):
                ax.plot(v, np.where(stable == 1, size, np.nan), **style, label=f"gyro {gyro}, {level} level")
                ax.plot(v, np.where(stable == 1, np.nan, size), **{**style, "linewidth": 0.6}, fillstyle="none")
                ax.plot(v, np.where(np.isnan(size), top, np.nan), "x", color=style["color"])
        column[0].set(yscale="log", ylim=(1, 30), title=f"set {name}", ylabel="mean comfort N$_{MV}$ on the floor")
        column[1].set(yscale="log", ylim=(40, 2000), xlabel="speed [m/s]", ylabel="T$\\gamma$ of all wheels, mean [N]")
        for ax, ticks in zip(column, ((1, 2, 5, 10, 20), (50, 100, 200, 500, 1000)), strict=True):
            ax.set_yticks(ticks, map(str, ticks))
        column[1].legend(fontsize=8)
        for limit, word in comfort.SCALE[:-1]:
            column[0].axhline(limit, color="0.7", linewidth=0.8, linestyle=":")
            column[0].annotate(word, (v[-1], limit), va="top", ha="right", fontsize=7, color="0.4")
    fig.suptitle("filled: stable on even track; hollow: unstable, against the flanges; cross: derails", fontsize=10)
    figures.save(fig, FOLDER / "comfort.png")
    write_summary(FOLDER / "comfort.json", summary)
