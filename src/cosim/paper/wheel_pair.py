"""The paper's first part: the wheel pair, figures 2 to 4, claims C1 to C4, and a map of damping beyond the paper."""

from pathlib import Path
from typing import Any

import numpy as np

from .. import figures
from ..master import Progress
from ..ssp import system as named_system
from ..stability import best, decay_rates
from ..stability.figures import damping_map, root_locus
from ..systems import System
from . import pair_measures
from .ledger import Claim
from .measures import holds
from .pair_measures import (
    AT_REST,
    ETA,
    HELD,
    NAMES,
    PSI,
    RPM,
    SPAN,
    SPEED,
    SPIN,
    Observed,
    Y,
    late_to_early,
    settling_time,
)

SIGNALS = {
    Y: ("lateral displacement $y_w$", "m", 1.0),
    PSI: ("yaw angle $\\psi_w$", "rad", 1.0),
    ETA: ("gimbal angle $\\eta$", "rad", 1.0),
}


def reproduce(folder: Path, *, progress: Progress | None = None) -> tuple[list[Claim], list[Path]]:
    """Draw figures 2 to 4 and the damping map into `folder`; returns the claims C1 to C4 and the files."""
    pair = named_system("wheel-pair")
    seen = pair_measures.observe(pair)
    if progress is not None:
        progress(1, 3)
    cases = {f"{rpm} rpm, v = 10 m/s": tr for rpm, tr in seen.turning.items()}
    still = {name: SIGNALS[name] for name in (Y, PSI)}
    drawn = {
        "figure_2.png": _root_loci(seen),
        "figure_3.png": figures.histories_in_columns({"0 rpm, v = 10 m/s": seen.still}, still),
        "figure_4.png": figures.histories_in_columns(cases, SIGNALS),
        "damping_map.png": _damping_map(pair),
    }
    if progress is not None:
        progress(2, 3)
    files = [figures.save(fig, folder / name) for name, fig in drawn.items()]
    return [_claim_1(seen), _claim_2(seen), _claim_3(seen), _claim_4(seen)], files


def _claim_1(seen: Observed) -> Claim:
    still = pair_measures.stay(seen.over_speed)
    return Claim(
        "C1", "fig. 2 left", "10 rpm, v = 1 to 100 m/s: four of six roots stay, two move, none crosses the imaginary axis",
        "4 stay, 2 move, none crosses",
        f"{still} stay, {6 - still} move; largest real part {seen.over_speed.real.max():.3g} 1/s",
        holds(pair_measures.claim_1(seen)),
    )  # fmt: skip


def _claim_2(seen: Observed) -> Claim:
    still = pair_measures.stay(seen.over_spin)
    turning = seen.over_spin[1:]  # at 0 rpm the yaw roots lie on the axis (claim C3)
    yaw = turning[np.arange(len(turning)), np.abs(turning.real).argmin(axis=1)]
    return Claim(
        "C2", "fig. 2 right", "v = 10 m/s, 0 to 1000 rpm: two roots stay, four move, none reaches the origin or crosses the axis",
        "2 stay, 4 move, none reaches the origin or crosses",
        f"{still} stay, {6 - still} move; above 0 rpm largest real part {turning.real.max():.3g} 1/s, "
        f"nearest to the origin {np.abs(seen.over_spin).min():.3g} 1/s",
        holds(pair_measures.claim_2(seen)),
        f"the slow yaw root returns towards the origin: {yaw[-1].real:.3f} {abs(yaw[-1].imag):+.2f}i at 1000 rpm, "
        f"so damping has a strongest spin",
    )  # fmt: skip


def _claim_3(seen: Observed) -> Claim:
    ratio = {name: late_to_early(seen.still, name) for name in (Y, PSI)}
    return Claim(
        "C3", "fig. 3", "v = 10 m/s, 0 rpm: lateral and yaw motion are only critically stable",
        "undamped oscillation",
        f"amplitude at the end over amplitude after the transient: y {ratio[Y]:.5f}, psi {ratio[PSI]:.5f}; "
        f"largest real part {seen.undamped:.1e} 1/s",
        holds(pair_measures.claim_3(seen)),
        f"y reaches {np.abs(seen.still[Y]).max():.2f} m, far beyond the 0.098 m between the wheels: with psi = 0.314 rad the "
        f"linear model is run outside what it describes, here as in the paper",
    )  # fmt: skip


def _claim_4(seen: Observed) -> Claim:
    settled = {rpm: {name: settling_time(t, name) for name in SIGNALS} for rpm, t in seen.turning.items()}
    words = "; ".join(
        f"{rpm} rpm: " + ", ".join(f"{NAMES[n]} {t:.1f} s" if t < SPAN - HELD else f"{NAMES[n]} never" for n, t in times.items())
        for rpm, times in settled.items()
    )
    return Claim(
        "C4", "fig. 4", "100 and 200 rpm: y, psi and then the gimbal angle eta come to rest",
        "all come to rest, the gimbal last",
        f"within {AT_REST:.0%} of the largest value after: {words}",
        holds(pair_measures.claim_4(seen)),
        f"the text gives no time span; {SPAN:g} s shown",
    )  # fmt: skip


def _root_loci(seen: Observed) -> Any:
    """Root loci over speed at 10 rpm and over spin at 10 m/s."""
    fig, axes = figures.figure(1, 2, (12.0, 5.0))
    root_locus(axes[0, 0], seen.over_speed, seen.speeds, "forward speed v [m/s]")
    root_locus(axes[0, 1], seen.over_spin, seen.spins, "rotor speed [rpm]", detail=((-0.13, 0.02), (0.0, 2.6)))
    axes[0, 0].set_title("10 rpm, v = 1 to 100 m/s")
    axes[0, 1].set_title("v = 10 m/s, 0 to 1000 rpm")
    return fig


def _damping_map(pair: System) -> Any:
    """Beyond the paper: decay of the slowest root over spin and speed, and the spin that damps most."""
    spin, speed = np.linspace(0.0, 600.0, 121), np.geomspace(0.5, 100.0, 60)
    decay = decay_rates(pair, (SPIN, spin * RPM), (SPEED, speed))
    strongest = np.array([best(pair, SPIN, (1.0 * RPM, 600.0 * RPM), {SPEED: v})[0] / RPM for v in speed])
    # Where the lateral root, which no spin moves, is the slowest, a range of spins is equally good and none is best.
    strongest[(decay > decay.max(axis=1, keepdims=True) * (1 - 1e-6)).sum(axis=1) > 1] = np.nan
    fig = damping_map(spin, speed, decay, strongest)
    rpm, rate = best(pair, SPIN, (1.0 * RPM, 600.0 * RPM), {SPEED: 10.0})
    fig.axes[0].set_title(f"at 10 m/s strongest at {rpm / RPM:.0f} rpm, {rate:.3f} 1/s", fontsize=10)
    return fig
