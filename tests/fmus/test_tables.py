"""Tables in C code: the bits of CasADi's interpreter, alone, in lanes, side by side and in WebAssembly; arrays stand once."""

import functools
import subprocess
from pathlib import Path

import casadi as ca
import numpy as np
import pytest
from fmu_models import tabled
from real_functions import ELSEWHERE, WIDTH, ZIG, C, Library, runner
from real_functions import FLAGS as OPTIONS

from gyro_cosim.component.tables import lattice, surface, table
from gyro_cosim.fmus import code, printing
from gyro_cosim.fmus.compiler import host_compiler
from gyro_cosim.fmus.graph import of_function
from gyro_cosim.fmus.table import Table
from gyro_cosim.fmus.twins import schedule

UNEVEN, EVEN = np.array([-1.0, -0.4, 0.1, 0.35, 0.7, 1.5]), np.linspace(-1.0, 1.5, 11)


def functions() -> dict[str, ca.Function]:
    """By name, functions of two numbers: tables of every kind, and derivatives."""
    a, b = ca.SX.sym("a"), ca.SX.sym("b")
    rng = np.random.default_rng(2)
    values: dict[str, ca.SX] = {}
    for kind in ("spline", "monotone", "linear"):
        for x, points in (("uneven", UNEVEN), ("even", EVEN)):
            for ends in ("constant", "straight", "periodic"):
                f = rng.standard_normal((points.size, 2))
                f[-1] = f[0]
                of = table(points, f, kind=kind, ends=ends)  # type: ignore[arg-type]
                values[f"{kind}_{x}_{ends}"] = of(a)[0] * of(b)[1]
    of = surface(UNEVEN, EVEN, rng.standard_normal((UNEVEN.size, EVEN.size, 2)))
    values["surface"] = of(a, b)[0] - of(b, a * b)[1]
    three = lattice((UNEVEN, EVEN, UNEVEN), rng.standard_normal((UNEVEN.size, EVEN.size, UNEVEN.size, 2)))
    values["lattice"] = three(a, b, a - b)[0] + three(b, a, 0.3)[1]
    slopes = {f"{name}_slope": ca.jtimes(v, ca.vertcat(a, b), ca.vertcat(b, 2.0)) for name, v in values.items()}
    slopes["surface_back"] = ca.sum1(ca.jtimes(values["surface"], ca.vertcat(a, b), b, True))
    return {name: ca.Function(name, [a, b], [value]) for name, value in (values | slopes).items()}


FUNCTIONS = functions()
ARRAY = """
__attribute__((visibility("default"))) void array_NAME(const double *a, const double *b, double *result, __SIZE_TYPE__ n) {
    for (__SIZE_TYPE__ i = 0; i < n; i += LANES) {
        real x, y, z;
        gc_copy(&x, a + i, sizeof x);
        gc_copy(&y, b + i, sizeof y);
        NAME((const real *[]){&x, &y}, (real *[]){&z}, 0, 0, 0);
        gc_copy(result + i, &z, sizeof z);
    }
}
"""


@pytest.fixture(scope="module")
def source(tmp_path_factory: pytest.TempPathFactory) -> Path:
    text = [printing.arrays(FUNCTIONS.values()), '#include "mathematics.h"\n']
    text += ["static " + printing.plain(name, f) + ARRAY.replace("NAME", name) for name, f in FUNCTIONS.items()]
    path = tmp_path_factory.mktemp("tables") / "tables_of_numbers.c"
    path.write_text("\n".join(text), encoding="utf-8")
    return path


def arguments() -> tuple[np.ndarray, np.ndarray]:
    """Between the points, at them, beyond the ends, and what is no number; a multiple of 8."""
    rng = np.random.default_rng(0)
    some = np.concatenate([4 * rng.random(200) - 1.7, UNEVEN, EVEN, [np.nan, 1e30, -1e30, 1.5 + 1e-15, -0.0, 0.0, 3.0]])
    return some, rng.permutation(some)


@functools.cache
def wanted(name: str) -> np.ndarray:
    a, b = arguments()
    return np.array(FUNCTIONS[name].map(a.size)(a, b)).ravel()


