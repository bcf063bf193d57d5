"""Our mathematics: how exact, the same in lanes as alone, the same from every compiler; special values as in C99's Annex F."""

import itertools
import math
import sys
from collections.abc import Callable
from pathlib import Path

import casadi as ca
import numpy as np
import pytest
from real_functions import (
    BINARY,
    CASES,
    COMPILERS,
    ELSEWHERE,
    EXACT,
    SPECIAL,
    Array,
    Library,
    build,
    elsewhere,
    errors,
    points,
    runner,
)

from gyro_cosim.fmus import polynomials

NAMES = tuple(dict.fromkeys([*CASES, *EXACT]))
PAIRS = tuple(np.array(list(itertools.product(SPECIAL, SPECIAL))).T)


@pytest.fixture(scope="module")
def libraries(tmp_path_factory: pytest.TempPathFactory) -> dict[tuple[str, int], Library]:
    """By compiler and number of lanes; those that this machine's processor can run."""
    folder = tmp_path_factory.mktemp("mathematics")
    flags = Path("/proc/cpuinfo").read_text(encoding="utf-8") if Path("/proc/cpuinfo").exists() else ""
    lanes = [1, 2, *([4] if " avx2 " in flags else []), *([8] if " avx512dq " in flags else [])]
    return {(c, n): build(folder, command, n, f"{c}{n}") for c, command in COMPILERS.items() if command for n in lanes}


@pytest.fixture(scope="module")
def alone(libraries: dict[tuple[str, int], Library]) -> Library:
    return libraries["zig", 1]


def arguments(name: str, count: int) -> tuple[Array, Array]:
    """Ordinary, hard and special ones."""
    if name not in CASES:
        return PAIRS
    a, b = points(CASES[name], count)
    return np.concatenate([a, PAIRS[0]]), np.concatenate([b, PAIRS[1]])


def same_bits(a: Array, b: Array) -> bool:
    """NaN is one value: processors give it different signs."""
    return bool(np.all((a.view(np.uint64) == b.view(np.uint64)) | (np.isnan(a) & np.isnan(b))))


@pytest.mark.parametrize("name", CASES)
def test_errors_are_within_their_bounds(alone: Library, name: str) -> None:
    a, b = points(CASES[name], 150)
    assert np.max(errors(name, a, b, alone(name, a, b))) <= CASES[name].bound


@pytest.mark.slow
@pytest.mark.parametrize("name", CASES)
def test_errors_are_within_their_bounds_at_many_points(alone: Library, name: str) -> None:
    a, b = points(CASES[name], 4000, seed=2)
    assert np.max(errors(name, a, b, alone(name, a, b))) <= CASES[name].bound


@pytest.mark.parametrize("name", NAMES)
def test_every_build_gives_the_same_bits(libraries: dict[tuple[str, int], Library], name: str) -> None:
    """One double or several in lanes, gcc or clang: the definition is the operations, not the compiler."""
    a, b = arguments(name, 2000)
    results = {build: library(name, a, b) for build, library in libraries.items()}
    wanted = results.pop(("zig", 1))
    assert results, "at least lanes of two doubles can be compiled everywhere"
    assert [build for build, result in results.items() if not same_bits(result, wanted)] == []


@pytest.mark.slow
@pytest.mark.parametrize("target", ELSEWHERE)
def test_other_platforms_give_the_same_bits(alone: Library, target: str, tmp_path: Path) -> None:
    """WebAssembly, another processor, another system: as far as this machine can run them."""
    if runner(target) is None:
        pytest.skip(f"nothing here runs {target}: {' or '.join(ELSEWHERE[target])} would")
    parts = [arguments(name, 500) for name in NAMES]
    a, b = (np.concatenate([part[i] for part in parts]) for i in (0, 1))
    results = elsewhere(tmp_path, target, NAMES, a, b)
    assert [name for name in NAMES if not same_bits(results[name], alone(name, a, b))] == []


