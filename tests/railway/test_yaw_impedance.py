"""The gyro unit as an impedance against yaw, and what it does to the hunting of a solid wheelset."""

from collections.abc import Callable
from dataclasses import replace
from typing import Any

import casadi as ca
import numpy as np
import pytest
from scipy.optimize import brentq

from gyro_cosim import Connection, System, SystemComponent
from gyro_cosim.railway.yaw_impedance import (
    SprungWheelset,
    critical_point,
    equivalent,
    impedance,
    root_shift,
    roots,
    stiffest_spring,
)
from gyro_cosim.railway.yaw_stability import Gimbal
from gyro_cosim.stability import AtRest
from gyro_cosim.systems import catalogue
from gyro_cosim.vehicle.reduction import wheelset_values

RPM = np.pi / 30
PAPER = Gimbal(22.04 * 2000 * RPM, 26.45, 2.04 * 21000.0 * 0.09, 2.04 * 86700.0 * 0.09)
WHEELSET = SprungWheelset(1400.0, 800.0, 173400.0, 84966.0, 1.5e7, 9e6, 1.7e6)


def random_wheelset(rng: np.random.Generator) -> SprungWheelset:
    return SprungWheelset(*(value * np.exp(rng.normal(0.0, 0.5)) for value in vars(WHEELSET).values()))


def random_gimbal(rng: np.random.Generator) -> Gimbal:
    return Gimbal(*np.exp(rng.normal(np.log([3000.0, 26.0, 1000.0, 3000.0]), [1.0, 0.5, 1.5, 1.5])))


def test_far_below_the_springs_rate_the_unit_is_an_inertia() -> None:
    w = 1e-3 * PAPER.stiffness / PAPER.damping
    seen = equivalent(PAPER, w)
    assert seen.inertia == pytest.approx(PAPER.momentum**2 / PAPER.stiffness, rel=1e-5)
    assert seen.damping < 2e-3 * seen.inertia * w


def test_between_the_rates_it_is_a_damper() -> None:
    unit = replace(PAPER, damping=1e5)  # k / c = 0.16, c / A = 3781 rad/s; sqrt(k / A) = 24.5, where the inertia vanishes
    seen = equivalent(unit, np.sqrt(unit.stiffness / unit.inertia))
    assert seen.damping == pytest.approx(unit.momentum**2 / unit.damping, rel=1e-12)
    assert abs(seen.inertia) < 1e-9 * seen.damping
    for w in (2.0, 300.0):
        assert equivalent(unit, w).damping == pytest.approx(unit.momentum**2 / unit.damping, rel=0.01)


def test_far_above_the_gimbals_frequency_it_is_a_spring() -> None:
    w = 1e3 * PAPER.damping / PAPER.inertia
    assert -(w**2) * equivalent(PAPER, w).inertia == pytest.approx(PAPER.momentum**2 / PAPER.inertia, rel=1e-5)


def test_the_inertia_changes_sign_at_the_gimbals_own_frequency_and_damping_never_does() -> None:
    rng = np.random.default_rng(1)
    for _ in range(300):
        unit, w = random_gimbal(rng), float(np.exp(rng.normal(2.0, 2.0)))
        seen = equivalent(unit, w)
        assert seen.damping > 0.0
        assert (seen.inertia > 0.0) == (w**2 < unit.stiffness / unit.inertia)


