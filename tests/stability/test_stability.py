"""Studies of the linearised vehicle: what stands behind them, and each script run short against stored norms.

The norms in norms are what the scripts wrote: each file holds the command that made it, and is a copy of that command's
file in results/studies/short.
"""

from collections.abc import Callable
from dataclasses import replace
from functools import cache
from pathlib import Path

import numpy as np
import pytest
from scipy.integrate import simpson
from scipy.optimize import linear_sum_assignment

from gyro_cosim import System, system
from gyro_cosim.accuracy.monolith import Monolith
from gyro_cosim.stability import AtRest, Release, measured_root, optimum

ROOT = Path(__file__).parents[2]
RPM = np.pi / 30
ALONG = ("vehicle.*_distance",)
FREE = ("gyro.rotor_speed", "gyro.gimbal_stiffness", "gyro.gimbal_damping", "gyro.spring_arm")


def straight(set_: str) -> System:
    return system("lrt-straight" + ("-b" if set_ == "B" else "")).with_value("vehicle.stretch_lateral", 0.0)


@cache
def over_speed_and_spin(set_: str) -> AtRest:
    return AtRest(straight(set_), ("vehicle.speed", "gyro.rotor_speed"), ALONG)


@cache
def pair() -> AtRest:
    return AtRest(system("wheel-pair"), FREE)


@cache
def pair_release() -> Release:
    return Release(pair(), [{"vehicle.yaw_angle": 0.314}], {"vehicle.yaw_angle": 0.314})


@cache
def set_b_release() -> Release:
    rest = AtRest(straight("B").with_value("vehicle.speed", 8.0), FREE, ALONG)
    return Release(rest, [{"vehicle.front_yaw_angle": 1e-3}], {"vehicle.front_yaw_angle": 1e-3, "vehicle.rear_yaw_angle": 1e-3})


# ---- the linearisation at rest


@pytest.mark.parametrize("set_", ["A", "B"])
def test_vehicle_is_at_rest_at_every_speed_and_spin(set_: str) -> None:
    """The trim depends on the speed; 1e-9 of a metre or radian is rounding of forces of 17 kN against the springs."""
    rest = over_speed_and_spin(set_)
    assert max(rest.rest_error((v, n * RPM)) for v in (0.5, 3.0, 8.0, 50.0, 120.0) for n in (0.0, 2000.0, -4000.0)) < 1e-9


@pytest.mark.parametrize("set_", ["A", "B"])
def test_the_root_that_is_removed_is_the_neutral_one_and_no_other(set_: str) -> None:
    """All roots of the whole matrix are those without the common shift, and zero; to rounding of the largest root."""
    rest = over_speed_and_spin(set_)
    q = (8.0, 2000.0 * RPM)
    whole = np.linalg.eigvals(rest.monolith.matrix(rest.parameters(q)))
    kept = rest.roots(q)
    assert whole.size == kept.size + 1
    distances = np.abs(whole[:, None] - np.append(kept, 0.0)[None, :])
    assert distances[linear_sum_assignment(distances)].max() < 1e-9 * np.abs(whole).max()
    assert np.abs(kept).min() > 0.1


def test_one_name_sets_all_gyros_alike() -> None:
    rest = over_speed_and_spin("B")
    assert rest.monolith.free == ("vehicle.speed", "gyro_front.rotor_speed", "gyro_rear.rotor_speed")
    assert rest.parameters((7.0, 9.0)).tolist() == [7.0, 9.0, 9.0]
    assert rest.q0.tolist() == [50.0, pytest.approx(2000.0 * RPM)]


def test_a_state_of_a_run_is_the_state_of_the_linearisation() -> None:
    """A difference of distances is put into the one of the two that is not the reference."""
    rest = over_speed_and_spin("B")
    starts = rest.starts(np.arange(len(rest.states), dtype=float))
    k = rest.states.index("vehicle.front_distance - vehicle.body_distance")
    assert starts["vehicle.front_distance"] == k
    assert "vehicle.body_distance" not in starts


