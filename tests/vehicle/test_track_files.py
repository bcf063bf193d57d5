"""Tracks by points: a line, its irregularity, a speed over it; what they mean, and which files are refused."""

import json
from importlib.resources import files
from pathlib import Path

import casadi as ca
import numpy as np
import pytest

from gyro_cosim.cli import main
from gyro_cosim.component import Component
from gyro_cosim.vehicle.alignment import Alignment
from gyro_cosim.vehicle.described.component import component_of, component_of_file
from gyro_cosim.vehicle.described.reading import read
from gyro_cosim.vehicle.irregularity import CHANNELS, unevenness
from gyro_cosim.vehicle.lrt import lrt_set_a
from gyro_cosim.vehicle.spectra import random_record, spectrum
from gyro_cosim.vehicle.track import Clothoid, Curve, Straight, Track
from gyro_cosim.vehicle.track_files import faded, line, record
from gyro_cosim.vehicle.track_parameters import parameters_of_track

LRT = files("gyro_cosim.vehicle").joinpath("library", "lrt.toml").read_text(encoding="utf-8")
B = 0.7475
SEGMENTS = (Straight(30), Clothoid(10), Curve(60, radius=50, cant=0.06), Clothoid(20), Curve(40, radius=-80), Clothoid(12),
            Straight(9))  # fmt: skip
LINE = """# surveyed
distance [m]; radius [m]; cant [mm]; gradient [permille]
0; 0; 0; 0
30; 0; 0; 0
40; 50; 60; 10
100; 50; 60; 10
"""


def at(x: ca.SX) -> float:
    return float(ca.Function("f", [], [ca.SX(x)])()["o0"])


def symbols(values: dict[str, float], knots: int) -> dict[str, ca.SX]:
    rows = {v.name: v.start for v in parameters_of_track(knots, 0)} | {"contact_half_distance": B} | values
    return {name: ca.SX(value) for name, value in rows.items()}


def as_file(folder: Path) -> Path:
    """The points of SEGMENTS."""
    curvature = ((0, 0), (30, 0), (40, 0.02), (100, 0.02), (120, -1 / 80), (160, -1 / 80), (172, 0), (181, 0))
    cant = {40: 60, 100: 60}
    file = folder / "line.csv"
    file.write_text("distance [m], curvature [1/km], cant [mm]\n" + "\n".join(
        f"{s}, {1e3 * k!r}, {cant.get(s, 0)}" for s, k in curvature), encoding="utf-8")  # fmt: skip
    return file


def test_a_line_of_a_file_is_that_of_its_segments(tmp_path: Path) -> None:
    """In every field, integrals of the heading among them, and where one place lies seen from another."""
    by_knots = Alignment.of(symbols(Track(SEGMENTS).parameters(knots=7), 7), 7)
    by_file = Alignment.of(symbols({}, 0), 0, line(as_file(tmp_path), B))
    for s in np.linspace(-5.0, 300.0, 41):
        ours, theirs = by_file.at(s), by_knots.at(s)
        for field in vars(theirs):
            assert at(getattr(ours, field)) == pytest.approx(at(getattr(theirs, field)), rel=1e-11, abs=1e-11), field
        places = [ca.vertcat(*(ca.vec(m) for m in a.between(s, a.at(s), s + 7.0, a.at(s + 7.0)))) for a in (by_file, by_knots)]
        assert np.array(ca.DM(places[0] - places[1])) == pytest.approx(np.zeros((12, 1)), abs=1e-10)


def test_units_radius_and_gradient_are_read(tmp_path: Path) -> None:
    (tmp_path / "line.csv").write_text(LINE, encoding="utf-8")
    read_line = line(tmp_path / "line.csv", B)
    assert read_line.curvature.tolist() == [0.0, 0.0, 0.02, 0.02]
    assert read_line.cant[2] == pytest.approx(-np.arcsin(0.06 / (2 * B)))
    assert np.tan(read_line.gradient[3]) == pytest.approx(0.01)
    assert at(read_line.at(500.0)["curvature"]) == 0.02  # goes on as it ends