@pytest.mark.parametrize("variant", ["linear_full", "nonlinear_full", "twin_full", "lateral_full"])
def test_every_horizontal_spin_axis_has_this_impedance(variant: str) -> None:
    """The component's transfer function from yaw rate to yaw moment, from its own equations at rest; 1e-12 is rounding."""
    unit = catalogue.component(f"gyro_unit:{variant}")
    x, u, p = ca.SX.sym("x", 2), ca.SX.sym("u", 3), unit.start_parameters
    at = ca.Function("at", [x, u], [ca.jacobian(f, z) for f in (unit.rhs(x, u, p), unit.output(x, u, p)) for z in (x, u)])
    A, B, C, D = (np.array(block) for block in at(np.zeros(2), np.zeros(3)))
    rate = [v.name for v in unit.inputs].index("yaw_rate")
    moment = [v.name for v in unit.outputs].index("yaw_moment")
    values = dict(zip((v.name for v in unit.parameters), p, strict=True))
    k, c = (values[f"gimbal_{kind}"] * values["spring_arm"] ** 2 for kind in ("stiffness", "damping"))
    gimbal = Gimbal(values["rotor_inertia"] * values["rotor_speed"], values["gimbal_inertia"], c, k)
    for s in (0.5j, 5j, 50j, 1.0 + 7j):
        transfer = C[moment] @ np.linalg.solve(s * np.eye(2) - A, B[:, rate]) + D[moment, rate]
        assert transfer == pytest.approx(-impedance(gimbal, s), rel=1e-12)


def test_critical_point_is_where_a_root_crosses() -> None:
    rng = np.random.default_rng(2)
    for _ in range(200):
        wheelset = random_wheelset(rng)
        v, w = critical_point(wheelset)
        first = roots(wheelset, v)[0]
        assert abs(first.real) < 1e-9 * w
        assert abs(first.imag) == pytest.approx(w, rel=1e-9)
        assert roots(wheelset, 0.99 * v)[0].real < 0.0 < roots(wheelset, 1.01 * v)[0].real


def test_roots_with_a_unit_are_those_of_the_equations() -> None:
    """State space y, y', psi, psi', eta, eta' against the polynomial."""
    rng = np.random.default_rng(3)
    for _ in range(50):
        w, g, v = random_wheelset(rng), random_gimbal(rng), float(rng.uniform(2.0, 60.0))
        A = np.zeros((6, 6))
        A[0, 1] = A[2, 3] = A[4, 5] = 1.0
        A[1, :3] = np.array([-w.lateral_stiffness, -w.lateral_creep / v, w.lateral_creep]) / w.mass
        A[3, [0, 2, 3, 5]] = np.array([-w.steering, -w.yaw_stiffness, -w.yaw_creep / v, g.momentum]) / w.yaw_inertia
        A[5, 3:] = np.array([-g.momentum, -g.stiffness, -g.damping]) / g.inertia
        found = roots(w, v, g)
        size = np.abs(found).max()
        for s in np.linalg.eigvals(A):
            assert np.abs(found - s).min() < 1e-6 * size


def test_shift_of_a_root_is_the_formulas_for_a_weak_unit() -> None:
    rng = np.random.default_rng(4)
    for _ in range(50):
        wheelset, gimbal = random_wheelset(rng), random_gimbal(rng)
        v, _ = critical_point(wheelset)
        root = roots(wheelset, v)[0]
        shift = root_shift(wheelset, v, root, gimbal)
        weak = replace(gimbal, momentum=gimbal.momentum * np.sqrt(1e-5 * abs(root) / abs(shift)))
        moved = roots(wheelset, v, weak)
        ds = moved[np.abs(moved - root).argmin()] - root
        assert ds == pytest.approx(root_shift(wheelset, v, root, weak), rel=1e-2)


def raised(growth: Callable[[float], float], v: float) -> float:
    """By how much the critical speed near v lies higher, relative."""
    return brentq(growth, 0.97 * v, 1.03 * v, xtol=1e-12 * v) / v - 1.0


