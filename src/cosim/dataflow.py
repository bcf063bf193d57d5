"""In which order outputs must be evaluated, and where they depend on themselves."""

from collections.abc import Iterable, Mapping, Sequence


def strong_components(nodes: Iterable[int], needs: Mapping[int, Sequence[int]]) -> list[list[int]]:
    """Groups of nodes that need one another, each group after all that it needs. Tarjan's algorithm, without recursion."""
    index: dict[int, int] = {}
    low: dict[int, int] = {}
    stack: list[int] = []
    on_stack: set[int] = set()
    groups: list[list[int]] = []
    for root in nodes:
        if root in index:
            continue
        work = [(root, iter(needs.get(root, ())))]
        index[root] = low[root] = len(index)
        stack.append(root)
        on_stack.add(root)
        while work:
            node, successors = work[-1]
            for other in successors:
                if other not in index:
                    index[other] = low[other] = len(index)
                    stack.append(other)
                    on_stack.add(other)
                    work.append((other, iter(needs.get(other, ()))))
                    break
                if other in on_stack:
                    low[node] = min(low[node], index[other])
            else:
                work.pop()
                if work:
                    low[work[-1][0]] = min(low[work[-1][0]], low[node])
                if low[node] == index[node]:
                    group = []
                    while True:
                        last = stack.pop()
                        on_stack.discard(last)
                        group.append(last)
                        if last == node:
                            break
                    groups.append(sorted(group))
    return groups


def loops(nodes: Iterable[int], needs: Mapping[int, Sequence[int]]) -> list[list[int]]:
    """The groups of nodes that depend on themselves."""
    return [g for g in strong_components(nodes, needs) if len(g) > 1 or g[0] in needs.get(g[0], ())]


def cycle(group: Sequence[int], needs: Mapping[int, Sequence[int]]) -> list[int]:
    """One way round a loop, first and last node the same, in the direction of the data: each feeds the next."""
    inside, path = set(group), [group[0]]
    while True:
        ahead = next(node for node in needs[path[-1]] if node in inside)
        if ahead in path:
            return [ahead, *reversed(path[path.index(ahead) :])]
        path.append(ahead)
