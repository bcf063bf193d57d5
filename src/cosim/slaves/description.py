"""What a slave is, as one frozen value: the same for an FMU, a component in this process, an isolated and a remote one."""

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from types import MappingProxyType

import numpy as np

from ..errors import unknown
from .signal import Given, Signal, Value


@dataclass(frozen=True, eq=False)
class SlaveDescription:
    """Signals and abilities of a slave; nothing in it changes, whatever the slave does.

    Parameters
    ----------
    inputs, outputs : tuple of Signal
        The signals u, n_u of them, and y, n_y of them, in the order of a slave's arrays.
    settable : mapping of str to Signal
        What may be given a value before the run: parameters, start values, unconnected inputs.
    feedthrough : ndarray of bool, shape (n_y, n_u)
        Which output depends directly on which input.
    initial_feedthrough : ndarray of bool, shape (n_y, n_u)
        The same in initialization mode; where None is given, no other.
    excluded : mapping of str to str
        Name and type of variables that take no part in connections.
    text_inputs, text_outputs : tuple of Signal
        Strings and binaries, which are passed on at communication points.
    input_degree : int
        Highest degree of an input polynomial that the slave follows: 0, 1 or 2.
    can_restore, can_serialize : bool
        Whether it can go back to a state, and whether a state can be written as bytes.
    counts_events : bool
        Whether it says how many events it has had.
    clock_inputs, clock_outputs : tuple of str
        Clocks that other components tick, and that tick those of others: output clocks, and clocks with an interval of their own.
    clocked : mapping of str to tuple of str
        The clocks of each clocked input, by name: it is set where one of them ticks, and only there.
    tunable : frozenset of str
        Parameters that may be given a value between two steps, see base.Tunable.
    variable_steps : bool
        Whether macro steps may differ in length.
    fixed_step : float
        The length of its own steps, of which macro steps must be whole numbers, s; 0 where it has none or does not say.
    """

    inputs: tuple[Signal, ...]
    outputs: tuple[Signal, ...]
    settable: Mapping[str, Signal]
    feedthrough: np.ndarray
    initial_feedthrough: np.ndarray = field(default=None)  # type: ignore[arg-type]
    excluded: Mapping[str, str] = field(default_factory=dict)
    input_degree: int = 0
    can_restore: bool = False
    can_serialize: bool = False
    counts_events: bool = False
    tunable: frozenset[str] = frozenset()
    clock_inputs: tuple[str, ...] = ()
    clock_outputs: tuple[str, ...] = ()
    clocked: Mapping[str, tuple[str, ...]] = field(default_factory=dict)
    text_inputs: tuple[Signal, ...] = ()
    text_outputs: tuple[Signal, ...] = ()
    variable_steps: bool = True
    fixed_step: float = 0.0

    def __post_init__(self) -> None:
        if self.initial_feedthrough is None:
            object.__setattr__(self, "initial_feedthrough", self.feedthrough)
        for name in ("feedthrough", "initial_feedthrough"):
            matrix = np.array(getattr(self, name), dtype=bool).reshape(len(self.outputs), len(self.inputs))
            matrix.flags.writeable = False
            object.__setattr__(self, name, matrix)

    def without_events(self) -> "SlaveDescription":
        """The same without event mode, and without clocks then."""
        return replace(self, counts_events=False, clock_inputs=(), clock_outputs=(), clocked={})

    def start_values(
        self, component: str, given: Mapping[str, Given], bound: Mapping[str, Given] = MappingProxyType({})
    ) -> dict[str, Value]:
        """Values by name in the slave's own units.

        Parameters
        ----------
        component : str
            What the slave is called in its system, for messages.
        given : mapping
            Values that must all belong to the slave.
        bound : mapping
            Values from parameter files, which count where `given` says nothing and the slave has such a variable.

        Raises
        ------
        ValueError
            Names component, variable, rule and value.
        """
        for name in given:
            if name not in self.settable and name in self.excluded:
                raise ValueError(f"{component}.{name} must be something that takes a value, is a {self.excluded[name]}")
            if name not in self.settable:
                raise unknown(f"parameter of {component!r}:", name, self.settable)
        values = {}
        for name, value in {**{n: v for n, v in bound.items() if n in self.settable}, **given}.items():
            try:
                values[name] = self.settable[name].value(value)
            except ValueError as error:
                raise ValueError(f"{component}.{name}: {error}") from None
        return values
