"""Linearised vehicles against textbook formulas: Klingel's wave, the critical speed, the divergence by spin inertia, the step."""

import casadi as ca
import numpy as np
import pytest
from joined import Joined

from gyro_cosim.gyro_unit.nonlinear import nonlinear_full
from gyro_cosim.vehicle.lrt import lrt_set_a
from gyro_cosim.vehicle.parameter_sets import parameter_set
from gyro_cosim.vehicle.variants import lrt_solid_axle
from gyro_cosim.vehicle.wheelset import sprung_wheelset


class Linear:
    """Eigenvalues of a vehicle about its rest state, as a function of parameters."""

    def __init__(self, joined: Joined) -> None:
        self.joined = joined
        x, p = ca.SX.sym("x", joined.x0.size), ca.SX.sym("p", joined.p({}).size)
        self.jacobian = ca.Function("J", [x, p], [ca.jacobian(joined.f(x, p), x)])

    def eigenvalues(self, **values: float) -> np.ndarray:
        """In order of falling real part; distances run are neutral and left out."""
        e = np.linalg.eigvals(np.array(self.jacobian(self.joined.x0, self.joined.p(values))))
        e = e[np.abs(e) > 1e-6]
        return e[np.argsort(-e.real)]

    def value(self, name: str, **values: float) -> float:
        return float(self.joined.p(values)[self.joined.parameter_names.index(name)])


@pytest.fixture(scope="module")
def vehicle() -> Linear:
    return Linear(Joined(lrt_set_a()))


@pytest.fixture(scope="module")
def damped() -> Linear:
    return Linear(Joined(lrt_set_a(), {"front": nonlinear_full(), "rear": nonlinear_full()}))


@pytest.fixture(scope="module")
def conventional() -> Linear:
    return Linear(Joined(sprung_wheelset()))


def creep(linear: Linear, load: float, **values: float) -> dict[str, float]:
    """Kalker's f11, f22, f23, f33 of a tread under `load`, patch by Hertz for mean curvature."""
    E, nu, r0, crown = (
        linear.value(n, **values) for n in ("youngs_modulus", "poisson_ratio", "rolling_radius", "rail_crown_radius")
    )
    radius = 2 / (1 / r0 + 1 / crown)
    ab = radius * (load / (4 / 3 * E / (2 * (1 - nu**2)) * radius**0.5)) ** (2 / 3)
    G = E / (2 * (1 + nu))
    C = {i: linear.value(f"kalker_c{i}", **values) for i in (11, 22, 23, 33)}
    return {"f11": G * ab * C[11], "f22": G * ab * C[22], "f23": G * ab**1.5 * C[23], "f33": G * ab**2 * C[33]}


def test_free_wheelset_runs_klingels_wave(conventional: Linear) -> None:
    """Slow and without springs: 2 pi sqrt(b r0 / gamma), to 0.05 % (spin creep and inertia at 1 m/s)."""
    e = conventional.eigenvalues(speed=1.0, guide_stiffness_x=0.0, guide_stiffness_y=0.0)
    wave = next(v for v in e if 0.01 < v.imag < 50.0)
    b, r0, gamma = (conventional.value(n) for n in ("contact_half_distance", "rolling_radius", "conicity"))
    assert 2 * np.pi * 1.0 / wave.imag == pytest.approx(2 * np.pi * np.sqrt(b * r0 / gamma), rel=5e-4)


def test_free_wheelset_hunts_the_more_the_faster(conventional: Linear) -> None:
    growth = [max(v.real for v in conventional.eigenvalues(speed=v, guide_stiffness_x=0.0, guide_stiffness_y=0.0) if v.imag > 1.0)
              for v in (5.0, 10.0, 20.0, 40.0)]  # fmt: skip
    assert growth == sorted(growth)
    assert growth[0] > 0.0


def textbook(v: float, linear: Linear) -> np.ndarray:
    """Eigenvalues of the textbook's wheelset with spin creep and gravity: y, psi and their rates (Wickens 2003)."""
    g = linear.value
    P = g("axle_load") / 2
    f = creep(linear, P)
    b, r0, gamma, m, I = (g(n) for n in ("contact_half_distance", "rolling_radius", "conicity", "wheelset_mass", "wheelset_izz"))
    kx, ky, l2 = g("guide_stiffness_x"), g("guide_stiffness_y"), g("guide_half_spacing") ** 2
    M = np.diag([m, I])
    C = np.array([[2 * f["f22"] / v, 2 * f["f23"] / v], [-2 * f["f23"] / v, (2 * f["f11"] * b**2 + 2 * f["f33"]) / v]])
    K = np.array([[2 * ky, -2 * f["f22"]], [2 * f["f11"] * b * gamma / r0, 2 * kx * l2 + 2 * f["f23"] - 2 * P * gamma * b]])
    return np.linalg.eigvals(np.block([[np.zeros((2, 2)), np.eye(2)], [-np.linalg.solve(M, K), -np.linalg.solve(M, C)]]))


