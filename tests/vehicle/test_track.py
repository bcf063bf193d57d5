"""Track and profiles as data: what the numbers mean, and which tables are refused."""

import casadi as ca
import numpy as np
import pytest

from gyro_cosim.vehicle.alignment import Alignment
from gyro_cosim.vehicle.irregularity import unevenness
from gyro_cosim.vehicle.profiles import (
    Profile,
    conventional_wheel,
    equivalent_conicity,
    ntcirw_wheel,
    rail_head,
    rolling_radius_difference,
)
from gyro_cosim.vehicle.spectra import random_track, spectrum, tabulated_track
from gyro_cosim.vehicle.track import Clothoid, Curve, Straight, Stretch, Track
from gyro_cosim.vehicle.track_parameters import parameters_of_track

LEFT_RIGHT = (
    Straight(30),
    Clothoid(10),
    Curve(60, radius=50, cant=0.06),
    Clothoid(20),
    Curve(40, radius=-80),
    Clothoid(12),
    Straight(9),
)
KNIFE = Profile(np.array([-1e-3, 0.0, 1e-3]), np.array([-0.01, 0.0, -0.01]))


def symbols(values: dict[str, float], knots: int, harmonics: int = 0) -> dict[str, ca.SX]:
    table = {v.name: v.start for v in parameters_of_track(knots, harmonics)} | {"contact_half_distance": 0.7475} | values
    return {name: ca.SX(value) for name, value in table.items()}


def numbers(at: object, *names: str) -> list[float]:
    return [float(ca.DM(getattr(at, name))) for name in names]


def test_segments_become_the_alignment_they_describe() -> None:
    alignment = Alignment.of(symbols(Track(LEFT_RIGHT).parameters(knots=6), 6), 6)
    angle = -np.arcsin(0.06 / (2 * 0.7475))  # a left curve lifts the right rail
    for s, curvature, cant in [(10, 0, 0), (35, 0.01, angle / 2), (70, 0.02, angle), (110, (0.02 - 1 / 80) / 2, angle / 2),
                               (130, -1 / 80, 0), (175, 0, 0), (900, 0, 0)]:  # fmt: skip
        assert numbers(alignment.at(s), "curvature", "cant") == pytest.approx([curvature, cant], abs=1e-12)
    turned = 0.02 * (5 + 60 + 10) - (10 + 40 + 6) / 80  # curvature times length, ramps by halves
    assert numbers(alignment.at(500.0), "heading") == pytest.approx([turned], abs=1e-12)


def test_the_standard_curve_is_the_same_as_its_segments() -> None:
    line = Track((Straight(20), Clothoid(10), Curve(60, radius=-50, cant=0.05), Clothoid(10), Straight(1)))
    by_segments = Alignment.of(symbols(line.parameters(), 4), 4)
    by_hand = Alignment.of(symbols({"curve_turn": -1.0, "curve_cant": 0.05}, 4), 4)
    for s in np.linspace(0.0, 130.0, 27):
        a, b = (numbers(x.at(s), "curvature", "heading", "cant", "cant_slope") for x in (by_segments, by_hand))
        assert a[:2] == pytest.approx(b[:2], abs=1e-12)
        assert a[2:] == pytest.approx(b[2:], rel=1e-3, abs=1e-12)  # arc sine of the cant against the cant itself


def test_gradient_table_is_interpolated_and_held() -> None:
    line = Track((Straight(10),), gradient=((20.0, 0.0), (40.0, 0.05), (60.0, 0.05), (90.0, -0.02)))
    alignment = Alignment.of(symbols(line.parameters(), 4), 4)
    for s, ratio in [(5, 0.0), (40, 0.05), (50, 0.05), (90, -0.02), (300, -0.02)]:
        assert numbers(alignment.at(s), "gradient") == pytest.approx([np.arctan(ratio)], abs=1e-12)


def rail_at(s: float, values: dict[str, float], harmonics: int, side: int) -> list[float]:
    return [float(ca.DM(v)) for v in unevenness(ca.SX(s), symbols(values, 4, harmonics), harmonics).rail(side)]