def same_bits(got: np.ndarray, name: str) -> bool:
    true = wanted(name)
    same = (got.view(np.uint64) == true.view(np.uint64)) | (np.isnan(got) & np.isnan(true))
    if name.removesuffix("_slope") != name:  # the signs of zeros go with the zeros that are left out
        same |= (got == 0.0) & (true == 0.0)
    undecided = np.isnan(arguments()).any(axis=0) & (name.removesuffix("_slope") != name)  # 0 NaN, which we leave out
    return bool(np.all(same | undecided))


@pytest.mark.parametrize("lanes", [1, 2, pytest.param(4, marks=pytest.mark.slow)])
def test_c_code_gives_the_bits_of_casadis_interpreter(source: Path, lanes: int) -> None:
    if lanes == 4 and " avx2 " not in Path("/proc/cpuinfo").read_text(encoding="utf-8"):
        pytest.skip("this processor has no such lanes")
    file = source.with_name(f"tables_{lanes}.so")
    command = [*(host_compiler() or ZIG), "-O2", *OPTIONS, *WIDTH[lanes], f"-DLANES={lanes}", f"-I{C}", "-Wno-psabi", "-fPIC"]
    subprocess.run([*command, "-shared", "-o", file, source], check=True)
    library = Library.load(file)
    assert [name for name in FUNCTIONS if not same_bits(library(name, *arguments()), name)] == []


@pytest.mark.slow
@pytest.mark.parametrize("target", [t for t in ELSEWHERE if t.startswith("wasm")])
def test_webassembly_gives_the_same_bits(source: Path, target: str, tmp_path: Path) -> None:
    program = runner(target)
    if program is None:
        pytest.skip(f"nothing here runs {target}")
    module, numbers, results = tmp_path / "tables.wasm", tmp_path / "numbers", tmp_path / "results"
    command = [*ZIG, "-target", target, "-O2", *OPTIONS, f"-I{C}", "-nostdlib", "-DLANES=1"]
    command += ["-Wl,--no-entry,--export=__heap_base,--export-dynamic", "-o", str(module), str(source)]
    subprocess.run(command, check=True)
    a, b = arguments()
    numbers.write_bytes(np.concatenate([[a.size], a, b]).astype("<f8").tobytes())
    driver = Path(__file__).parents[1] / "support" / "arrays_in_node.mjs"
    subprocess.run([program, str(driver), str(module), str(numbers), str(results), *FUNCTIONS], check=True)
    got = np.fromfile(results, "<f8").reshape(len(FUNCTIONS), a.size)
    assert [name for row, name in zip(got, FUNCTIONS, strict=True) if not same_bits(row, name)] == []


def test_the_slopes_of_lookups_leave_nothing_behind() -> None:
    """The derivative of an entry is 0: no operation of a derivative is on such a zero."""
    graph = of_function(FUNCTIONS["spline_uneven_constant_slope"])
    zeros = {i for i, o in enumerate(graph.operations) if o.name == "const" and o.value == 0.0}
    reads = [o.name for o in graph.operations if zeros & set(o.arguments)]
    assert reads == []


def test_both_sides_of_a_vehicle_look_up_side_by_side() -> None:
    x = ca.SX.sym("x", 2)
    of = table(UNEVEN, np.sin(UNEVEN))
    graph = of_function(ca.Function("two", [x], [ca.vertcat(of(x[0]), of(x[1]))]))
    steps = schedule(graph)
    assert all(i != j for (i, j), _ in steps)
    assert {graph.operations[i].name for (i, _), _ in steps} >= {"entry", "interval"}


def test_arrays_stand_once_in_an_fmus_code() -> None:
    files = code.generate(Table(tabled()), "tabled")
    assert files["model_tables.h"].count("static const double") == 5
    assert all("static const double table" not in text for name, text in files.items() if name != "model_tables.h")
    assert "gc_entry(" in files["model.c"]
    assert "gc_entry(" in files["rhs_derivatives.c"]


def test_another_function_in_a_graph_has_no_code() -> None:
    x, m = ca.SX.sym("x"), ca.MX.sym("m")
    other = ca.Function("other", [m], [ca.sin(m)], {"never_inline": True})
    with pytest.raises(printing.UnknownOperationError, match="it: the operation 'call of other' has no C code here"):
        printing.plain("it", ca.Function("it", [x], [other(x)]))
