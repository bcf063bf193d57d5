"""How exact our mathematics is, and what it costs: the tables of docs/mathematics.md.

    PYTHONPATH=tests/support python benchmarks/mathematics.py [POINTS]

Largest error against values in high precision, in units in the last place (1/2 is the best there can be), over POINTS (2000) even
and as many logarithmic points of each interval of tests/support/real_functions.py, and over hard ones. Nanoseconds a number for
arguments of ordinary size, beside the C library's; a minute or two.
"""

import subprocess
import sys
import tempfile
import time
from pathlib import Path

import numpy as np
from real_functions import BINARY, CASES, COMPILERS, ZIG, Library, build, errors, points
from rich.console import Console
from rich.table import Table

REPEATS, SIZE = 30, 4096


def nanoseconds(library: Library, name: str) -> float:
    """Least time per number."""
    rng = np.random.default_rng(1)
    a, b = rng.uniform(0.05, 0.95, SIZE), rng.uniform(0.05, 3.0, SIZE)
    a = a + 1.0 if name == "acosh" else a if name in ("asin", "acos", "atanh") else 3.0 * a
    call, _ = library.prepared(name, a, b)
    times = []
    for _ in range(REPEATS):
        began = time.perf_counter()
        call()
        times.append(time.perf_counter() - began)
    return min(times) / SIZE * 1e9


def c_library(folder: Path) -> Library:
    """The same array functions with those of the C library."""
    calls = "".join(
        f"void array_{name}(const double *a, const double *b, double *r, size_t n)"
        f" {{ for (size_t i = 0; i < n; i++) r[i] = {name}({'a[i], b[i]' if name in BINARY else 'a[i]'}); }}\n"
        for name in CASES
    )
    (folder / "c_library.c").write_text(f"#include <math.h>\n#include <stddef.h>\n{calls}", encoding="utf-8")
    command = [*(COMPILERS["host"] or ZIG), "-O2", "-shared", "-fPIC", "c_library.c", "-o", "c_library.so", "-lm"]
    subprocess.run(command, cwd=folder, check=True)
    return Library.load(folder / "c_library.so")


def main() -> None:
    """Measure and print."""
    count = int(sys.argv[1]) if len(sys.argv) > 1 else 2000
    processor = Path("/proc/cpuinfo").read_text(encoding="utf-8")
    lanes = [1, 2, *([4] if " avx2 " in processor else []), *([8] if " avx512dq " in processor else [])]
    with tempfile.TemporaryDirectory() as scratch:
        folder = Path(scratch)
        ours = {n: build(folder, COMPILERS["host"] or ZIG, n, f"lanes{n}") for n in lanes}
        theirs = c_library(folder)
        table = Table("function", "bound", "largest error", "at", "C library, ns", *(f"lanes {n}, ns" for n in lanes), box=None)
        for name, case in CASES.items():
            a, b = points(case, count)
            error = errors(name, a, b, ours[1](name, a, b))
            worst = int(np.argmax(error))
            place = f"{a[worst]:.6g}" + (f", {b[worst]:.6g}" if name in BINARY else "")
            times = [f"{nanoseconds(library, name):.1f}" for library in (theirs, *ours.values())]
            table.add_row(name, f"{case.bound:g}", f"{error[worst]:.3f}", place, *times)
    Console(highlight=False, width=130).print(table)


if __name__ == "__main__":
    main()
