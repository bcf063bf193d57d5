"""Coupling algorithms: which input polynomial each slave follows over a macro step, in which order, how often."""

from collections.abc import Callable, Sequence

from .base import Algorithm, Memory, Step
from .explicit import Explicit, GaussSeidel, Jacobi, Nepce
from .history import MAX_DEGREE, History
from .iterated import Iterated, Newton

__all__ = [
    "ALGORITHMS", "MAX_DEGREE", "Algorithm", "Explicit", "GaussSeidel", "History", "Iterated", "Jacobi", "Memory", "Nepce",
    "Newton", "Step", "algorithm",
]  # fmt: skip

ALGORITHMS: dict[str, Callable[[int], Algorithm]] = {
    "jacobi": Jacobi, "gauss-seidel": GaussSeidel, "nepce": Nepce, "iterated": Iterated, "newton": Newton,
}  # fmt: skip


def algorithm(name: str, degree: int, sequence: Sequence[str] = ()) -> Algorithm:
    """The algorithm that the command line calls `name`."""
    if name not in ALGORITHMS:
        raise ValueError(f"algorithm must be one of {', '.join(ALGORITHMS)}, got {name!r}")
    if sequence and name != "gauss-seidel":
        raise ValueError(f"a sequence of components goes with gauss-seidel only, got {name!r}")
    return GaussSeidel(degree, tuple(sequence)) if name == "gauss-seidel" else ALGORITHMS[name](degree)
