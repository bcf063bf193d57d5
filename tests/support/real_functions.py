"""Our mathematics as array functions, compiled for tests and benchmarks, and how far they are from the true values."""

import ctypes
import functools
import os
import shutil
import subprocess
import sys
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import mpmath
import numpy as np

from gyro_cosim import fmus
from gyro_cosim.fmus.compiler import FLAGS, host_compiler

C = Path(fmus.__file__).parent / "c"
SOURCE = Path(__file__).parent / "real_functions.c"
ZIG = [sys.executable, "-m", "ziglang", "cc"]
COMPILERS = {"host": host_compiler(), "zig": ZIG}
WIDTH = {1: [], 2: [], 4: ["-mavx2"], 8: ["-mavx512f", "-mavx512dq", "-mprefer-vector-width=512"]}

Array = np.ndarray[Any, np.dtype[np.float64]]


@dataclass(frozen=True)
class Case:
    """A function, where it is tried, and its largest error.

    Attributes
    ----------
    bound : float
        Largest error in units in the last place.
    ranges : tuple of (float, float)
        Intervals of its argument: equally many points of each, half of them spread over the powers of 2.
    second : tuple of (float, float)
        Intervals of a second argument.
    hard : tuple of float
        Further arguments.
    """

    bound: float
    ranges: tuple[tuple[float, float], ...]
    second: tuple[tuple[float, float], ...] = ()
    hard: tuple[float, ...] = field(default=())


TINY, LARGE = 1e-300, 1e300


def _near_quarter_turns() -> tuple[float, ...]:
    """The doubles nearest to multiples of pi/2, among them the two that come closest of all."""
    counts = [*range(1, 200), *(2**k for k in range(8, 60)), *(3 * 2**k + 1 for k in range(8, 50))]
    with mpmath.workdps(400):
        near = [float(n * mpmath.pi / 2) for n in counts]
    return (*near, *(np.nextafter(x, s) for x in near for s in (0.0, np.inf)), 6381956970095103.0 * 2.0**797, 51000.0, 50999.9999)


