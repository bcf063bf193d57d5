"""Tables: through their points, as smooth as their kind says, derivatives of the table itself, ends as they are asked for."""

from collections.abc import Callable

import casadi as ca
import numpy as np
import pytest
from scipy.interpolate import CubicSpline, PchipInterpolator

from gyro_cosim.component.tables import lattice, surface, table

UNEVEN = np.array([0.0, 0.1, 0.35, 0.4, 0.7, 1.0])
EVEN = np.linspace(0.0, 1.0, 6)
POINTS = pytest.mark.parametrize("x", [UNEVEN, EVEN], ids=["uneven", "even"])


def of_one(f: Callable[..., ca.SX]) -> tuple[ca.Function, ca.Function]:
    """A table and its derivative."""
    x = ca.SX.sym("x")
    return ca.Function("f", [x], [f(x)]), ca.Function("f", [x], [ca.jacobian(f(x), x)])


def over(function: ca.Function, *x: np.ndarray) -> np.ndarray:
    """Shape (quantities, x.size)."""
    return np.array(function.map(x[0].size)(*(row.reshape(1, -1) for row in x)))


@POINTS
@pytest.mark.parametrize(("kind", "truth"), [("spline", CubicSpline), ("monotone", PchipInterpolator)])
def test_a_table_is_the_spline_of_its_kind(x: np.ndarray, kind: str, truth: Callable) -> None:
    f = np.column_stack([np.sin(5 * x), np.exp(x)])
    value, slope = of_one(table(x, f, kind=kind))  # type: ignore[arg-type]
    at = np.linspace(0.001, 0.999, 200)
    np.testing.assert_allclose(over(value, at), truth(x, f)(at).T, rtol=0, atol=1e-14)
    np.testing.assert_allclose(over(slope, at), truth(x, f)(at, 1).T, rtol=0, atol=1e-12)


@POINTS
def test_straight_lines(x: np.ndarray) -> None:
    f = np.sin(5 * x)
    value, slope = of_one(table(x, f, kind="linear"))
    at = np.linspace(0.001, 0.999, 200)
    np.testing.assert_allclose(over(value, at)[0], np.interp(at, x, f), rtol=0, atol=1e-15)
    np.testing.assert_allclose(over(slope, at)[0], (np.diff(f) / np.diff(x))[np.searchsorted(x, at) - 1], rtol=1e-12)


@POINTS
@pytest.mark.parametrize("kind", ["spline", "monotone", "linear"])
def test_ends(x: np.ndarray, kind: str) -> None:
    """Constant, straight on, or from the start again; where they begin is where the points end."""
    f = np.sin(2 * np.pi * x) + 0.3
    f[-1] = f[0]
    inside = of_one(table(x, f, kind=kind))[0]  # type: ignore[arg-type]
    outside = np.array([-0.4, -1e-9, 1.0 + 1e-9, 1.6])
    constant, straight, periodic = (of_one(table(x, f, kind=kind, ends=e)) for e in ("constant", "straight", "periodic"))  # type: ignore[arg-type]
    assert over(constant[0], outside).ravel() == pytest.approx([f[0], f[0], f[-1], f[-1]])
    assert not np.any(over(constant[1], outside))
    slope = over(of_one(table(x, f, kind=kind))[1], np.array([1e-12, 1 - 1e-12])).ravel()  # type: ignore[arg-type]
    ends = f[0] + slope[0] * outside[:2], f[-1] + slope[1] * (outside[2:] - 1)
    assert over(straight[0], outside).ravel() == pytest.approx(np.concatenate(ends))
    if kind != "spline":  # a periodic spline is another one
        assert over(periodic[0], outside) == pytest.approx(over(inside, outside - np.floor(outside)), abs=1e-8)
    else:
        steps = over(periodic[1], np.array([-1e-9, 1e-9, 1 - 1e-9, 1 + 1e-9])).ravel()
        assert np.ptp(steps) < 1e-6 * abs(steps[0])


def test_monotone_tables_stay_between_their_points() -> None:
    x, f = np.arange(8.0), np.array([0.0, 0.0, 0.0, 1.0, 1.0, 1.0, 0.5, 0.5])
    at = np.linspace(0.0, 7.0, 500)
    assert np.max(over(of_one(table(x, f, kind="spline"))[0], at)) > 1.02
    inside = over(of_one(table(x, f, kind="monotone"))[0], at)
    assert np.min(inside) >= 0.0
    assert np.max(inside) <= 1.0 + 1e-15


