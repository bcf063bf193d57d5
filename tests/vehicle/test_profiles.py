"""Profiles by points: reading, the standards' formulas, contact in space against published results, conicity of unlike sides."""

from math import radians, tan
from pathlib import Path

import numpy as np
import pytest

from gyro_cosim.vehicle import contact_points
from gyro_cosim.vehicle.contact import hertz_patch
from gyro_cosim.vehicle.normal_patch import half_space, kik_piotrowski
from gyro_cosim.vehicle.profiles import Profile, equivalent_conicity, rail_60e1, read, s1002

WHEEL, RAIL = s1002(), rail_60e1()
BENCHMARK = {"rolling_radius": 0.46, "gauge": 1.435, "inner_distance": 1.36, "inclination": 1 / 40}


def written(path: Path, y: np.ndarray, z: np.ndarray, head: str = "") -> Path:
    path.write_text(head + "\n".join(f"{a:.7f} {b:.7f}" for a, b in zip(y, z, strict=True)) + "\n", encoding="utf-8")
    return path


# The open code CONTACT (github.com/eve70a/CONTACT, commit d431cdb, examples/mbench_a22_left.ref_out): Manchester contact
# benchmark, left wheel, 10 kN: lateral shift (mm, to the right), yaw (mrad), |y| of the contact in the track (mm), angle
LEFT = (
    (0.0, 0.0, 751.8726, 0.0290), (0.5, 1.2, 754.2094, 0.0211), (2.0, 4.8, 756.5057, 0.0134), (4.0, 9.6, 757.6646, 0.0096),
    (6.0, 14.4, 758.0212, 0.0084), (8.0, 19.2, 758.2200, 0.0077), (10.0, 24.0, 757.0952, 0.0115),
)  # fmt: skip


@pytest.mark.parametrize(("shift", "yaw", "place", "angle"), LEFT)
def test_the_contact_benchmark_is_met(shift: float, yaw: float, place: float, angle: float) -> None:
    """Within 0.1 mm and 1 mrad, by the standards' formulas."""
    found = contact_points(WHEEL, RAIL, **BENCHMARK, lateral=-1e-3 * shift, yaw=-1e-3 * yaw, axle_load=2e4)
    (contact,) = found.left
    assert 1e3 * contact.track_lateral == pytest.approx(place, abs=0.1)
    assert contact.contact_angle == pytest.approx(angle, abs=1e-3)
    assert contact.normal_force == pytest.approx(1e4 / np.cos(angle), rel=1e-3)


def test_flange_contact_and_roll_meet_the_benchmark() -> None:
    """A-2.2 at 10 mm and 24 mrad: the right wheel climbs, y = 39.44 mm inside the rail's top, 0.7992 rad; roll 11.26 mrad."""
    found = contact_points(WHEEL, RAIL, **BENCHMARK, lateral=-0.01, yaw=-0.024, axle_load=2e4)
    (contact,) = found.right
    assert contact.contact_angle == pytest.approx(0.7992, abs=1e-3)
    assert contact.wheel_lateral == pytest.approx(-44.3815e-3, abs=1e-4)
    assert abs(found.roll) == pytest.approx(0.01126, rel=5e-3)


def test_both_sides_are_mirrors_and_two_contacts_share_the_load() -> None:
    central = contact_points(WHEEL, RAIL, **BENCHMARK)
    assert central.left[0].lateral == pytest.approx(central.right[0].lateral, abs=1e-9)
    double = contact_points(WHEEL, RAIL, **BENCHMARK, lateral=-5.0e-3, yaw=-0.012, axle_load=2e4).right
    assert len(double) == 2
    assert sum(c.normal_force * np.cos(c.contact_angle) for c in double) == pytest.approx(1e4, rel=1e-3)


@pytest.mark.parametrize("rail_radius", [0.03, 0.3, 1.0])
@pytest.mark.parametrize("model", [half_space, kik_piotrowski])
def test_constant_curvatures_give_hertz(model: object, rail_radius: float) -> None:
    hertz = hertz_patch(2e4, 0.46, np.inf, rail_radius, 2.1e11, 0.28)
    y = np.linspace(-0.02, 0.02, 1601)
    found = model(y, hertz.approach - y**2 / (2 * rail_radius), 0.0, 0.46, 2.1e11, 0.28)  # type: ignore[operator]
    assert found.load == pytest.approx(2e4, rel=1e-3)
    assert (found.a, found.b) == pytest.approx((hertz.a, hertz.b), rel=0.03)


@pytest.mark.parametrize("turned", [False, True])
@pytest.mark.parametrize(("unit", "factor", "head"), [("mm", 1e3, ""), ("m", 1.0, ""), ("inch", 1 / 0.0254, "# unit: inch\n")])
@pytest.mark.parametrize("up", [1, -1])
def test_text_is_read_in_any_order_sign_and_unit(
    tmp_path: Path, turned: bool, unit: str, factor: float, head: str, up: int
) -> None:
    y, z = factor * WHEEL.y, up * factor * WHEEL.z
    if turned:
        y, z = -y[::-1], z[::-1]
        y, z = y[::-1], z[::-1]
    wheel = read(written(tmp_path / "w.txt", y, z, head))
    assert wheel.kind == "wheel"
    assert wheel.z == pytest.approx(np.interp(wheel.y, WHEEL.y, WHEEL.z), abs=2e-6)


