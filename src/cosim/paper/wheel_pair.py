"""The paper's first part: the wheel pair, figures 2 to 4, claims C1 to C4, and a map of damping beyond the paper."""

from collections.abc import Callable
from pathlib import Path

import numpy as np

from cosim import figures
from cosim.coupling import Jacobi
from cosim.master import simulate
from cosim.report import Claim
from cosim.ssd import system as named_system
from cosim.studies import best, decay_rates, roots, travel
from cosim.system import System
from cosim.trajectory import Trajectory

RPM = 2 * np.pi / 60  # rad/s
SPIN, SPEED = "gyro.rotor_speed", "vehicle.speed"
Y, PSI, ETA = "vehicle.lateral_displacement", "vehicle.yaw_angle", "gyro.gimbal_angle"
SIGNALS = {
    Y: ("lateral displacement $y_w$", "m", 1.0),
    PSI: ("yaw angle $\\psi_w$", "rad", 1.0),
    ETA: ("gimbal angle $\\eta$", "rad", 1.0),
}
SPAN = 60.0  # s; the paper's text gives no time span for figures 3 and 4: ten decay times of the case with 100 rpm are ~100 s
STAYS = 1e-9  # a root that moves less than this part of its size stays
AT_REST = 0.02  # at rest: below this part of the largest value, to the end of the run


def reproduce(folder: Path, *, progress: Callable[[float, float], None] | None = None) -> tuple[list[Claim], list[Path]]:
    """Draw figures 2 to 4 and the damping map into `folder`; returns the claims C1 to C4 and the files."""
    pair = named_system("wheel-pair")
    jobs = (_figure_2, _figure_3, _figure_4, _damping_map)
    claims: list[Claim] = []
    files: list[Path] = []
    for done, job in enumerate(jobs):
        if progress is not None:
            progress(done, len(jobs))
        found, file = job(pair, folder)
        claims += found
        files.append(file)
    return claims, files


def _figure_2(pair: System, folder: Path) -> tuple[list[Claim], Path]:
    """Root loci over speed at 10 rpm and over spin at 10 m/s: claims C1 and C2."""
    speeds, spins = np.geomspace(1.0, 100.0, 400), np.linspace(0.0, 1000.0, 801)
    over_speed = roots(pair.with_value(SPIN, "10rpm"), SPEED, speeds)
    over_spin = roots(pair.with_value(SPEED, 10.0), SPIN, spins * RPM)
    made, axes = figures.figure(1, 2, (12.0, 5.0))
    figures.root_locus(axes[0, 0], over_speed, speeds, "forward speed v [m/s]")
    figures.root_locus(axes[0, 1], over_spin, spins, "rotor speed [rpm]", detail=((-0.13, 0.02), (0.0, 2.6)))
    axes[0, 0].set_title("10 rpm, v = 1 to 100 m/s")
    axes[0, 1].set_title("v = 10 m/s, 0 to 1000 rpm")
    file = figures.save(made, folder / "figure_2.png")

    still = int((travel(over_speed) < STAYS).sum())
    c1 = Claim(
        "C1", "fig. 2 left", "10 rpm, v = 1 to 100 m/s: four of six roots stay, two move, none crosses the imaginary axis",
        "4 stay, 2 move, none crosses",
        f"{still} stay, {6 - still} move; largest real part {over_speed.real.max():.3g} 1/s",
        {"four stay": still == 4, "none crosses the imaginary axis": bool(over_speed.real.max() < 0.0)},
    )  # fmt: skip
    still = int((travel(over_spin) < STAYS).sum())
    turning = over_spin[1:]  # at 0 rpm the yaw roots lie on the axis (claim C3)
    yaw = turning[np.arange(len(turning)), np.abs(turning.real).argmin(axis=1)]
    c2 = Claim(
        "C2", "fig. 2 right", "v = 10 m/s, 0 to 1000 rpm: two roots stay, four move, none reaches the origin or crosses the axis",
        "2 stay, 4 move, none reaches the origin or crosses",
        f"{still} stay, {6 - still} move; above 0 rpm largest real part {turning.real.max():.3g} 1/s, "
        f"nearest to the origin {np.abs(over_spin).min():.3g} 1/s",
        {
            "two stay": still == 2,
            "none crosses the imaginary axis": bool(turning.real.max() < 0.0),
            "none reaches the origin": bool(np.abs(over_spin).min() > 0.0),
        },
        f"the slow yaw root returns towards the origin: {yaw[-1].real:.3f} {abs(yaw[-1].imag):+.2f}i at 1000 rpm, "
        f"so damping has a strongest spin",
    )  # fmt: skip
    return [c1, c2], file


