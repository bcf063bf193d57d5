"""A scalar function of CasADi as a list of operations: what the printer of C code works on.

Each operation stands once and after those that it needs, so a place in the list is a name for a value.
"""

import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field

import casadi as ca
import numpy as np

from gyro_cosim.component.lookups import is_lookup, lookup_of

__all__ = ["COMMUTATIVE", "Graph", "Operation", "arrays_of", "of_function"]

_NAMES = {getattr(ca, name): name.removeprefix("OP_").lower() for name in dir(ca) if name.startswith("OP_")}
COMMUTATIVE = frozenset({"mul", "add", "fmax", "fmin", "and", "or", "eq", "ne", "hypot"})
_DERIVATIVE = re.compile(r"^(?:(?:fwd|adj|jac)\d*_)+")
_VANISHES = {"mul": (0, 1), "div": (0,), "neg": (0,), "twice": (0,), "sq": (0,)}  # operands of which one that is 0 makes it 0


@dataclass(frozen=True, slots=True)
class Operation:
    """One operation.

    Attributes
    ----------
    name : str
        CasADi's name of it in lower case, without "OP_"; "input" and "const" for the leaves; "entry" and "interval" for what
        is looked up in a table (component/lookups.py).
    arguments : tuple of int
        Places of its operands.
    place : tuple of int
        Of an input: which argument of the function, and which element of it. Of an entry: 0, and how far behind its operand.
    value : float
        Of a constant.
    array : str
        Of what is looked up: in which array.
    """

    name: str
    arguments: tuple[int, ...] = ()
    place: tuple[int, int] = (0, 0)
    value: float = 0.0
    array: str = ""

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
    arrays : mapping of str to array
        What is looked up in, by name.
    """

    operations: Sequence[Operation]
    results: Sequence[Sequence[int]]
    arrays: Mapping[str, np.ndarray] = field(default_factory=dict)


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
    return _Builder(whole).graph()


def arrays_of(function: ca.Function) -> Mapping[str, np.ndarray]:
    """What an SX function looks up in, by name."""
    calls = [k for k in range(function.n_instructions()) if function.instruction_id(k) == ca.OP_CALL]
    expressions = function.instructions_sx() if calls else ca.SX()
    found = (lookup_of(expressions[k].which_function()) for k in calls)
    return {lookup.name: lookup.numbers for lookup in found if lookup is not None}


class _Builder:
    """Goes through the instructions of an SX function."""

    def __init__(self, function: ca.Function) -> None:
        self._function = function
        self._operations: list[Operation] = []
        self._arrays: dict[str, np.ndarray] = {}
        self._held: dict[int, int] = {}  # CasADi's work vector -> place of the operation that wrote it last
        self._zeros: set[int] = set()  # places that are 0 since a lookup has no slope

    def graph(self) -> Graph:
        """All of it."""
        f, held = self._function, self._held
        results = [[-1] * f.numel_out(i) for i in range(f.n_out())]
        expressions: ca.SX | None = None
        for k in range(f.n_instructions()):
            name = _NAMES[f.instruction_id(k)]
            reads, writes = f.instruction_input(k), f.instruction_output(k)
            if name == "output":
                results[writes[0]][writes[1]] = held[reads[0]]
            elif name == "call":
                expressions = f.instructions_sx() if expressions is None else expressions
                self._call(expressions[k].which_function(), reads, writes)
            elif name == "assign":
                held[writes[0]] = held[reads[0]]
            elif name == "input":
                held[writes[0]] = self._place(Operation(name, place=(reads[0], reads[1])))
            elif name == "const":
                held[writes[0]] = self._place(Operation(name, value=f.instruction_constant(k)))
            else:
                held[writes[0]] = self._computed(name, tuple(held[r] for r in reads))
        return Graph(self._operations, results, self._arrays)

    def _place(self, operation: Operation) -> int:
        self._operations.append(operation)
        return len(self._operations) - 1

    def _computed(self, name: str, operands: tuple[int, ...]) -> int:
        """Place of an operation, which may be that of an operand where another one is 0."""
        zero = [operand in self._zeros for operand in operands]
        if any(zero[i] for i in _VANISHES.get(name, ())):
            return operands[zero.index(True)]
        if name in ("add", "sub") and zero[1]:
            return operands[0]
        if name in ("add", "sub") and zero[0]:
            return operands[1] if name == "add" else self._place(Operation("neg", operands[1:]))
        return self._place(Operation(name, operands))

    def _call(self, function: ca.Function, reads: Sequence[int], writes: Sequence[int]) -> None:
        """The results of a call: what is looked up, or the derivatives of that, which are 0."""
        name = function.name()
        if _DERIVATIVE.match(name) and is_lookup(_DERIVATIVE.sub("", name)):
            zero = self._place(Operation("const"))
            self._zeros.add(zero)
            self._held |= dict.fromkeys(writes, zero)
            return
        lookup = lookup_of(function)
        if lookup is None:
            self._held |= dict.fromkeys(writes, self._place(Operation(f"call of {name}")))
            return
        self._arrays[lookup.name] = lookup.numbers
        operands = (self._held[reads[0]],)
        for offset, slot in enumerate(writes):
            kind = "interval" if lookup.searches else "entry"
            if slot >= 0:
                self._held[slot] = self._place(Operation(kind, operands, (0, offset), array=lookup.name))
