"""The interface between the master and a component: what every slave has, and what some can do besides.

Every slave is called in this order, and in no other:

    1. `description` may be read at any time from the constructor on. A slave that is `Promised` is told before `begin` how the
       run will use it, and may then say that it can do less.
    2. `begin` starts a run and enters initialization mode.
    3. `output` may now be asked again and again, until the inputs and outputs of all slaves agree.
    4. `finish` leaves initialization mode.
    5. `output` and `step` follow in any number. A step begins where the last one ended; before it, `output` may be asked with
       other inputs at the same time. From 3 on, `texts` and `give_texts` may stand wherever `output` may.
    6. Between two calls of 5 a slave that can may `save` its state, `restore` a saved one (the next step then begins there),
       `discard` one, `serialize`, be tuned or be linearised.
       From 2 on a slave with clocks may be told in `expect` what ticks, and asked by `take_ticks` what has ticked.
    7. `begin` starts the next run, from 2. `close` ends it all.

After an exception of its own a slave is broken: only 7 may follow. EndRequest is no failure; `output` may be asked once more.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from .description import SlaveDescription
from .signal import Signal, Text, Value
from .tick import Tick

if TYPE_CHECKING:
    from .usage import Usage


@dataclass(frozen=True, eq=False)
class StateSpace:
    """A slave linearised where it stands: x' = A x + B u, y = C x + D u, of its continuous states and smooth real signals.

    Shapes: A (n_x, n_x), B (n_x, n_u), C (n_y, n_x), D (n_y, n_u); zero for signals that are not smooth.
    """

    A: np.ndarray
    B: np.ndarray
    C: np.ndarray
    D: np.ndarray


@dataclass(frozen=True)
class Counts:
    """What a slave has counted since begin(): events, None where it does not tell; warnings, and the text of the first."""

    events: int | None = None
    warnings: int = 0
    first_warning: str = ""


class Slave(ABC):
    """A component between communication points; the module's docstring has the order of calls.

    name : what it is called in its system. description : what it is.
    """

    name: str
    description: SlaveDescription

    @property
    def inputs(self) -> tuple[Signal, ...]:
        """The signals u, in the order of the arrays below."""
        return self.description.inputs

    @property
    def outputs(self) -> tuple[Signal, ...]:
        """The signals y, in the order of the arrays below."""
        return self.description.outputs

    @abstractmethod
    def begin(self, values: Mapping[str, Value], t: float, stop: float) -> None:
        """Start anew at `t` (s) with start values by name, into initialization mode; `stop` (s) is when the run will end."""

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
    def close(self) -> None:
        """Free everything; the slave is of no use afterwards."""


class Promised(Slave):
    """A slave that is told how a run will use it; tell it with usage.promise()."""

    @abstractmethod
    def promise(self, usage: Usage, values: Mapping[str, Value], t: float, stop: float) -> tuple[str, ...]:
        """See usage.promise(); called before begin()."""


class Restorable(Slave):
    """A slave that can go back, where `description.can_restore` says so; ask with restorable()."""

    @abstractmethod
    def save(self) -> Any:
        """The present state; valid until discard()."""

    @abstractmethod
    def restore(self, snapshot: Any) -> None:
        """Go back to a state that save() returned."""

    @abstractmethod
    def discard(self, snapshot: Any) -> None:
        """Free what save() returned."""


class Serializable(Restorable):
    """A slave whose state can be written, where `description.can_serialize` says so; ask with serializable()."""

    @abstractmethod
    def serialize(self) -> bytes:
        """The present state for another process."""

    @abstractmethod
    def deserialize(self, data: bytes) -> None:
        """Go to a state that serialize() gave for the same component; begin() with the same values and finish() come first."""


class Linearisable(Slave):
    """A slave that may give its derivatives; ask with linearisation()."""

    @abstractmethod
    def state_space(self) -> StateSpace | None:
        """The linearisation at the present state and inputs; None where the slave does not give it."""


class Tunable(Slave):
    """A slave whose parameters may change on the way, as far as `description.tunable` says so; ask with tunable()."""

    @abstractmethod
    def tune(self, values: Mapping[str, Value], t: float) -> None:
        """Give parameters new values, by name, at the present time `t` (s), between two steps."""


class Texting(Slave):
    """A slave with strings or binaries that can be connected; ask with texting()."""

    @abstractmethod
    def texts(self, t: float) -> tuple[Text, ...]:
        """Its text outputs at the present time t (s), in the order of the description."""

    @abstractmethod
    def give_texts(self, texts: Mapping[str, Text], t: float) -> bool:
        """Text inputs by name, at the present time t (s); whether one of them is another than before."""


class Clocked(Slave):
    """A slave with clocks that can be connected; ask with clocked()."""

    @abstractmethod
    def expect(self, ticks: Sequence[Tick]) -> None:
        """Ticks of its input clocks that are to come: in the next step, or in finish(). One that is late comes at once there."""

    @abstractmethod
    def take_ticks(self) -> Sequence[Tick]:
        """What its output clocks have ticked since it was called last, in the order of time. Nothing is noted before the first
        call, which stands between begin() and finish()."""


class Counting(Slave):
    """A slave that counts; ask with counts()."""

    @property
    @abstractmethod
    def counts(self) -> Counts:
        """Since begin()."""


def restorable(slave: Slave) -> Restorable | None:
    """`slave`, if it can go back to a state; else None."""
    return slave if isinstance(slave, Restorable) and slave.description.can_restore else None


def serializable(slave: Slave) -> Serializable | None:
    """`slave`, if its state can be written; else None."""
    return slave if isinstance(slave, Serializable) and slave.description.can_serialize else None


def linearisation(slave: Slave) -> StateSpace | None:
    """The linearisation of `slave` where it stands; None where it gives none."""
    return slave.state_space() if isinstance(slave, Linearisable) else None


def tunable(slave: Slave) -> Tunable | None:
    """`slave`, if any of its parameters may change on the way; else None."""
    return slave if isinstance(slave, Tunable) and slave.description.tunable else None


def texting(slave: Slave) -> Texting | None:
    """`slave`, if it has texts that can be connected; else None."""
    d = slave.description
    return slave if isinstance(slave, Texting) and (d.text_inputs or d.text_outputs) else None


def clocked(slave: Slave) -> Clocked | None:
    """`slave`, if it has clocks that can be connected; else None."""
    d = slave.description
    return slave if isinstance(slave, Clocked) and (d.clock_inputs or d.clock_outputs) else None


def counts(slave: Slave) -> Counts:
    """What `slave` has counted; nothing where it does not count."""
    return slave.counts if isinstance(slave, Counting) else Counts()
