"""Functions of CasADi as C code of our own: plain, for one number or as many as a register holds, or with twins side by side.

Plain code computes with the type `real` of c/real.h: with LANES defined, the same text serves several vehicles at once.
Paired code serves one vehicle and does twin operations at once (twins.py). Both do the operations of the function on the same
numbers, so both give the same bits. What is more than arithmetic is called by the names of c/mathematics.h.

    int NAME(const real **arg, real **res, int *, real *, int)         as CasADi's own generator has it
"""

from collections.abc import Iterable, Mapping

import casadi as ca

from .graph import Graph, Operation, arrays_of, of_function
from .parts import definition
from .twins import schedule

__all__ = ["UnknownOperationError", "arrays", "file", "has_twins", "paired", "plain"]

WORTH = 0.4  # share of operations with a twin from which on paired code is faster
SMALL = 200  # operations below which it is not

INFIX = {
    "add": "{0} + {1}", "sub": "{0} - {1}", "mul": "{0} * {1}", "div": "{0} / {1}", "neg": "-{0}", "sq": "{0} * {0}",
    "twice": "{0} + {0}", "inv": "gc_real(1.0) / {0}",
}  # fmt: skip
CALLED = {
    name: f"gc_{name}"
    for name in (
        "sqrt", "sin", "cos", "tan", "asin", "acos", "atan", "atan2", "sinh", "cosh", "tanh", "asinh", "acosh", "atanh", "exp",
        "expm1", "log", "log1p", "pow", "hypot", "floor", "ceil", "fabs", "sign", "copysign", "fmin", "fmax", "fmod", "lt", "le",
        "eq", "ne", "and", "or", "not", "erf", "remainder",
    )
} | {"constpow": "gc_pow", "if_else_zero": "gc_if"}  # fmt: skip


_OTHER = {"sin": "cos", "cos": "sin"}


class UnknownOperationError(ValueError):
    """An operation that c/mathematics.h has not."""


def _expression(what: str, operation: Operation, operands: list[str]) -> str:
    if operation.name in INFIX:
        return INFIX[operation.name].format(*operands)
    if operation.name == "entry":
        return f"gc_entry({operation.array}, {operands[0]}, {operation.place[1]})"
    if operation.name == "interval":
        return f"gc_interval({operation.array}, {operation.array}_size, {operands[0]})"
    if operation.name in CALLED:
        return f"{CALLED[operation.name]}({', '.join(operands)})"
    raise UnknownOperationError(f"{what}: the operation {operation.name!r} has no C code here")


def plain(name: str, function: ca.Function, storage: str = "", *, apart: bool = False) -> str:
    """C code of an SX function, for `real`.

    Parameters
    ----------
    name : str
        Of the C function.
    function : casadi.Function
        An SX function.
    storage : str
        What stands before the definition, such as "static ".
    apart : bool
        Whether it comes in parts if it is long (parts.py).

    Returns
    -------
    str
        The definition.

    Raises
    ------
    UnknownOperationError
        If it has an operation without C code; the message names it.
    """
    graph = of_function(function)
    names, lines, both = [], [], _with_both(graph)
    for i, operation in enumerate(graph.operations):
        if operation.name == "input":
            names.append(f"arg[{operation.place[0]}][{operation.place[1]}]")
        elif operation.name == "const":
            names.append(f"gc_real({operation.value!r})")
        else:
            operands = [names[k] for k in operation.arguments]
            if both.get(i, i) != i:
                other = both[i]
                lines += [f"real a{i}, a{other};", _sincos(operation, operands[0], f"a{i}", f"a{other}")] if other > i else []
            else:
                lines.append(f"const real a{i} = {_expression(name, operation, operands)};")
            names.append(f"a{i}")
    for o, column in enumerate(graph.results):
        lines += [f"res[{o}][{k}] = {names[i]};" for k, i in enumerate(column)]
    return definition(name, "real", lines, storage, apart=apart)


def _with_both(graph: Graph) -> dict[int, int]:
    """Place of a sine -> place of the cosine of the same number, and back: c/trigonometry.h computes both at once."""
    found: dict[tuple[str, int], int] = {(o.name, o.arguments[0]): i for i, o in enumerate(graph.operations) if o.name in _OTHER}
    return {i: found[_OTHER[name], k] for (name, k), i in found.items() if (_OTHER[name], k) in found}


def _sincos(operation: Operation, operand: str, name: str, other: str) -> str:
    """The statement that computes sine and cosine, called `name` and `other` where the operation is a sine."""
    sine, cosine = (name, other) if operation.name == "sin" else (other, name)
    return f"gc_sincos({operand}, &{sine}, &{cosine});"


def has_twins(function: ca.Function) -> bool:
    """Whether paired code of an SX function is worth while."""
    graph = of_function(function)
    operations = sum(not operation.is_leaf for operation in graph.operations)
    together = sum(2 for step in schedule(graph) if step.pair[0] != step.pair[1])
    return operations >= SMALL and together >= WORTH * operations