@pytest.mark.parametrize("name", NAMES)
def test_special_values_are_those_of_the_c_standard(alone: Library, name: str) -> None:
    """As CasADi evaluates them, with this machine's library: zeros with their signs, infinities, NaN, subnormal numbers."""
    symbols = a, b = ca.SX.sym("a"), ca.SX.sym("b")
    casadi: dict[str, Callable[..., ca.SX]] = {
        "lt": lambda: a < b, "le": lambda: a <= b, "eq": lambda: a == b, "ne": lambda: a != b, "not": lambda: ca.logic_not(a),
        "and": lambda: ca.logic_and(a, b), "or": lambda: ca.logic_or(a, b), "if": lambda: ca.if_else(a, b, 0),
        "pow": lambda: a**b,
    }  # fmt: skip
    of_two = name in BINARY
    expression = casadi.get(name, lambda: getattr(ca, name)(*symbols[: 1 + of_two]))()
    function = ca.Function("f", [ca.vertcat(a, b)], [expression])
    wanted = np.array(function(np.array(PAIRS))).ravel()
    got = alone(name, *PAIRS)
    unlike = (np.isnan(got) != np.isnan(wanted)) | (np.signbit(got) != np.signbit(wanted)) & ~np.isnan(got)
    with np.errstate(invalid="ignore"):
        close = np.abs(got - wanted) <= np.maximum(1e-15 * np.abs(wanted), 5e-324)
    unlike |= (got != wanted) & ~np.isnan(got) & ~close
    if name in ("fmin", "fmax"):
        unlike &= np.any(np.array(PAIRS) != 0, axis=0)  # which of two zeros is the smaller one is left open by C
    assert [(*(float(v[i]) for v in PAIRS), float(got[i]), float(wanted[i])) for i in np.flatnonzero(unlike)] == []


def test_the_polynomials_are_those_that_the_script_computes(capsys: pytest.CaptureFixture[str]) -> None:
    assert polynomials.FILE.read_text(encoding="utf-8") == polynomials.text()
    assert polynomials.main(["--check"]) == 0


@pytest.mark.parametrize("polynomial", polynomials.POLYNOMIALS, ids=lambda p: p.name)
def test_polynomials_are_closer_than_half_a_unit(polynomial: polynomials.Polynomial) -> None:
    """A quarter of 2^-53, since the function's own rounding errors come on top."""
    assert polynomials.truncation(polynomial) < 2.0**-55


def test_what_casadi_can_express_is_there_or_named() -> None:
    """Every scalar operation of CasADi, so that one of a later version is noticed."""
    arithmetic = {"assign", "add", "sub", "mul", "div", "neg", "sq", "twice", "inv", "lift", "constpow"}
    lacking = {"erfinv", "printme"}
    scalar = {name[3:].lower() for name in dir(ca) if name.startswith("OP_") and _is_scalar(getattr(ca, name))}
    ours = {"if_else_zero" if name == "if" else name for name in NAMES}
    assert scalar == arithmetic | lacking | ours


def _is_scalar(operation: int) -> bool:
    """Up to atan2 the numbers are those of scalar operations; behind it stand a few more among those of matrices."""
    return operation <= ca.OP_ATAN2 or operation in {
        ca.OP_ERFINV, ca.OP_PRINTME, ca.OP_LIFT, ca.OP_LOG1P, ca.OP_EXPM1, ca.OP_HYPOT, ca.OP_REMAINDER,
    }  # fmt: skip


def test_a_sine_is_right_where_the_argument_is_far_beyond_any_angle(alone: Library) -> None:
    """2^120 and the number that comes closest of all to a multiple of pi/2 (6381956970095103 2^797)."""
    x = np.array([2.0**120, 6381956970095103.0 * 2.0**797])
    assert alone("sin", x, x) == pytest.approx([math.sin(v) for v in x], rel=1e-15)
    assert alone("cos", x, x)[1] == pytest.approx(-4.687165924254624e-19, rel=1e-15)


@pytest.mark.parametrize("compiler", [name for name, command in COMPILERS.items() if command])
def test_no_library_of_mathematics_is_called(compiler: str, tmp_path: Path) -> None:
    """Linked without any library, not even C's: the linker would name what is missing."""
    if sys.platform != "linux":
        pytest.skip("the linker's options are those of Linux")
    build(tmp_path, [*(COMPILERS[compiler] or []), "-nostdlib", "-Wl,-z,defs"], 1, "alone")
