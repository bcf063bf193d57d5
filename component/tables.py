"""Tables of numbers in a component's equations, over one variable or more, in CasADi and as C code.

    f(x) = f_i + h01(t) (f_i+1 - f_i) + w h10(t) s_i + w h11(t) s_i+1        t = (x - x_i) / w,  w = x_i+1 - x_i       (1)
    h01 = t^2 (3 - 2 t),   h10 = t (1 - t)^2,   h11 = t^2 (t - 1)                                  Hermite's cubics
    f(x) = f_i + t (f_i+1 - f_i)                                                                                       (2)

in two variables the tensor product of (1), or of (2), in more of (2). The kinds differ in the slopes s_i of (1): those of the
cubic spline through the points (smooth to the second derivative), or Fritsch and Carlson's (to the first derivative, and between
two points never beyond both). The third is (2). Beyond its ends a table goes on as a constant, straight, or in a period.

A graph holds a table by the two kinds of calls of component/lookups.py, so that the derivatives of (1) follow by themselves.

References
----------
Fritsch, Carlson 1980, SIAM J. Numer. Anal. 17, p. 238.
"""

from collections.abc import Callable, Sequence
from typing import Any, Literal

import casadi as ca
import numpy as np

from .lookups import entries, interval

__all__ = ["Ends", "Kind", "lattice", "pieces", "surface", "table"]

Kind = Literal["spline", "monotone", "linear"]
Ends = Literal["constant", "straight", "periodic"]
Interpolated = Callable[..., ca.SX]

EVEN = 1e-9  # of the distance: points that are as even as that need no search
FEWEST = {"spline": 4, "monotone": 2, "linear": 2}  # points


def table(x: Sequence[float], values: Any, *, kind: Kind = "spline", ends: Ends = "constant", name: str = "x") -> Interpolated:
    """A table over one variable.

    Parameters
    ----------
    x : sequence of float, length n
        Rising. Where all distances are the same, no search is needed.
    values : array, shape (n,) or (n, quantities)
        Of each quantity at each x.
    kind : str
        "spline", which needs 4 points and, where it is periodic, is so in its derivatives; "monotone"; or "linear", which
        has no derivative at its points.
    ends : str
        "constant", "straight", or "periodic": then the values at both ends are the same.
    name : str
        What x is called in messages.

    Returns
    -------
    callable
        Of a scalar SX expression: the quantities there, a column.

    Raises
    ------
    ValueError
        For points that do not rise, numbers that are not finite, or shapes that do not fit.
    """
    if ends not in ("constant", "straight", "periodic"):
        raise ValueError(f"table over {name}: ends must be 'constant', 'straight' or 'periodic', got {ends!r}")
    points, f = _points(x, kind, name), np.array(values, float)
    f = f[:, np.newaxis] if f.ndim == 1 else f
    _check(f, 2, (points.size,), f"table over {name}")
    if ends == "periodic" and not np.array_equal(f[0], f[-1]):
        raise ValueError(f"table over {name}: a periodic one must end with the values that it starts with")
    axis, n, width = _Axis(points, ends), f.shape[1], 1 if kind == "linear" else 2
    slopes = np.empty_like(f) if kind == "linear" else _slopes(points, f, kind, ends)
    read = entries(np.stack([f, slopes][:width], axis=2), 2 * n * width)

    def at(place: Any) -> ca.SX:
        i, t, w, beyond = axis.interval(ca.SX(place))
        e = ca.vertcat(*read.call([i * (n * width)]))
        near, far = e[: n * width : width], e[n * width :: width]
        if kind == "linear":
            result, first, last = near + t * (far - near), (far - near) / w, (far - near) / w
        else:
            first, last = e[1 : n * width : width], e[n * width + 1 :: width]
            result = _hermite(t, w, near, first, far, last)
        return result + beyond * ca.if_else(beyond < 0, first, last) if ends == "straight" else result

    return at


