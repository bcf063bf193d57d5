"""The paper's second part: the full vehicle, figures 6 to 10, claims C5 to C10, by co-simulation of the FMUs.

Everything is computed for two vehicles side by side, since a choice that the paper does not document decides C6 and C10: with
Table 2's wheels as they are (set A), and with wheels almost without spin inertia, as in equations (1)-(3) (set B).
A run that hunts in the flanges is chaotic, so every case in the curve is run for several starts a tenth of a millimetre apart;
figures show the first, verdicts count all. Cases: gyro_cosim.paper.cases; measures and verdicts: gyro_cosim.paper.measures.
"""

from collections.abc import Mapping
from pathlib import Path
from typing import Any

from .. import figures
from ..master import Progress
from ..railway.forms import with_creep_law
from ..stability import AtRest
from ..systems import catalogue
from . import measures
from .cases import FAST, SETS, SLOW, SPINS, STRAIGHT, Case, Extent, Key, base, of_set, run_all, with_case
from .ledger import Claim
from .measures import COEFFICIENT, FORCE, PSI, Y, climb, curve, holds, medians

ANGLES = {Y: ("lateral displacement y [mm]", 1e3), PSI: ("yaw angle $\\psi$ [mrad]", 1e3)}
FORCES = {
    FORCE: ("lateral force Y, inner front wheel [kN]", 1e-3),
    COEFFICIENT: ("Y/Q, inner front wheel [1]", 1.0),
}
Cases = Mapping[Key, Case]
SMOOTH = ("Polach", "Shen-Hedrick-Elkins")  # laws whose state of rest is one of zeros; FASTSIM's cells are not even about it
LAW = (
    "the law of a pair of wheels: a ratio of gimbal damper to spring that grows with the speed is needed, whatever the spin; "
    "on set A's flat tread no unit that is stable by itself is enough (studies/stability_law.py, and what would change it "
    "studies/lean_units.py)"
)


def at_rest(speed: int) -> str:
    """Whether small motion on even track dies out with the gyro on, from the eigenvalues of both vehicles, and why not."""
    words = []
    for name in SETS:
        plan = with_case(base(name, STRAIGHT), speed, "on", "0mm").with_value("vehicle.stretch_lateral", 0.0)
        for law in SMOOTH:
            growth = AtRest(with_creep_law(plan, "vehicle", law), (), ignorable=("vehicle.*_distance",)).growth(())
            words.append(f"{name} {growth:+.2g} 1/s ({law})")
    return f"growth of small motion on even track at {speed:g} m/s with the gyro on: {', '.join(words)}; {LAW}"


def reproduce(folder: Path, *, extent: Extent | None = None, progress: Progress | None = None) -> tuple[list[Claim], list[Path]]:
    """Draw figures 6 to 10 into `folder`; returns the claims C5 to C10 and the files."""
    extent = extent or Extent()
    cases = run_all(extent, progress)
    claims = [degrees_of_freedom(), claim_6(cases), *claims_7_and_8(cases), *claims_9_and_10(cases)]
    drawn = {
        "figure_6.png": _figure_6(cases),
        "figure_7.png": _over_time(cases, SLOW, tuple(SPINS), ANGLES),
        "figure_8.png": _over_time(cases, SLOW, tuple(SPINS), FORCES),
        "figure_9.png": _over_time(cases, FAST, ("off",), ANGLES),
        "figure_10.png": _over_time(cases, FAST, ("on",), ANGLES),
    }
    return claims, [figures.save(fig, folder / name) for name, fig in drawn.items()]


def degrees_of_freedom() -> Claim:
    """C5: velocities among the states of the vehicle and of two gyro units, and the spin of each rotor."""
    counts = []
    for part in base("A", SLOW).components:
        c = catalogue.component(part.source)
        velocities = sum(v.unit in ("m/s", "rad/s") and v.variability == "continuous" for v in c.states)
        rotors = sum(v.name == "rotor_speed" for v in c.parameters)  # held at its speed: a degree of freedom that is prescribed
        counts.append(velocities + rotors)
    return Claim(
        "C5", "sec. 3.1", "the full vehicle has 28 degrees of freedom", "28",
        " + ".join(map(str, counts)) + f" = {sum(counts)} (vehicle, two gyro units with their rotors)",
        {"28 degrees of freedom": sum(counts) == 28},
    )  # fmt: skip


def claim_6(cases: Cases) -> Claim:
    """Straight track at 50 m/s over five waves."""
    words: list[str] = []
    parts: dict[str, bool] = {}
    for name in SETS:
        measured: dict[str, measures.Measures] = {}
        for gyro in SPINS:
            (case,) = of_set(cases, name, STRAIGHT, gyro)
            measured[gyro] = run = measures.straight(case.trajectory)
            lost = ", derailed" if case.assessment.verdict.derailed else ""
            words.append(f"{name} {gyro}: |y| {run['y']:.1e} m, |psi| {run['psi']:.1e} rad{lost}")
        parts |= _of_set(name, holds(measures.claim_6(measured["off"], measured["on"])))
    return Claim(
        "C6", "fig. 6", "50 m/s over waves of 50 m and 10 mm: off does not settle, on goes to y about 1e-6 m and yaw 0",
        "off critically stable, on settles", "in the last 2 s " + "; ".join(words), parts,
        "five waves, so that there is a steady state; " + at_rest(STRAIGHT),
    )  # fmt: skip


