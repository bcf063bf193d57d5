"""What joins and pushes the bodies of a vehicle file: energy is kept, and each element has its limits."""

import itertools

import casadi as ca
import numpy as np
import pytest

from gyro_cosim.component import Component
from gyro_cosim.vehicle.described.component import component_of
from gyro_cosim.vehicle.described.equations import Motion, motion
from gyro_cosim.vehicle.described.reading import read_text
from gyro_cosim.vehicle.track import Clothoid, Curve, Straight, Stretch, Track

CART = """
[vehicle]
name = "cart"
[bodies.body]
mass = "8 t"
inertia = { x = "6000 kg.m2", y = "30000 kg.m2", z = "30000 kg.m2" }
centre = { x = "0 m", z = "1.4 m" }
[wheelsets.front]
axle = "independent"
x = "3 m"
mass = "1.4 t"
inertia = { x = "800 kg.m2", y = "90 kg.m2", z = "800 kg.m2" }
spin_inertia = "30 kg.m2"
[wheelsets.rear]
axle = "solid"
x = "-3 m"
mass = "1.4 t"
inertia = { x = "800 kg.m2", z = "800 kg.m2" }
spin_inertia = "60 kg.m2"
[springs.front]
between = ["body", "front"]
at = { x = "3 m", z = "0.5 m" }
half_spacing = { x = "0.4 m", y = "1 m" }
stiffness = { x = "1 kN/mm", y = "0.5 kN/mm", z = "0.2 kN/mm" }
damping = { x = "4 kN.s/m", y = "8 kN.s/m", z = "10 kN.s/m" }
[springs.rear]
between = ["body", "rear"]
at = { x = "-3 m", z = "0.5 m" }
half_spacing = { y = "1 m" }
stiffness = { x = "2 kN/mm", y = "1 kN/mm", z = "0.4 kN/mm" }
damping = { z = "10 kN.s/m" }
[wheels.coned]
flange = "inside"
conicity = "0.05"
conicity_gradient = "0 1/m"
flange_clearance = "7 mm"
"""
MORE = """
[bodies.second]
mass = "5 t"
inertia = { x = "4000 kg.m2", y = "9000 kg.m2", z = "9000 kg.m2" }
centre = { x = "-5 m", y = "30 mm", z = "1.2 m" }
[wheelsets.last]
like = "rear"
x = "-7 m"
[springs.last]
like = "rear"
between = ["second", "last"]
at = { x = "-7 m", y = "10 mm", z = "0.5 m" }
half_spacing = { x = "0.6 m", y = "0.9 m" }
friction = { y = "900 N", z = "1.2 kN" }
friction_speed = "30 mm/s"
[springs.shared]
like = "rear"
between = ["second", "rear"]
at = { x = "-3.2 m", z = "0.6 m" }
[links.coupler]
between = ["body", "second"]
upper_end = { x = "-4 m", z = "0.8 m" }
lower_end = { x = "-4.8 m", z = "0.85 m" }
stiffness = "3 kN/mm"
damping = "5 kN.s/m"
[links.yaw_damper]
between = ["body", "rear"]
upper_end = { x = "-4 m", y = "1.2 m", z = "0.6 m" }
lower_end = { x = "-3.2 m", y = "1.1 m", z = "0.5 m" }
mirrored = true
damping = "90 kN.s/m"
series_stiffness = "2 kN/mm"
friction = "400 N"
curve = [["-20 mm", "-3 kN"], ["0 mm", "0 kN"], ["10 mm", "0.5 kN"]]
[roll_bars.bar]
between = ["body", "front"]
stiffness = "500 kN.m/rad"
damping = "7 kN.m.s/rad"
[forces.wind]
on = "body"
at = { x = "0 m", z = "2.1 m" }
force = { x = "0 N", y = "0 N", z = "0 N" }
[torques.motor]
on = "front"
[torques.brake]
on = "rear"
against = "body"
[mounts.unit]
on = "body"
[track]
knots = 6
harmonics = 8
"""
HELD = """series_stiffness = { x = "0.9 kN/mm", y = "0.7 kN/mm", z = "2 kN/mm" }
curve.y = [["5 mm", "0 N"], ["8 mm", "700 N"], ["11 mm", "3 kN"]]
curve.z = [["0 mm", "0 N"], ["9 mm", "1 kN"], ["12 mm", "3 kN"]]
rounding = "2 mm"
"""
TWISTED = Track(
    (Straight(30), Clothoid(15), Curve(60, radius=50, cant=0.04), Clothoid(15), Straight(100)),
    gradient=((25.0, 0.0), (60.0, 0.03)),
    stretch=Stretch(10.0, 20.0, 8, {"lateral": 0.004, "vertical": 0.003, "cross_level": 0.002, "gauge": 0.001}),
)
SIZES = {
    "distance": 0.1, "lateral_displacement": 4e-3, "vertical_displacement": 4e-5, "yaw_angle": 0.02, "roll_angle": 4e-5,
    "pitch_angle": 0.01, "spin_deviation": 0.1, "roll_rate": 0.02, "series": 3e-3,
}  # fmt: skip