def test_the_vehicle_on_a_line_of_a_file_moves_as_on_the_standard_curve(tmp_path: Path) -> None:
    """Rates and outputs of `vehicle:lrt` in the transition and in the curve, to rounding."""
    (tmp_path / "line.csv").write_text("distance [m], radius [m]\n0, 0\n20, 0\n30, 50\n90, 50\n100, 0\n", encoding="utf-8")
    (tmp_path / "own.toml").write_text(LRT + '\n[track]\nline = "line.csv"\n', encoding="utf-8")
    ours, theirs = component_of_file(tmp_path / "own.toml"), lrt_set_a({"curve_turn": 1.0})
    rng = np.random.default_rng(1)
    for s in (24.0, 60.0):
        places = {v.name: s if v.name.endswith("distance") else 1e-4 * rng.normal() for v in theirs.states}
        rows = []
        for c in (ours, theirs):
            x = np.array([places[v.name] for v in c.states])
            rows.append(
                dict(zip((v.name for v in c.states), np.array(c.rhs(x, c.start_input, c.start_parameters)).ravel(), strict=True))
            )
        for name, rate in rows[1].items():
            assert rows[0][name] == pytest.approx(rate, rel=1e-6, abs=1e-6), name


def wave(s: np.ndarray) -> np.ndarray:
    return 5e-3 * np.sin(2 * np.pi * s / 7.0)


def test_a_record_passes_through_its_points_and_fades(tmp_path: Path) -> None:
    """4 km at 0.25 m: a cubic spline between points; its slope within 1e-3 of the largest; nothing at the ends."""
    s = 0.25 * np.arange(16001)
    file = tmp_path / "record.csv"
    rows = "\n".join(f"{a},{b}" for a, b in zip(s, 1e3 * wave(s), strict=True))
    file.write_text("distance [m],lateral [mm]\n" + rows, encoding="utf-8")
    rough = record(file, 10.0)
    x = ca.SX.sym("x")
    f = ca.Function("f", [x], [rough.at(x)[0]["lateral"], rough.at(x)[1]["lateral"]])
    for place in (123.4, 2000.1, 3985.6):
        value, slope = (float(v) for v in f(place))
        assert value == pytest.approx(float(wave(np.array(place))), abs=4e-8)
        assert slope == pytest.approx(5e-3 * 2 * np.pi / 7 * np.cos(2 * np.pi * place / 7), abs=1e-3 * 5e-3)
    assert [float(v) for v in f(0.0)] == pytest.approx([0.0, 0.0], abs=1e-5)
    assert [float(v) for v in f(4000.0)] == pytest.approx([0.0, 0.0], abs=1e-5)
    assert float(f(-3.0)[0]) == float(f(4100.0)[1]) == 0.0


def test_rails_and_channels_are_two_ways_to_say_it(tmp_path: Path) -> None:
    s = 0.5 * np.arange(60)
    rng = np.random.default_rng(0)
    rails = rng.normal(size=(4, 60)) * 1e-3
    file = tmp_path / "rails.csv"
    names = "distance [m]\tleft_lateral [m]\tleft_vertical [m]\tright_lateral [m]\tright_vertical [m]\n"
    file.write_text(
        names + "\n".join("\t".join(map(repr, map(float, row))) for row in zip(s, *rails, strict=True)), encoding="utf-8"
    )
    rough = unevenness(ca.SX(12.5), symbols({}, 0), 0, record(file, 0.0))
    for side, row in ((1, 0), (-1, 2)):
        lateral, vertical, _, _ = rough.rail(side)
        assert at(lateral) == pytest.approx(rails[row, 25], abs=1e-12)
        assert at(vertical) == pytest.approx(rails[row + 1, 25], abs=1e-12)