def test_a_weak_unit_raises_the_critical_speed_if_and_only_if_its_spring_is_below_the_stiffest() -> None:
    """Condition (8) against the roots, 0.5 % on either side, and where the hunting root is the only one that may cross."""
    rng = np.random.default_rng(5)
    tried = 0
    while tried < 100:
        wheelset, gimbal = random_wheelset(rng), random_gimbal(rng)
        v, w = critical_point(wheelset)
        limit = stiffest_spring(wheelset, gimbal)
        if not limit > 0.0 or gimbal.damping < 0.02 * np.sqrt(gimbal.inertia * limit):  # a resonance is no weak unit
            continue
        for factor, sign in ((0.995, 1.0), (1.005, -1.0)):
            unit = replace(gimbal, stiffness=limit * factor)
            root = roots(wheelset, v)[0]
            weak = replace(unit, momentum=unit.momentum * np.sqrt(1e-5 * w / abs(root_shift(wheelset, v, root, unit))))
            assert np.sign(-root_shift(wheelset, v, root, weak).real) == sign
            assert np.sign(raised(lambda u, g=weak, x=wheelset: float(roots(x, u, g)[0].real), v)) == sign  # type: ignore[misc]
        tried += 1


def test_a_spring_raises_and_an_inertia_lowers() -> None:
    """The two ends: a gimbal with next to no spring and damper, and the paper's with ten times the stiffest spring."""
    v, _ = critical_point(WHEELSET)
    stiff = 10.0 * stiffest_spring(WHEELSET, PAPER)
    for unit, sign in ((Gimbal(300.0, 26.45, 10.0, 10.0), 1.0), (replace(PAPER, momentum=1000.0, stiffness=stiff), -1.0)):
        assert np.sign(raised(lambda u, g=unit: float(roots(WHEELSET, u, g)[0].real), v)) == sign  # type: ignore[misc]


@pytest.fixture(scope="module")
def model() -> AtRest:
    """The wheelset of the multibody model with the gyro unit."""
    pairs = (("vehicle", "yaw_rate"), ("gyro", "yaw_rate")), (("gyro", "yaw_moment"), ("vehicle", "yaw_moment"))
    plan = System(
        "wheelset",
        (SystemComponent("vehicle", "vehicle:wheelset"), SystemComponent("gyro", "gyro_unit:linear_full")),
        tuple(Connection(*pair) for pair in pairs),
    )
    free = ("vehicle.speed", *(f"gyro.{name}" for name in ("rotor_speed", "gimbal_damping", "gimbal_stiffness")))
    return AtRest(plan, free, ignorable=("vehicle.distance",))


def test_the_multibody_wheelset_obeys_the_condition(model: AtRest) -> None:
    """Its critical speed rises with a weak unit (100 rpm) at 0.9 of the stiffest spring, and falls at 1.1 of it; the 10 %
    are for gravity, spin creep and roll, which the condition leaves out. With the paper's damper and a hundredth of it."""
    wheelset = of_the_component()
    arm = 0.3**2
    for c in (42840.0, 428.4):
        limit = stiffest_spring(wheelset, replace(PAPER, damping=c * arm)) / arm
        alone = brentq(lambda v, c=c: model.growth((v, 0.0, c, 1e5)), 15.0, 40.0, xtol=1e-9)  # type: ignore[misc]
        change = [raised(lambda v, c=c, k=limit * f: model.growth((v, 100 * RPM, c, k)), alone) for f in (0.9, 1.1)]  # type: ignore[misc]
        assert change[0] > 0.0 > change[1], c


def of_the_component() -> SprungWheelset:
    return SprungWheelset(**wheelset_values({}))


@pytest.mark.parametrize(("make", "message"), [
    (lambda: replace(WHEELSET, mass=0.0), "mass must be above 0, got 0"),
    (lambda: replace(WHEELSET, yaw_stiffness=-1.0), "yaw_stiffness must be at least 0, got -1"),
    (lambda: replace(WHEELSET, steering=np.nan), "steering must be finite, got nan"),
    (lambda: critical_point(replace(WHEELSET, yaw_stiffness=0.0, lateral_stiffness=0.0)), "must not both be 0"),
    (lambda: critical_point(replace(WHEELSET, steering=1e-6)), "steering must be large enough"),
    (lambda: equivalent(PAPER, 0.0), "frequency must be above 0, got 0"),
    (lambda: roots(WHEELSET, 0.0), "speed must be above 0, got 0"),
])  # fmt: skip
def test_refusals(make: Any, message: str) -> None:
    with pytest.raises(ValueError, match=message):
        make()