class Cart:
    """A vehicle text as a component, and its equations as functions of (x, u, p)."""

    def __init__(self, text: str) -> None:
        self.description = read_text(text, "cart.toml")
        self.component: Component = component_of(self.description)
        self.rows = [list(row) for row in (self.component.states, self.component.inputs, self.component.parameters)]

    def equations(self) -> tuple[list[ca.SX], ca.SX, Motion]:
        s = {v.name: ca.SX.sym(v.name) for row in self.rows for v in row}
        found = motion(s, self.description)
        x, u, p = (ca.vertcat(*(s[v.name] for v in row)) for row in self.rows)
        return [x, u, p], ca.vertcat(*(found.derivatives[v.name] for v in self.rows[0])), found

    def row(self, kind: int, **values: float) -> np.ndarray:
        names = [v.name for v in self.rows[kind]]
        at = np.array([v.start for v in self.rows[kind]])
        for name, value in values.items():
            at[names.index(name)] = value
        return at

    def rates(self, x: dict[str, float] | None = None, u: dict[str, float] | None = None, **p: float) -> dict[str, float]:
        rates = self.component.rhs(self.row(0, **(x or {})), self.row(1, **(u or {})), self.row(2, **p))
        return dict(zip((v.name for v in self.rows[0]), np.array(rates).ravel(), strict=True))

    def pushed(self, x: dict[str, float] | None = None, u: dict[str, float] | None = None, **p: float) -> dict[str, float]:
        """Rates less those at rest."""
        here, rest = self.rates(x, u, **p), self.rates(**p)
        return {name: here[name] - rest[name] for name in here}

    def roots(self, **p: float) -> np.ndarray:
        names = [v.name for v in self.rows[0]]
        columns = []
        for name in names:
            up, down = (list(self.rates({name: sign * 1e-7}, **p).values()) for sign in (1, -1))
            columns.append((np.array(up) - down) / 2e-7)
        return np.linalg.eigvals(np.array(columns).T)


@pytest.fixture(scope="module")
def cart() -> Cart:
    return Cart(CART)


def test_energy_is_kept_by_every_element() -> None:
    """d(kinetic + spring energy)/dt = gravity + drive + mounts + forces and torques - dampers and friction - creep - pressing, at
    random states in a canted curve that climbs, and in its transition, rough; with no knot of the track between bodies, which
    costs up to 1e-4 of the largest term by the quadrature of `Alignment.between`."""
    held = CART.replace('damping = { x = "4 kN', HELD + 'damping = { x = "4 kN').replace(
        '{ y = "1 m" }', '{ x = "0.3 m", y = "1 m" }'
    )
    held = held.replace('axle = "solid"\n', 'axle = "solid"\npitches = true\n')  # one that cannot pitch takes work on a slope
    held = held.replace('inertia = { x = "800 kg.m2", z', 'inertia = { x = "800 kg.m2", y = "70 kg.m2", z')
    whole = Cart(held + MORE)
    (x, u, p), x_dot, found = whole.equations()
    out = found.account
    terms = ca.vertcat(
        ca.jtimes(out["kinetic_energy"] + out["spring_energy"], x, x_dot), -out["gravity_power"], -out["drive_power"],
        -out["mount_power"], -out["applied_power"], out["damper_heat"], out["creep_heat"], out["press_power"],
    )  # fmt: skip
    terms_of = ca.Function("terms", [x, u, p], [terms])
    rng, values = np.random.default_rng(3), whole.row(2, **TWISTED.parameters(knots=6))
    for where in (38.5, 71.0, 88.0):
        state = np.array([
            rng.normal() * next((size for key, size in SIZES.items() if key in v.name), 0.1)
            + (where if v.name.endswith("distance") else 0.0) for v in whole.rows[0]
        ])  # fmt: skip
        shares = np.array(terms_of(state, rng.normal(size=len(whole.rows[1])) * 500, values)).ravel()
        assert abs(shares.sum()) < 1e-8 * np.abs(shares).max()
        assert shares[5] > 0.0
        assert abs(shares[4]) > 1.0