def test_simpack_and_miniprof_give_the_same_section(tmp_path: Path) -> None:
    head = "header.begin\n type = 1\nheader.end\nspline.begin\n mirror.y = 1\n units.len.f = 1000.\n point.begin\n"
    simpack = read(written(tmp_path / "w.prw", -1e3 * WHEEL.y[::-1], -1e3 * WHEEL.z[::-1], head))
    miniprof = read(written(tmp_path / "w.whl", 1e3 * WHEEL.y + 70, -1e3 * WHEEL.z, "Filename=w\nColumnDef=X,Y\n32.5 28.0\n\n"))
    for wheel in (simpack, miniprof):
        assert wheel.z == pytest.approx(np.interp(wheel.y, WHEEL.y, WHEEL.z), abs=2e-6)
    rail = read(written(tmp_path / "r.ban", -1e3 * RAIL.y[::-1] - 2.0, 1e3 * RAIL.z[::-1], "Filename=r\n\n"))
    assert rail.y[rail.z.argmax()] == pytest.approx(2e-3, abs=1e-4)


def test_noise_is_smoothed_and_the_contact_stays(tmp_path: Path) -> None:
    noise = 2e-3 * np.random.default_rng(1).standard_normal(RAIL.z.size)
    rail = read(written(tmp_path / "r.txt", 1e3 * RAIL.y, 1e3 * RAIL.z + noise))
    assert "smoothed over 6 mm" in rail.notes
    found, exact = (contact_points(WHEEL, r, **BENCHMARK, lateral=-4e-3).left[0] for r in (rail, RAIL))
    assert found.contact_angle == pytest.approx(exact.contact_angle, abs=1e-3)


def test_a_cone_with_unlike_wheels_has_the_mean_conicity() -> None:
    """dr = (g_left + g_right) y: on a knife edge two cones swing as one of their mean conicity."""
    y = np.linspace(-0.04, 0.04, 801)
    edge = Profile(np.array([-0.001, 0.0, 0.001]), np.array([-0.01, 0.0, -0.01]))
    left, right = Profile(y, 0.05 * y), Profile(y, 0.10 * y)
    assert equivalent_conicity(left, edge, 0.46, 1.5, right_wheel=right) == pytest.approx(0.075, rel=1e-3)
    other = Profile(y, 0.05 * y + 1e-4)  # a radius smaller by 0.1 mm moves the place, not the wavelength
    assert equivalent_conicity(left, edge, 0.46, 1.5, right_wheel=other) == pytest.approx(0.05, rel=1e-3)


def test_no_radius_difference_near_the_middle_lengthens_the_wave() -> None:
    """dr = 0 within +-d, then 2 g (|y| - d): the wave is that of the cone of amplitude A - d plus the straight run between."""
    g, d, A, e, r0 = 0.1, 1e-3, 3e-3, 1.5, 0.46
    y = np.linspace(-0.02, 0.02, 16001)
    edge = Profile(np.array([-0.001, 0.0, 0.001]), np.array([-0.01, 0.0, -0.01]))
    wheel = Profile(y, g * np.sign(y) * np.maximum(np.abs(y) - d, 0.0))
    k = np.sqrt(2 * g / (e * r0))
    wavelength = 2 * np.pi / k + 4 * d / (k * (A - d))
    expected = (np.pi / wavelength) ** 2 * 2 * e * r0
    assert equivalent_conicity(wheel, edge, r0, e, A) == pytest.approx(expected, rel=5e-3)


ZIGZAG = np.where((np.arange(1301) > 800) & (np.arange(1301) < 820), -0.4, 0.0)


@pytest.mark.parametrize(
    ("y", "z", "message"),
    [
        (1e3 * WHEEL.y[::130][:10], 1e3 * WHEEL.z[::130][:10], "a profile must have 25 points or more, got 10"),
        (WHEEL.y / 0.0254, WHEEL.z / 0.0254, "the unit must be stated where a profile is 5.118 wide"),
        (1e3 * WHEEL.y + ZIGZAG, 1e3 * WHEEL.z, "a profile must not fold back, got y = "),
        (1e3 * WHEEL.y + 200.0, 1e3 * WHEEL.z, "a wheel must reach over its tape line, y = 0"),
        (1e6 * WHEEL.y, 1e6 * WHEEL.z, "a profile must be 30 to 250 mm or 0.03 to 0.25 m wide, got 1.3e"),
        (np.where(np.arange(1301) == 5, np.nan, 1e3 * WHEEL.y), 1e3 * WHEEL.z, "a profile must hold finite numbers only"),
    ],
)
def test_bad_profiles_are_refused_in_one_line(tmp_path: Path, y: np.ndarray, z: np.ndarray, message: str) -> None:
    path = written(tmp_path / "bad.txt", y, z)
    with pytest.raises(ValueError, match=message) as error:
        read(path, kind="wheel")
    assert str(error.value).startswith(f"{path}: ")
    assert "\n" not in str(error.value)


def test_a_wheel_beside_its_rail_is_refused() -> None:
    with pytest.raises(ValueError, match="wheel and rail profile must overlap"):
        contact_points(WHEEL, RAIL, **BENCHMARK | {"gauge": 2.0})
    with pytest.raises(ValueError, match="axle_load must be positive and finite, got 0"):
        contact_points(WHEEL, RAIL, **BENCHMARK, axle_load=0.0)


def test_formulas_meet_their_standards() -> None:
    """S1002: flange 28 mm high, its face at 70 deg; 60E1: 72 mm wide 14.3 mm under the top, sides of 1 : 20."""
    assert WHEEL.z.min() == pytest.approx(-0.028, abs=1e-7)
    y, _, slope = WHEEL.fine
    assert np.interp(-0.039, y, slope) == pytest.approx(tan(radians(70)), rel=1e-3)
    assert np.interp(-0.0143, RAIL.z[500:][::-1], RAIL.y[500:][::-1]) == pytest.approx(0.036, abs=2e-6)