CIRCLE = ((-1e-3, 1e-3), (-4.0, 4.0), (-5.2e4, 5.2e4), (-1e9, 1e9), (-LARGE, LARGE))
CASES = {
    "sqrt": Case(0.5, ((0.0, 10.0), (0.0, LARGE)), hard=(5e-324, 1e-310)),
    "sin": Case(1.0, CIRCLE, hard=_near_quarter_turns()),
    "cos": Case(1.0, CIRCLE, hard=_near_quarter_turns()),
    "tan": Case(1.0, CIRCLE, hard=_near_quarter_turns()),
    "asin": Case(1.0, ((-1.0, 1.0), (-1e-3, 1e-3), (0.999, 1.0)), hard=(0.5, -0.5, 0.49999999999999994)),
    "acos": Case(1.0, ((-1.0, 1.0), (-1e-3, 1e-3), (0.999, 1.0)), hard=(0.5, -0.5, 0.49999999999999994)),
    "atan": Case(1.0, ((-0.5, 0.5), (-5.0, 5.0), (-LARGE, LARGE)), hard=(0.375, 0.6875, 1.5, 4.0, 0.37499999999999994)),
    "atan2": Case(1.0, ((-1.0, 1.0), (-LARGE, LARGE)), ((-1.0, 1.0), (-LARGE, LARGE))),
    "exp": Case(1.0, ((-1.0, 1.0), (-745.0, 709.7), (-745.2, -708.0)), hard=(709.782712893384, -745.1332191019411)),
    "expm1": Case(1.0, ((-1.0, 1.0), (-50.0, 50.0), (-745.0, 709.7)), hard=(709.782712893384, -38.0)),
    "log": Case(1.0, ((0.9, 1.1), (0.0, 10.0), (0.0, LARGE)), hard=(5e-324, 1e-310, 0.7071067811865475, 0.7071067811865476)),
    "log1p": Case(1.0, ((-0.9, 1.0), (-1e-3, 1e-3), (0.0, LARGE)), hard=(-0.9999999999999999, 0.41421356237309503)),
    "pow": Case(1.0, ((0.0, 4.0), (0.999, 1.001), (0.0, LARGE)), ((-8.0, 8.0), (-700.0, 700.0), (-1e5, 1e5))),
    "sinh": Case(1.5, ((-1.0, 1.0), (-30.0, 30.0), (-710.4, 710.4)), hard=(710.4758600739439,)),
    "cosh": Case(1.5, ((-1.0, 1.0), (-30.0, 30.0), (-710.4, 710.4)), hard=(710.4758600739439,)),
    "tanh": Case(1.5, ((-1.0, 1.0), (-20.0, 20.0), (-LARGE, LARGE))),
    "asinh": Case(2.0, ((-1.0, 1.0), (-100.0, 100.0), (-LARGE, LARGE))),
    "acosh": Case(2.5, ((1.0, 1.1), (1.0, 100.0), (1.0, LARGE))),
    "atanh": Case(2.0, ((-1.0, 1.0), (-1e-3, 1e-3), (0.99, 1.0))),
    "erf": Case(1.5, ((-1.0, 1.0), (-6.5, 6.5), (-1e-3, 1e-3))),
    "hypot": Case(1.0, ((-1.0, 1.0), (-LARGE, LARGE)), ((-1.0, 1.0), (-LARGE, LARGE))),
    "fmod": Case(0.0, ((-100.0, 100.0), (-LARGE, LARGE)), ((-3.0, 3.0), (-LARGE, LARGE))),
    "remainder": Case(0.0, ((-100.0, 100.0), (-LARGE, LARGE)), ((-3.0, 3.0), (-LARGE, LARGE))),
}  # fmt: skip
BINARY = ("atan2", "pow", "hypot", "fmod", "remainder", "copysign", "fmin", "fmax", "lt", "le", "eq", "ne", "and", "or", "if")
EXACT = ("floor", "ceil", "fabs", "sign", "not", "copysign", "fmin", "fmax", "lt", "le", "eq", "ne", "and", "or", "if")
SPECIAL = np.array(
    [0.0, -0.0, 1.0, -1.0, 0.5, -0.5, 1.5, -2.0, 2.0, 3.0, -3.0, np.inf, -np.inf, np.nan, 5e-324, -5e-324, 2.2e-308, 1e-310,
     1e-17, -1e-17, 1e-9, 1e300, -1e300, 1.7e308, 709.0, 710.0, -745.0, -746.0, 2.0**52 + 1.0, 2.0**52 - 0.5, 2.0**53,
     1.0 - 2.0**53, 0.49999999999999994, 1e5, 1e15, 1e22, -1e22]
)  # fmt: skip


def build(folder: Path, compiler: Sequence[str], lanes: int, name: str) -> "Library":
    """Compile for `lanes`; `name` is that of the file."""
    file = folder / f"{name}.so"
    command = [*compiler, "-O2", *FLAGS, *WIDTH[lanes], f"-DLANES={lanes}", f"-I{C}", "-Wno-psabi", "-fPIC", "-shared"]
    subprocess.run([*command, "-o", file, SOURCE], check=True, capture_output=True)
    return Library.load(file)


ELSEWHERE = {  # target of Zig, and the programs of which one runs what is compiled for it
    "wasm32-freestanding": ("node",),
    "aarch64-linux-musl": ("qemu-aarch64", "qemu-aarch64-static"),
    "x86_64-windows-gnu": ("wine",),
}


def runner(target: str) -> str | None:
    """The program that runs `target` on this machine; None if there is none."""
    return next(filter(None, map(shutil.which, ELSEWHERE[target])), None)


def elsewhere(folder: Path, target: str, names: Sequence[str], a: Array, b: Array) -> dict[str, Array]:
    """Results by name of the functions of (a, b), computed as `target` does; `runner` must know a program for it."""
    program, file, wasm = runner(target), folder / "mathematics.exe", target.startswith("wasm")
    assert program is not None
    command = [*ZIG, "-target", target, "-O2", *FLAGS, f"-I{C}", "-o", str(file), str(SOURCE)]
    command += ["-nostdlib", "-Wl,--no-entry,--export=__heap_base,--export-dynamic"] if wasm else ["-DPROGRAM"]
    subprocess.run(command, check=True, capture_output=True)
    numbers, results = folder / "numbers", folder / "results"
    numbers.write_bytes(np.concatenate([[a.size], a, b]).astype("<f8").tobytes())
    driver = [program, str(SOURCE.with_name("arrays_in_node.mjs"))] if wasm else [program]
    environment = {**os.environ, "WINEPREFIX": str(folder / "wine"), "WINEDEBUG": "-all"}
    subprocess.run([*driver, str(file), str(numbers), str(results), *names], check=True, capture_output=True, env=environment)
    return dict(zip(names, np.fromfile(results, "<f8").reshape(len(names), a.size), strict=True))


