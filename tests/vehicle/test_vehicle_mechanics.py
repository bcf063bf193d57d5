"""What the full vehicle's equations must keep at any state: energy, momentum, and the geometry of contact."""

import casadi as ca
import numpy as np
import pytest

from gyro_cosim.vehicle import car_body
from gyro_cosim.vehicle.alignment import Alignment
from gyro_cosim.vehicle.lrt import lrt_set_a, motion, wheel_load
from gyro_cosim.vehicle.profiles import ntcirw_wheel
from gyro_cosim.vehicle.running_gear import Design, body_state, frame_mass
from gyro_cosim.vehicle.track import Clothoid, Curve, Straight, Stretch, Track
from gyro_cosim.vehicle.trim import rest_state
from gyro_cosim.vehicle.wheel_rail import Wheel, flange_profile, touch, tread_profile

G = 9.81
TWISTED = Track(
    (Straight(30), Clothoid(15), Curve(60, radius=50, cant=0.04), Clothoid(15), Straight(100)),
    gradient=((25.0, 0.0), (60.0, 0.03)),
    stretch=Stretch(10.0, 20.0, 8, {"lateral": 0.004, "vertical": 0.003, "cross_level": 0.002, "gauge": 0.001}),
)


class Inside:
    """Everything `motion` knows, as functions of (x, u, p) of a vehicle with room for TWISTED."""

    def __init__(self) -> None:
        self.design = Design(knots=6)
        self.component = lrt_set_a(knots=6)
        self.s = {
            v.name: ca.SX.sym(v.name) for v in self.component.variables if v.is_state or v.causality in ("input", "parameter")
        }
        found = motion(self.s, self.design)
        self.rates, self.out, self.account = found.derivatives, found.outputs, found.account
        rows = (self.component.states, self.component.inputs, self.component.parameters)
        self.arguments = [ca.vertcat(*(self.s[v.name] for v in row)) for row in rows]
        self.x_dot = ca.vertcat(*(self.rates[v.name] for v in self.component.states))
        values = self.component.start_parameters.copy()
        names = [v.name for v in self.component.parameters]
        pivots = {"pivot_damping": 7e3, "pivot_inertance": 300.0}  # so that their terms are in every balance
        for name, value in (TWISTED.parameters(knots=6) | pivots).items():
            values[names.index(name)] = value
        self.p = values

    def states(self, n: int) -> list[np.ndarray]:
        """Random states of a vehicle in the twisted curve, wheels on the rails or near them, at random speeds."""
        rng = np.random.default_rng(11)
        found = []
        sizes = {
            "distance": 0.3, "lateral_displacement": 4e-3, "vertical_displacement": 4e-5, "yaw_angle": 0.02, "roll_angle": 4e-5,
            "pitch_angle": 0.01, "angle": 0.05, "bogie_rate": 0.2, "spin_deviation": 0.1, "roll_rate": 0.02,
        }  # fmt: skip
        for _ in range(n):
            x = np.zeros(len(self.component.states))
            where = rng.uniform(26.0, 80.0)
            for i, v in enumerate(self.component.states):
                size = next((size for key, size in sizes.items() if v.name.endswith(key)), 0.1)
                x[i] = rng.normal() * size + (where if v.name.endswith("distance") else 0.0)
            found.append(x)
        return found

    def value(self, expression: ca.SX, x: np.ndarray, u: np.ndarray) -> np.ndarray:
        return np.array(ca.Function("f", self.arguments, [expression])(x, u, self.p)).ravel()


@pytest.fixture(scope="module")
def inside() -> Inside:
    return Inside()


def test_energy_is_kept(inside: Inside) -> None:
    """d(kinetic + spring energy)/dt = gravity + drive + mount - dampers - creep - pressing, at random states in a twisted,
    rough, canted curve that climbs. 1e-7 of the largest term: a knot between body and frame costs the track's quadrature that."""
    out, x = inside.account, inside.arguments[0]
    energy_rate = ca.jtimes(out["kinetic_energy"] + out["spring_energy"], x, inside.x_dot)
    terms = ca.vertcat(energy_rate, -out["gravity_power"], -out["drive_power"], -out["mount_power"], out["damper_heat"],
                       out["creep_heat"], out["press_power"])  # fmt: skip
    rng = np.random.default_rng(3)
    for state in inside.states(5):
        values = inside.value(terms, state, rng.normal(size=6) * 500)
        assert abs(values.sum()) < 1e-7 * np.abs(values).max()
        assert values[4] >= 0.0
        assert values[5] >= 0.0


def test_contact_gap_follows_the_wheel(inside: Inside) -> None:
    """The gap of each contact changes by the wheel's motion along its normal: contact point, rail tangent and creepages belong
    together in curve, cant, gradient and unevenness. Of the speed of 5 m/s 2e-4 is left: the slope of the unevenness and the
    angle of the normal are taken as constant over the few mm between the wheel's centre line and its contact."""
    gaps, rates = (ca.vertcat(*column) for column in zip(*inside.account["gaps"], strict=True))
    both = ca.vertcat(-ca.jtimes(gaps, inside.arguments[0], inside.x_dot), rates)
    for state in inside.states(3):
        got, wanted = inside.value(both, state, np.zeros(6)).reshape(2, 8)
        assert np.abs(got - wanted).max() < 2e-4 * 5.0
        assert np.abs(wanted).max() > 0.05


