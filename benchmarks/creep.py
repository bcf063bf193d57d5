"""How far the creep laws are from the exact theory, and what they cost: the tables of docs/vehicle.md.

    PYTHONPATH=tests/support python benchmarks/creep.py

Errors of force (the vector (Fx, Fy) over mu N) and of spin moment (over the largest of its ellipse) against the stored grid of
tests/support/exact_creep.py: 5 ratios a / b, 8 magnitudes, 19 directions of creepage and spin. Nanoseconds an evaluation of
each law as it stands in an FMU's C code, beside Polach's in the same run. Some seconds.
"""

import ctypes
import subprocess
import tempfile
import time
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import casadi as ca
import numpy as np
from exact_creep import POISSON, Exact, read, scaled
from rich.console import Console
from rich.table import Table

from gyro_cosim import fmus
from gyro_cosim.fmus.compiler import FLAGS, host_compiler
from gyro_cosim.fmus.printing import arrays, file
from gyro_cosim.vehicle.creep_laws import Forces, Patch, fastsim, half_space, polach, shen_hedrick_elkins
from gyro_cosim.vehicle.kalker import Coefficients, coefficients

CIRCLE = "half-space, b = a"
LAWS: dict[str, tuple[Callable[[Any, Any, Any, Patch], Forces], int]] = {  # law, FASTSIM's grid
    "polach": (polach, 0),
    "shen-hedrick-elkins": (shen_hedrick_elkins, 0),
    "fastsim 7 x 7": (fastsim, 7),
    "fastsim 50 x 50": (fastsim, 50),
    "half-space": (half_space, 0),
    CIRCLE: (half_space, 0),
}
COMPILED_UP_TO = 7  # cells: beyond, the code is too long
LOAD, FRICTION, SHEAR, AXIS = 17.2e3, 0.3, 8.2e10, 3.2e-3  # N, 1, Pa, m; the errors do not depend on them
ROUNDS = 30
DRIVER = """
int law(const double **arg, double **res, int *, double *, int);
void all(int n, const double *in, double *out) {
    for (int i = 0; i < n; i++) {
        const double *arg[1] = {in + 12 * i};
        double *res[1] = {out + 3 * i};
        law(arg, res, 0, 0, 0);
    }
}
"""


@dataclass(frozen=True)
class Grid:
    """The stored grid as creepages of a patch of AXIS^2 = a b, shape (n, 3), and those patches."""

    exact: Exact
    creepages: np.ndarray
    patches: list[Patch]

    @classmethod
    def of(cls, exact: Exact) -> "Grid":
        """Scale it."""
        unit = FRICTION * LOAD / (SHEAR * AXIS**2)
        scales = np.array([scaled(ratio) for ratio in exact.ratio])
        patches = []
        for ratio in exact.ratio:
            a, b = AXIS * ratio**0.5, AXIS * ratio**-0.5
            patches.append(Patch(a, b, LOAD, FRICTION, SHEAR, Coefficients(*map(float, coefficients(a, b, POISSON)))))
        return cls(exact, exact.creepages / scales * unit / np.array([1.0, 1.0, AXIS]), patches)

    def errors(self, law: Callable[[Any, Any, Any, Patch], Forces], cells: int) -> tuple[np.ndarray, np.ndarray]:
        """Of force and of moment, each shape (n,)."""
        found = np.empty_like(self.creepages)
        for i, (creepages, patch) in enumerate(zip(self.creepages, self.patches, strict=True)):
            found[i] = np.array(law(*creepages, Patch(*_of(patch), grid=cells)), float).ravel()
        found /= FRICTION * LOAD * np.array([1.0, 1.0, AXIS])
        apart = found - self.exact.forces
        return np.hypot(apart[:, 0], apart[:, 1]), np.abs(apart[:, 2]) / self.exact.largest_moment()

    def rows(self) -> np.ndarray:
        """Arguments of the compiled laws, shape (n, 12)."""
        return np.array([[*c, *_of(p)[:5], *p.C] for c, p in zip(self.creepages, self.patches, strict=True)])