def surface(
    x: Sequence[float], y: Sequence[float], values: Any, *, kind: Kind = "spline", names: tuple[str, str] = ("x", "y")
) -> Interpolated:
    """A table over two variables, constant beyond its ends.

    Parameters
    ----------
    x, y : sequence of float, lengths n and m
        Rising.
    values : array, shape (n, m) or (n, m, quantities)
        Of each quantity at each x and y.
    kind : str
        "spline", which needs 4 points each way; "monotone", which is so along the lines through its points; or "linear" both
        ways, which has no derivative there.
    names : pair of str
        What x and y are called in messages.

    Returns
    -------
    callable
        Of two scalar SX expressions: the quantities there, a column.

    Raises
    ------
    ValueError
        As for table().
    """
    over = f"table over {names[0]} and {names[1]}"
    p, q, f = _points(x, kind, names[0]), _points(y, kind, names[1]), np.array(values, float)
    f = f[:, :, np.newaxis] if f.ndim == 2 else f
    _check(f, 3, (p.size, q.size), over)
    if kind == "linear":
        return lattice((p, q), f, names=names)
    first, second, n, m = _Axis(p, "constant"), _Axis(q, "constant"), f.shape[2], q.size
    along_x = _slopes(p, f, kind)
    along_y, mixed = (np.moveaxis(_slopes(q, np.moveaxis(g, 1, 0), kind), 0, 1) for g in (f, along_x))
    read = entries(np.stack([f, along_x, along_y, mixed], axis=3), 8 * n)

    def at(place_x: Any, place_y: Any) -> ca.SX:
        i, t, w, _ = first.interval(ca.SX(place_x))
        j, u, h, _ = second.interval(ca.SX(place_y))
        rows: list[ca.SX] = []
        for k in (0, 1):
            e = ca.vertcat(*read.call([((i + k) * m + j) * (4 * n)]))
            near, far = ([e[4 * n * side + quantity : 4 * n * (side + 1) : 4] for quantity in range(4)] for side in (0, 1))
            rows += [_hermite(u, h, near[d], near[d + 2], far[d], far[d + 2]) for d in (0, 1)]
        return _hermite(t, w, *rows)

    return at


def lattice(axes: Sequence[Sequence[float] | np.ndarray], values: Any, *, names: Sequence[str] = ()) -> Interpolated:
    """A table over any number of variables, straight between its points along each of them, constant beyond its ends.

    Parameters
    ----------
    axes : sequence of sequence of float, lengths n, m, ...
        Rising; 2 or more points of each variable.
    values : array, shape (n, m, ..., quantities)
        Of each quantity at each point.
    names : sequence of str
        What the variables are called in messages; x1, x2, ... where nothing is given.

    Returns
    -------
    callable
        Of as many scalar SX expressions as there are variables: the quantities there, a column.

    Raises
    ------
    ValueError
        As for table().
    """
    called = tuple(names) or tuple(f"x{k + 1}" for k in range(len(axes)))
    points, f = [_points(x, "linear", name) for x, name in zip(axes, called, strict=True)], np.array(values, float)
    _check(f, len(points) + 1, tuple(p.size for p in points), f"table over {', '.join(called)}")
    along, n = [_Axis(p, "constant") for p in points], f.shape[-1]
    strides = [int(np.prod(f.shape[k + 1 :])) for k in range(len(points))]
    read = entries(f, 2 * n)

    def at(*places: Any) -> ca.SX:
        found = [axis.interval(ca.SX(place))[:2] for axis, place in zip(along, places, strict=True)]

        def between(k: int, start: Any) -> ca.SX:
            i, t = found[k]
            if k == len(found) - 1:
                row = ca.vertcat(*read.call([start + i * n]))
                return row[:n] + t * (row[n:] - row[:n])
            near, far = (between(k + 1, start + (i + side) * strides[k]) for side in (0, 1))
            return near + t * (far - near)

        return between(0, ca.SX(0))

    return at