def test_a_held_damper_lies_between_damper_and_spring() -> None:
    """Maxwell: held firmly it is the damper; without a way to yield it is the spring that holds it."""
    held = Cart(CART.replace('damping = { z = "10 kN', 'series_stiffness = { z = "1 kN/mm" }\ndamping = { z = "10 kN'))
    plain = Cart(CART)
    stiff = held.roots(rear_series_stiffness_z=1e12)
    for root in plain.roots():
        assert np.abs(stiff - root).min() < 1e-4 * max(abs(root), 1.0)
    frozen, sprung = held.roots(rear_damping_z=1e13), plain.roots(rear_damping_z=0.0, rear_stiffness_z=1.4e6)
    for root in sprung:
        assert np.abs(frozen - root).min() < 1e-4 * max(abs(root), 1.0)


def test_dry_friction_takes_four_amplitudes_a_cycle() -> None:
    """A body that swings sideways by +-A over friction F loses 4 A F a cycle; where the sliding speed v_0 is small beside that of
    the swing. By the equations' own account of heat, and by the force."""
    rubbing = Cart(CART.replace('damping = { z = "10 kN', 'friction = { y = "1 kN" }\ndamping = { z = "10 kN'))
    (x, u, p), x_dot, found = rubbing.equations()
    states = [v.name for v in rubbing.rows[0]]
    force = 8000.0 * x_dot[states.index("body_lateral_velocity")]
    account = ca.Function("account", [x, u, p], [found.account["damper_heat"], force])
    amplitude, omega = 0.02, 2 * np.pi
    for v_0, miss in ((2e-3, 0.01), (2e-4, 0.001)):
        values, plain = (
            rubbing.row(2, rear_friction_speed=v_0, rear_friction_y=size, front_damping_y=0.0) for size in (1e3, 0.0)
        )
        heat, work = 0.0, 0.0
        for phase in (np.arange(400) + 0.5) * 2 * np.pi / 400:
            rate = omega * amplitude * np.cos(phase)
            here = rubbing.row(0, body_lateral_displacement=amplitude * np.sin(phase), body_lateral_velocity=rate)
            h, f = (float(value) for value in account(here, rubbing.row(1), values))
            f -= float(account(here, rubbing.row(1), plain)[1])
            heat, work = heat + h / 400, work - f * rate / 400
        lost = 2 * 4 * amplitude * 1e3  # two of them
        assert heat == pytest.approx(lost, rel=miss)
        assert work == pytest.approx(lost, rel=miss)


def test_a_bump_stop_is_free_in_its_gap_and_follows_its_table() -> None:
    table = [(25, 0), (30, 600), (35, 1760), (40, 3730), (45, 6870), (50, 11580), (55, 17170), (60, 29200), (65, 230000)]
    curve = ", ".join(f'["{d} mm", "{f} N"]' for d, f in table)
    stop = """[springs.stop]
between = ["body", "rear"]
at = { x = "-3 m", z = "1.4 m" }
curve.y = [%s]
"""
    stopped, plain = Cart(CART + stop % curve), Cart(CART)

    def force(y: float) -> float:
        x = {"body_lateral_displacement": y}
        name = "body_lateral_velocity"
        return -8000.0 * (stopped.rates(x)[name] - plain.rates(x)[name])

    for y in (-0.0247, -0.01, 0.0, 0.0247):
        assert force(y) == 0.0
    for (d, f), (e, g) in itertools.pairwise(table):
        assert force((d + e) / 2e3) == pytest.approx((f + g) / 2, rel=1e-9)
        assert force(-(d + e) / 2e3) == pytest.approx(-(f + g) / 2, rel=1e-9)
    assert force(0.066) == pytest.approx(230000 + (230000 - 29200) / 5, rel=1e-9)  # straight on beyond the last point
    assert force(0.030) == pytest.approx(600 + (1160 - 600) / 5e-3 * 2e-4 / 4, rel=1e-9)  # a corner rounded over 0.2 mm
    one_way = Cart(CART + stop % '["-1 mm", "0 N"], ["0 mm", "0 N"], ["20 mm", "0 N"], ["30 mm", "5 kN"]')
    for y, f in ((-0.03, 5000.0), (0.025, 0.0)):  # travel is that of the lower body: the body to the right, it to the left
        x = {"body_lateral_displacement": y}
        got = one_way.rates(x)["body_lateral_velocity"] - plain.rates(x)["body_lateral_velocity"]
        assert 8000.0 * got == pytest.approx(f, rel=1e-9)


