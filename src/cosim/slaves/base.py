"""The interface between the master and a component."""

from abc import ABC, abstractmethod
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from types import MappingProxyType
from typing import Any

import numpy as np

from ..errors import unknown
from .signal import Given, Signal, Value

__all__ = ["RawFmu", "Signal", "Slave", "Value"]


@dataclass(frozen=True, eq=False)
class RawFmu:
    """What C code needs to drive an instance of an FMU: addresses as integers, value references as arrays.

    version : of FMI, 2 or 3.
    instance : of the FMU; valid until the slave starts anew or closes.
    set_real, get_real, do_step : fmi2SetReal, fmi2GetReal, fmi2DoStep, or fmi3SetFloat64, fmi3GetFloat64, fmi3DoStep.
    set_derivatives : fmi2SetRealInputDerivatives, or 0 where the FMU follows constant inputs only.
    asks : whether it asks for its inputs within a step, which the slave answers: C code may then hold inputs only.
    u_refs, y_refs : uint32, shapes (n_u,) and (n_y,), of the inputs and outputs in the order of U and y.
    du_refs, du_orders : uint32 and int32, shape (2 n_u,): of U[1], then of U[2]; the first n_u are those of U[1] alone.
    no_set_state : what to pass as noSetFMUStatePriorToCurrentPoint.
    check : check(status, name of the call, t, h) raises the slave's SlaveError, with its log, for a status above 1.
    step_failed : step_failed(status, t, h) raises what a step with such a status means.
    told : of FMI 3.0, what doStep answers: flags of event, end and early return, and from byte 8 on the time reached.
    finish_step : of FMI 3.0: finish_step(U, t, h, begun) does what is left of a step that returned with one of the flags or
        short of its end, or, where it has not begun, the whole of it.
    due : of FMI 3.0, the time (s) from which on a step must be left to finish_step from its begin.
    """

    version: int
    instance: int
    set_real: int
    get_real: int
    do_step: int
    set_derivatives: int
    u_refs: np.ndarray
    y_refs: np.ndarray
    du_refs: np.ndarray
    du_orders: np.ndarray
    no_set_state: int
    check: Callable[[int, str, float, float], None]
    step_failed: Callable[[int, float, float], None]
    asks: bool = False
    told: np.ndarray | None = None
    finish_step: Callable[[np.ndarray, float, float, bool], None] | None = None
    due: Callable[[], float] | None = None


@dataclass(frozen=True, eq=False)
class StateSpace:
    """A slave linearised where it stands: x' = A x + B u, y = C x + D u, of its continuous states and smooth real signals.

    Shapes: A (n_x, n_x), B (n_x, n_u), C (n_y, n_x), D (n_y, n_u); zero for signals that are not smooth.
    """

    A: np.ndarray
    B: np.ndarray
    C: np.ndarray
    D: np.ndarray


class Slave(ABC):
    """A component between communication points; a step may be repeated after restore().

    name : its name in the system.
    inputs, outputs : the signals u and y, in the order of the arrays below.
    settable : what may be given a value before the run, by name: parameters, start values, unconnected inputs.
    excluded : name -> what it is, of variables that take no part in connections (strings, clocks, ...).
    feedthrough : boolean (n_y, n_u), which output depends directly on which input.
    initial_feedthrough : the same in initialization mode; None: no other.
    input_degree : highest degree of an input polynomial that step() follows.
    can_restore : whether save() and restore() work.
    can_serialize : whether serialize() and deserialize() work.
    events : handled since begin(); None where the slave does not tell.
    raw : from finish() on, how C code can step it, where it is an FMU of this process with real signals only.
    """

    name: str
    inputs: tuple[Signal, ...]
    outputs: tuple[Signal, ...]
    settable: Mapping[str, Signal]
    excluded: Mapping[str, str] = MappingProxyType({})
    feedthrough: np.ndarray
    initial_feedthrough: np.ndarray | None = None
    input_degree: int
    can_restore: bool
    can_serialize: bool
    events: int | None = None
    raw: RawFmu | None = None

    @abstractmethod
    def begin(self, values: Mapping[str, Value], t: float, stop: float) -> None:
        """Start anew at `t` (s) with start values by name, into initialization mode; `stop` (s) is when the run will end.

        There output() may be asked again and again, until the inputs and outputs of all slaves agree.
        """

    @abstractmethod
    def finish(self) -> None:
        """Leave initialization mode; only now may steps follow."""

    def initialize(self, values: Mapping[str, Value], t: float, stop: float) -> None:
        """begin() and finish(), for a slave that nothing is connected to."""
        self.begin(values, t, stop)
        self.finish()

    @abstractmethod
    def output(self, u: np.ndarray, t: float) -> np.ndarray:
        """y at the present time `t` (s) for inputs u, shape (n_u,); returns shape (n_y,), the caller's own."""

    @abstractmethod
    def step(self, U: np.ndarray, t: float, h: float) -> None:
        """From t to t + h (s) under u(t + s) = U[0] + U[1] s + U[2] s^2 / 2; U has shape (3, n_u).

        EndRequest where the slave has come to the end that it wants.
        """

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
    def serialize(self) -> bytes:
        """The present state for another process; ValueError names the component if it cannot."""

    @abstractmethod
    def deserialize(self, data: bytes) -> None:
        """Go to a state that serialize() gave for the same component; begin() with the same values and finish() come first."""

    @abstractmethod
    def jacobian(self) -> np.ndarray | None:
        """dy/du at the present state and inputs of the last output(), shape (n_y, n_u); None where the slave offers none.

        Zero for signals that are not smooth.
        """

    @abstractmethod
    def state_space(self) -> StateSpace | None:
        """The linearisation at the present state and inputs; None where the slave does not give it."""

    @abstractmethod
    def close(self) -> None:
        """Free everything; the slave is of no use afterwards."""

    def start_values(self, given: Mapping[str, Given], bound: Mapping[str, Given] = MappingProxyType({})) -> dict[str, Value]:
        """Values by name in the slave's own units; ValueError names component, variable, rule and value.

        bound : values from parameter files, which count where `given` says nothing and the slave has such a variable.
        """
        for name in given:
            if name not in self.settable:
                raise unknown(f"parameter of {self.name!r}:", name, self.settable)
        values = {}
        for name, value in {**{n: v for n, v in bound.items() if n in self.settable}, **given}.items():
            try:
                values[name] = self.settable[name].value(value)
            except ValueError as error:
                raise ValueError(f"{self.name}.{name}: {error}") from None
        return values
