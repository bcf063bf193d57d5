"""The functions of Model Exchange in an FMU of FMI 2.0 or 3.0, under one name each."""

import ctypes
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

from ..fmi.description import Description
from ..fmi.library import POINTER, SIZE, Library

Check = Callable[[int, str, float, float], None]


@dataclass(frozen=True)
class Update:
    """What an FMU answers to one round of event mode.

    more : another round is needed. ends : it wants the run to end. nominals : those of its states have changed.
    due : when its next time event is (s); infinite where it has none.
    """

    more: bool
    ends: bool
    nominals: bool
    due: float


class EventInfo2(ctypes.Structure):
    """fmi2EventInfo."""

    _fields_ = (
        ("more", ctypes.c_int), ("ends", ctypes.c_int), ("nominals", ctypes.c_int), ("states", ctypes.c_int),
        ("defined", ctypes.c_int), ("due", ctypes.c_double),
    )  # fmt: skip


class Functions:
    """Called with the instance; `check` raises for a bad status.

    set_time(instance, t) and set_states, get_states, rates, indicators, nominals(instance, address, n) return FMI's status.
    """

    def __init__(self, library: Library, model: Description, check: Check) -> None:
        two, arrays = model.version == "2", (POINTER, POINTER, SIZE)
        prefix = "fmi2" if two else "fmi3"

        def function(name: str, *types: Any) -> Any:
            return library.function(f"{prefix}{name}", *types)

        self.prefix, self._check = prefix, check
        self.rates_name = f"{prefix}Get{'Derivatives' if two else 'ContinuousStateDerivatives'}"
        self.set_time = function("SetTime", POINTER, ctypes.c_double)
        self.set_states, self.get_states = (function(f"{verb}ContinuousStates", *arrays) for verb in ("Set", "Get"))
        self.rates = library.function(self.rates_name, *arrays)
        self.indicators = function("GetEventIndicators", *arrays)
        self.nominals = function("GetNominalsOfContinuousStates", *arrays)
        self._enter_event_mode = function("EnterEventMode", POINTER)
        self._enter_continuous_time_mode = function("EnterContinuousTimeMode", POINTER)
        flag = ctypes.c_int if two else ctypes.c_bool
        self._completed = function("CompletedIntegratorStep", POINTER, flag, POINTER, POINTER)
        self._event, self._ends = flag(), flag()
        self._info, self._told, self._due = EventInfo2(), [flag() for _ in range(5)], ctypes.c_double()
        if two:
            self._update = function("NewDiscreteStates", POINTER, POINTER)
            self._told_by_update: tuple[Any, ...] = (ctypes.byref(self._info),)
            self._counts: tuple[Any, ...] = ()
        else:
            self._update = function("UpdateDiscreteStates", POINTER, *[POINTER] * 6)
            self._told_by_update = tuple(ctypes.byref(x) for x in (*self._told, self._due))
            self._counts = tuple(
                function(f"GetNumberOf{what}", POINTER, POINTER) for what in ("ContinuousStates", "EventIndicators")
            )
        self._model = model

    def enter_event_mode(self, instance: Any, t: float, h: float) -> None:
        """From continuous-time mode."""
        self._check(self._enter_event_mode(instance), f"{self.prefix}EnterEventMode", t, h)

    def enter_continuous_time_mode(self, instance: Any, t: float, h: float) -> None:
        """From event mode."""
        self._check(self._enter_continuous_time_mode(instance), f"{self.prefix}EnterContinuousTimeMode", t, h)

    def update(self, instance: Any, t: float, h: float) -> Update:
        """One round of event mode."""
        name = "NewDiscreteStates" if self.prefix == "fmi2" else "UpdateDiscreteStates"
        self._check(self._update(instance, *self._told_by_update), f"{self.prefix}{name}", t, h)
        if self.prefix == "fmi2":
            info = self._info
            more, ends, nominals, _, defined = (bool(getattr(info, name)) for name, _ in EventInfo2._fields_[:-1])
            due = info.due
        else:
            more, ends, nominals, _, defined = (bool(flag.value) for flag in self._told)
            due = self._due.value
        return Update(more, ends, nominals, due if defined else float("inf"))

    def completed(self, instance: Any, no_set_state: bool, t: float, h: float) -> tuple[bool, bool]:
        """After a step of the integrator: whether event mode shall be entered, and whether the FMU wants the run to end."""
        told = ctypes.byref(self._event), ctypes.byref(self._ends)
        self._check(self._completed(instance, no_set_state, *told), f"{self.prefix}CompletedIntegratorStep", t, h)
        return bool(self._event.value), bool(self._ends.value)

    def sizes(self, instance: Any, t: float) -> tuple[int, int]:
        """How many continuous states and event indicators the instance has, from the end of initialization mode on."""
        if not self._counts:
            return len(self._model.states), self._model.indicators
        found = []
        for count, what in zip(self._counts, ("ContinuousStates", "EventIndicators"), strict=True):
            n = SIZE()
            self._check(count(instance, ctypes.byref(n)), f"fmi3GetNumberOf{what}", t, 0.0)
            found.append(n.value)
        return found[0], found[1]