def pieces(x: Sequence[float], rows: Any, *, name: str = "x") -> Callable[[Any], tuple[ca.SX, ca.SX]]:
    """A row of numbers for each interval: what is a polynomial between the points is then its coefficients there.

    Parameters
    ----------
    x : sequence of float, length n
        Rising, 2 or more.
    rows : array, shape (n - 1, quantities)
        Of each interval. The first and the last go on beyond the ends.
    name : str
        What x is called in messages.

    Returns
    -------
    callable
        Of a scalar SX expression: how far it is beyond the start of its interval, and the interval's row, a column.

    Raises
    ------
    ValueError
        As for table().
    """
    points, f = _points(x, "linear", name), np.array(rows, float)
    _check(f, 2, (points.size - 1,), f"table over {name}")
    search, read = interval(points), entries(np.column_stack([points[:-1], f]), f.shape[1] + 1)

    def at(place: Any) -> tuple[ca.SX, ca.SX]:
        row = ca.vertcat(*read.call([search(place) * (f.shape[1] + 1)]))
        return place - row[0], row[1:]

    return at


class _Axis:
    """The points along one variable."""

    def __init__(self, points: np.ndarray, ends: Ends) -> None:
        self._first, self._last, self._n, self._ends = float(points[0]), float(points[-1]), points.size, ends
        even = np.linspace(self._first, self._last, points.size)
        self._even = bool(np.max(np.abs(points - even)) <= EVEN * (even[1] - even[0]))
        self._search, self._read = interval(points), entries(points, 2)

    def interval(self, x: ca.SX) -> tuple[ca.SX, ca.SX, ca.SX, ca.SX]:
        """Number of the interval, place in it (0..1), its width, and how far x is beyond the ends (0 between them)."""
        length = self._last - self._first
        if self._ends == "periodic":
            inside = x - length * ca.floor((x - self._first) / length)
        else:
            inside = ca.fmin(ca.fmax(x, self._first), self._last)
        beyond = x - inside
        if not self._even:
            i = self._search(inside)
            start, end = self._read(i)
            return i, (inside - start) / (end - start), end - start, beyond
        far = (inside - self._first) * ((self._n - 1) / length)
        i = ca.fmin(ca.floor(far), self._n - 2)
        return i, far - i, ca.SX(length / (self._n - 1)), beyond


def _hermite(t: ca.SX, w: ca.SX, f0: ca.SX, s0: ca.SX, f1: ca.SX, s1: ca.SX) -> ca.SX:
    """(1)."""
    return f0 + (t * t * (3 - 2 * t)) * (f1 - f0) + (w * t * (1 - t) * (1 - t)) * s0 + (w * t * t * (t - 1)) * s1


def _slopes(x: np.ndarray, f: np.ndarray, kind: Kind, ends: Ends = "constant") -> np.ndarray:
    """Slopes at the points along the first axis of f, shape (n, ...); a spline ends without a jump in the third derivative."""
    from scipy.interpolate import CubicSpline, PchipInterpolator  # late: importing it takes longer than most uses

    if kind == "monotone":
        return np.asarray(PchipInterpolator(x, f)(x, 1))
    return np.asarray(CubicSpline(x, f, bc_type="periodic" if ends == "periodic" else "not-a-knot")(x, 1))


def _points(x: Sequence[float] | np.ndarray, kind: Kind, name: str) -> np.ndarray:
    points = np.array(x, float)
    if kind not in FEWEST:
        raise ValueError(f"table over {name}: kind must be one of {', '.join(map(repr, FEWEST))}, got {kind!r}")
    if points.ndim != 1 or points.size < FEWEST[kind]:
        raise ValueError(f"table over {name}: a {kind} one must have {FEWEST[kind]} points or more, got {points.size}")
    _require_finite(points, f"table over {name}: points")
    falls = np.flatnonzero(np.diff(points) <= 0)
    if falls.size:
        i = int(falls[0])
        raise ValueError(f"table over {name}: points must rise, got {points[i]:.9g} and {points[i + 1]:.9g} at number {i + 1}")
    return points


def _check(values: np.ndarray, dimensions: int, sizes: tuple[int, ...], what: str) -> None:
    if values.ndim != dimensions or values.shape[: len(sizes)] != sizes:
        raise ValueError(f"{what}: values must begin with the shape {sizes} of the points, got {values.shape}")
    _require_finite(values, f"{what}: values")


def _require_finite(numbers: np.ndarray, what: str) -> None:
    bad = np.argwhere(~np.isfinite(numbers))
    if bad.size:
        place = ", ".join(str(int(i) + 1) for i in bad[0])
        raise ValueError(f"{what} must be finite, got {numbers[tuple(bad[0])]} at number {place}")
