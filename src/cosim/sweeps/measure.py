"""The user's numbers that a sweep keeps of every run, from the run's trajectory: a verdict, a filtered maximum, a mean.

A measure is a function that worker processes can import (at the top of a module, or of the script that sweeps). It gets
the trajectory of all outputs at the communication points, as far as the run came, and returns one number a column.
"""

import hashlib
import inspect
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any

from ..trajectory import Trajectory


@dataclass(frozen=True)
class Measure:
    """A function that measures a run.

    Parameters
    ----------
    of
        Takes the trajectory of a run and returns one number for each column.
    columns
        Column -> unit, "1" for a pure number; the function must return exactly these.

    Raises
    ------
    ValueError
        Where workers could not import the function, or there are no columns.
    """

    of: Callable[[Trajectory], Mapping[str, float]]
    columns: Mapping[str, str]

    def __post_init__(self) -> None:
        """Refuse what a worker could not import, and no columns."""
        if "<" in getattr(self.of, "__qualname__", "<"):
            raise ValueError(f"a measure must be a function at the top of a module, got {self.of!r}")
        if not self.columns:
            raise ValueError("a measure must name at least one column, names none")

    def __call__(self, trajectory: Trajectory) -> list[float]:
        """The numbers in the order of the columns; ValueError if the function returns others."""
        numbers = self.of(trajectory)
        if set(numbers) != set(self.columns):
            raise ValueError(f"a measure must return {', '.join(self.columns)}, got {', '.join(numbers) or 'nothing'}")
        return [float(numbers[column]) for column in self.columns]

    @property
    def identity(self) -> list[Any]:
        """What tells it from another measure: the function's name, the text it was written as, and the columns.

        What the function calls, and constants beside it, are not looked at.
        """
        text = hashlib.sha256(inspect.getsource(self.of).encode()).hexdigest()[:16]
        return [self.of.__qualname__, text, dict(self.columns)]
