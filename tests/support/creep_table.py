"""The table of the creep law "half-space": what the exact theory gives, over shape, magnitude and direction of the creepages.

    python tests/support/creep_table.py > vehicle/half_space.txt          some half an hour on two cores

With X, Y, S as in exact_creep.py, Z = S max(1, b / a), since in a wide patch little spin does much, and
sigma = sqrt(X^2 + Y^2 + Z^2), the axes of the table are

    t = a / (a + b),   s = sigma / (1 + sigma),   y = Y / sigma,   z = Z / sigma                                          (1)

and what it holds, all even in X and therefore smooth over the disc y^2 + z^2 <= 1 up to its rim,

    -Fx / (mu N s x),  -Fy / (mu N s),  -Mz / (mu N sqrt(a b) s),   x = X / sigma                                         (2)

At s = 0 they follow from Kalker's linear theory, at s = 1 from rigid sliding; between them the half-space is solved. The values
at the nodes of a layer (t, s) are those whose interpolation meets the solutions on the disc best; nodes outside it have no
solution of their own. Turning y and z into -y and -z turns the signs of Fy and Mz, so the file holds the nodes z > 0 alone.
"""

import os

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

from concurrent.futures import ProcessPoolExecutor
from itertools import product

import numpy as np
from exact_creep import POISSON, scaled, solver_creepages
from rolling_contact import HalfSpace, Solution, rigid

from gyro_cosim.vehicle.kalker import coefficients

__all__ = ["SHAPES", "STEPS", "WIDTH", "fitted", "sampled", "samples"]

SHAPES = np.linspace(1 / 6, 5 / 6, 7)  # t: a / b from 1 / 5 to 5
STEPS = np.linspace(0.0, 1.0, 13)  # s
WIDTH = 10  # nodes over y and over z, from -1 to 1; even, so that pure spin lies within a cell
CELLS = 12  # of the solver, and twice that
STIFFNESS = 3e-3  # weight of second differences against the misfit of a sample
RINGS = ((1.0, 24), (0.93, 22), (0.8, 18), (0.62, 14), (0.42, 9), (0.2, 4), (0.0, 1))  # radius, places on half a ring


def samples() -> np.ndarray:
    """Places (y, z) on the half disc z >= 0, shape (n, 2)."""
    return np.array([(r * np.cos(a), r * np.sin(a)) for r, n in RINGS for a in (np.arange(n) + 0.5) / n * np.pi])


def sampled(t: float) -> np.ndarray:
    """(2) of a shape for each of STEPS and samples(), shape (steps, n, 3)."""
    ratio, places = t / (1 - t), samples()
    x = np.sqrt(np.maximum(1 - (places**2).sum(axis=1), 0.0))
    x = np.where(x < 1e-3, 1e-3, x)  # on the rim -Fx / x by a small X
    wide = max(1.0, 1 / ratio)
    directions = np.column_stack([x, places]) / [1.0, 1.0, wide]
    grids = HalfSpace(ratio, POISSON, CELLS), HalfSpace(ratio, POISSON, 2 * CELLS)
    result = np.empty((STEPS.size, len(places), 3))
    C, kalker = coefficients(ratio, 1.0, POISSON), scaled(ratio)
    moment = float(C.C23) / kalker[1], float(C.C33) / kalker[2]
    y, z = directions[:, 1:].T
    result[0] = np.column_stack([np.ones(len(places)), y + z, moment[1] * z - moment[0] * y])
    for i, direction in enumerate(directions):
        before: list[Solution | None] = [None, None]
        for k, s in enumerate(STEPS[1:-1], start=1):
            creepages = solver_creepages(s / (1 - s) * direction, ratio)
            found = [_solved(grid, creepages, start) for grid, start in zip(grids, before, strict=True)]
            result[k, i] = -(2 * found[1].force - found[0].force) / s / [direction[0], 1.0, 1.0]
            before = found
        result[-1, i] = -rigid(solver_creepages(direction, ratio), ratio) / [direction[0], 1.0, 1.0]
    return result


def _solved(grid: HalfSpace, creepages: np.ndarray, start: Solution | None) -> Solution:
    """The solution; where Newton's method gets stuck between two sets of sliding cells, that of creepages a little longer."""
    for longer in (1.0, 1.002, 0.998, 1.005, 0.995):
        for begin in (start, None):
            solution = grid.solve(longer * creepages, begin)
            if solution.residual < 1e-6:
                return solution
    raise ArithmeticError(f"creepages {creepages} at a / b = {grid.ratio:g}: the tractions must meet (2)")


def fitted(values: np.ndarray) -> np.ndarray:
    """Nodes of a layer whose interpolation meets `values` at samples(), shape (WIDTH, WIDTH, 3) over y, z and (2)."""
    half = samples()
    places = np.vstack([half, -half])
    both = np.vstack([values, values * [1.0, -1.0, -1.0]])
    far = (np.clip(places, -1, 1) + 1) / 2 * (WIDTH - 1)
    cell = np.minimum(far.astype(int), WIDTH - 2)
    part = far - cell
    matrix = np.zeros((len(places), WIDTH, WIDTH))
    for i, j in product((0, 1), (0, 1)):
        weight = np.prod(np.where([i, j], part, 1 - part), axis=1)
        np.add.at(matrix, (np.arange(len(places)), cell[:, 0] + i, cell[:, 1] + j), weight)
    second = np.diff(np.eye(WIDTH), 2, axis=0)
    rough = np.vstack(
        [
            np.einsum("ai,bj->abij", second, np.eye(WIDTH)).reshape(-1, WIDTH**2),
            np.einsum("ai,bj->abij", np.eye(WIDTH), second).reshape(-1, WIDTH**2),
        ]
    )
    whole = np.vstack([matrix.reshape(len(places), -1), STIFFNESS * rough])
    right = np.vstack([both, np.zeros((len(rough), 3))])
    return np.linalg.lstsq(whole, right, rcond=None)[0].reshape(WIDTH, WIDTH, 3)


def main() -> None:
    """Solve, fit and print."""
    with ProcessPoolExecutor(2) as pool:
        layers = list(pool.map(sampled, SHAPES))
    print("# Creep forces of the exact theory, nu = 0.28. Made by: python tests/support/creep_table.py > vehicle/half_space.txt")
    print(f"# Axes t, s, y, z, from 1/6 to 5/6, 0 to 1, -1 to 1 and above 0: {SHAPES.size} {STEPS.size} {WIDTH} {WIDTH // 2}")
    for layer in layers:
        for values in layer:
            for row in fitted(values)[:, WIDTH // 2 :].reshape(-1, 3):
                print(*(f"{number + 0.0:.4g}" for number in np.round(row, 4)))


if __name__ == "__main__":
    main()