@dataclass(frozen=True, eq=False)
class Library:
    """The array functions of one build."""

    library: ctypes.CDLL

    @classmethod
    def load(cls, file: Path) -> "Library":
        """The functions in a shared library."""
        return cls(ctypes.CDLL(str(file)))

    def prepared(self, name: str, a: Array, b: Array) -> tuple[Callable[[], None], Array]:
        """A call of the function `name` of (a, b) and where it puts the result; lengths must be multiples of 8."""
        result = np.empty(a.size)
        pointers = [v.ctypes.data_as(ctypes.c_void_p) for v in (a, b, result)]
        return functools.partial(getattr(self.library, f"array_{name}"), *pointers, ctypes.c_size_t(a.size)), result

    def __call__(self, name: str, a: Array, b: Array) -> Array:
        """The function `name` of each element of a; b: the second arguments, where it has two."""
        padding = np.ones(-a.size % 8)
        padded = [np.concatenate([v, padding]) for v in (a, b)]
        call, result = self.prepared(name, padded[0], padded[1])
        call()
        return result[: a.size]


def points(case: Case, count: int, seed: int = 1) -> tuple[Array, Array]:
    """Arguments: dense in each range and over its powers of 2, and the hard ones."""
    rng = np.random.default_rng(seed)

    def some(ranges: Sequence[tuple[float, float]], n: int) -> Array:
        parts = []
        for low, high in ranges:
            even = low + (high - low) * rng.random(n)
            size = max(abs(low), abs(high))
            least = max(min(abs(low), abs(high)) if low * high > 0 else 0.0, size * 1e-12 if size < LARGE else TINY)
            spread = np.exp(rng.uniform(np.log(least), np.log(size), n))
            if low < 0 < high:
                spread *= rng.choice([-1.0, 1.0], n)
            elif high <= 0:
                spread = -spread
            parts += [even, spread]
        return np.concatenate(parts)

    a = np.concatenate([some(case.ranges, count), np.array(case.hard), -np.array(case.hard if case.ranges[0][0] < 0 else ())])
    if not case.second:
        return a, a
    b = some(case.second, count)
    pairs = max(a.size, b.size)
    return rng.permutation(np.resize(a, pairs)), rng.permutation(np.resize(b, pairs))


@functools.cache
def true_function(name: str) -> Callable[..., Any]:
    """The function in mpmath."""

    def power(x: Any, y: Any) -> Any:
        return mpmath.power(x, y)

    special = {
        "pow": power,
        "fmod": lambda x, y: mpmath.sign(x) * mpmath.fmod(abs(x), abs(y)),
        "remainder": lambda x, y: x - y * mpmath.nint(x / y),
    }
    return special.get(name) or getattr(mpmath, name)


def errors(name: str, a: Array, b: Array, result: Array) -> Array:
    """Error of each result in units in the last place of the true value; where that overflows, the result must be infinite."""
    function, two = true_function(name), name in BINARY
    digits = 700 if name in ("fmod", "remainder") else 360 if name in ("sin", "cos", "tan") else 60
    found = np.zeros(a.size)
    with mpmath.workdps(digits):
        for i in range(a.size):
            x, y = mpmath.mpf(float(a[i])), mpmath.mpf(float(b[i]))
            true = function(x, y) if two else function(x)
            if abs(true) >= mpmath.mpf(2) ** 1024 * (1 - mpmath.mpf(2) ** -54):
                found[i] = 0.0 if np.isinf(result[i]) and (result[i] > 0) == (true > 0) else np.inf
            elif not np.isfinite(result[i]):
                found[i] = np.inf
            else:
                exponent = max(mpmath.frexp(true)[1], -1021) if true else -1021
                found[i] = float(abs(mpmath.mpf(float(result[i])) - true) * mpmath.mpf(2) ** (53 - exponent))
    return found
