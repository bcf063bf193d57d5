"""Twin operations: each operation once, after what it needs, and the halves of what is done twice beside one another."""

import ctypes
from pathlib import Path

import casadi as ca
import numpy as np
import pytest

from gyro_cosim.fmus import parts, printing
from gyro_cosim.fmus.compiler import compile_libraries, host
from gyro_cosim.fmus.graph import Graph, of_function
from gyro_cosim.fmus.twins import schedule
from gyro_cosim.systems import catalogue

C = Path(printing.__file__).parent / "c"


def gear(x: ca.SX, p: ca.SX, side: float) -> ca.SX:
    """What is done for one of two: the second with a difference where the first has a sum."""
    a, b = x[0] * p[0], ca.sin(x[1]) / (p[1] + x[0] ** 2)
    c = a + b if side > 0 else b - a
    return ca.vertcat(ca.fmax(c, 0.1) * ca.cos(x[1]), ca.if_else(a < b, c, a * b), ca.sqrt(a * a + b * b) - c)


def two(copies: int = 1) -> ca.Function:
    x, p = ca.SX.sym("x", 4), ca.SX.sym("p", 2)
    left, right = x[:2], x[2:]
    for _ in range(copies):
        left, right = gear(left, p, 1.0)[:2], gear(right, p, -1.0)[:2]
    return ca.Function("two", [x, p], [ca.vertcat(left, right, left[0] + right[1])])


@pytest.mark.parametrize("function", [two(), two(4), catalogue.component("vehicle:lrt").rhs], ids=["one", "four", "vehicle"])
def test_every_operation_stands_once_and_after_its_operands(function: ca.Function) -> None:
    graph = of_function(function)
    done = {i for i, operation in enumerate(graph.operations) if operation.is_leaf}
    for step in schedule(graph):
        for i in set(step.pair):
            assert i not in done
            assert set(graph.operations[i].arguments) <= done
        done |= set(step.pair)
        for k in (0, 1):  # the operands are those of both operations, one of them perhaps turned round
            assert sorted(p[k] for p in step.operands) == sorted(graph.operations[step.pair[k]].arguments)
    assert done == set(range(len(graph.operations)))


def test_what_is_done_twice_is_paired() -> None:
    graph: Graph = of_function(two(4))
    steps = schedule(graph)
    assert sum(i == j for (i, j), _ in steps) == 1  # the last sum
    assert {graph.operations[i].name for (i, j), _ in steps if i != j} >= {"sin", "cos", "div", "fmax", "lt"}
    assert any({graph.operations[i].name for i in pair} == {"add", "sub"} for pair, _ in steps)


def values(function: ca.Function, arguments: list[np.ndarray], folder: Path, *, paired: bool, apart: bool = False) -> np.ndarray:
    """The function compiled as plain or as paired code, apart: in parts."""
    folder.mkdir()
    for file in C.iterdir():
        (folder / file.name).write_bytes(file.read_bytes())
    visible = '__attribute__((visibility("default"))) '
    text = (printing.paired if paired else printing.plain)("it", function, visible, apart=apart)
    assert (" it_1(" in text) == apart
    lanes = "#define LANES 2\n" if paired else ""
    (folder / "it.c").write_text(f'{lanes}#include "mathematics.h"\n{text}')
    (library,) = compile_libraries(folder, {"it.c": "-O2"}, "it", {host(): True}).values()
    (folder / "it.so").write_bytes(library)
    result = np.zeros(function.numel_out(0))
    pointers = (ctypes.c_void_p * len(arguments))(*(a.ctypes.data for a in arguments))
    ctypes.CDLL(str(folder / "it.so")).it(pointers, (ctypes.c_void_p * 1)(result.ctypes.data), None, None, 0)
    return result


@pytest.mark.parametrize("copies", [1, 5])
def test_paired_code_gives_the_bits_of_plain_code(copies: int, tmp_path: Path) -> None:
    function, rng = two(copies), np.random.default_rng(copies)
    x, p = rng.standard_normal(4), rng.standard_normal(2)
    plain, paired = (values(function, [x, p], tmp_path / str(kind), paired=kind) for kind in (False, True))
    assert plain.tobytes() == paired.tobytes()
    np.testing.assert_allclose(plain, np.array(function(x, p)).ravel(), rtol=1e-12)


@pytest.mark.parametrize("paired", [False, True])
def test_a_function_in_parts_gives_the_bits_of_the_whole(paired: bool, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    function, rng = two(5), np.random.default_rng(3)
    arguments = [rng.standard_normal(4), rng.standard_normal(2)]
    monkeypatch.setattr(parts, "LENGTH", 9)
    whole, apart = (values(function, arguments, tmp_path / str(cut), paired=paired, apart=cut) for cut in (False, True))
    assert whole.tobytes() == apart.tobytes()


def test_an_operation_without_code_is_named() -> None:
    x = ca.SX.sym("x")
    with pytest.raises(printing.UnknownOperationError, match="it: the operation 'erfinv' has no C code here"):
        printing.plain("it", ca.Function("it", [x], [ca.erfinv(x)]))