def test_forces_inside_make_no_momentum(inside: Inside) -> None:
    """Lifted off the rails, without drive: momentum and angular momentum of the vehicle change by its weight alone. A lifted
    tread keeps a normal force of 3 mN; knots between body and frame cost 0.1 um of the springs' arms."""
    s, x, x_dot, design = inside.s, inside.arguments[0], inside.x_dot, inside.design
    track = Alignment.of(s, design.knots)
    m_body, h_body = car_body.masses(s)
    m_frame, J = frame_mass(s)
    height = rest_state(s, wheel_load(s), design.law, design.pairing.standing(s, design.grid)).axle_height
    half = s["pivot_spacing"] / 2
    body = body_state(s, "body", 0, h_body)
    here = track.at(body.s)
    angles, rates = ((s[f"front_{k}"], s[f"rear_{k}"]) for k in ("bogie_angle", "bogie_rate"))
    Jxx, Jyy, Jxy, Jzz = car_body.common_inertia(s, angles)
    w = body.omega
    own = ca.vertcat(Jxx * w[0] + Jxy * w[1], Jxy * w[0] + Jyy * w[1], Jzz * w[2] + s["bogie_izz"] * (rates[0] + rates[1]))
    parts = [(m_body, ca.vertcat(0, body.y, body.z), body.v, body.attitude() @ own)]
    for end, offset in (("front", half), ("rear", -half)):
        spins = [inside.out[f"{end}_{side}_spin"] for side in ("left", "right")]
        frame = body_state(s, end, offset, height, (spins[0], spins[1]))
        shift, turned = track.between(body.s, here, frame.s, track.at(frame.s))
        own = ca.vertcat(*J) * frame.omega + ca.vertcat(0, s["wheel_spin_inertia"] * (spins[0] + spins[1]), 0)
        place = shift + turned @ ca.vertcat(0, frame.y, frame.z)
        parts.append((m_frame, place, turned @ frame.v, turned @ frame.attitude() @ own))
    P = sum((m * v for m, _, v, _ in parts), ca.SX.zeros(3))
    L = sum((ca.cross(place, m * v) + own for m, place, v, own in parts), ca.SX.zeros(3))
    fall = -s["gravity"] * here.up()
    weight = sum((m * fall for m, *_ in parts), ca.SX.zeros(3))
    tipping = sum((ca.cross(place, m * fall) for m, place, *_ in parts), ca.SX.zeros(3))
    # written in the body's track frame, which turns and moves along: add turn x P, turn x L and velocity x P
    turn = inside.rates["body_distance"] * here.turn_rate()
    P_dot = ca.jtimes(P, x, x_dot) + ca.cross(turn, P)
    L_dot = ca.jtimes(L, x, x_dot) + ca.cross(turn, L) + ca.cross(ca.vertcat(inside.rates["body_distance"], 0, 0), P)
    f = ca.Function("f", inside.arguments, [P_dot - weight, L_dot - tipping])
    p = inside.p.copy()
    p[[v.name for v in inside.component.parameters].index("drive_on")] = 0.0
    for state in inside.states(3):
        for i, v in enumerate(inside.component.states):
            if v.name.endswith("vertical_displacement"):
                state[i] += 1.0
        P_rate, L_rate = (np.array(v).ravel() for v in f(state, np.zeros(6), p))
        assert np.abs(P_rate).max() < 0.1  # N, of springs and dampers that push with some 10 kN
        assert np.abs(L_rate).max() < 0.5  # N m