def test_a_piecewise_spring_carries_with_its_slope_at_rest() -> None:
    """A progressive spring in the place of a linear one of the same slope: the same modes; and beyond its bend it is stiffer."""
    bent = Cart(
        CART.replace(
            'y = "1 kN/mm", z = "0.4 kN/mm" }',
            'y = "1 kN/mm" }\ncurve.z = [["0 mm", "0 N"], ["20 mm", "8 kN"], ["30 mm", "20 kN"]]',
        )
    )
    assert np.abs(np.sort(bent.roots().imag) - np.sort(Cart(CART).roots().imag)).max() < 1e-3
    low, high = (bent.pushed({"body_vertical_displacement": z})["body_vertical_velocity"] for z in (-0.01, -0.03))
    front = 4 * 0.2e6
    assert low * 8000.0 == pytest.approx((front + 2 * 0.4e6) * 0.01, rel=1e-3)
    assert high * 8000.0 == pytest.approx(front * 0.03 + 2 * 20e3, rel=1e-3)


def test_links_act_along_their_line(cart: Cart) -> None:
    """A rod at an angle of 60 degrees gives a quarter of its stiffness along x; yaw dampers l off the middle give 2 c l^2."""
    rod = Cart(
        CART
        + """[links.rod]
between = ["body", "rear"]
upper_end = { x = "-2.5 m", z = "1.4 m" }
lower_end = { x = "-3 m", z = "0.53397459621556 m" }
stiffness = "1 kN/mm"
"""
    )
    x = {"body_distance": 1e-6}
    got = rod.pushed(x)["body_speed_deviation"] - cart.pushed(x)["body_speed_deviation"]
    assert got * 8000.0 == pytest.approx(-0.25 * 1e6 * 1e-6, rel=1e-4)
    damper = """[links.yaw_damper]
between = ["body", "rear"]
upper_end = { x = "-3.9 m", y = "1.2 m", z = "1.4 m" }
lower_end = { x = "-3 m", y = "1.2 m", z = "1.4 m" }
mirrored = true
damping = "100 kN.s/m"
"""
    damped, x = Cart(CART + damper), {"body_yaw_rate": 0.01}
    got = damped.pushed(x)["body_yaw_rate"] - cart.pushed(x)["body_yaw_rate"]
    assert got * 30000.0 == pytest.approx(-2 * 100e3 * 1.2**2 * 0.01, rel=1e-6)
    one_sided = Cart(CART + damper.replace("mirrored = true", ""))
    got = one_sided.pushed(x)["body_yaw_rate"] - cart.pushed(x)["body_yaw_rate"]
    assert got * 30000.0 == pytest.approx(-100e3 * 1.2**2 * 0.01, rel=1e-6)


def test_a_roll_bar_resists_roll_alone(cart: Cart) -> None:
    bar = Cart(CART + '[roll_bars.bar]\nbetween = ["body", "rear"]\nstiffness = "600 kN.m/rad"\n')
    for name, moment in (("roll", -600e3), ("pitch", 0.0), ("yaw", 0.0)):
        x = {f"body_{name}_angle": 1e-4}
        both = (vehicle.pushed(x)[f"body_{name}_rate"] for vehicle in (bar, cart))
        inertia = 6000.0 if name == "roll" else 30000.0
        assert (next(both) - next(both)) * inertia == pytest.approx(moment * 1e-4, rel=1e-6, abs=1e-4)