@pytest.mark.parametrize(
    ("plan", "free", "ignorable", "words"),
    [
        (straight("B"), ("vehicle.speed",), ("vehicle.*_yaw_angle",), r"'vehicle.\*_yaw_angle' must be ignorable: .* changes"),
        (straight("B"), ("vehicle.speed",), ("vehicle.*_miles",), r"ignorable states: 'vehicle.\*_miles'"),
        (straight("B"), ("vehicle.sped",), ALONG, "'vehicle.sped' must be a parameter"),
        (straight("B"), ("tram.speed",), ALONG, "'tram'"),
        (straight("B").with_value("vehicle.curve_turn", 1.0).with_value("vehicle.curve_start", -60.0), (), ALONG,
         "'lrt-straight-b' must be at rest where its states are zero; it is .* away"),
    ],
)  # fmt: skip
def test_refusals_name_what_is_wrong(plan: System, free: tuple[str, ...], ignorable: tuple[str, ...], words: str) -> None:
    with pytest.raises(ValueError, match=words):
        AtRest(plan, free, ignorable)


def test_a_point_must_have_a_value_for_each_parameter() -> None:
    with pytest.raises(ValueError, match=r"`q` must hold a value for each of vehicle.speed, gyro.rotor_speed, got 1"):
        over_speed_and_spin("B").matrix([8.0])


# ---- known limits


def test_without_spin_the_roots_are_those_of_the_vehicle_alone() -> None:
    """At 0 rpm no moment links the gimbals with yaw, only with pitch: slow roots are the same."""
    alone = straight("B")
    alone = replace(alone, components=alone.components[:1], connections=(), bonds=(), exchange=None)
    for v in (2.0, 8.0, 50.0):
        bare = AtRest(alone, ("vehicle.speed",), ALONG).roots((v,))
        both = over_speed_and_spin("B").roots((v, 0.0))
        slow = bare[np.abs(bare) < 3.5]
        assert slow.size >= 4
        assert [np.abs(both - s).min() for s in slow] == pytest.approx([0.0] * slow.size, abs=1e-3)
        assert both[0].real == pytest.approx(bare[0].real, rel=1e-6)


@pytest.mark.parametrize("set_", ["A", "B"])
def test_the_sense_of_the_spin_does_not_matter(set_: str) -> None:
    """The mirror image of the vehicle spins the other way round."""
    rest = over_speed_and_spin(set_)
    for v in (5.0, 30.0):
        assert rest.growth((v, -1500.0 * RPM)) == pytest.approx(rest.growth((v, 1500.0 * RPM)), rel=1e-8)


def test_the_gyro_holds_no_steady_yaw_so_set_a_stays_unstable() -> None:
    """The product of all roots does not depend on the spin (to rounding): none of the two that grow reaches zero on the axis."""
    rest = over_speed_and_spin("A")
    for v in (2.0, 20.0):
        signs, sizes = zip(*(np.linalg.slogdet(rest.matrix((v, n * RPM))) for n in (0.0, 2000.0, 20000.0)), strict=True)
        assert len(set(signs)) == 1
        assert np.ptp(sizes) < 1e-8 * abs(sizes[0])
        assert all((rest.roots((v, n * RPM)).real > 0.0).sum() == 2 for n in (0.0, 2000.0, 20000.0))


def test_slow_yaw_of_set_b_is_a_pendulum_and_spin_adds_inertia_to_it() -> None:
    """omega^2 = K / (I + H^2 / k), K = 2 P g0 (b + g0 r0) with spin below k / c: to 8 % at 8 m/s,
    since the bogie's springs give way and omega is half of k / c."""
    rest = over_speed_and_spin("B")
    K = 2 * 7000 * 9.81 / 4 * 0.45 * (0.7475 + 0.45 * 0.30)
    I = 115.54 + 2 * (25.13 + 600 * 0.7475**2) + 24.03 + 26.45 + 404.7
    k = 1.5 * 86700.0 * 0.3**2
    for rpm in (0.0, 2000.0):
        slow = rest.roots((8.0, rpm * RPM))[0]
        assert abs(slow.imag) == pytest.approx(np.sqrt(K / (I + (22.04 * rpm * RPM) ** 2 / k)), rel=0.08)


def test_vehicle_on_solid_axles_runs_klingels_wave() -> None:
    """2 pi sqrt(b r0 / gamma) at 1 m/s, to 0.1 %."""
    rest = AtRest(straight("A").with_source("vehicle", "lrt_solid_axle"), ("vehicle.speed", "gyro.rotor_speed"), ALONG)
    slow = rest.roots((1.0, 0.0))[0]
    assert abs(slow.imag) == pytest.approx(np.sqrt(0.05 / (0.7475 * 0.3)), rel=1e-3)


