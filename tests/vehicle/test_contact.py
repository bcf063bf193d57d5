"""Contact mechanics: published values, limits every law must keep, and one formula for numbers and symbols."""

import math

import casadi as ca
import numpy as np
import pytest

from gyro_cosim.vehicle.contact import creep_forces, hertz_patch
from gyro_cosim.vehicle.creep_laws import LAWS
from gyro_cosim.vehicle.kalker import LONG, RATIO, WIDE, coefficients

E, NU = 2.1e11, 0.3
G = E / (2 * (1 + NU))
N, MU = 17.2e3, 0.3
PATCH = hertz_patch(N, 0.3, math.inf, 0.3, E, NU)
SATURATING = ["shen-hedrick-elkins", "polach", "fastsim"]


def forces(xi: float, eta: float, phi: float, law: str, mu: float = MU) -> np.ndarray:
    return np.array(creep_forces(xi, eta, phi, PATCH.a, PATCH.b, N, mu, G, NU, law=law))


def test_hertz_gives_the_reference_patch() -> None:
    """PHYSICS section 4: 17.2 kN, both radii 300 mm; the reference is printed to four digits."""
    assert PATCH.a == pytest.approx(3.225e-3, rel=2e-4)
    assert PATCH.b == PATCH.a
    assert PATCH.approach == pytest.approx(34.67e-6, rel=2e-4)
    assert PATCH.peak_pressure == pytest.approx(789.6e6, rel=2e-4)


@pytest.mark.parametrize("rail_radius", [0.03, 0.15, 0.3, 2.0])
def test_hertz_meets_its_own_equations(rail_radius: float) -> None:
    """The elliptic pressure, integrated over the half-space, gives the assumed gap along both axes (numerical potential)."""
    p = hertz_patch(N, 0.3, math.inf, rail_radius, E, NU)
    assert p.peak_pressure == pytest.approx(1.5 * N / (math.pi * p.a * p.b), rel=1e-12)
    compliance = 2 * (1 - NU**2) / (math.pi * E)
    w = (np.arange(4000) + 0.5) / 4000 * math.pi / 2  # potential of an ellipsoid, Johnson eq. (3.61), w = tan substitution
    s = np.tan(w) * max(p.a, p.b)
    ds = max(p.a, p.b) / np.cos(w) ** 2 * (math.pi / 2 / 4000)
    # potential of p0 sqrt(1 - x^2/a^2 - y^2/b^2) over the patch, with s^2 the confocal parameter
    root = np.sqrt((p.a**2 + s**2) * (p.b**2 + s**2))
    factor = compliance * math.pi * p.a * p.b * p.peak_pressure / 2 * 2
    integral = [np.sum(k / root * ds) for k in (1.0, 1 / (p.a**2 + s**2), 1 / (p.b**2 + s**2))]
    approach, curve_x, curve_y = (factor * i for i in integral)
    assert approach == pytest.approx(p.approach, rel=1e-5)
    assert curve_x == pytest.approx(0.5 / 0.3, rel=1e-5)
    assert curve_y == pytest.approx(0.5 / rail_radius, rel=1e-5)


def test_hertz_turns_with_the_longer_axis() -> None:
    along, across = hertz_patch(N, 2.0, math.inf, 0.3, E, NU), hertz_patch(N, 0.3, math.inf, 2.0, E, NU)
    assert (along.a, along.b) == pytest.approx((across.b, across.a), rel=1e-9)
    assert along.a > along.b


@pytest.mark.parametrize("row", range(10))
def test_kalker_table_is_met_at_its_rows(row: int) -> None:
    g = RATIO[row]
    wide, long = coefficients(g, 1.0), coefficients(1.0, g)
    for i in range(4):
        at = 1 if i < 3 else 0
        assert float(wide[i]) == pytest.approx(WIDE[i][at][row], rel=1e-12)
        assert float(long[i]) == pytest.approx(LONG[i][at][row], rel=1e-12)


def test_kalker_table_joins_at_the_circle() -> None:
    assert [rows[1 if i < 3 else 0][-1] for i, rows in enumerate(WIDE)] == [4.12, 3.67, 1.47, 1.19]
    assert [rows[-1] for block in WIDE for rows in block] == [rows[-1] for block in LONG for rows in block]


def test_kalker_circle_is_isotropic_without_poisson_effect() -> None:
    c = coefficients(1.0, 1.0, 0.0)
    assert float(c.C11) == pytest.approx(float(c.C22), rel=1e-12)


@pytest.mark.parametrize(("xi", "exact"), [(0.0005, 0.3175), (0.001, 0.5656), (0.002, 0.8770)])
def test_fastsim_is_within_six_per_cent_of_the_half_space(xi: float, exact: float) -> None:
    """Values of an exact half-space solver, PHYSICS section 4."""
    assert -forces(xi, 0.0, 0.0, "fastsim")[0] / (MU * N) == pytest.approx(exact, rel=0.06)