def test_stretch_is_a_finite_sine_and_gauge_parts_the_rails() -> None:
    values = Track((Straight(1),), stretch=Stretch(30.0, 50.0, 5, {"lateral": 0.01, "gauge": 0.004})).parameters()
    assert rail_at(29.9, values, 0, 1) == [0, 0, 0, 0]
    assert rail_at(280.1, values, 0, 1) == [0, 0, 0, 0]
    left, right = rail_at(42.5, values, 0, 1), rail_at(42.5, values, 0, -1)  # a crest
    assert (left[0], right[0]) == pytest.approx((0.012, 0.008))
    slope = (rail_at(50.0 + 1e-4, values, 0, 1)[0] - rail_at(50.0 - 1e-4, values, 0, 1)[0]) / 2e-4
    assert rail_at(50.0, values, 0, 1)[2] == pytest.approx(slope, rel=1e-6)


def test_table_comes_back_from_its_harmonics() -> None:
    s = np.linspace(5.0, 65.0, 601)
    w = 2e-3 * np.sin(2 * np.pi * s / 20) + 1e-3 * np.cos(2 * np.pi * s / 7.5)
    values = tabulated_track(s, {"vertical": w}, harmonics=12) | {"harmonics_start": -50.0}
    for at in (7.3, 31.0, 100.1):
        exact = 2e-3 * np.sin(2 * np.pi * at / 20) + 1e-3 * np.cos(2 * np.pi * at / 7.5)
        slope = 2e-3 * 2 * np.pi / 20 * np.cos(2 * np.pi * at / 20) - 1e-3 * 2 * np.pi / 7.5 * np.sin(2 * np.pi * at / 7.5)
        got = rail_at(at, values, 12, -1)
        assert got[1] == pytest.approx(exact, abs=2e-6)  # linear interpolation between 0.1 m points
        assert got[3] == pytest.approx(slope, abs=5e-6)


def test_random_track_has_the_power_of_its_band() -> None:
    """Half the sum of squared amplitudes is the spectrum's integral; quadrature on both sides."""
    values = random_track("low", seed=3, harmonics=200, longest=100.0)
    K = 2 * np.pi / 100.0
    for channel in ("lateral", "vertical", "cross_level"):
        power = sum(v**2 for k, v in values.items() if k.startswith(channel)) / 2
        W = np.linspace(K / 2, 200.5 * K, 200001)
        assert power == pytest.approx(np.trapezoid(spectrum(channel, "low", W), W), rel=1e-4)
    again, other = random_track("low", 3, 200, 100.0), random_track("low", 4, 200, 100.0)
    assert values == again
    assert values != other
    assert values["lateral_cosine[0]"] / values["lateral_sine[0]"] != values["vertical_cosine[0]"] / values["vertical_sine[0]"]


def test_spectrum_meets_hand_values() -> None:
    """Low lateral disturbance at 0.1 rad/m: 2.119e-7 * 0.6800 / ((0.01 + 0.000424) (0.01 + 0.680))."""
    by_hand = 2.119e-7 * 0.8246**2 / ((0.01 + 0.0206**2) * (0.01 + 0.8246**2))
    assert spectrum("lateral", "low", np.array([0.1]))[0] == pytest.approx(by_hand, rel=1e-12)
    assert spectrum("lateral", "high", np.array([0.1]))[0] == pytest.approx(by_hand * 6.125 / 2.119, rel=1e-12)


@pytest.mark.parametrize(
    "conicity", [pytest.param(0.025, marks=pytest.mark.slow), 0.05, pytest.param(0.1, marks=pytest.mark.slow)]
)
def test_a_cone_has_its_own_equivalent_conicity(conicity: float) -> None:
    """EN 15302: for a cone the kinematic wavelength is Klingel's whatever the amplitude."""
    for amplitude in (1e-3, 3e-3, 5e-3):
        found = equivalent_conicity(conventional_wheel(conicity), rail_head(), 0.3, 1.495, amplitude)
        assert found == pytest.approx(conicity, rel=1e-6)


