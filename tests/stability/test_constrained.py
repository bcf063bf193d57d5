"""Optimum within bounds and limits: against what can be said by hand."""

import numpy as np
import pytest

from gyro_cosim.stability import Limit, constrained_optimum, pareto_front

BOUNDS = np.array([(0.1, 100.0), (0.1, 100.0)])


def bowl(q: np.ndarray) -> tuple[float, np.ndarray]:
    """Lowest at (30, 2)."""
    return float(np.log(q[0] / 30.0) ** 2 + np.log(q[1] / 2.0) ** 2), 2 * np.log(q / (30.0, 2.0)) / q


def product(q: np.ndarray) -> tuple[float, np.ndarray]:
    return float(np.log(q[0] * q[1])), 1.0 / q


def test_without_limits_the_lowest_place_is_found_across_several_boxes() -> None:
    found = constrained_optimum(bowl, BOUNDS, [np.array([0.2, 90.0])])
    np.testing.assert_allclose(found.q, (30.0, 2.0), rtol=1e-3)
    assert not found.failures


@pytest.mark.parametrize("largest", [1.0, 10.0, 40.0])
def test_a_limit_is_kept_and_lies_at_the_nearest_point(largest: float) -> None:
    """In logarithms the nearest point of a line: both move by half of what log(60) is too large."""
    found = constrained_optimum(
        bowl, BOUNDS, [np.array([1.0, 1.0]), np.array([90.0, 90.0])], [Limit("p", product, np.log(largest))]
    )
    half = np.sqrt(60.0 / largest)
    np.testing.assert_allclose(found.q, (30.0 / half, 2.0 / half), rtol=1e-3)
    assert found.values["p"] == pytest.approx(np.log(largest), abs=1e-5)
    assert found.criterion == pytest.approx(2 * np.log(half) ** 2, rel=1e-3)


def test_bounds_hold_and_what_no_place_keeps_is_infinite() -> None:
    narrow = np.array([(0.1, 5.0), (0.1, 100.0)])
    found = constrained_optimum(bowl, narrow, [np.array([50.0, 1.0])])
    np.testing.assert_allclose(found.q, (5.0, 2.0), rtol=1e-3)
    impossible = constrained_optimum(bowl, BOUNDS, [np.array([1.0, 1.0])], [Limit("p", product, np.log(1e-4))])
    assert impossible.criterion == np.inf


def test_front_falls_as_its_limit_rises_and_is_flat_beyond_the_optimum() -> None:
    values = np.log((1.0, 5.0, 25.0, 100.0))
    front = pareto_front(bowl, BOUNDS, lambda _: [np.array([1.0, 1.0])], [Limit("p", product, 0.0)], values)
    expected = [2 * np.log(max(60.0 / np.exp(value), 1.0) ** 0.5) ** 2 for value in values]
    np.testing.assert_allclose([design.criterion for design in front], expected, rtol=1e-3, atol=1e-6)


def test_bad_questions_are_refused() -> None:
    with pytest.raises(ValueError, match=r"`bounds` must hold.*\[\[2.0, 1.0\]\]"):
        constrained_optimum(bowl, np.array([(2.0, 1.0)]), [np.array([1.0])])
    with pytest.raises(ValueError, match="`starts` must hold at least one"):
        constrained_optimum(bowl, BOUNDS, [])
    with pytest.raises(ValueError, match="`along` must hold rising values"):
        pareto_front(bowl, BOUNDS, lambda _: [], [Limit("p", product, 0.0)], [1.0, 0.5])