def _figure_3(pair: System, folder: Path) -> tuple[list[Claim], Path]:
    """Time histories without spin: claim C3."""
    trajectory = _run(pair, "0rpm")
    still = {name: SIGNALS[name] for name in (Y, PSI)}
    file = figures.save(figures.histories_in_columns({"0 rpm, v = 10 m/s": trajectory}, still), folder / "figure_3.png")
    ratio = {name: _late_to_early(trajectory, name) for name in (Y, PSI)}
    root = float(roots(pair, SPIN, np.array([0.0])).real.max())
    claim = Claim(
        "C3", "fig. 3", "v = 10 m/s, 0 rpm: lateral and yaw motion are only critically stable",
        "undamped oscillation",
        f"amplitude at the end over amplitude after the transient: y {ratio[Y]:.5f}, psi {ratio[PSI]:.5f}; "
        f"largest real part {root:.1e} 1/s",
        {
            "yaw neither grows nor decays": abs(ratio[PSI] - 1.0) < 1e-3,
            "lateral motion neither grows nor decays": abs(ratio[Y] - 1.0) < 1e-3,
            "a root on the imaginary axis": abs(root) < 1e-9,
        },
        f"y reaches {np.abs(trajectory[Y]).max():.2f} m, far beyond the 0.098 m between the wheels: with psi = 0.314 rad the "
        f"linear model is run outside what it describes, here as in the paper",
    )  # fmt: skip
    return [claim], file


def _figure_4(pair: System, folder: Path) -> tuple[list[Claim], Path]:
    """Time histories with spin: claim C4."""
    cases = {f"{rpm} rpm, v = 10 m/s": _run(pair, f"{rpm}rpm") for rpm in (100, 200)}
    file = figures.save(figures.histories_in_columns(cases, SIGNALS), folder / "figure_4.png")
    settled = {case: {name: _settling_time(t, name) for name in SIGNALS} for case, t in cases.items()}
    names = {Y: "y", PSI: "psi", ETA: "eta"}
    words = "; ".join(
        f"{case.partition(',')[0]}: "
        + ", ".join(f"{names[n]} {t:.1f} s" if t < SPAN else f"{names[n]} never" for n, t in times.items())
        for case, times in settled.items()
    )
    claim = Claim(
        "C4", "fig. 4", "100 and 200 rpm: y, psi and then the gimbal angle eta come to rest",
        "all come to rest, the gimbal last",
        f"within {AT_REST:.0%} of the largest value after: {words}",
        {f"{names[n]} at rest at {case.partition(',')[0]}": t < SPAN for case, times in settled.items() for n, t in times.items()}
        | {"the gimbal not before yaw": all(times[ETA] >= times[PSI] for times in settled.values())},
        f"the text gives no time span; {SPAN:g} s shown",
    )  # fmt: skip
    return [claim], file


def _damping_map(pair: System, folder: Path) -> tuple[list[Claim], Path]:
    """Beyond the paper: decay of the slowest root over spin and speed, and the spin that damps most."""
    spin, speed = np.linspace(0.0, 600.0, 121), np.geomspace(0.5, 100.0, 60)
    decay = decay_rates(pair, (SPIN, spin * RPM), (SPEED, speed))
    strongest = np.array([best(pair, SPIN, (1.0 * RPM, 600.0 * RPM), {SPEED: v})[0] / RPM for v in speed])
    # Where the lateral root, which no spin moves, is the slowest, a range of spins is equally good and none is best.
    strongest[(decay > decay.max(axis=1, keepdims=True) * (1 - 1e-6)).sum(axis=1) > 1] = np.nan
    made = figures.damping_map(spin, speed, decay, strongest)
    rpm, rate = best(pair, SPIN, (1.0 * RPM, 600.0 * RPM), {SPEED: 10.0})
    made.axes[0].set_title(f"at 10 m/s strongest at {rpm / RPM:.0f} rpm, {rate:.3f} 1/s", fontsize=10)
    return [], figures.save(made, folder / "damping_map.png")


def _run(pair: System, spin: str) -> Trajectory:
    """The paper's case of figures 3 and 4 at a spin, by co-simulation of the FMUs."""
    return simulate(pair.with_value(SPIN, spin).with_value(SPEED, 10.0), algorithm=Jacobi(2), step=2e-3, stop=SPAN).trajectory


def _late_to_early(trajectory: Trajectory, name: str) -> float:
    """Largest value in the last third of the run over the largest in the middle third."""
    size, n = np.abs(trajectory[name]), len(trajectory) // 3
    return float(size[-n:].max() / size[n : 2 * n].max())


def _settling_time(trajectory: Trajectory, name: str) -> float:
    """Time (s) after which the signal stays below AT_REST of its largest value; the end of the run where it does not."""
    size = np.abs(trajectory[name])
    return float(trajectory.t[np.flatnonzero(size > AT_REST * size.max())[-1]])
