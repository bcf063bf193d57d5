"""Exact steady rolling contact of two bodies of one material: Kalker's variational theory on a half-space.

The ellipse that Hertz gives is cut into strips along the rolling direction x, narrower towards their ends, and every strip
into cells, each with an even traction p on the wheel: about n^2 of them, as long as they are wide, since slip turns about a pole
that may lie anywhere. With u = A p the difference of the surfaces' displacements, by Cerruti's
integrals in closed form, material moving through the patch against x slips by

    s = w - du/dx,   w = (xi - phi y, eta + phi x),   taken a third of a cell ahead of the cell's centre;      (1)
    |p| <= g = mu p_n,   p = -g s / |s| where s is not 0.                                                     (2)

(A third: there Kalker's coefficients are met with the fewest cells; at the centre (1) would not determine p.) (2) is
p = P(p - s), P the projection on |p| <= g, solved by Newton's method with steps halved where the residual would grow. The
pressure is Hertz', scaled so that its sum is the load. What the cells miss falls with 1 / n: `exact` extrapolates from n and 2 n.

`rigid` is the limit of large creepage, where nothing is elastic, by quadrature.

References: Kalker 1990, Three-dimensional elastic bodies in rolling contact; Johnson, Contact mechanics, section 3.6, for the
integrals; Alart, Curnier 1991, A mixed formulation for frictional contact problems prone to Newton like solution methods.
"""

from dataclasses import dataclass, field

import numpy as np
from scipy.linalg import lu_factor, lu_solve

__all__ = ["HalfSpace", "Solution", "exact", "rigid"]

STEPS = 80
ENOUGH = 1e-8  # of the bound on the traction at the centre
AHEAD = 1 / 3  # of a cell


@dataclass(frozen=True)
class Solution:
    """What the patch does to the wheel.

    Attributes
    ----------
    force : array, shape (3,)
        Fx / (mu N), Fy / (mu N) and Mz / (mu N sqrt(a b)).
    traction : array, shape (2, m)
        In the cells, over the bound at the patch's centre.
    sliding : array of bool, shape (m,)
        Cells at the bound.
    residual : float
        Largest violation of (2), over that bound.
    """

    force: np.ndarray
    traction: np.ndarray
    sliding: np.ndarray
    residual: float


@dataclass
class HalfSpace:
    """Ellipses of one shape and material, whose influence numbers are computed once.

    Everything is without dimension: lengths over sqrt(a b), tractions over the bound at the centre g0 = 3 mu N / (2 pi a b).
    Forces then depend on the shape, on Poisson's ratio and on (xi, eta, phi sqrt(a b)) G / g0.

    Attributes
    ----------
    ratio : float
        a / b, a along the rolling direction.
    poisson_ratio : float
        Of both bodies.
    n : int
        Strips, and cells in a strip, of a circle.
    """

    ratio: float
    poisson_ratio: float
    n: int
    x: np.ndarray = field(init=False, repr=False)  # centres of the cells
    y: np.ndarray = field(init=False, repr=False)
    area: np.ndarray = field(init=False, repr=False)
    bound: np.ndarray = field(init=False, repr=False)

    def __post_init__(self) -> None:
        a, b = self.ratio**0.5, self.ratio**-0.5
        cells, strips = (2 * max(2, round(self.n / 2 * side)) for side in (a, b))  # even, so that 2 n halves each
        edges = -np.cos(np.linspace(0.0, np.pi, strips + 1))  # of the strips, over b
        even = np.linspace(-1.0, 1.0, cells + 1)  # of the cells, over the half length of their strip
        length = np.diff(_under_half_circle(edges)) / np.diff(edges)  # half length of a strip over a, its mean
        middle = (even[1:] + even[:-1]) / 2
        self.x = (a * middle[:, None] * length).ravel()
        self.y = np.broadcast_to(b * (edges[1:] + edges[:-1]) / 2, (cells, strips)).ravel()
        self._half_x = np.broadcast_to(a * length / cells, (cells, strips)).ravel()
        self._half_y = np.broadcast_to(b * np.diff(edges) / 2, (cells, strips)).ravel()
        self.area = 4 * self._half_x * self._half_y
        mean = np.diff(_under_half_circle(even)) / np.diff(even)
        self.bound = (mean[:, None] * length).ravel()
        self.bound *= (2 * np.pi / 3) / (self.bound @ self.area)
        self._at = self.x + 2 * AHEAD * self._half_x
        self._slip = self._influence()

    def _influence(self) -> np.ndarray:
        """-du/dx by p, both components, where the slip is taken; shape (2 m, 2 m)."""
        nu, m = self.poisson_ratio, self.x.size
        xx, yy, xy = np.zeros((m, m)), np.zeros((m, m)), np.zeros((m, m))
        for i in (-1, 1):
            for j in (-1, 1):
                X = self._at[:, None] - self.x + i * self._half_x
                Y = self.y[:, None] - self.y + j * self._half_y
                r = np.hypot(X, Y)
                along, across = np.arcsinh(Y / np.abs(X)) - Y / r, Y / r  # d/dx of X asinh(Y / |X|) and Y asinh(X / |Y|)
                xx -= i * j * ((1 - nu) * along + across)
                yy -= i * j * (along + (1 - nu) * across)
                xy += i * j * nu * X / r
        return np.block([[xx, xy], [xy, yy]]) / np.pi

    def solve(self, creepages: np.ndarray, start: Solution | None = None) -> Solution:
        """Solve (1) and (2).

        Parameters
        ----------
        creepages : array, shape (3,)
            (xi, eta, phi sqrt(a b)) G / g0.
        start : Solution or None
            Of creepages near by on this grid, which saves steps; from no traction on otherwise.
        """
        xi, eta, phi = creepages
        m = self.x.size
        w = np.concatenate([xi - phi * self.y, eta + phi * self._at])
        p = np.zeros(2 * m) if start is None else start.traction.ravel()
        here = _Residual(self._slip, w, self.bound, p)
        for _ in range(STEPS):
            if here.size < ENOUGH:
                break
            p, here = self._newton(w, p, here)
        px, py = p[:m] * self.area, p[m:] * self.area
        force = np.array([px.sum(), py.sum(), self.x @ py - self.y @ px]) * 1.5 / np.pi
        return Solution(force, p.reshape(2, m), here.slides, here.size)

    def _newton(self, w: np.ndarray, p: np.ndarray, here: "_Residual") -> tuple[np.ndarray, "_Residual"]:
        step = lu_solve(lu_factor(here.jacobian(self._slip), check_finite=False), -here.value, check_finite=False)
        before = np.linalg.norm(here.value)
        t = 1.0
        while True:
            ahead = _Residual(self._slip, w, self.bound, p + t * step)
            if t < 0.02 or np.linalg.norm(ahead.value) < (1 - 1e-4 * t) * before:
                return p + t * step, ahead
            t /= 2


