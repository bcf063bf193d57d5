"""Normal contact of a wheel and a rail that overlap: patches of any shape. SI units.

Over the rail's surface, s = y / cos(delta) across, x along, the bodies would overlap undeformed by h(s) - x^2 / 2 R, h the normal
overlap on the locus and R = r / cos(delta) the wheel's radius in the plane of the normal. Two models give the load:

Kik and Piotrowski: contact where the overlap, both bodies drawn back so that EPSILON of the deepest, D, is left, is positive;
    x_l(s) = sqrt(2 R (h - (1 - EPSILON) D)),    p ~ sqrt(x_l^2 - x^2),
    N = pi E D / (2 (1 - nu^2))  int int sqrt(x_l^2 - x^2)  /  int int sqrt(x_l^2 - x^2) / rho,     rho from the deepest place,
the pressure that sinks that place by D. EPSILON = 0.55, as they have it. On an ellipse that is 3 to 5 % above Hertz, by a factor
of the ratio of curvatures alone: load and axes are corrected by that of the ellipse with the same width at the same depth, so
that constant curvatures give Hertz' load.

Half-space: the pressure on square cells, Boussinesq's influence numbers, found where it is positive by conjugate gradients
(Polonsky and Keer): the truth for a flat patch, and a hundred times as dear.

Hertz, for laws that want an ellipse: semi-axes of the ellipse with the patch's area and its length to width ratio.

References: Kik, Piotrowski 1996, A fast, approximate method to calculate normal load at contact between wheel and rail;
Piotrowski, Kik 2008, A simplified model of wheel/rail contact mechanics for non-Hertzian problems;
Polonsky, Keer 1999, A numerical method for solving rough contact problems.
"""

from dataclasses import dataclass
from functools import cache
from math import cos, exp, inf, log, pi, sqrt

import numpy as np
from scipy.fft import irfft2, next_fast_len, rfft2

from .contact import hertz_patch

__all__ = ["MODELS", "Pressed", "half_space", "kik_piotrowski"]

EPSILON = 0.55
STRIPS = 81


@dataclass(frozen=True)
class Pressed:
    """A loaded patch.

    Attributes
    ----------
    load : float
        Normal force (N).
    place : float
        y of the pressure's centre (m).
    a, b : float
        Semi-axes of the ellipse of the same area and proportion, along and across (m).
    peak_pressure : float
        Pa.
    """

    load: float
    place: float
    a: float
    b: float
    peak_pressure: float


def _across(y: np.ndarray, overlap: np.ndarray, angle: float, level: float, strips: int) -> tuple[np.ndarray, np.ndarray]:
    """`strips` even places s over where the normal overlap exceeds `level`, and the overlap less `level` there."""
    depth = overlap * cos(angle) - level
    inside = np.flatnonzero(depth > 0.0)
    s = y / cos(angle)
    low, high = s[max(inside[0] - 1, 0)], s[min(inside[-1] + 1, s.size - 1)]
    ds = (high - low) / strips
    centres = low + (np.arange(strips) + 0.5) * ds
    return centres, np.maximum(np.interp(centres, s, depth), 0.0)


def kik_piotrowski(
    y: np.ndarray, overlap: np.ndarray, angle: float, radius: float, youngs_modulus: float, poisson_ratio: float
) -> Pressed:
    """Compute the load of an overlap by Kik and Piotrowski.

    Parameters
    ----------
    y, overlap : array, shape (n,)
        Across (m), in even steps, and the vertical overlap on the locus (m), somewhere positive.
    angle : float
        Contact angle (rad).
    radius : float
        Rolling radius (m).
    youngs_modulus, poisson_ratio : float
        Of both bodies (Pa, 1).
    """
    R = radius / cos(angle)
    deepest = float(overlap.max()) * cos(angle)
    s, h = _across(y, overlap, angle, (1 - EPSILON) * deepest, STRIPS)
    ds = s[1] - s[0]
    half = np.sqrt(2 * R * h)  # x_l
    volume = pi / 2 * half**2  # int sqrt(x_l^2 - x^2) dx
    apart = s - y[int(np.argmax(overlap))] / cos(angle)
    ratio = volume.sum() / _sunk(half, apart, ds)
    compliance = pi * youngs_modulus / (2 * (1 - poisson_ratio**2))
    width = np.count_nonzero(h) * ds
    ellipse = _ellipse(8 * R * EPSILON * deepest / width**2)  # B / A, were h a parabola of that width
    load = compliance * deepest * ratio * ellipse[0]
    patch = _patch(load, s, volume, half, ds, 0.0, angle)
    a, b = patch.a * ellipse[1], patch.b * ellipse[2]
    return Pressed(load, patch.place, a, b, 1.5 * load / (pi * a * b))


@cache
def _corrections() -> tuple[np.ndarray, np.ndarray]:
    """log(B / A) and, in rows, the factors on load and semi-axes that turn the uncorrected model's ellipse into Hertz'."""
    grid = np.linspace(log(0.02), log(200.0), 41)
    rows = [_hertz_over_model(exp(g)) for g in grid]
    return grid, np.array(rows).T


def _ellipse(ratio: float) -> tuple[float, float, float]:
    grid, rows = _corrections()
    load, a, b = (float(np.interp(log(ratio), grid, row)) for row in rows)
    return load, a, b