def test_wind_pushes_where_it_acts_and_torques_turn_wheels() -> None:
    pushed = Cart(CART + MORE[MORE.index("[forces.wind]") : MORE.index("[mounts.unit]")])
    wind = pushed.pushed(u={"wind_force_y": 4000.0})
    assert wind["body_lateral_velocity"] == pytest.approx(4000.0 / 8000.0)
    assert wind["body_roll_rate"] == pytest.approx(-4000.0 * (2.1 - 1.4) / 6000.0)
    motor = pushed.pushed(u={"motor_left_torque": 90.0})
    assert motor["front_left_spin_deviation"] == pytest.approx(90.0 / 30.0)
    assert motor["front_right_spin_deviation"] == 0.0
    assert motor["front_pitch_rate"] == pytest.approx(-90.0 / 90.0)
    brake = pushed.pushed(u={"brake_torque": -600.0})
    assert brake["rear_axle_spin_deviation"] == pytest.approx(-600.0 / 120.0)
    assert brake["body_pitch_rate"] == pytest.approx(600.0 / 30000.0)


def test_a_train_of_three_cars_moves_as_three_masses_on_two_couplers() -> None:
    """Along the track, all alike: natural frequencies sqrt(k/m) and sqrt(3 k/m) of free-free chains, wheels' spin in the mass."""
    cars = (
        CART.replace('"independent"', '"solid"')
        .replace('y = "90 kg.m2", ', "")
        .replace('spin_inertia = "30', 'spin_inertia = "60')
    )
    text = cars.replace('stiffness = { x = "1 kN', 'stiffness = { x = "900 kN').replace('stiffness = { x = "2 kN',
                                                                                       'stiffness = { x = "900 kN')  # fmt: skip
    for i, x in ((1, -20), (2, -40)):
        text += f"""[bodies.body_{i}]
like = "body"
centre = {{ x = "{x} m", z = "1.4 m" }}
"""
        for end, at in (("front", x + 3), ("rear", x - 3)):
            text += f"""[wheelsets.{end}_{i}]
like = "{end}"
x = "{at} m"
[springs.{end}_{i}_spring]
like = "{end}"
between = ["body_{i}", "{end}_{i}"]
at = {{ x = "{at} m", z = "0.5 m" }}
"""
    for i, (a, b, x) in enumerate((("body", "body_1", -10), ("body_1", "body_2", -30))):
        text += f"""[links.coupler_{i}]
between = ["{a}", "{b}"]
upper_end = {{ x = "{x + 0.5} m", z = "1 m" }}
lower_end = {{ x = "{x - 0.5} m", z = "1 m" }}
stiffness = "0.5 kN/mm"
"""
    train = Cart(text + '[drive]\non = "0"\n')
    assert max(abs(rate) for name, rate in train.rates().items() if "distance" not in name) < 1e-2
    assert sum(v.name.endswith(("_rate", "_velocity", "_deviation")) for v in train.rows[0]) == 3 * (6 + 2 * 6)
    roots, r = train.roots(), 0.3
    m = 8000.0 + 2 * (1400.0 + 120.0 / r**2)
    for factor in (1.0, 3.0):
        wanted = np.sqrt(factor * 0.5e6 / m)
        assert np.abs(roots - 1j * wanted).min() < 0.03 * wanted


def test_an_unsymmetric_vehicle_loads_its_wheels_by_the_lever() -> None:
    """A body 60 mm off the middle: the springs of both ends carry it, the left wheels more by m g y / (2 b)."""
    off = Cart(CART.replace('centre = { x = "0 m", z', 'centre = { x = "0 m", y = "60 mm", z'))
    y = dict(zip((v.name for v in off.component.outputs),
                 np.array(off.component.output(off.row(0), off.row(1), off.row(2))).ravel(), strict=True))  # fmt: skip
    b = off.row(2)[[v.name for v in off.rows[2]].index("contact_half_distance")]
    total = (8000 + 2 * 1400) * 9.81
    left, right = (sum(y[f"{end}_{side}_vertical_force"] for end in ("front", "rear")) for side in ("left", "right"))
    assert left + right == pytest.approx(total, rel=1e-3)
    assert left - right == pytest.approx(8000 * 9.81 * 0.06 / b, rel=1e-2)
    rates = off.rates()
    assert max(abs(rates[name]) for name in ("body_vertical_velocity", "body_pitch_rate")) < 1e-2
    assert abs(rates["body_roll_rate"]) < 0.02 * 8000 * 9.81 * 0.06 / 6000