def claims_7_and_8(cases: Cases) -> list[Claim]:
    """The curve at 5 m/s."""
    words7: list[str] = []
    words8: list[str] = []
    parts7: dict[str, bool] = {}
    parts8: dict[str, bool] = {}
    lost: list[str] = []
    for name in SETS:
        measured = {gyro: [curve(case.trajectory) for case in of_set(cases, name, SLOW, gyro)] for gyro in SPINS}
        off, on = medians(measured["off"]), medians(measured["on"])
        parts7 |= _of_set(name, holds(measures.claim_7(measured["off"], measured["on"])))
        parts8 |= _of_set(name, holds(measures.claim_8(measured["off"], measured["on"])))
        words7.append(
            f"{name}: max |y| {off['y'] * 1e3:.1f} -> {on['y'] * 1e3:.1f} mm, "
            f"max |psi| {off['psi'] * 1e3:.0f} -> {on['psi'] * 1e3:.0f} mrad, "
            f"swing of y {off['swing'] * 1e3:.2f} -> {on['swing'] * 1e3:.2f} mm"
        )
        words8.append(
            f"{name}: Y {off['force'] / 1e3:.1f} -> {on['force'] / 1e3:.1f} kN, "
            f"Y/Q (EN 14363) {off['filtered']:.2f} -> {on['filtered']:.2f}"
        )
        lost += [f"{name} {gyro} {_derailed(rows)}" for gyro, rows in measured.items() if any(run["climb"] > 1.0 for run in rows)]
    note = "medians over the starts, off -> on" + ("; " + ", ".join(lost) if lost else "")
    return [
        Claim("C7", "fig. 7", "R = 50 m at 5 m/s: on has the better transients and steady state of y and psi",
              "on better than off", "; ".join(words7), parts7, note),
        Claim("C8", "fig. 8", "same run: on lowers lateral force and derailment coefficient of the inner wheel", "both lower",
              "; ".join(words8), parts8, note),
    ]  # fmt: skip


def claims_9_and_10(cases: Cases) -> list[Claim]:
    """The curve at 8 m/s."""
    words9: list[str] = []
    words10: list[str] = []
    parts9: dict[str, bool] = {}
    parts10: dict[str, bool] = {}
    for name in SETS:
        off, on = ([curve(case.trajectory) for case in of_set(cases, name, FAST, gyro)] for gyro in SPINS)
        parts9 |= _of_set(name, holds(measures.claim_9(off)))
        parts10 |= _of_set(name, holds(measures.claim_10(on)))
        words9.append(f"{name}: {_derailed(off)}; {of_set(cases, name, FAST, 'off')[0].assessment.verdict.text}")
        run = medians(on)
        words10.append(
            f"{name}: {_derailed(on)}, mean |psi| in the steady curve {run['steady']:.4f} rad, "
            f"|y| in the last 50 m {run['after'] * 1e3:.2f} mm"
        )
    return [
        Claim("C9", "fig. 9", "R = 50 m at 8 m/s, off: derails", "derails", "; ".join(words9), parts9),
        Claim("C10", "fig. 10", "R = 50 m at 8 m/s, on: passes; yaw falls to about 0.001 rad, y goes back to 0 after the curve",
              "passes, 0.001 rad, back to 0", "; ".join(words10), parts10,
              at_rest(FAST)),
    ]  # fmt: skip


def _of_set(name: str, parts: Mapping[str, bool]) -> dict[str, bool]:
    return {f"{name}: {part}": is_so for part, is_so in parts.items()}


def _derailed(rows: list[measures.Measures]) -> str:
    """In how many of the starts a wheel left its rail."""
    return f"derails in {sum(run['climb'] > 1.0 for run in rows)} of {len(rows)} runs"


def _figure_6(cases: Cases) -> Any:
    """y and psi over time on straight track, one column a set."""
    fig, axes = figures.figure(2, len(SETS), (6.0 * len(SETS), 6.0), sharex=True)
    for column, (name, label) in enumerate(SETS.items()):
        for gyro in SPINS:
            for ax, (signal, (_, factor)) in zip(axes[:, column], ANGLES.items(), strict=True):
                _course(ax, cases, (name, STRAIGHT, gyro), signal, factor)
        axes[0, column].legend(fontsize=8)
        axes[0, column].set_title(f"set {name}: {label}, 50 m/s", fontsize=10)
        axes[1, column].set_xlabel("time [s]")
    for ax, (label, _) in zip(axes[:, 0], ANGLES.values(), strict=True):
        ax.set_ylabel(label)
    return fig


def _course(ax: Any, cases: Cases, which: tuple[str, int, str], signal: str, factor: float) -> None:
    """A signal of the first start over time, in the colour of its state of the gyro, with a cross where it derails."""
    tr, colour = of_set(cases, *which)[0].trajectory, figures.COLOURS[tuple(SPINS).index(which[2])]
    lost = climb(tr) > 1.0
    ax.plot(tr.t, tr[signal] * factor, color=colour, linewidth=0.9, label=f"gyro {which[2]}{', derailed' if lost else ''}")
    if lost:
        ax.plot(tr.t[-1], tr[signal][-1] * factor, "x", color=colour, markersize=8)


def _over_time(cases: Cases, speed: int, gyros: tuple[str, ...], labels: Mapping[str, tuple[str, float]]) -> Any:
    """Signals of the first start over time: one row a set, one column a signal, one curve a state of the gyro."""
    fig, axes = figures.figure(len(SETS), len(labels), (6.0 * len(labels), 3.4 * len(SETS)))
    for row, (name, described) in zip(axes, SETS.items(), strict=True):
        for ax, (signal, (label, factor)) in zip(row, labels.items(), strict=True):
            for gyro in gyros:
                _course(ax, cases, (name, speed, gyro), signal, factor)
            ax.set_ylabel(label)
            ax.set_xlabel("time [s]")
            ax.set_title(f"set {name}: {described}, R = 50 m at {speed} m/s", fontsize=9)
            ax.legend(fontsize=7)
    return fig