def _hertz_over_model(ratio: float) -> tuple[float, float, float]:
    """Factors on load, a and b for an ellipse with curvatures A = 1 / 2 along and B = `ratio` A across, sunk by 1e-4."""
    depth, E = 1e-4, 1.0
    hertz = hertz_patch(1.0, 1.0, inf, 1 / ratio, E, 0.0)
    load = (depth / hertz.approach) ** 1.5  # approach goes with load^(2/3)
    width = 2 * sqrt(2 * EPSILON * depth / ratio)
    ds = width / STRIPS
    s = (np.arange(STRIPS) - STRIPS // 2) * ds
    half = np.sqrt(np.maximum(2 * EPSILON * depth - ratio * s**2, 0.0))
    sunk, volume = _sunk(half, s, ds), pi / 2 * half**2
    mine = _patch(pi * E * depth / 2 * volume.sum() / sunk, s, volume, half, ds, 0.0, 0.0)
    scale = load ** (1 / 3)
    return load / mine.load, hertz.a * scale / mine.a, hertz.b * scale / mine.b


def _sunk(half: np.ndarray, s: np.ndarray, ds: float) -> float:
    """int int sqrt(x_l^2 - x^2) / rho over the strips, over ds."""
    nodes, weights = _nodes()
    x = half[:, None] * np.sin(pi / 4 * (nodes + 1))[None, :]  # x from 0 to x_l, dense at the edge
    dx = half[:, None] * (pi / 4 * weights * np.cos(pi / 4 * (nodes + 1)))[None, :]
    return float(2 * np.sum(dx * np.sqrt(np.maximum(half[:, None] ** 2 - x**2, 0.0)) * _inverse_distance(x, s[:, None], ds)))


@cache
def _nodes() -> tuple[np.ndarray, np.ndarray]:
    return np.polynomial.legendre.leggauss(24)


def _inverse_distance(x: np.ndarray, s: np.ndarray, ds: float) -> np.ndarray:
    """Mean of 1 / sqrt(x^2 + t^2) over t from s - ds / 2 to s + ds / 2."""
    x = np.maximum(x, 1e-9)
    mean: np.ndarray = (np.arcsinh((s + ds / 2) / x) - np.arcsinh((s - ds / 2) / x)) / ds
    return mean


def _patch(load: float, s: np.ndarray, share: np.ndarray, half: np.ndarray, ds: float, peak: float, angle: float) -> Pressed:
    """The patch of strips with loads in proportion to `share` and half lengths `half`."""
    area = float(2 * half.sum() * ds)
    length, width = float(2 * half.max()), float(np.count_nonzero(half) * ds)
    b = sqrt(area / pi * width / length)
    return Pressed(load, float((s * share).sum() / share.sum() * cos(angle)), area / (pi * b), b, peak)


def half_space(
    y: np.ndarray, overlap: np.ndarray, angle: float, radius: float, youngs_modulus: float, poisson_ratio: float, cells: int = 40
) -> Pressed:
    """Compute the load of an overlap by the half-space; arguments as `kik_piotrowski`, and cells across the overlap."""
    R = radius / cos(angle)
    s, h = _across(y, overlap, angle, 0.0, cells)
    ds = s[1] - s[0]
    reach = sqrt(2 * R * float(h.max()))
    n = cells | 1
    x = (np.arange(n) - n // 2) * (2 * reach / n)
    dx = x[1] - x[0]
    wanted = h[None, :] - x[:, None] ** 2 / (2 * R)
    kernel = _influence(n, s.size, dx, ds) * (1 - poisson_ratio**2) / (pi * youngs_modulus) * 2  # both bodies
    p = _pressure(kernel, wanted)
    strips = p.sum(axis=0) * dx
    inside = np.count_nonzero(p, axis=0) * dx / 2
    return _patch(float(strips.sum() * ds), s, strips, inside, ds, float(p.max()), angle)


def _influence(n: int, m: int, dx: float, ds: float) -> np.ndarray:
    """Boussinesq: int int 1 / rho over a cell, at the centres of all cells of a grid n x m; shape (2 n - 1, 2 m - 1)."""
    x = np.arange(-n + 1, n)[:, None] * dx
    s = np.arange(-m + 1, m)[None, :] * ds
    total: np.ndarray = np.zeros((2 * n - 1, 2 * m - 1))
    for i in (-1, 1):
        for j in (-1, 1):
            a, b = x + i * dx / 2, s + j * ds / 2
            total += i * j * (a * np.arcsinh(b / np.abs(a)) + b * np.arcsinh(a / np.abs(b)))
    return total


def _pressure(kernel: np.ndarray, wanted: np.ndarray, tolerance: float = 1e-4) -> np.ndarray:
    """p >= 0 with K p = wanted where p > 0 and K p >= wanted elsewhere: conjugate gradients that drop and add cells."""
    n, m = wanted.shape
    shape = (next_fast_len(3 * n - 2, real=True), next_fast_len(3 * m - 2, real=True))
    spectrum = rfft2(kernel, shape)

    def sink(p: np.ndarray) -> np.ndarray:
        depth: np.ndarray = irfft2(rfft2(p, shape) * spectrum, shape)[n - 1 : 2 * n - 1, m - 1 : 2 * m - 1]
        return depth

    p: np.ndarray = np.sqrt(np.maximum(wanted, 0.0))
    p *= wanted.max() / sink(p).max()
    direction, before = np.zeros_like(p), 1.0
    for _ in range(400):
        r = sink(p) - wanted
        inside = p > 0.0
        square = float((r[inside] ** 2).sum())
        direction = np.where(inside, r + (square / before) * direction, 0.0)
        along = sink(direction)
        step = float((r * direction)[inside].sum() / (along * direction)[inside].sum())
        p = np.maximum(p - step * direction, 0.0)
        late = (p <= 0.0) & (r < -1e-12 * wanted.max()) & (wanted > 0.0)
        p = np.where(late, -step * r, p)
        before = 1e300 if late.any() else square
        if sqrt(square / max(int(inside.sum()), 1)) < tolerance * wanted.max() and not late.any():
            break
    return p


MODELS = {"kik-piotrowski": kik_piotrowski, "half-space": half_space}