def test_a_random_record_has_the_spectrum_and_repeats_nothing() -> None:
    """20 km: the power of each octave band is that of the spectrum, as it is drawn; halves of the record are not correlated."""
    position, found = random_record("low", 3, 20000.0)
    assert position.size == 80000
    assert set(found) == set(CHANNELS)
    W = 2 * np.pi * np.fft.rfftfreq(position.size, 0.25)
    for channel, values in found.items():
        power = 2 * np.abs(np.fft.rfft(values) / position.size) ** 2
        for low in (0.02, 0.1, 0.5, 2.0):
            band = (low <= W) & (2 * low > W)
            wanted = np.trapezoid(spectrum(channel, "low", W[band]), W[band])
            assert power[band].sum() == pytest.approx(wanted, rel=0.03)
        assert abs(np.corrcoef(values[:40000], values[40000:])[0, 1]) < 0.3
    again = random_record("low", 3, 20000.0)[1]["gauge"]
    assert np.array_equal(again, found["gauge"])
    assert not np.array_equal(random_record("low", 4, 20000.0)[1]["gauge"], found["gauge"])


def test_a_record_fades_without_a_step() -> None:
    rough = faded(np.arange(101.0), {"gauge": np.ones(101)}, 20.0)
    assert rough.displacement["gauge"][[0, 10, 20, 50, 90, 100]] == pytest.approx([0.0, 0.5, 1.0, 1.0, 0.5, 0.0])