class _Residual:
    """p - P(p - s): s itself where |p - s| is within the bound, p + g (s - p) / |s - p| elsewhere."""

    def __init__(self, slip: np.ndarray, w: np.ndarray, bound: np.ndarray, p: np.ndarray) -> None:
        m = bound.size
        s = w + slip @ p
        q = p - s
        self.length = np.hypot(q[:m], q[m:])
        self.slides = self.length > bound
        self.bound = bound
        self.direction = q.reshape(2, m) / np.maximum(self.length, 1e-300)
        on = np.concatenate([self.slides, self.slides])
        self.value = np.where(on, p - (bound * self.direction).ravel(), s)
        self.size = float(np.abs(self.value).max())

    def jacobian(self, slip: np.ndarray) -> np.ndarray:
        """By p: in a sliding cell the projection turns with the part of p - s that is square to it."""
        m = self.bound.size
        matrix = slip.copy()
        i = np.flatnonzero(self.slides)
        x, y = self.direction[:, i]
        by_x, by_y = -slip[i], -slip[m + i]
        by_x[np.arange(i.size), i] += 1
        by_y[np.arange(i.size), m + i] += 1
        square = (self.bound[i] / self.length[i])[:, None] * (y[:, None] * by_x - x[:, None] * by_y)
        matrix[i], matrix[m + i] = -y[:, None] * square, x[:, None] * square
        matrix[i, i] += 1
        matrix[m + i, m + i] += 1
        return matrix


def _under_half_circle(t: np.ndarray) -> np.ndarray:
    """Integral of sqrt(1 - t^2)."""
    return (t * np.sqrt(np.maximum(1 - t * t, 0.0)) + np.arcsin(np.clip(t, -1.0, 1.0))) / 2


def exact(coarse: HalfSpace, fine: HalfSpace, creepages: np.ndarray) -> tuple[np.ndarray, float]:
    """Force of `Solution`, extrapolated from n and 2 n cells, and how far that is from the finer of them.

    Raises
    ------
    ArithmeticError
        If Newton's method has not ended.
    """
    solutions = [grid.solve(creepages) for grid in (coarse, fine)]
    if max(solution.residual for solution in solutions) > 1e-6:
        raise ArithmeticError(f"creepages {creepages} at a / b = {coarse.ratio:g}: the tractions must meet (2)")
    difference = solutions[1].force - solutions[0].force
    return solutions[1].force + difference, float(np.abs(difference).max())


def rigid(creepages: np.ndarray, ratio: float, n: int = 400) -> np.ndarray:
    """The force of `Solution` where everything slides, -mu p_n w / |w|, over n x n places of the ellipse."""
    u, angle = np.meshgrid((np.arange(n) + 0.5) / n, (np.arange(n) + 0.5) / n * 2 * np.pi)
    radius = np.sqrt(1 - (1 - u) ** (2 / 3))  # so that every place carries as much of the load
    x, y = ratio**0.5 * radius * np.cos(angle), ratio**-0.5 * radius * np.sin(angle)
    wx, wy = creepages[0] - creepages[2] * y, creepages[1] + creepages[2] * x
    length = np.maximum(np.hypot(wx, wy), 1e-300)
    px, py = -wx / length, -wy / length
    return np.array([px.mean(), py.mean(), (x * py - y * px).mean()])