def _of(patch: Patch) -> tuple[Any, ...]:
    return patch.a, patch.b, patch.N, patch.mu, patch.G, patch.C


def compiled(folder: Path, law: Callable[[Any, Any, Any, Patch], Forces], cells: int, circle: bool) -> Any:
    """The law as C code of an FMU, called over arrays; circle : for patches whose b is a."""
    v = ca.SX.sym("v", 12)
    part = [v[i] for i in range(12)]
    part[4] = part[3] if circle else part[4]
    forces = law(*part[:3], Patch(*part[3:8], Coefficients(*part[8:]), cells))
    function = ca.Function("law", [v], [ca.vertcat(*forces)])
    folder.mkdir()
    (folder / "model_data.h").write_text("#include <stdint.h>\n", encoding="utf-8")
    text = file({"law": function}, prefix="", side_by_side=False, apart=False)
    (folder / "law.c").write_text(text, encoding="utf-8")
    (folder / "model_tables.h").write_text(arrays([function]), encoding="utf-8")
    (folder / "driver.c").write_text(DRIVER, encoding="utf-8")
    compiler = host_compiler()
    if compiler is None:
        raise SystemExit("a C compiler must be at hand: $CC, cc, gcc or clang")
    include = f"-I{Path(fmus.__file__).parent / 'c'}"
    flags = [*FLAGS, "-fvisibility=default", "-O3", "-fPIC", "-shared", include, f"-I{folder}"]
    subprocess.run([*compiler, *flags, "-o", folder / "law.so", folder / "law.c", folder / "driver.c", "-lm"], check=True)
    return ctypes.CDLL(str(folder / "law.so")).all


def nanoseconds(calls: dict[str, Any], rows: np.ndarray) -> dict[str, float]:
    """Least time an evaluation, the laws by turns."""
    rows = np.ascontiguousarray(rows)
    out = np.empty((len(rows), 3))
    at, to = (ctypes.c_void_p(x.ctypes.data) for x in (rows, out))
    times: dict[str, list[float]] = {name: [] for name in calls}
    for _ in range(ROUNDS):
        for name, call in calls.items():
            began = time.perf_counter()
            call(len(rows), at, to)
            times[name].append(time.perf_counter() - began)
    return {name: min(spent) / len(rows) * 1e9 for name, spent in times.items()}


def main() -> None:
    """Compare and print."""
    grid = Grid.of(read())
    console = Console(highlight=False, width=130)
    with tempfile.TemporaryDirectory() as scratch:
        calls = {name: compiled(Path(scratch) / str(i), *law, name == CIRCLE) for i, (name, law) in enumerate(LAWS.items())
                 if law[1] <= COMPILED_UP_TO}  # fmt: skip
        spent = nanoseconds(calls, grid.rows())
    found = {name: grid.errors(*law) for name, law in LAWS.items()}
    found[CIRCLE] = tuple(values[grid.exact.ratio == 1.0] for values in found[CIRCLE])
    table = Table("law", "force, largest", "rms", "spin moment, largest", "rms", "ns", "of Polach's", box=None)
    by_ratio = Table("law", *(f"a/b {ratio:g}" for ratio in np.unique(grid.exact.ratio)), box=None)
    for name, (force, moment) in found.items():
        cost = (f"{spent[name]:.0f}", f"{spent[name] / spent['polach']:.2f}") if name in spent else ("", "")
        table.add_row(name, f"{force.max():.3f}", f"{_rms(force):.3f}", f"{moment.max():.3f}", f"{_rms(moment):.3f}", *cost)
        if name == CIRCLE:
            continue
        parts = [grid.exact.ratio == ratio for ratio in np.unique(grid.exact.ratio)]
        by_ratio.add_row(name, *(f"{force[part].max():.3f}, {moment[part].max():.3f}" for part in parts))
    console.print("errors: force over mu N, spin moment over the largest of its ellipse; cost of an evaluation in C")
    console.print(table)
    console.print("\nlargest error of force, of spin moment, by ellipse")
    console.print(by_ratio)


def _rms(x: np.ndarray) -> float:
    return float(np.sqrt(np.mean(x**2)))


if __name__ == "__main__":
    main()