@pytest.mark.parametrize("law", LAWS)
def test_small_creepages_give_kalkers_forces(law: str) -> None:
    """Fx and Fy of every law start with Kalker's slope; 1e-6 of the saturation is 0.02 N. FASTSIM's cells cost 0.3 %."""
    xi, eta, phi = 1e-6, -2e-6, 1e-4
    linear = forces(xi, eta, phi, "linear")
    assert forces(xi, eta, phi, law)[:2] == pytest.approx(linear[:2], rel=5e-3)


@pytest.mark.parametrize("law", SATURATING)
def test_forces_stay_within_friction(law: str) -> None:
    """The guard of 1e-3 N against 0 / 0 and FASTSIM's sum over 50 x 50 cells (midpoints of a parabola) may exceed it a little."""
    excess = 1e-3 if law == "fastsim" else 1e-6
    for xi, eta, phi in [(0.05, 0.0, 0.0), (0.0, 0.05, 0.0), (0.03, -0.04, 0.3), (1e-3, 1e-3, 3.0), (0.0, 0.0, 100.0)]:
        assert np.hypot(*forces(xi, eta, phi, law)[:2]) <= MU * N * (1 + excess)
    assert -forces(0.5, 0.0, 0.0, law)[0] == pytest.approx(MU * N, rel=0.01)


@pytest.mark.parametrize("law", SATURATING)
def test_forces_take_power_out(law: str) -> None:
    """Creep force times slip is heat at every mixture of creepages."""
    rng = np.random.default_rng(5)
    for xi, eta, phi in rng.normal(size=(50, 3)) * [2e-3, 2e-3, 0.3]:
        assert forces(xi, eta, phi, law) @ [xi, eta, phi] < 0.0


@pytest.mark.parametrize("law", LAWS)
def test_forces_mirror_with_the_creepages(law: str) -> None:
    """Left and right are images: (xi, eta, phi) -> (xi, -eta, -phi) turns (Fx, Fy, Mz) into (Fx, -Fy, -Mz)."""
    here, there = forces(1e-3, 2e-3, 0.2, law), forces(1e-3, -2e-3, -0.2, law)
    assert there == pytest.approx(here * [1, -1, -1], rel=1e-9, abs=1e-9)


@pytest.mark.parametrize("law", LAWS)
def test_symbols_follow_the_same_formula_as_numbers(law: str) -> None:
    """FASTSIM has 7 x 7 cells as symbols and 50 x 50 as numbers: 4 %; the others are one formula."""
    x = [ca.SX.sym(n) for n in ("xi", "eta", "phi", "a", "b", "N")]
    f = ca.Function("f", x, [ca.vertcat(*creep_forces(*x, MU, G, NU, law=law))])
    got = np.array(f(1e-3, -2e-3, 0.15, PATCH.a, PATCH.b, N)).ravel()
    wanted = forces(1e-3, -2e-3, 0.15, law)
    assert got[:2] == pytest.approx(wanted[:2], rel=0.04 if law == "fastsim" else 1e-12)
    jacobian = ca.Function("jacobian", x, [ca.jacobian(f(*x), ca.vertcat(*x))])
    assert np.all(np.isfinite(np.array(jacobian(0.0, 0.0, 0.0, PATCH.a, PATCH.b, N))))


@pytest.mark.parametrize(
    ("change", "message"),
    [
        (
            {"law": "coulomb"},
            "law must be one of kalker, linear, shen-hedrick-elkins, polach, fastsim, half-space, got 'coulomb'",
        ),
        ({"friction": 1.2}, "friction must lie in 0..1, got 1.2"),
        ({"friction": -0.1}, "friction must lie in 0..1, got -0.1"),
        ({"a": 0.0}, "a must be positive and finite, got 0"),
        ({"b": 1e-5}, "a / b must lie between 0.1 and 10"),
        ({"normal_load": math.nan}, "normal_load must lie in 0..inf, got nan"),
        ({"spin": math.inf}, "spin must be finite, got inf"),
        ({"poisson_ratio": 0.6}, "poisson_ratio must lie in 0..0.5, got 0.6"),
    ],
)
def test_creep_forces_refuse_in_one_line(change: dict, message: str) -> None:
    good = {
        "longitudinal_creepage": 1e-3, "lateral_creepage": 0.0, "spin": 0.0, "a": 3e-3, "b": 3e-3, "normal_load": N,
        "friction": MU, "shear_modulus": G, "poisson_ratio": NU,
    }  # fmt: skip
    with pytest.raises(ValueError, match="(?s)^" + message.replace("/", ".").replace("(", ".")) as error:
        creep_forces(**(good | change))
    assert "\n" not in str(error.value)


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ((0.0, 0.3, math.inf, 0.3, E, NU), "normal_load must be positive and finite, got 0"),
        ((N, -0.3, math.inf, 0.3, E, NU), "wheel_rolling_radius must be positive, got -0.3"),
        ((N, 0.3, -0.2, 0.3, E, NU), "relative curvatures must be positive"),
        ((N, 0.3, math.inf, 0.3, E, 0.7), "poisson_ratio must lie in -1..0.5, got 0.7"),
    ],
)
def test_hertz_refuses_in_one_line(arguments: tuple[float, ...], message: str) -> None:
    with pytest.raises(ValueError, match=message):
        hertz_patch(*arguments)
