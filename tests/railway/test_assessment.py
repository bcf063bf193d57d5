"""What a run says of a railway vehicle, from signals whose answer is known."""

import numpy as np
import pytest

from gyro_cosim.railway.assessment import assess
from gyro_cosim.railway.field import RAILWAY
from gyro_cosim.trajectory import Trajectory


def made(climb: float, n: int = 4001, stop: float = 4.0) -> Trajectory:
    """10 m/s for 4 s; the left wheel's Y/Q is 0.9 throughout, its flange climbs to `climb` at the end."""
    t = np.linspace(0.0, stop, n)
    signals = {
        "v.body_distance": 10.0 * t,
        "v.front_left_climb": climb * t / stop,
        "v.front_left_derailment_coefficient": np.full(n, -0.9),
        "v.front_right_climb": np.zeros(n),
        "v.front_right_derailment_coefficient": np.zeros(n),
        "v.front_lateral_displacement": 5e-3 * np.exp(-t),
        "v.front_yaw_angle": -2e-3 * np.exp(-t),
        "other.body_distance": t,  # no wheels: no vehicle
    }
    return Trajectory(t, tuple(signals), ("",) * len(signals), np.column_stack(list(signals.values())))


def test_a_vehicle_is_known_by_its_signals_and_judged_by_them() -> None:
    (found,) = assess(made(0.5))
    assert (found.vehicle, found.wheels, found.pairs) == ("v", ("front_left", "front_right"), ("front",))
    assert not found.verdict.derailed
    assert found.worst is not None
    assert found.worst.wheel == "front_left"
    assert found.worst.value == pytest.approx(0.9, rel=1e-6)
    assert found.worst.exceeded
    assert found.lateral["front"] == pytest.approx((5e-3, 5e-3 * np.exp(-3.6)), rel=1e-3)
    assert found.yaw["front"][0] == pytest.approx(2e-3)


def test_a_flange_over_the_rail_is_a_derailment_with_its_place() -> None:
    (found,) = assess(made(2.0))
    assert found.verdict.derailed
    assert found.verdict.wheel == "front_left"
    assert found.verdict.distance == pytest.approx(20.0, abs=0.02)


def test_too_few_points_for_the_filter_leave_the_coefficient_open() -> None:
    (found,) = assess(made(0.5, n=150))
    assert found.worst is None


def test_a_run_without_a_vehicle_says_nothing() -> None:
    t = np.linspace(0, 1, 200)
    assert assess(Trajectory(t, ("a.x",), ("m",), t[:, None])) == ()


def test_what_is_asked_of_a_vehicle_is_known_from_names_and_answered_from_a_run() -> None:
    names = made(0.5).names
    assert RAILWAY.questions(names) == ["v: derailed", "v: Y/Q within its limit"]
    assert RAILWAY.starts(names) == {"v.front_lateral_displacement": "1mm"}
    assert not RAILWAY.questions(("other.body_distance",))
    (found,) = assess(made(0.5))
    assert RAILWAY.measures(found) == {
        "v: largest Y/Q": (pytest.approx(0.9, rel=1e-6), "1"),
        "v: distance to derailment, of the flange's way over the rail": (pytest.approx(0.5), "1"),
    }
    assert not RAILWAY.starts(("other.body_distance",))
    answers = [RAILWAY.answers(found) for run in (made(0.5), made(2.0), made(0.5, n=150)) for found in assess(run)]
    assert [one["v: derailed"] for one in answers] == ["no", "yes", "no"]
    assert [one.get("v: Y/Q within its limit") for one in answers] == ["no", "no", None]
