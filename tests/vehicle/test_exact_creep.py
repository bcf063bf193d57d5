"""The exact theory of rolling contact: the oracle against published values and limits, the creep laws against the oracle."""

import math
from dataclasses import replace

import casadi as ca
import numpy as np
import pytest
from exact_creep import POISSON, RATIOS, Exact, directions, read, scaled, solver_creepages
from rolling_contact import HalfSpace, exact, rigid

from gyro_cosim.vehicle.creep_laws import Patch, fastsim, half_space, linear, polach, shen_hedrick_elkins
from gyro_cosim.vehicle.kalker import Coefficients, coefficients

AXIS, LOAD, FRICTION, SHEAR = 3.2e-3, 17.2e3, 0.3, 8.2e10  # m, N, 1, Pa; the errors do not depend on them
UNIT = np.array([1.0, 1.0, AXIS])


@pytest.fixture(scope="module")
def stored() -> Exact:
    return read()


def solved(ratio: float, poisson: float, creepages: tuple[float, float, float], n: int = 10) -> np.ndarray:
    return exact(HalfSpace(ratio, poisson, n), HalfSpace(ratio, poisson, 2 * n), np.array(creepages))[0]


def physical(
    a: float, b: float, N: float, mu: float, G: float, poisson: float, creepages: tuple[float, float, float]
) -> np.ndarray:
    """Fx / (mu N), Fy / (mu N), Mz in N m for creepages with spin in 1/m."""
    middle = math.sqrt(a * b)
    strength = G / (1.5 * mu * N / (math.pi * a * b))
    xi, eta, phi = creepages
    return solved(a / b, poisson, (xi * strength, eta * strength, phi * middle * strength)) * [1.0, 1.0, mu * N * middle]


@pytest.mark.parametrize("ratio", [0.3, 1.0, 1 / 0.3])
def test_small_creepages_give_kalkers_table(ratio: float) -> None:
    """Kalker 1967 prints three digits; 24 x 24 cells, extrapolated, are good to 3 %."""
    small = 1e-4
    C = coefficients(ratio, 1.0, 0.25)
    grids = HalfSpace(ratio, 0.25, 12), HalfSpace(ratio, 0.25, 24)
    along, across, turning = (exact(*grids, small * unit)[0] * (-2 * math.pi / 3 / small) for unit in np.eye(3))
    assert along[0] == pytest.approx(float(C.C11), rel=0.02)
    assert across[1] == pytest.approx(float(C.C22), rel=0.02)
    assert turning[1] == pytest.approx(float(C.C23), rel=0.03)
    assert -across[2] == pytest.approx(float(C.C23), rel=0.025)
    assert turning[2] == pytest.approx(float(C.C33), rel=0.02)


@pytest.mark.parametrize(("xi", "published"), [(0.0005, 0.3175), (0.001, 0.5656), (0.002, 0.8770)])
def test_longitudinal_creepage_gives_the_half_space_values(xi: float, published: float) -> None:
    """Values of another half-space solver for the circle of 3.225 mm under 17.2 kN; they carry a per cent of their cells."""
    G = 2.1e11 / 2.6
    force = physical(3.225e-3, 3.225e-3, 17.2e3, 0.3, G, 0.3, (xi, 0.0, 0.0))
    assert -force[0] == pytest.approx(published, abs=0.01)
    assert abs(force[1:]).max() < 1e-9


def test_spin_and_lateral_creepage_give_contacts_example() -> None:
    """The example `fastsim` of CONTACT: semi-axes 8 and 4 mm, 82 kN, 40 x 40 cells. Its slip is taken upstream of ours, which
    costs it 0.016 at that size, as the same scheme of ours shows; ours is good to 0.01."""
    force = physical(8e-3, 4e-3, 82e3, 0.3, 82e9, 0.28, (0.0, -6.25e-4, 0.625))
    assert -force[1] == pytest.approx(0.6074, abs=0.03)
    assert -force[2] == pytest.approx(48.21, rel=0.03)