def test_a_vehicle_on_a_record_starts_at_rest_and_can_be_linearised(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """Even up to 5 m ahead of the first wheelset; at the first speed of the file."""
    (tmp_path / "speeds.csv").write_text("distance [m], speed [km/h]\n0, 36\n100, 36\n200, 54\n", encoding="utf-8")
    own = tmp_path / "own.toml"
    own.write_text('[vehicle]\nextends = "vehicle:lrt_solid_axle"\n[track]\nspeed = "speeds.csv"\n'
                   'random = { level = "high", length = "400 m" }\n', encoding="utf-8")  # fmt: skip
    c = component_of_file(own)
    assert next(v.start for v in c.parameters if v.name == "speed") == 10.0
    rates = np.array(c.rhs(c.start_state, c.start_input, c.start_parameters)).ravel()
    moving = [abs(r) for v, r in zip(c.states, rates, strict=True) if not v.name.endswith("distance")]
    assert max(moving) < 1e-6
    assert main(["vehicle", "check", str(own), "--json"]) == 0
    assert json.loads(capsys.readouterr().out)["rest_error"] < 1e-6


CART = """
[vehicle]
speed = "10 m/s"
[wheelsets.axle]
axle = "solid"
mass = "1400 kg"
inertia = { x = "800 kg.m2", z = "800 kg.m2" }
spin_inertia = "60 kg.m2"
load = "50 kN"
[wheels.coned]
flange = "inside"
conicity_gradient = "0 1/m"
[drive]
gain = "10 kN.s/m"
traction_limit = "8 kN"
braking_limit = "5 kN"
[track]
speed = "speeds.csv"
"""


def drive_power(c: Component, distance: float, faster: float) -> float:
    x = c.start_state.copy()
    names = [v.name for v in c.states]
    x[names.index("axle_distance")], x[names.index("axle_speed_deviation")] = distance, faster
    y = np.array(c.output(x, c.start_input, c.start_parameters)).ravel()
    return float(y[[v.name for v in c.outputs].index("drive_power")])


def test_the_drive_holds_the_speed_of_the_file_within_its_limits(tmp_path: Path) -> None:
    """10 m/s, from 100 m on up to 15 m/s at 200 m, coasting from 400 m: force by gain and limits, on top of the track's drag."""
    (tmp_path / "speeds.csv").write_text(
        "distance [m], speed [km/h], drive\n0, 36, 1\n100, 36, 1\n200, 54, 1\n400, 54, 1\n400.1, 54, 0\n500, 54, 0\n",
        encoding="utf-8",
    )
    (tmp_path / "axle.toml").write_text(CART, encoding="utf-8")
    c = component_of(read(tmp_path / "axle.toml"))
    drag = drive_power(c, 50.0, 0.0) / 10.0
    assert 0.0 <= drag < 200.0
    assert drive_power(c, 101.0, 0.0) == pytest.approx((drag + 1e4 * 0.05) * 10.0, rel=1e-6)
    assert drive_power(c, 150.0, 0.0) == pytest.approx((drag + 8e3) * 10.0, rel=1e-6)
    assert drive_power(c, 50.0, 0.2) == pytest.approx((drag - 2e3) * 10.2, rel=1e-6)
    assert drive_power(c, 50.0, 3.0) == pytest.approx((drag - 5e3) * 13.0, rel=1e-6)
    assert drive_power(c, 450.0, 0.0) == 0.0


REFUSED = (
    ("line", LINE.replace("40; 50", "25; 50"), "distance must rise, got 30 m and 25 m after it"),
    ("line", LINE.replace("radius", "radios"), "unknown column 'radios [m]'"),
    ("line", LINE.replace("radius [m]", "radius"), "column 'radius' must have its unit, such as radius [m]"),
    ("line", LINE.replace("[mm]", "[kg]"), "column 'cant'"),
    ("line", LINE.replace("40; 50", "40; 5"), "curvature must lie within 0.1 1/m, got 0.2 at 40 m"),
    ("line", LINE.replace("40; 50; 60", "40; 50; 600"), "cant must lie within 0.2 m, got 0.6 at 40 m"),
    ("line", LINE.replace("40; 50; 60", "40; 50"), "row 4 must have 4 numbers, got 3"),
    ("line", LINE.replace("40; 50", "40; wide"), "row 4: radius must be a number, got 'wide'"),
    ("line", LINE.replace("40; 50", "40; nan"), "row 4: radius must be finite"),
    ("line", "distance [m], cant [mm]\n", "must have a line of names and two lines of numbers or more"),
    (
        "irregularity",
        "distance [m],lateral [mm]\n" + "".join(f"{i + 3 * (i > 5)},0\n" for i in range(12)),
        "a record must have no gaps",
    ),
    ("irregularity", "distance [m],lateral [m]\n" + "".join(f"{i},0.2\n" for i in range(12)), "lateral must lie within 0.1 m"),
    ("irregularity", "distance [m],left_lateral [m]\n" + "".join(f"{i},0\n" for i in range(12)), "must have all of left_lateral"),
    ("irregularity", "distance [m],lateral [m]\n0,0\n1,0\n2,0\n", "must have 8 rows or more, got 3"),
    ("speed", "distance [m],speed [m/s]\n0,10\n100,0\n", "speed must be positive all the way, got 0 m/s at 100 m"),
    ("speed", "distance [m],drive\n0,1\n100,0\n", "must have a column 'speed'"),
)


@pytest.mark.parametrize(("key", "text", "message"), REFUSED, ids=[message for _, _, message in REFUSED])
def test_a_bad_file_is_refused_in_one_line(tmp_path: Path, key: str, text: str, message: str) -> None:
    (tmp_path / "bad.csv").write_text(text, encoding="utf-8")
    (tmp_path / "axle.toml").write_text(CART.replace('speed = "speeds.csv"', f'{key} = "bad.csv"'), encoding="utf-8")
    with pytest.raises(ValueError, match=r"^axle.toml: track: bad.csv") as refused:
        read(tmp_path / "axle.toml")
    assert message in str(refused.value)
    assert "\n" not in str(refused.value)


@pytest.mark.parametrize(
    ("keys", "message"),
    [
        ('line = "none.csv"', "track.line must be a file beside this one that there is, got 'none.csv'"),
        ('random = { level = "lower", length = "1 km" }', "track.random.level"),
        ('random = { level = "low", length = "1 m" }', "track.random.length must be from 8 steps"),
        ('random = { level = "low", length = "1 km", period = "1 m" }', "unknown key 'period'"),
        ('random = { level = "low", length = "1 km" }\nfade = "2 km"', "track.fade must be from 0 to 1000 m"),
    ],
)
def test_bad_keys_are_refused(tmp_path: Path, keys: str, message: str) -> None:
    (tmp_path / "axle.toml").write_text(CART.replace('speed = "speeds.csv"', keys), encoding="utf-8")
    with pytest.raises(ValueError, match=r"^axle.toml: track") as refused:
        read(tmp_path / "axle.toml")
    assert message in str(refused.value)
