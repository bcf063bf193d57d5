"""Which operations of a graph are the same on other numbers: the two running gears of a vehicle, the two sides of a wheel pair.

A processor does two such operations at once, in the two halves of a register that every processor has (SSE2, NEON, SIMD128
of WebAssembly), with the bits that each has alone. Two operations are twins where the trees of operations above them, down to
inputs and constants, have the same shape; a sum counts as a difference of the negated, which changes no bit.
"""

from collections import defaultdict
from collections.abc import Iterable, Sequence
from typing import NamedTuple

from .graph import COMMUTATIVE, Graph, Operation

__all__ = ["Step", "schedule"]

Pair = tuple[int, int]  # places in the graph; an operation alone is (i, i)


class Step(NamedTuple):
    """What is computed at once: a pair of operations, or one, (i, i); and the pairs of their operands."""

    pair: Pair
    operands: list[Pair]


def _shape_name(operation: Operation) -> str:
    if operation.name == "input":
        return f"input {operation.place[0]}"
    if operation.array:
        return f"{operation.name} {operation.place[1]} {operation.array}"
    return "add" if operation.name == "sub" else operation.name


def _shapes(operations: Sequence[Operation]) -> list[int]:
    """A number for each operation, equal for trees of the same shape."""
    numbers: dict[tuple[object, ...], int] = {}
    shapes: list[int] = []
    for operation in operations:
        name = _shape_name(operation)
        below = [shapes[i] for i in operation.arguments]
        key = (name, *(sorted(below) if name in COMMUTATIVE else below))
        shapes.append(numbers.setdefault(key, len(numbers)))
    return shapes


def _aligned(graph: Graph, shapes: Sequence[int], pair: Pair) -> list[Pair]:
    """The operands of a pair, those that belong together beside one another: of what commutes, one side may be turned round."""
    first, second = (graph.operations[i] for i in pair)
    a, b = first.arguments, second.arguments
    straight, turned = list(zip(a, b, strict=True)), list(zip(a, reversed(b), strict=True))
    if pair[0] == pair[1] or _shape_name(first) not in COMMUTATIVE or _fit(shapes, straight) >= _fit(shapes, turned):
        return straight
    if second.name != "sub":
        return turned
    return straight if first.name == "sub" else list(zip(reversed(a), b, strict=True))


def _fit(shapes: Sequence[int], operands: Iterable[Pair]) -> int:
    """How well the pairs go together: the same operand of both counts most, then the same shape."""
    return sum(2 if a == b else shapes[a] == shapes[b] for a, b in operands)


def schedule(graph: Graph) -> list[Step]:
    """All operations but the leaves, in an order in which they can be computed: twins together, the others alone."""
    shapes = _shapes(graph.operations)
    partner = _partners(graph, shapes)
    owner: dict[int, Pair] = {}
    for i, operation in enumerate(graph.operations):
        if not operation.is_leaf:
            owner.setdefault(i, (i, i) if i not in partner else (min(i, partner[i]), max(i, partner[i])))
    order: list[Pair] = []
    done: set[Pair] = set()
    for wanted in sorted(set(owner.values())):
        waiting = [wanted]
        while waiting:
            pair = waiting[-1]
            needs = {owner[a] for i in pair for a in graph.operations[i].arguments if a in owner} - done
            if needs:
                waiting.extend(sorted(needs, reverse=True))
                continue
            waiting.pop()
            if pair not in done:
                done.add(pair)
                order.append(pair)
    return [Step(pair, _aligned(graph, shapes, pair)) for pair in order]


def _partners(graph: Graph, shapes: Sequence[int]) -> dict[int, int]:
    """Twin of each operation that has one. From the results down, so that operands of twins become twins."""
    operations = graph.operations
    partner: dict[int, int] = {}

    def join(pairs: Iterable[Pair]) -> None:
        waiting = list(pairs)
        while waiting:
            i, j = waiting.pop()
            if i == j or i in partner or j in partner or shapes[i] != shapes[j] or operations[i].is_leaf:
                continue
            partner[i], partner[j] = j, i
            waiting.extend(_aligned(graph, shapes, (min(i, j), max(i, j))))

    alike: dict[int, list[int]] = defaultdict(list)
    for column in graph.results:
        for i in dict.fromkeys(column):
            alike[shapes[i]].append(i)
    for shape in sorted(alike, reverse=True):
        join(_halves(list(dict.fromkeys(alike[shape]))))
    alike.clear()
    for i, shape in enumerate(shapes):
        alike[shape].append(i)
    for i in range(len(operations) - 1, -1, -1):
        if i not in partner:
            join(_halves([k for k in alike[shapes[i]] if k not in partner]))
    return partner


def _halves(places: list[int]) -> list[Pair]:
    """The first half beside the second: of front left, front right, rear left, rear right the front beside the rear."""
    half = len(places) // 2
    return list(zip(places[:half], places[half : 2 * half], strict=True))