def test_large_creepage_is_rigid_sliding() -> None:
    """Nothing elastic is left but near the pole of the slip, whose share falls with the creepage."""
    for creepages in ((30.0, 40.0, 0.0), (0.0, 60.0, 80.0), (50.0, -20.0, 60.0)):
        assert solved(2.0, POISSON, creepages) == pytest.approx(rigid(np.array(creepages), 2.0), abs=0.02)


def test_rigid_spin_has_its_moment_in_closed_form() -> None:
    """Pressure times distance over the circle: 3 pi / 16 of mu N a."""
    assert rigid(np.array([0.0, 0.0, 1.0]), 1.0) == pytest.approx([0.0, 0.0, -3 * math.pi / 16], abs=1e-5)


def test_forces_mirror_with_the_creepages() -> None:
    grids = HalfSpace(0.5, POISSON, 6), HalfSpace(0.5, POISSON, 12)
    here, turned, mirrored = (
        exact(*grids, np.array([2.0, 1.5, s]) * sign)[0] for s, sign in ((1.0, 1), (1.0, -1), (-1.0, (1, -1, 1)))
    )
    assert turned == pytest.approx(-here, abs=1e-6)
    assert mirrored == pytest.approx(here * [1, -1, -1], abs=1e-6)


def test_the_tractions_keep_coulombs_law() -> None:
    patch = HalfSpace(1.0, POISSON, 12)
    solution = patch.solve(np.array([0.4, 0.2, 0.3]))
    size = np.hypot(*solution.traction)
    assert solution.residual < 1e-8
    assert 0.1 < solution.sliding.mean() < 0.9
    assert size[solution.sliding] == pytest.approx(patch.bound[solution.sliding], rel=1e-6)
    assert np.all(size[~solution.sliding] < patch.bound[~solution.sliding])


def test_the_file_holds_the_grid_and_what_the_solver_gives(stored: Exact) -> None:
    """Two rows solved anew, with fewer cells: 0.01."""
    assert sorted(set(stored.ratio)) == list(RATIOS)
    assert len(stored.ratio) == len(RATIOS) * 8 * len(directions())
    for row in (2 * 152 + 3 * 19 + 6, 3 * 152 + 4 * 19 + 11):
        force = solved(stored.ratio[row], POISSON, tuple(solver_creepages(stored.creepages[row], stored.ratio[row])))
        assert force == pytest.approx(stored.forces[row], abs=0.01)


def test_pure_spin_has_its_maximum_of_force(stored: Exact) -> None:
    """Lateral force by spin alone rises, has a maximum well below mu N, and falls again."""
    pure = (stored.ratio == 1.0) & (np.hypot(stored.creepages[:, 0], stored.creepages[:, 1]) < 1e-9)
    force = -stored.forces[pure, 1]
    top = int(np.argmax(force))
    assert 0 < top < len(force) - 1
    assert 0.5 < force[top] < 0.7
    assert force[-1] < 0.5 * force[top]


def test_spin_moment_falls_in_sliding(stored: Exact) -> None:
    """Lateral creepage alone turns the wheel most while it still sticks at the leading edge."""
    lateral = (stored.ratio == 1.0) & (np.abs(stored.creepages[:, [0, 2]]).max(axis=1) < 1e-9)
    moment = stored.forces[lateral, 2]
    assert moment[-1] < 0.1 * moment.max()


@pytest.mark.parametrize(
    ("law", "cells", "force", "moment"),
    [
        (polach, 0, 1.090, 67.520),
        (shen_hedrick_elkins, 0, 1.093, 67.520),
        (fastsim, 7, 0.250, 0.177),
        (half_space, 0, 0.037, 0.027),
    ],
)
def test_laws_are_as_far_off_as_stated(stored: Exact, law, cells: int, force: float, moment: float) -> None:
    """Largest errors over the grid, those of docs/vehicle.md: benchmarks/creep.py prints them."""
    apart = np.empty_like(stored.forces)
    for i, (ratio, creepages) in enumerate(zip(stored.ratio, stored.creepages, strict=True)):
        a, b = AXIS * ratio**0.5, AXIS * ratio**-0.5
        C = Coefficients(*map(float, coefficients(a, b, POISSON)))
        at = creepages / scaled(ratio) * (FRICTION * LOAD / (SHEAR * AXIS**2)) / UNIT
        result = np.array(law(*at, Patch(a, b, LOAD, FRICTION, SHEAR, C, cells)), float).ravel()
        apart[i] = result / (FRICTION * LOAD * UNIT) - stored.forces[i]
    assert np.hypot(apart[:, 0], apart[:, 1]).max() == pytest.approx(force, abs=0.002)
    assert (np.abs(apart[:, 2]) / stored.largest_moment()).max() == pytest.approx(moment, abs=0.002)