def test_sprung_wheelset_has_the_textbooks_critical_speed(conventional: Linear) -> None:
    """The speed at which the hunting root crosses: 3 % for roll, gyroscopic terms and gravity's lateral part left out there."""

    def critical(growth: object) -> float:
        low, high = 5.0, 100.0
        for _ in range(30):
            middle = (low + high) / 2
            low, high = (low, middle) if growth(middle) > 0.0 else (middle, high)  # type: ignore[operator]
        return low

    found = critical(lambda v: max(e.real for e in conventional.eigenvalues(speed=v) if e.imag > 1.0))
    assert found == pytest.approx(critical(lambda v: max(e.real for e in textbook(v, conventional) if e.imag > 1.0)), rel=0.03)
    assert 20.0 < found < 40.0


def test_vehicle_on_solid_axles_hunts_along_klingels_wave() -> None:
    """The bogies turn freely about their pivots, so the wheelsets behave as free ones: Klingel's wave, growing at any speed."""
    linear = Linear(Joined(lrt_solid_axle()))
    b, r0, gamma = (linear.value(n) for n in ("contact_half_distance", "rolling_radius", "conicity"))
    waves = [next(e for e in linear.eigenvalues(speed=v) if 0.1 < e.imag < 15.0) for v in (2.0, 5.0, 10.0, 20.0)]
    assert 2 * np.pi * 2.0 / waves[0].imag == pytest.approx(2 * np.pi * np.sqrt(b * r0 / gamma), rel=1e-3)
    growth = [wave.real for wave in waves]
    assert growth == sorted(growth)
    assert growth[0] > 0.0


def reduced(linear: Linear, v: float, **values: float) -> np.ndarray:
    """Roots of a wheel pair whose free wheels must spin up as it moves sideways; derivation:

    Quasi-static lateral motion y' = v psi - L y, L = k_y v / (2 f22). A wheel at radius r0 -+ g0 y without slip along the rail
    has W' = (-+ b psi'' +- v g0 y' / r0) / r0; its force I_y W' / r0 and the spin momentum 2 I_y v / r0 tilted by -g0 y / b give

        I psi'' + (2 f33 / v) psi' + K psi = B g0 v y' + c y,    B = 2 I_y (b / r0^3 + 1 / (r0 b))
        I = frame + bogie + 2 I_y b^2 / r0^2
        K = 2 P g0 (b + g0 r0),   k_y = 2 (P - f23 / r0) g1 (1 - g r0)^2 - 4 P g,  g = g0 / (b + g0 r0)
        c = 2 f33 g1 / r0 (1 - 2 b g0 / r0) - f23 k_y / f22        spin moments, less what the free wheels turn into torque
    """
    r0, b, g0, g1, I_y = (linear.value(n, **values) for n in ("rolling_radius", "contact_half_distance", "conicity",
                                                              "conicity_gradient", "wheel_spin_inertia"))  # fmt: skip
    P = 7000 * 9.81 / 4
    f = creep(linear, P, **values)
    g = g0 / (b + g0 * r0)
    k_y = 2 * (P - f["f23"] / r0) * g1 * (1 - g * r0) ** 2 - 4 * P * g
    K, B, L, D = 2 * P * g0 * (b + g0 * r0), 2 * I_y * (b / r0**3 + 1 / (r0 * b)), k_y * v / (2 * f["f22"]), 2 * f["f33"] / v
    c = 2 * f["f33"] * g1 / r0 * (1 - 2 * b * g0 / r0) - f["f23"] * k_y / f["f22"]
    frame = 115.54 + 2 * (25.13 + 600 * b**2) + 24.03 + 26.45
    I = frame + 404.7 + 2 * I_y * b**2 / r0**2
    roots = np.roots([I, I * L + D, K + D * L - B * g0 * v**2, K * L - c * v])
    return roots[np.argsort(-roots.real)]


