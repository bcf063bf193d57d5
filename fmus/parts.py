"""A long function of C code in parts: what a compiler takes for straight code grows faster than the code.

Each part is a function of its own. A value that another part needs too stands in an array between them; the rest stays where the
compiler puts it. The operations and their order are the same, so the bits are.
"""

import re
from collections.abc import Sequence

__all__ = ["definition"]

LENGTH = 1000  # statements of a part
_NAME = re.compile(r"\b[ab]\d+\b")
_DEFINED = re.compile(r"^(?:const )?real (a\d+|b\d+)(?:, (a\d+))?")


def definition(name: str, kind: str, statements: Sequence[str], storage: str = "", *, apart: bool = False) -> str:
    """C code of a function as CasADi's own generator calls it.

    Parameters
    ----------
    name : str
        Of the function.
    kind : str
        The type of its numbers: "real", or "double" where `real` holds a pair.
    statements : sequence of str
        Its body; values are called a0, a1, ... and b0, b1, ..., each is defined once, as `real`.
    storage : str
        What stands before the definition, such as "static ".
    apart : bool
        Whether it comes in parts if it is long: sooner compiled, and a little slower.

    Returns
    -------
    str
        The definition, after those of its parts where it comes in some.
    """
    unused = "(void)arg, (void)res, (void)integers, (void)work, (void)memory;"
    head = f"{storage}int {name}(const {kind} **arg, {kind} **res, int *integers, {kind} *work, int memory)"
    if not apart or len(statements) < 2 * LENGTH:
        return _function(head, [unused, *statements, "return 0;"])
    parts = [statements[k : k + LENGTH] for k in range(0, len(statements), LENGTH)]
    made, slots = _places(parts)
    functions, calls = [], []
    for k, part in enumerate(parts):
        used = dict.fromkeys(n for statement in part for n in _NAME.findall(statement) if n in slots)
        reads = [f"const real {n} = between[{slots[n]}];" for n in used if made[n] < k]
        writes = [f"between[{slots[n]}] = {n};" for n in used if made[n] == k]
        own = f"GC_APART static void {name}_{k}(const {kind} **arg, {kind} **res, real *between)"
        functions.append(_function(own, ["(void)arg, (void)res, (void)between;", *reads, *part, *writes]))
        calls.append(f"{name}_{k}(arg, res, between);")
    room = f"real between[{max(slots.values(), default=0) + 1}];"
    return "\n".join([*functions, _function(head, [unused, room, *calls, "return 0;"])])


def _places(parts: Sequence[Sequence[str]]) -> tuple[dict[str, int], dict[str, int]]:
    """By value: the part that makes it; and, where a later one needs it, its place between them. Places are used again."""
    made: dict[str, int] = {}
    last: dict[str, int] = {}
    for k, part in enumerate(parts):
        for statement in part:
            if found := _DEFINED.match(statement):
                made |= dict.fromkeys((n for n in found.groups() if n), k)
            last |= dict.fromkeys(_NAME.findall(statement), k)
    slots: dict[str, int] = {}
    free: list[int] = []
    ending: dict[int, list[str]] = {}
    for n, k in last.items():
        if k > made[n]:
            ending.setdefault(k, []).append(n)
    size = 0
    begun: dict[int, list[str]] = {}
    for n in (n for names in ending.values() for n in names):
        begun.setdefault(made[n], []).append(n)
    for k in range(len(parts)):
        free += [slots[n] for n in ending.get(k, ())]  # a part reads all that it needs before it writes
        for n in begun.get(k, ()):
            if free:
                slots[n] = free.pop()
            else:
                slots[n], size = size, size + 1
    return made, slots


def _function(head: str, statements: Sequence[str]) -> str:
    return f"{head} {{\n" + "".join(f"    {statement}\n" for statement in statements) + "}\n"
