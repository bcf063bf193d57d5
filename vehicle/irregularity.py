"""Irregularity of the track in the equations of motion: a sinusoidal stretch and a sum of harmonics, in four channels.

    w_c(s) = A_c sin(k (s - s_0)),  0 <= s - s_0 <= n 2 pi / k                                        stretch
           + f(s) sum_n (a_cn cos(n K s) + b_cn sin(n K s)),  K = 2 pi / L, n = 1..N                  harmonics

c is one of lateral, vertical, cross_level, gauge (m): a rail lies at lateral + e gauge / 2 to the left and vertical +
e cross_level / 2 up, e = +1 for the left rail and -1 for the right. f fades in from 0 to 1 over `fade` metres from `start`
on (a cubic), so that the vehicle starts on even track. vehicle.spectra turns tables and random spectra into harmonics.
The sines of n K s come from the recurrence sin((n+1) x) = 2 cos x sin n x - sin((n-1) x), two operations each.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from math import pi
from typing import Any

import casadi as ca

from .track_files import CHANNELS, Record

__all__ = ["CHANNELS", "PARTS", "Unevenness", "unevenness"]


@dataclass(frozen=True)
class Unevenness:
    """Irregularity of the rails at one s, as expressions.

    Attributes
    ----------
    displacement, slope : dict
        By channel: m, and m per m.
    """

    displacement: dict[str, Any]
    slope: dict[str, Any]

    def rail(self, side: int) -> tuple[Any, Any, Any, Any]:
        """(lateral, vertical, lateral slope, vertical slope) of the left (`side` = 1) or right (-1) rail."""
        d, t = self.displacement, self.slope
        return (
            d["lateral"] + side * d["gauge"] / 2,
            d["vertical"] + side * d["cross_level"] / 2,
            t["lateral"] + side * t["gauge"] / 2,
            t["vertical"] + side * t["cross_level"] / 2,
        )


def unevenness(s: Any, symbols: Mapping[str, ca.SX], harmonics: int, record: Record | None = None) -> Unevenness:
    """Set up the irregularity at a place.

    Parameters
    ----------
    s : casadi.SX
        Where (m).
    symbols : mapping of str to casadi.SX
        A component's symbols by name.
    harmonics : int
        N, harmonics in each channel.
    record : Record, optional
        Of a file, which is added.

    Returns
    -------
    Unevenness
        Displacement and slope.
    """
    k = 2 * pi / symbols["stretch_wavelength"]
    run = s - symbols["stretch_start"]
    inside = ca.logic_and(run >= 0, run <= symbols["stretch_cycles"] * symbols["stretch_wavelength"])
    sine, cosine = inside * ca.sin(k * run), inside * k * ca.cos(k * run)
    displacement = {c: symbols[f"stretch_{c}"] * sine for c in CHANNELS}
    slope = {c: symbols[f"stretch_{c}"] * cosine for c in CHANNELS}
    if record is not None:
        values, slopes = record.at(s)
        displacement = {c: displacement[c] + values[c] for c in CHANNELS}
        slope = {c: slope[c] + slopes[c] for c in CHANNELS}
    if harmonics:
        fade = symbols["harmonics_fade"]
        u = ca.fmin(ca.fmax((s - symbols["harmonics_start"]) / fade, 0.0), 1.0)
        f, f_slope = u * u * (3 - 2 * u), 6 * u * (1 - u) / fade
        K = 2 * pi / symbols["harmonics_length"]
        waves = _waves(K * s, harmonics)
        for c in CHANNELS:
            value, derivative = _series(waves, K, *([symbols[f"{c}_{part}[{n}]"] for n in range(harmonics)] for part in PARTS))
            displacement[c] += f * value
            slope[c] += f * derivative + f_slope * value
    return Unevenness(displacement, slope)


PARTS = ("cosine", "sine")


def _waves(x: Any, count: int) -> list[tuple[Any, Any]]:
    """(cos n x, sin n x) for n = 1..count."""
    waves = [(ca.SX(1), ca.SX(0)), (ca.cos(x), ca.sin(x))]
    double = 2 * waves[1][0]
    for _ in range(count - 1):
        waves.append(tuple(double * now - before for now, before in zip(waves[-1], waves[-2], strict=True)))
    return waves[1:]


def _series(waves: Sequence[tuple[Any, Any]], K: Any, a: Sequence[Any], b: Sequence[Any]) -> tuple[Any, Any]:
    """Sum of a_n cos + b_n sin, and its derivative by s."""
    value: Any = 0
    derivative: Any = 0
    for n, ((cosine, sine), a_n, b_n) in enumerate(zip(waves, a, b, strict=True), start=1):
        value = value + a_n * cosine + b_n * sine
        derivative = derivative + n * (b_n * cosine - a_n * sine)
    return value, K * derivative
