"""A scalar function of CasADi as a list of operations: what the printer of C code works on.

Each operation stands once and after those that it needs, so a place in the list is a name for a value.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import casadi as ca

__all__ = ["COMMUTATIVE", "Graph", "Operation", "of_function"]

_NAMES = {getattr(ca, name): name.removeprefix("OP_").lower() for name in dir(ca) if name.startswith("OP_")}
COMMUTATIVE = frozenset({"mul", "add", "fmax", "fmin", "and", "or", "eq", "ne", "hypot"})


@dataclass(frozen=True, slots=True)
class Operation:
    """One operation.

    Attributes
    ----------
    name : str
        CasADi's name of it in lower case, without "OP_"; "input" and "const" for the leaves.
    arguments : tuple of int
        Places of its operands.
    place : tuple of int
        Of an input: which argument of the function, and which element of it.
    value : float
        Of a constant.
    """

    name: str
    arguments: tuple[int, ...] = ()
    place: tuple[int, int] = (0, 0)
    value: float = 0.0

    @property
    def is_leaf(self) -> bool:
        """Whether it computes nothing."""
        return self.name in ("input", "const")


@dataclass(frozen=True)
class Graph:
    """The operations of a function.

    Attributes
    ----------
    operations : sequence of Operation
        In an order in which they can be computed.
    results : sequence of sequence of int
        For each result of the function the places of its elements; -1 for an element that is 0 by structure.
    """

    operations: Sequence[Operation]
    results: Sequence[Sequence[int]]


def of_function(function: ca.Function) -> Graph:
    """The operations of an SX function, equal ones once, every result dense.

    Raises
    ------
    ValueError
        If the function is no SX function.
    """
    if not function.is_a("SXFunction"):
        raise ValueError(f"function {function.name()!r} must be an SX function, is {function.class_name()}")
    args = [ca.SX.sym(f"a{i}", *function.size_in(i)) for i in range(function.n_in())]
    values = ca.cse([ca.densify(value) for value in function.call(args)])
    whole = ca.Function("whole", args, values)
    operations: list[Operation] = []
    held: dict[int, int] = {}  # CasADi's work vector -> place of the operation that wrote it last
    results = [[-1] * whole.numel_out(i) for i in range(whole.n_out())]
    for k in range(whole.n_instructions()):
        name = _NAMES[whole.instruction_id(k)]
        reads, writes = whole.instruction_input(k), whole.instruction_output(k)
        if name == "output":
            results[writes[0]][writes[1]] = held[reads[0]]
            continue
        if name == "assign":
            held[writes[0]] = held[reads[0]]
            continue
        if name == "input":
            operation = Operation(name, place=(reads[0], reads[1]))
        elif name == "const":
            operation = Operation(name, value=whole.instruction_constant(k))
        else:
            operation = Operation(name, tuple(held[r] for r in reads))
        operations.append(operation)
        held[writes[0]] = len(operations) - 1
    return Graph(operations, results)