def test_explicit_contact_meets_a_search_by_brute_force() -> None:
    """Gap and contact angle of tread and flange against the least gap over a fine grid along the rail: below 0.2 um and
    0.5 mrad at yaw angles up to 0.1 rad, lateral displacements from flange to flange and on the flange's tip."""
    s = {v.name: ca.SX(v.start) for v in lrt_set_a().parameters}
    y, psi, phi = (ca.SX.sym(n) for n in ("y", "psi", "phi"))
    a = ca.vertcat(-ca.sin(psi) * ca.cos(phi), ca.cos(psi) * ca.cos(phi), ca.sin(phi))
    t = ca.vertcat(1, 0, 0)
    H = s["rolling_radius"]
    origin = ca.vertcat(0, y, H)
    wheel = Wheel(
        origin + s["contact_half_distance"] * a, a, origin, ca.SX.zeros(3), ca.SX.zeros(3), 1.0, lambda slip: s["friction"]
    )
    rail = ca.vertcat(-s["contact_half_distance"] * ca.sin(psi), s["contact_half_distance"], 0)
    profile, summit = flange_profile(s)
    corner = rail + ca.vertcat(0, s["corner_offset"], -s["corner_depth"])
    for place, q, R, newton in ((rail, 0, tread_profile(s), 1), (corner, s["corner_radius"], profile, 3)):
        gap, _, slope, _, _ = touch(wheel, place, t, q, R, newton)
        x = ca.SX.sym("x")
        P = place + x * t - wheel.centre
        d = ca.dot(P, a)
        radius, R_slope, _ = R(d)
        along = ca.Function("along", [y, psi, phi, x], [ca.sqrt(ca.dot(P, P) - d * d) - radius, R_slope])
        found = ca.Function("found", [y, psi, phi], [gap, slope])
        grid = np.linspace(-0.15, 0.15, 30001)
        for case in [(0.0, 0.0, 0.0), (0.003, 0.02, 0.0), (-0.0061, -0.05, 0.002), (-0.012, 0.1, -0.01), (-0.02, 0.06, 0.02),
                     (-0.03, 0.03, 0.03)]:  # fmt: skip
            f, slopes = (np.array(v).ravel() for v in along(*(np.tile(c, (1, grid.size)) for c in case), grid[None, :]))
            i = int(np.argmin(f))
            got_gap, got_slope = (float(v) for v in found(*case))
            assert got_gap == pytest.approx(f[i] / np.hypot(1, slopes[i]), abs=2e-7), case
            assert np.arctan(got_slope) == pytest.approx(np.arctan(slopes[i]), abs=5e-4), case
    assert float(summit) > float(s["flange_clearance"] + s["corner_offset"])


def test_flange_in_the_equations_is_the_drawn_profile_grown_by_the_rails_corner() -> None:
    """Every point of the grown flange, cone and tip, is the corner's radius away from the table; 4001 points: 2 um."""
    s = {v.name: ca.SX(v.start) for v in lrt_set_a().parameters}
    grown, summit = flange_profile(s)
    d = ca.SX.sym("d")
    curve = ca.Function("curve", [d], [grown(d)[0] - s["rolling_radius"]])
    drawn = ntcirw_wheel()
    start, end = float(s["flange_clearance"] + s["corner_offset"]), float(summit)
    for at in np.linspace(start + 0.003, end, 12):  # from where the cone is clear of the fillet
        away = np.hypot(drawn.y - at, -drawn.z - float(curve(at)))
        assert away.min() == pytest.approx(float(s["corner_radius"]), abs=2e-6)
    assert drawn.y[np.argmin(drawn.z)] == pytest.approx(end, abs=5e-5)


def test_reported_forces_and_climb_mean_what_they_say() -> None:
    """Y of both wheels makes the pair's force; climb goes from 0 at the clearance to 1 on top of the drawn flange; a flange
    pressed some 2 mm into the rail's spring carries k times that, less 20 um of soft start (the axle's static 35 um: 1 %)."""
    component, drawn = lrt_set_a(), ntcirw_wheel()
    p = {v.name: v.start for v in component.parameters}
    clearance = p["flange_clearance"]
    way = drawn.y[np.argmin(drawn.z)] - clearance - p["corner_offset"]

    def outputs(y: float, z: float) -> dict[str, float]:
        """With the front pair moved by y to the left and by z up: to the right the left flange comes in."""
        moved = {"front_lateral_displacement": y, "front_vertical_displacement": z}
        x = np.array([moved.get(v.name, v.start) for v in component.states])
        values = np.array(component.output(x, component.start_input, component.start_parameters)).ravel()
        return dict(zip((v.name for v in component.outputs), values, strict=True))

    for share in (0.0, 0.5, 1.0):
        found = outputs(-(clearance + share * way), 0.03 * share)
        assert found["front_left_climb"] == pytest.approx(share, abs=2e-3)
        assert found["front_right_climb"] == pytest.approx(-2 * clearance / way - share, abs=2e-3)
        assert found["front_guiding_force"] == pytest.approx(
            found["front_left_lateral_force"] - found["front_right_lateral_force"]
        )
        ratio = found["front_left_lateral_force"] / max(found["front_left_vertical_force"], 100.0)
        assert found["front_left_derailment_coefficient"] == pytest.approx(ratio)

    def rise(d: float) -> float:
        return p["conicity"] * d + p["conicity_gradient"] * d**2 / 2

    sine, cosine = np.sin(p["flange_angle"]), np.cos(p["flange_angle"])
    found = outputs(-(clearance + 2.5e-3), rise(clearance + 2.5e-3) + 1e-3)  # the tread 1 mm off the rail
    depth = 2.5e-3 * sine - (rise(clearance + 2.5e-3) - rise(clearance) + 1e-3) * cosine
    assert found["front_left_flange_force"] == pytest.approx(p["rail_lateral_stiffness"] * depth**2 / (depth + 20e-6), rel=0.01)
    assert found["front_left_contact_angle"] == pytest.approx(p["flange_angle"], abs=1e-6)
    assert found["front_left_lateral_force"] > 0.5 * found["front_left_flange_force"]
    assert found["front_right_flange_force"] == 0.0