def paired(name: str, function: ca.Function, storage: str = "", *, apart: bool = False) -> str:
    """C code of an SX function with twins side by side, for LANES 2. Parameters, errors: see plain()."""
    graph = of_function(function)
    return definition(name, "double", _Paired(name, graph).lines(), storage, apart=apart)


def file(functions: Mapping[str, ca.Function], *, prefix: str, side_by_side: bool, apart: bool) -> str:
    """A C file of SX functions.

    Parameters
    ----------
    functions : mapping of str to casadi.Function
        By their names in C.
    prefix : str
        What stands before every definition.
    side_by_side : bool
        Whether compilers that know vectors get paired code, where the file serves one vehicle; others get plain code.
    apart : bool
        Whether long functions come in parts.

    Returns
    -------
    str
        The file.

    Raises
    ------
    UnknownOperationError
        See plain().
    """
    simple = '#include "mathematics.h"\n\n' + "\n".join(plain(name, f, prefix, apart=apart) for name, f in functions.items())
    data = '#include "model_data.h"\n' + '#include "model_tables.h"\n' * any(map(arrays_of, functions.values()))
    if not side_by_side:
        return data + simple
    pairs = '#define LANES 2\n#include "mathematics.h"\n\n' + "\n".join(
        paired(n, f, prefix, apart=apart) for n, f in functions.items()
    )
    return f"{data}#if defined(__GNUC__) && !defined(LANES)\n{pairs}#else\n{simple}#endif\n"


def arrays(functions: Iterable[ca.Function]) -> str:
    """A C header with the arrays in which SX functions look up; empty where they do not."""
    found = {name: numbers for function in functions for name, numbers in arrays_of(function).items()}
    lines = ["#ifndef MODEL_TABLES_H", "#define MODEL_TABLES_H"]
    for name, numbers in found.items():
        lines += [f"#define {name}_size {numbers.size}", f"static const double {name}[] = {{"]
        texts = list(map(repr, numbers.tolist()))
        lines += [", ".join(texts[i : i + 6]) + "," for i in range(0, len(texts), 6)] + ["};"]
    return "\n".join([*lines, "#endif", ""]) if found else ""


class _Paired:
    """The printer of one function: `real` holds a pair, or twice what stands alone."""

    def __init__(self, what: str, graph: Graph) -> None:
        self._what, self._graph = what, graph
        self._half: dict[int, tuple[str, int]] = {}  # place -> variable and half that hold it
        self._known: dict[tuple[int, int], str] = {}  # pair of places -> variable
        self._lines: list[str] = []

    def lines(self) -> list[str]:
        """The statements of the body."""
        steps = schedule(self._graph)
        called = {(self._graph.operations[step.pair[0]].name, *step.operands): step.pair for step in steps}
        for (i, j), pairs in steps:
            if (i, j) in self._known:
                continue
            first, second = self._graph.operations[i], self._graph.operations[j]
            operands = [self._pair(*pair) for pair in pairs]
            other = called.get((_OTHER.get(first.name, ""), *pairs))
            if other is not None:
                self._lines += [f"real a{i}, a{other[0]};", _sincos(first, operands[0], f"a{i}", f"a{other[0]}")]
                self._keep((i, j))
                self._keep(other)
                continue
            if first.name == second.name:
                expression = _expression(self._what, first, operands)
            else:  # a sum beside a difference: subtracting is adding the negated
                signs = ", ".join("1.0" if operation.name == "add" else "-1.0" for operation in (first, second))
                expression = f"{operands[0]} + (real){{{signs}}} * {operands[1]}"
            self._lines.append(f"const real a{i} = {expression};")
            self._keep((i, j))
        for o, column in enumerate(self._graph.results):
            self._lines += [f"res[{o}][{k}] = {self._one(i)};" for k, i in enumerate(column)]
        return self._lines

    def _keep(self, pair: tuple[int, int]) -> None:
        """The pair is held by the variable that is called after its first place."""
        name = f"a{pair[0]}"
        self._known[pair] = name
        self._half[pair[0]] = name, 0
        self._half.setdefault(pair[1], (name, 1))

    def _one(self, i: int) -> str:
        """The value at place i as a double."""
        operation = self._graph.operations[i]
        if operation.name == "input":
            return f"arg[{operation.place[0]}][{operation.place[1]}]"
        if operation.name == "const":
            return repr(operation.value)
        name, half = self._half[i]
        return f"{name}[{half}]"

    def _pair(self, i: int, j: int) -> str:
        """The values at i and j as a variable."""
        if (i, j) not in self._known:
            name = f"b{len(self._known)}"
            self._lines.append(f"const real {name} = {{{self._one(i)}, {self._one(j)}}};")
            self._known[i, j] = name
        return self._known[i, j]