@pytest.mark.parametrize(
    ("addition", "says"),
    [
        ('[springs.more]\nbetween = ["body", "rear"]\nat.z = "1 m"\nseries_stiffness.x = "1 N/m"',
         "springs.more.series_stiffness.x must have a damper that it holds"),
        ('[springs.more]\nbetween = ["body", "rear"]\nat.z = "1 m"\ncurve.x = [["1 mm", "0 N"], ["2 mm", "3 N"], ["9 m", "2 N"]]',
         "springs.more.curve.x must have forces that do not fall: no negative stiffness"),
        ('[springs.more]\nbetween = ["body", "rear"]\nat.z = "1 m"\ncurve.x = [["1 mm", "0 N"], ["1 mm", "3 N"]]',
         "springs.more.curve.x must have travels that rise"),
        ('[springs.more]\nbetween = ["body", "rear"]\nat.z = "1 m"\ncurve.x = [["1 mm", "2 N"], ["2 mm", "3 N"]]',
         "springs.more.curve.x must have no force at rest, nor at the end of its gap"),
        ('[springs.more]\nbetween = ["body", "rear"]\nat.z = "1 m"\ncurve.w = []', "springs.more.curve: unknown key 'w'"),
        ('[springs.more]\nbetween = ["body", "rear"]\nat.z = "1 m"\ncurve.x = [["1 mm", "2 N", "3 N"]]',
         "springs.more.curve.x must be a list of pairs"),
        ('[springs.more]\nbetween = ["body", "rear"]\nat.z = "1 m"\nfriction.x = "1 N"\nfriction_speed = "0 m/s"',
         "springs.more.friction_speed must be more than 0 m/s, got '0 m/s'"),
        ('[links.rod]\nbetween = ["body", "rear"]\nupper_end = { x = "1 m", z = "1 m" }\nlower_end = { x = "1 m", z = "1 m" }',
         "links.rod.lower_end must be apart from upper_end"),
        ('[links.front]\nbetween = ["body", "rear"]\nupper_end = { x = "1 m", z = "1 m" }\nlower_end = { x = "2 m", z = "1 m" }',
         "links.front must have a name of its own: springs are called so"),
        ('[links.rod]\nbetween = ["body", "rear"]\nmirrored = true\nupper_end = { x = "1 m", z = "1 m" }\n'
         'lower_end = { x = "2 m", z = "1 m" }', "links.rod.mirrored must have ends off the middle of the track"),
        ('[roll_bars.bar]\nbetween = ["body", "reer"]\nstiffness = "1 N.m/rad"',
         "roll_bars.bar.between: unknown body 'reer'; did you mean 'rear'?"),
        ('[roll_bars.bar]\nbetween = ["body", "rear"]\nstiffness = "-1 N.m/rad"',
         "roll_bars.bar.stiffness must be at least 0 N.m/rad"),
        ('[forces.wind]\non = "bode"\nat.z = "1 m"\nat.x = "0 m"\nforce.y = "1 N"', "forces.wind.on: unknown body 'bode'"),
        ('[forces.wind]\non = "body"\nat.z = "1 m"\nat.x = "0 m"\nforce.y = "1 m"', "forces.wind.force.y unit 'm' cannot"),
        ('[forces.wind]\non = "body"\nat.z = "1 m"\nat.x = "0 m"', "forces.wind.force must name an axis"),
        ('[torques.brake]\non = "rear"', "torques.brake.against must name the body that takes the reaction"),
        ('[torques.brake]\non = "body"', "torques.brake.on: unknown wheelset 'body'"),
        ('[torques.brake]\non = "rear"\nagainst = "frame"', "torques.brake.against: unknown body 'frame'"),
    ],
)  # fmt: skip
def test_elements_that_cannot_be_are_refused_in_one_line(addition: str, says: str) -> None:
    with pytest.raises(ValueError, match="cart") as told:
        read_text(CART + addition, "cart.toml")
    assert str(told.value).startswith(f"cart.toml: {says}")
    assert "\n" not in str(told.value)