def test_equivalent_conicity_of_a_cubic_radius_difference_is_exact() -> None:
    """dr = 2 c y + 4 q y^3 (a wheel r = r0 + c y + 2 q y^3 on a knife edge): Duffing's period, by complete elliptic integral."""
    from scipy.special import ellipk

    y = np.linspace(-0.02, 0.02, 4001)
    c, q, r0, e, A = 0.05, 800.0, 0.3, 1.495, 3e-3
    wheel = Profile(y, c * y + 2 * q * y**3)  # z up: the radius shrinks outwards, so the conicity is positive
    alpha, beta = 2 * c / (e * r0), 4 * q / (e * r0)
    root = np.sqrt(alpha + beta * A**2)
    wavelength = 4 * ellipk(beta * A**2 / (2 * (alpha + beta * A**2))) / root
    exact = (np.pi / wavelength) ** 2 * 2 * e * r0
    assert equivalent_conicity(wheel, KNIFE, r0, e, A) == pytest.approx(exact, rel=1e-4)


def test_ntcirw_has_the_negative_of_its_conicity() -> None:
    """r_left - r_right = -2 g0 y on a knife edge whatever g1, whose part is even. The edge's flanks of 10 : 1 cost 0.1 %."""
    assert equivalent_conicity(ntcirw_wheel(0.05, 1.0), KNIFE, 0.3, 1.495) == pytest.approx(-0.05, rel=2e-3)
    y = np.array([1e-3, 3e-3])
    assert rolling_radius_difference(ntcirw_wheel(0.049, 10.65), KNIFE, y) == pytest.approx(-2 * 0.049 * y, rel=2e-3)


@pytest.mark.parametrize(
    ("make", "message"),
    [
        (lambda: Track((Straight(5), Curve(5, radius=50))).parameters(), "put a Clothoid before segment 2"),
        (lambda: Track((Straight(5), Clothoid(5))).parameters(), "a Clothoid must stand between two segments"),
        (lambda: Track((Clothoid(5), Straight(5))).parameters(), "the track must begin with a Straight"),
        (lambda: Track((Straight(-5),)).parameters(), "the length of a segment must be positive"),
        (
            lambda: Track((Straight(5), Clothoid(5), Curve(5, radius=6))).parameters(),
            "the radius must be at least 10.2 m for a wheel",
        ),
        (lambda: Track((Straight(5), Clothoid(5), Curve(5, radius=float("nan")))).parameters(), "the radius must be at least"),
        (lambda: Track(()).parameters(), "at least one segment"),
        (lambda: Track(LEFT_RIGHT).parameters(), "the track needs 6 knots, got a vehicle with 4: build it with knots=6"),
        (
            lambda: Track((Straight(5),), gradient=((5, 0), (5, 0.1))).parameters(),
            "positions of the gradient table must increase",
        ),
        (lambda: Track((Straight(5),), gradient=((5, 0.1),)).parameters(), "must begin with gradient 0"),
        (lambda: tabulated_track([0, 2, 1], {"lateral": [0, 0, 0]}, 4), "positions of an irregularity table"),
        (lambda: tabulated_track([0, 1, 2], {"up": [0, 0, 0]}, 4), "channel must be one of lateral, vertical"),
        (lambda: tabulated_track(np.arange(9), {"lateral": [0, 1] * 4 + [0]}, 2), "2 harmonics miss"),
        (lambda: random_track("medium", 1, 8), "level must be one of low, high, got 'medium'"),
        (lambda: Profile(np.array([0.0, 1.0, 1.0]), np.zeros(3)), "the y of a profile must increase, got 1 before 1"),
        (lambda: Profile(np.arange(3.0), np.array([0.0, np.nan, 0.0])), "a profile must hold finite numbers only"),
        (
            lambda: equivalent_conicity(Profile(np.array([0.5, 0.6, 0.7]), np.zeros(3)), rail_head(), 0.3, 1.495),
            "wheel and rail profile must overlap",
        ),
        (lambda: equivalent_conicity(ntcirw_wheel(), rail_head(), -0.3, 1.495), "rolling_radius must be positive, got -0.3"),
        (lambda: ntcirw_wheel(g0=0.45, g1=5.0), "the flange must be high enough for fillet, cone and tip, got 0.028 m"),
    ],
)
def test_bad_tables_are_refused_in_one_line(make: object, message: str) -> None:
    with pytest.raises(ValueError, match=message) as error:
        make()  # type: ignore[operator]
    assert "\n" not in str(error.value)