PATCH = Patch(AXIS, AXIS, LOAD, FRICTION, SHEAR, Coefficients(*map(float, coefficients(AXIS, AXIS, POISSON))))


def test_the_table_of_the_exact_theory_is_one_for_circles_and_ellipses() -> None:
    """A circle has a table of its own, with one variable less; numbers are as symbols."""
    v, a, b = ca.SX.sym("v", 3), ca.SX.sym("a"), ca.SX.sym("b")
    ellipse = ca.Function("f", [v, a, b], [ca.vertcat(*half_space(*v.elements(), replace(PATCH, a=a, b=b)))])
    circle = ca.Function("f", [v, a], [ca.vertcat(*half_space(*v.elements(), replace(PATCH, a=a, b=a)))])
    for creepages in ([1e-3, -2e-3, 0.4], [0.0, 0.0, 1.4], [-4e-3, 1e-3, -0.2]):
        forces = np.array(circle(creepages, AXIS)).ravel()
        assert np.array(ellipse(creepages, AXIS, AXIS)).ravel() == pytest.approx(forces, rel=1e-9, abs=1e-9)
        assert half_space(*creepages, PATCH) == pytest.approx(forces, rel=1e-12)


def test_the_table_begins_as_kalkers_theory_and_ends_as_sliding() -> None:
    small = np.array([1e-7, -2e-7, 3e-5])
    assert half_space(*small, PATCH) == pytest.approx(linear(*small, PATCH), rel=2e-3)
    large = np.array([0.6, 0.8, 0.0])
    assert np.array(half_space(*large, PATCH)[:2]) / (FRICTION * LOAD) == pytest.approx([-0.6, -0.8], abs=5e-3)


def test_the_table_mirrors_as_the_theory_does() -> None:
    here = np.array(half_space(1e-3, 5e-4, 0.6, PATCH))
    assert half_space(-1e-3, -5e-4, -0.6, PATCH) == pytest.approx(-here, rel=1e-9)
    assert half_space(1e-3, -5e-4, -0.6, PATCH) == pytest.approx(here * [1, -1, -1], rel=1e-9)


def test_the_table_has_slopes_at_pure_spin() -> None:
    """A wheel at rest on a steep cone spins and does nothing else: there a vehicle is linearised. The slopes by the
    solver's differences; the table's are those of its cell, whose sides are a fifth of the disc's radius."""
    creepages = np.array([0.0, 0.0, 1.0]) * FRICTION * LOAD / (SHEAR * AXIS**3 * PATCH.C.C23)  # S = 1
    v = ca.SX.sym("v", 3)
    patch = replace(PATCH, a=ca.SX(AXIS))
    forces = ca.vertcat(*half_space(*v.elements(), replace(patch, b=patch.a)))
    slopes = np.array(ca.Function("slopes", [v], [ca.jacobian(forces[:2], v)[:, :2]])(creepages))
    scale = SHEAR * AXIS**2 * np.array([PATCH.C.C11, PATCH.C.C22])  # of the linear theory
    grids, step = (HalfSpace(1.0, POISSON, 10), HalfSpace(1.0, POISSON, 20)), 0.1
    for k in (0, 1):
        ends = [
            exact(*grids, solver_creepages(np.array([0.0, 0.0, 1.0]) + sign * step * np.eye(3)[k], 1.0))[0] for sign in (1, -1)
        ]
        wanted = (ends[0][k] - ends[1][k]) / (2 * step)
        assert slopes[k, k] / scale[k] == pytest.approx(wanted, abs=0.06)
        assert slopes[1 - k, k] / scale[k] == pytest.approx((ends[0][1 - k] - ends[1][1 - k]) / (2 * step), abs=0.06)