@pytest.mark.parametrize(("g0", "g1"), [(0.05, 10.0), (0.1, 5.0), (0.2, 5.0)])
def test_spin_inertia_makes_negative_conicity_diverge(vehicle: Linear, g0: float, g1: float) -> None:
    """Without spin creep: growth within 6 % (and 0.005 / s) of the formula; a real root, divergence, when fast."""
    values = {"conicity": g0, "conicity_gradient": g1, "rolling_radius": 0.3, "kalker_c23": 0.0, "kalker_c33": 0.0}
    for v in (3.0, 5.0, 8.0, 12.0, 20.0):
        full, formula = vehicle.eigenvalues(speed=v, **values)[0], reduced(vehicle, v, **values)[0]
        assert full.real == pytest.approx(formula.real, rel=0.06, abs=0.005), v
        if v != 5.0:  # there the two roots are about to meet, and nothing is as sensitive as how far they are apart
            assert abs(full.imag) == pytest.approx(abs(formula.imag), rel=0.01), v
    assert vehicle.eigenvalues(speed=20.0, **values)[0].imag == 0.0


def test_spin_inertias_growth_is_that_of_the_formula_with_spin_creep_too(vehicle: Linear) -> None:
    """Set A, where the spin moments rule the slow growth: 4 %."""
    for v in (1.0, 3.0, 5.0, 8.0, 12.0, 20.0):
        full, formula = vehicle.eigenvalues(speed=v)[0], reduced(vehicle, v)[0]
        assert full == pytest.approx(formula, rel=0.05), v


def test_without_spin_inertia_nothing_diverges_and_with_the_gyro_all_is_damped(vehicle: Linear, damped: Linear) -> None:
    """Set B at 8 m/s: off a slow oscillation without damping, on every root to the left."""
    B = parameter_set("B")
    values = B.vehicle | {"speed": 8.0}
    off = vehicle.eigenvalues(**values)
    assert 0.0 < off[0].real < 0.1
    assert abs(off[0].imag) > 1.0
    on = damped.eigenvalues(**values, **{f"unit.{n}": v for n, v in B.gyro.items()})
    assert on[0].real < -0.05


def test_gyro_lowers_the_divergence_only_in_part(vehicle: Linear, damped: Linear) -> None:
    for v in (5.0, 8.0, 20.0):
        off, on = vehicle.eigenvalues(speed=v)[0].real, damped.eigenvalues(speed=v)[0].real
        assert 0.5 * off < on < off


def test_root_locus_of_the_spin_begins_at_the_vehicle_without_gyro(vehicle: Linear, damped: Linear) -> None:
    """At 0 rpm the unit's own two roots are those of the sprung gimbal, and the vehicle's are hardly touched."""
    still = damped.eigenvalues(speed=8.0, **{"unit.rotor_speed": 0.0})
    assert still[0] == pytest.approx(vehicle.eigenvalues(speed=8.0)[0], rel=1e-3)
    growth = [
        damped.eigenvalues(speed=8.0, **{"unit.rotor_speed": rpm * np.pi / 30})[0].real for rpm in (0, 500, 1000, 2000, 3000)
    ]
    assert growth == sorted(growth, reverse=True)


def test_reversed_conicity_reverses_the_yaw_mode(vehicle: Linear) -> None:
    """g0 < 0, no spin inertia's speed: the restoring yaw moment turns against the pair (a real growing root)."""
    values = {"kalker_c23": 0.0, "kalker_c33": 0.0, "speed": 1.0}
    assert vehicle.eigenvalues(conicity=0.2, **values)[0].real < 0.05
    assert vehicle.eigenvalues(conicity=-0.2, **values)[0].real > 1.0


@pytest.mark.parametrize("speed", [0.5, 2.0, 8.0, 50.0])
def test_longest_step_is_six_sevenths_of_the_stability_limit(vehicle: Linear, speed: float) -> None:
    """The classical method bears 2.785 over the fastest decay."""
    component = lrt_set_a({"speed": speed})
    limit = 2.785 / -vehicle.eigenvalues(speed=speed).real.min()
    longest = float(component.longest_step(component.start_state, component.start_input, component.start_parameters))
    assert longest == pytest.approx(0.86 * limit, rel=0.03)


def test_vehicle_is_stable_at_half_a_metre_per_second() -> None:
    """A tenth of a second at 0.5 m/s with 0.5 ms as the internal step: the step is cut, the creepages die out, none chatters."""
    component = lrt_set_a({"speed": 0.5})
    names = [v.name for v in component.states]
    x, p, U = component.start_state, component.start_parameters, np.zeros((6, 3))
    x[names.index("front_left_spin_deviation")] = 0.05
    for _ in range(200):
        x = np.array(component.step(x, U, p, 0.0, component.internal_step)).ravel()
    y = dict(zip((v.name for v in component.outputs), np.array(component.output(x, U[:, 0], p)).ravel(), strict=True))
    assert np.all(np.isfinite(x))
    for wheel in ("front_left", "front_right", "rear_left", "rear_right"):
        assert abs(y[f"{wheel}_longitudinal_creepage"]) < 1e-4