def test_surfaces_of_splines_hold_what_is_cubic_in_each_variable() -> None:
    x, y = UNEVEN, np.linspace(-1.0, 2.0, 5)

    def f(a: np.ndarray, b: np.ndarray) -> np.ndarray:
        return np.stack([a**3 * b - 2 * a * b**3 + b**2, 3 * a + b], axis=-1)

    a, b = ca.SX.sym("a"), ca.SX.sym("b")
    value = surface(x, y, f(x[:, None], y[None, :]))(a, b)
    function = ca.Function("f", [a, b], [value])
    slope = ca.Function("f", [a, b], [ca.vec(ca.jacobian(value, ca.vertcat(a, b)))])
    at = np.random.default_rng(0).random((2, 50)) * [[1.0], [3.0]] - [[0.0], [1.0]]
    np.testing.assert_allclose(over(function, *at), f(*at).T, atol=1e-13)
    wanted = np.array([3 * at[0] ** 2 * at[1] - 2 * at[1] ** 3, 0 * at[0] + 3, at[0] ** 3 - 6 * at[0] * at[1] ** 2 + 2 * at[1]])
    np.testing.assert_allclose(over(slope, *at)[:3], wanted, atol=1e-12)
    beyond = np.array([[1.5, -0.3, 0.5], [0.0, 3.0, -2.0]])
    edge = np.array([np.clip(beyond[0], 0, 1), np.clip(beyond[1], -1, 2)])
    np.testing.assert_allclose(over(function, *beyond), f(*edge).T, atol=1e-13)


@pytest.mark.parametrize(
    ("arguments", "options", "message"),
    [
        (([0, 1, 1, 2], [0, 1, 2, 3]), {}, "table over x: points must rise, got 1 and 1 at number 2"),
        (([0, 1, 2], [0, 1, 2]), {}, "table over x: a spline one must have 4 points or more, got 3"),
        (([0, 1, 2, 3], [0, 1, 2]), {"name": "s"}, r"table over s: values must begin with the shape \(4,\) .* got \(3, 1\)"),
        (([0, 1, 2, 3], [0, 1, float("nan"), 3]), {}, "table over x: values must be finite, got nan at number 3, 1"),
        (([0, 1, 2, float("inf")], [0, 1, 2, 3]), {}, "table over x: points must be finite, got inf at number 4"),
        (([0, 1], [0, 1]), {"kind": "cubic"}, "kind must be one of 'spline', 'monotone', 'linear', got 'cubic'"),
        (([0, 1], [0, 1]), {"kind": "linear", "ends": "open"}, "ends must be 'constant', 'straight' or 'periodic', got 'open'"),
        (([0, 1], [0, 1]), {"kind": "linear", "ends": "periodic"}, "a periodic one must end with the values that it starts with"),
    ],
)
def test_what_is_no_table_is_refused(arguments: tuple, options: dict, message: str) -> None:
    with pytest.raises(ValueError, match=message):
        table(*arguments, **options)


def test_a_surface_of_straight_lines_is_bilinear() -> None:
    """What is linear in each variable, to rounding, uneven points included; constant beyond its ends."""
    x, y = UNEVEN, np.linspace(-1.0, 2.0, 4)
    a, b = ca.SX.sym("a"), ca.SX.sym("b")
    values = np.stack([2 * x[:, None] * y + y, 3 * x[:, None] + 0 * y], axis=-1)
    function = ca.Function("f", [a, b], [surface(x, y, values, kind="linear")(a, b)])
    at = np.random.default_rng(0).random((2, 50)) * [[1.0], [3.0]] - [[0.0], [1.0]]
    np.testing.assert_allclose(over(function, *at), np.array([2 * at[0] * at[1] + at[1], 3 * at[0]]), atol=1e-13)
    np.testing.assert_allclose(over(function, np.array([2.0]), np.array([5.0])), over(function, np.array([1.0]), np.array([2.0])))


def test_a_lattice_is_linear_in_each_of_its_variables() -> None:
    """What is linear in each of three variables, to rounding; constant beyond its ends; its derivative that of its cell."""
    x, y, z = UNEVEN, np.linspace(-1.0, 2.0, 4), np.array([0.0, 0.2, 1.0])
    p, q, r = np.meshgrid(x, y, z, indexing="ij")
    v = ca.SX.sym("v", 3)
    made = lattice((x, y, z), np.stack([p * q * r - q, 2 * p + r], axis=-1))(*v.elements())
    function, slope = ca.Function("f", [v], [made]), ca.Function("s", [v], [ca.jacobian(made, v)])
    at = np.random.default_rng(0).random((3, 50)) * [[1.0], [3.0], [1.0]] - [[0.0], [1.0], [0.0]]
    np.testing.assert_allclose(function(at), np.array([at[0] * at[1] * at[2] - at[1], 2 * at[0] + at[2]]), atol=1e-13)
    np.testing.assert_allclose(slope([0.3, 0.5, 0.1]), [[0.05, 0.03 - 1, 0.15], [2, 0, 1]], atol=1e-12)
    np.testing.assert_allclose(function([9, 9, 9]), function([1, 2, 1]))
    with pytest.raises(
        ValueError, match=r"table over x1, x2: values must begin with the shape \(2, 2\) of the points, got \(2, 3, 1\)"
    ):
        lattice(([0, 1], [0, 1]), np.zeros((2, 3, 1)))