def test_on_solid_axles_the_gyro_is_an_added_yaw_inertia() -> None:
    """Klingel's wave at 1 m/s, 0.5 rad/s, is slow against k / c = 4.1 rad/s: the gyro lets it grow as H^2 / k on the frame would,
    1 / k of the gimbal's spring and of the four primary springs on which its moment pitches the frame.
    To 3 %: the gimbal lags by omega c / k, the square of which is 1.5 %."""
    plan = straight("A").with_source("vehicle", "lrt_solid_axle").with_value("vehicle.speed", 1.0)
    H, k = 22.04 * 2000.0 * RPM, 1 / (1 / (2.04 * 86700.0 * 0.3**2) + 1 / (4 * 86700.0 * 0.5**2))
    still, spinning = (AtRest(plan.with_value("gyro.rotor_speed", f"{rpm}rpm"), (), ALONG).growth(()) for rpm in (0, 2000))
    heavy = plan.with_value("gyro.rotor_speed", 0.0).with_value("vehicle.frame_izz", 115.54 + H**2 / k)
    assert spinning - still > 0.0
    assert AtRest(heavy, (), ALONG).growth(()) - still == pytest.approx(spinning - still, rel=0.03)


@pytest.mark.parametrize(
    ("rpm", "root"), [(0.0, 2.40j), (100.0, -0.100 + 1.91j), (200.0, -0.087 + 1.33j), (1000.0, -0.007 + 0.32j)]
)
def test_wheel_pairs_roots_are_the_published_ones(rpm: float, root: complex) -> None:
    """PHYSICS section 2, to its last digit; the lateral ones are -10.91 and -0.72 at any spin."""
    found = pair().roots((rpm * RPM, *pair().q0[1:]))
    for wanted in (root, -10.91, -0.72):
        assert np.abs(found - wanted).min() < 0.007


# ---- gradients


@pytest.mark.parametrize("release", [pair_release, set_b_release])
def test_derivatives_of_the_matrix_equal_differences(release: Callable[[], Release]) -> None:
    """Central differences of 1e-4 of each parameter: 1e-6 of the largest element."""
    rest = release().rest
    for k, (q, exact) in enumerate(zip(rest.q0, rest.derivatives(rest.q0), strict=True)):
        h = 1e-4 * q * np.eye(len(rest.q0))[k]
        difference = (rest.matrix(rest.q0 + h) - rest.matrix(rest.q0 - h)) / (2e-4 * q)
        assert np.abs(difference - exact).max() < 1e-6 * np.abs(exact).max()


def logarithmic(f: Callable[[np.ndarray], float], q: np.ndarray, part: float = 1e-3) -> np.ndarray:
    """q df/dq by differences of fourth order."""
    result = []
    for row in np.eye(q.size):
        at = [f(q * np.exp(n * part * row)) for n in (-2, -1, 1, 2)]
        result.append((at[0] - 8 * at[1] + 8 * at[2] - at[3]) / (12 * part))
    return np.array(result)


@pytest.mark.parametrize("release", [pair_release, set_b_release])
def test_gradient_of_the_cost_equals_differences(release: Callable[[], Release]) -> None:
    """1e-6: what cancels in the differences of a cost known to some 1e-10."""
    r = release()
    J, by_q, by_s = r.gradient(r.rest.q0)
    assert pytest.approx(r.cost(r.rest.q0), rel=1e-12) == J
    np.testing.assert_allclose(by_q * r.rest.q0, logarithmic(r.cost, r.rest.q0), rtol=1e-5, atol=1e-6 * J)
    step = 1e-4
    assert by_s == pytest.approx((r.gradient(r.rest.q0, step)[0] - r.gradient(r.rest.q0, -step)[0]) / (2 * step), rel=1e-5)


@pytest.mark.parametrize("release", [pair_release, set_b_release])
def test_gradient_of_the_smoothed_growth_equals_differences(release: Callable[[], Release]) -> None:
    r = release()
    level = 100.0 * r.cost(r.rest.q0)
    s, slope = r.smoothed_growth(r.rest.q0, level)
    found = logarithmic(lambda q: r.smoothed_growth(q, level)[0], r.rest.q0)
    np.testing.assert_allclose(slope * r.rest.q0, found, rtol=1e-5, atol=1e-5 * abs(s))


