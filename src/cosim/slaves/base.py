"""The interface between the master and a component."""

from abc import ABC, abstractmethod
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, Literal

import numpy as np

from cosim.catalogue import unknown


@dataclass(frozen=True)
class Signal:
    """A variable as the master sees it: numbers in `unit` (empty where the component states none)."""

    name: str
    kind: Literal["input", "output", "parameter", "state"]
    unit: str = ""
    start: float | None = None
    min: float | None = None
    max: float | None = None
    meaning: str = ""

    def value(self, given: str | float) -> float:
        """`given`, a number or text with an optional unit, in the signal's unit and checked against its bounds."""
        from component.units import quantity

        number = quantity(given, self.unit or "1") if isinstance(given, str) else float(given)
        if not np.isfinite(number):
            raise ValueError(f"must be finite, got {given}")
        if self.min is not None and number < self.min:
            raise ValueError(f"must be at least {self.min:g} {self.unit}, got {given}")
        if self.max is not None and number > self.max:
            raise ValueError(f"must be at most {self.max:g} {self.unit}, got {given}")
        return number


class Slave(ABC):
    """A component between communication points; a step may be repeated after restore().

    name : its name in the system.
    inputs, outputs : the signals u and y, in the order of the arrays below.
    settable : what may be given a value before the run, by name: parameters, start values, unconnected inputs.
    feedthrough : boolean (n_y, n_u), which output depends directly on which input.
    input_degree : highest degree of an input polynomial that step() follows.
    can_restore : whether save() and restore() work.
    """

    name: str
    inputs: tuple[Signal, ...]
    outputs: tuple[Signal, ...]
    settable: Mapping[str, Signal]
    feedthrough: np.ndarray
    input_degree: int
    can_restore: bool

    @abstractmethod
    def initialize(self, values: Mapping[str, float], t: float, stop: float) -> None:
        """Start anew at `t` (s) with start values by name; `stop` (s) is when the run will end."""

    @abstractmethod
    def output(self, u: np.ndarray, t: float) -> np.ndarray:
        """y at the present time `t` (s) for inputs u, shape (n_u,); returns shape (n_y,), the caller's own."""

    @abstractmethod
    def step(self, U: np.ndarray, t: float, h: float) -> None:
        """From t to t + h (s) under u(t + s) = U[0] + U[1] s + U[2] s^2 / 2; U has shape (3, n_u)."""

    @abstractmethod
    def save(self) -> Any:
        """The present state; valid until discard()."""

    @abstractmethod
    def restore(self, snapshot: Any) -> None:
        """Go back to a state that save() returned."""

    @abstractmethod
    def discard(self, snapshot: Any) -> None:
        """Free what save() returned."""

    @abstractmethod
    def close(self) -> None:
        """Free everything; the slave is of no use afterwards."""

    def start_values(self, given: Mapping[str, str | float]) -> dict[str, float]:
        """Values by name in the slave's own units; ValueError names component, variable, rule and value."""
        values = {}
        for name, value in given.items():
            if name not in self.settable:
                raise unknown(f"parameter of {self.name!r}:", name, self.settable)
            try:
                values[name] = self.settable[name].value(value)
            except ValueError as error:
                raise ValueError(f"{self.name}.{name}: {error}") from None
        return values
