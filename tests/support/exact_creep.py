"""Creep forces of the exact theory over a grid of creepages: the grid, the file that holds them, and the command that made it.

    python tests/support/exact_creep.py > tests/vehicle/exact_creep.txt          some twenty minutes

Creepages are given by what Kalker's linear theory makes of them, over the friction limit:

    X = G a b C11 xi / (mu N),   Y = G a b C22 eta / (mu N),   S = G (a b)^1.5 C23 phi / (mu N).

The grid has ratios a / b, magnitudes u = sqrt(X^2 + Y^2 + S^2), and directions: the spin's share S = u sin(latitude) and the
angle between X and Y. By symmetry X >= 0 and S >= 0 are enough.
"""

import sys
from dataclasses import dataclass
from math import cos, pi, radians, sin
from pathlib import Path

import numpy as np
from rolling_contact import HalfSpace, exact

from gyro_cosim.vehicle.kalker import coefficients

__all__ = ["FILE", "MAGNITUDES", "RATIOS", "Exact", "directions", "read", "scaled", "solver_creepages"]

FILE = Path(__file__).parents[1] / "vehicle" / "exact_creep.txt"
POISSON = 0.28
RATIOS = (0.2, 0.5, 1.0, 2.0, 5.0)
MAGNITUDES = (0.25, 0.5, 1.0, 1.5, 2.25, 3.5, 6.0, 12.0)
LATITUDES = (0.0, 22.5, 45.0, 67.5, 90.0)  # deg
CELLS, WIDE_CELLS = 12, 16  # and twice that; in wide patches spin turns about a pole that is small beside them


@dataclass(frozen=True)
class Exact:
    """The file.

    Attributes
    ----------
    ratio : array, shape (n,)
        a / b.
    creepages : array, shape (n, 3)
        X, Y and S.
    forces : array, shape (n, 3)
        Fx / (mu N), Fy / (mu N) and Mz / (mu N sqrt(a b)).
    """

    ratio: np.ndarray
    creepages: np.ndarray
    forces: np.ndarray

    def largest_moment(self) -> np.ndarray:
        """For each row the largest |Mz| / (mu N sqrt(a b)) of its ellipse, shape (n,)."""
        return np.array([np.abs(self.forces[self.ratio == ratio, 2]).max() for ratio in self.ratio])


def directions() -> list[tuple[float, float, float]]:
    """Unit vectors (X, Y, S) of the grid."""
    result = []
    for latitude in LATITUDES:
        angles = (90.0,) if latitude == 90.0 else (0.0, 45.0, 90.0) if latitude == 0.0 else (-90.0, -45.0, 0.0, 45.0, 90.0)
        for angle in angles:
            flat = 0.0 if latitude == 90.0 else cos(radians(latitude))
            result.append((flat * cos(radians(angle)), flat * sin(radians(angle)), sin(radians(latitude))))
    return result


def scaled(ratio: float) -> np.ndarray:
    """(X / xi, Y / eta, S / (phi sqrt(a b))) in units of G a b / (mu N), shape (3,)."""
    C = coefficients(ratio, 1.0, POISSON)
    return np.array([float(C.C11), float(C.C22), float(C.C23)])


def solver_creepages(creepages: np.ndarray, ratio: float) -> np.ndarray:
    """(X, Y, S) -> what `HalfSpace.solve` takes: over 3 mu N / (2 pi a b) instead of mu N / (a b)."""
    return creepages / scaled(ratio) * (2 * pi / 3)


def read(file: Path = FILE) -> Exact:
    """Read the file."""
    rows = np.loadtxt(file)
    return Exact(rows[:, 0], rows[:, 1:4], rows[:, 4:7])


def main() -> None:
    """Solve and print."""
    print("# Exact creep forces, nu = 0.28. Made by: python tests/support/exact_creep.py > tests/vehicle/exact_creep.txt")
    print("# a/b  X  Y  S  Fx/(mu N)  Fy/(mu N)  Mz/(mu N sqrt(a b))")
    largest = 0.0
    for ratio in RATIOS:
        cells = WIDE_CELLS if ratio < 1 else CELLS
        grids = HalfSpace(ratio, POISSON, cells), HalfSpace(ratio, POISSON, 2 * cells)
        for magnitude in MAGNITUDES:
            for direction in directions():
                creepages = magnitude * np.array(direction)
                force, beyond = exact(*grids, solver_creepages(creepages, ratio))
                largest = max(largest, beyond)
                row = (*np.round(creepages, 6), *np.round(force, 4))
                print(f"{ratio:g}", *(f"{number + 0.0:g}" for number in row), flush=True)
    print(f"farthest extrapolation: {largest:.3f}", file=sys.stderr)


if __name__ == "__main__":
    main()