def test_a_roots_derivative_equals_differences() -> None:
    rest = set_b_release().rest
    root, vector, slope = rest.mode(rest.q0, rest.roots(rest.q0)[0])
    np.testing.assert_allclose(rest.matrix(rest.q0) @ vector, root * vector, atol=1e-8)
    for part in (np.real, np.imag):
        found = logarithmic(lambda q, part=part: float(part(rest.mode(q, root)[0])), rest.q0)
        np.testing.assert_allclose(part(slope * rest.q0), found, rtol=1e-5, atol=1e-6)


def test_smoothed_growth_comes_down_on_the_slowest_root() -> None:
    r = set_b_release()
    growth = r.rest.growth(r.rest.q0)
    s = [r.smoothed_growth(r.rest.q0, level)[0] for level in (1e2, 1e3, 1e4, 1e5)]
    assert s == sorted(s, reverse=True)
    assert growth < s[-1] < growth + 1e-3


# ---- cost of a release


@pytest.mark.parametrize("until", [3.0, 12.0])
def test_cost_is_that_of_the_released_wheel_pair(until: float) -> None:
    """Simpson's rule over the exact solution every 20 ms: its error is h^4 / 180 of the fourth derivative, some 1e-6."""
    q = (100.0 * RPM, *pair().q0[1:])
    plan = system("wheel-pair").with_value("gyro.rotor_speed", "100rpm").with_value("vehicle.lateral_displacement", 0.0)
    t = np.linspace(0.0, until, round(until / 0.02) + 1)
    psi = Monolith(plan).solve(t)["vehicle.yaw_angle"] / 0.314
    assert pair_release().cost(q, until=until) == pytest.approx(simpson(psi**2, x=t), rel=1e-5)


def test_what_never_comes_to_rest_costs_without_end() -> None:
    r = pair_release()
    still = np.array([0.0, *pair().q0[1:]])
    assert r.cost(still) == np.inf
    assert np.isfinite(r.cost(still, until=5.0))
    J, by_q, _ = r.gradient(still)
    assert np.isinf(J)
    assert np.isnan(by_q).all()


def test_release_refuses_what_it_cannot_measure() -> None:
    with pytest.raises(ValueError, match=r"scale of 'vehicle.yaw_angle' must be positive, got 0"):
        Release(pair(), [], {"vehicle.yaw_angle": 0.0})
    with pytest.raises(ValueError, match=r"state at rest: 'vehicle.yaw'"):
        Release(pair(), [{"vehicle.yaw": 1.0}], {})
    with pytest.raises(ValueError, match="`level` must be positive, got 0 s"):
        pair_release().smoothed_growth(pair().q0, 0.0)
    with pytest.raises(ValueError, match=r"`level` must be one that the releases reach to the right of -0.1\d* 1/s, got 5 s"):
        Release(pair(), [], {"vehicle.yaw_angle": 0.3}).smoothed_growth(pair().q0, 5.0)


def test_optimum_refuses_bounds_that_make_no_sense() -> None:
    good = np.array([0.5, 2.0]) * pair().q0[:, None]
    for row, values, words in (
        (0, (2.0, 1.0), "'gyro.rotor_speed' must be positive, finite and in rising order, got 2 and 1"),
        (3, (0.1, 0.2), "'gyro.spring_arm' must begin within its bounds of 0.1 and 0.2, got 1"),
    ):
        bounds = good.copy()
        bounds[row] = values
        with pytest.raises(ValueError, match=words):
            optimum(pair_release(), bounds)
    with pytest.raises(ValueError, match=r"`bounds` must hold lowest and highest value of each of .*, got shape \(4, 1\)"):
        optimum(pair_release(), good[:, :1])
    with pytest.raises(ValueError, match="`starts` must be at least 1, got 0"):
        optimum(pair_release(), good, starts=0)


def test_optimum_is_a_minimum_inside_and_points_outwards_on_a_bound() -> None:
    """The conditions of Karush, Kuhn and Tucker, to 1e-4 of the cost per e-fold of a parameter."""
    bounds = np.array([(1.0 * RPM, 1000.0 * RPM), (0.0045, 0.018), (6.3e-4, 25.2e-4), (0.03, 1.0)])
    best = optimum(pair_release(), bounds, starts=2)
    assert best.criteria[0] == pytest.approx(best.criteria[1], abs=1e-6)
    assert best.at_bound == ("gyro.gimbal_stiffness lowest", "gyro.gimbal_damping highest")
    J, by_q, _ = pair_release().gradient(best.q)
    slope = by_q * best.q / J
    assert slope[[0, 3]] == pytest.approx([0.0, 0.0], abs=1e-4)
    assert slope[1] > 0.0 > slope[2]


FULL = np.array([(100.0 * RPM, 4000.0 * RPM), (86700.0, 4 * 86700.0), (21000.0, 4 * 21000.0), (0.3, 0.5)])


def test_a_start_that_never_comes_to_rest_does_no_harm() -> None:
    """A third of the way up all bounds the rotors turn at 342 rpm, too slowly for set B at 8 m/s."""
    best = optimum(set_b_release(), FULL, starts=3)
    assert set_b_release().rest.growth(np.exp(np.log(FULL) @ (2 / 3, 1 / 3))) > 0.0
    assert best.criteria[1] == np.inf
    assert best.not_converged == ("start 2: its release never comes to rest",)
    assert best.criterion == min(best.criteria)
    assert best.criteria[2] == pytest.approx(best.criteria[0], abs=1e-6)


def test_growth_has_no_largest_value_to_count() -> None:
    """A low level puts s far above 100 1/s everywhere, and the optimum is still one."""
    bounds = np.array([0.5, 2.0]) * pair().q0[:, None]
    best = optimum(pair_release(), bounds, starts=2, level=1e-3)
    assert best.criterion > 100.0
    assert best.not_converged == ()


def test_optimum_reports_a_search_that_did_not_converge(monkeypatch: pytest.MonkeyPatch) -> None:
    """Stopped after one iteration: the result still counts, and says so."""
    import scipy.optimize

    real = scipy.optimize.minimize
    monkeypatch.setattr(scipy.optimize, "minimize", lambda *args, **kw: real(*args, **kw, options={"maxiter": 1}))
    bounds = np.array([0.5, 2.0]) * pair().q0[:, None]
    best = optimum(pair_release(), bounds, starts=2)
    assert [text.partition(":")[0] for text in best.not_converged] == ["start 1", "start 2"]
    assert "ITERATIONS" in best.not_converged[0].upper()
    assert np.isfinite(best.criterion)


def test_optimum_says_when_nothing_comes_to_rest_and_then_slows_the_growth() -> None:
    rest = AtRest(straight("A").with_value("vehicle.speed", 8.0), FREE, ALONG)
    release = Release(rest, set_b_release().starts, set_b_release().scales)
    with pytest.raises(ValueError, match="the release of system 'lrt-straight' must come to rest at one of the 1 starts"):
        optimum(release, FULL, starts=1)
    assert rest.growth(optimum(release, FULL, starts=1, level=100.0).q) < 0.6 * rest.growth(rest.q0)


# ---- roots seen in time


@pytest.mark.parametrize("root", [-0.3 + 5.0j, 0.2 + 5.0j, -1e-6 + 0.3j])
def test_measured_root_is_the_signals(root: complex) -> None:
    t = np.arange(0.0, 40.0, 0.01)
    found = measured_root(t, ((0.3 - 0.7j) * np.exp(root * t)).real)
    assert found == pytest.approx(root, abs=1e-9)


def test_measured_root_refuses_what_it_cannot_read() -> None:
    t = np.arange(0.0, 4.0, 0.01)
    with pytest.raises(ValueError, match="`y` must change its sign at least three times, it does 0 times"):
        measured_root(t, np.exp(-t))
    with pytest.raises(ValueError, match="`t` must be evenly spaced"):
        measured_root(t**2, np.sin(t))


def test_paths_are_continuous_and_cross_without_changing_hands() -> None:
    """Halving the step along the speed halves the largest jump of a slow root."""
    jumps = []
    for n in (100, 200, 400):
        paths = over_speed_and_spin("B").paths(np.column_stack([np.linspace(1.0, 30.0, n), np.full(n, 2000.0 * RPM)]))
        jumps.append(np.abs(np.diff(paths[:, np.abs(paths).max(axis=0) < 5.0], axis=0)).max())
    assert jumps[1] < 0.75 * jumps[0]
    assert jumps[2] < 0.75 * jumps[1]
