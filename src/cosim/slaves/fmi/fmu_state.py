"""Saving an FMU's state, in memory and as bytes: the functions of FMI 2.0 and 3.0 differ in their names only."""

import ctypes
from collections.abc import Callable
from typing import Any

from .library import Library

_POINTER, _SIZE = ctypes.c_void_p, ctypes.c_size_t


class States:
    """The functions for the states of an FMU's instances; `check` raises for a bad status.

    _held : of each saved state that is not discarded, by its address, the time (s); infinite until the next step tells it.
    """

    def __init__(
        self, library: Library, prefix: str, state: str, check: Callable[[int, str, float, float], None], *, serialize: bool
    ) -> None:
        self._check, self._prefix, self._state = check, prefix, state
        self._held: dict[int | None, float] = {}
        self._get = library.function(f"{prefix}Get{state}", _POINTER, _POINTER)
        self._set = library.function(f"{prefix}Set{state}", _POINTER, _POINTER)
        self._free = library.function(f"{prefix}Free{state}", _POINTER, _POINTER)
        if serialize:
            self._size = library.function(f"{prefix}Serialized{state}Size", _POINTER, _POINTER, _POINTER)
            self._write = library.function(f"{prefix}Serialize{state}", _POINTER, _POINTER, ctypes.c_char_p, _SIZE)
            self._spelling = "DeSerialize" if prefix == "fmi2" else "Deserialize"
            self._read = library.function(f"{prefix}{self._spelling}{state}", _POINTER, ctypes.c_char_p, _SIZE, _POINTER)

    def save(self, instance: Any) -> Any:
        """A copy of the state, to be freed by discard()."""
        state = ctypes.c_void_p()
        self._check(self._get(instance, ctypes.byref(state)), f"{self._prefix}Get{self._state}", 0.0, 0.0)
        self._held[state.value] = float("inf")
        return state

    def final(self, t: float) -> bool:
        """What FMI calls noSetFMUStatePriorToCurrentPoint of a step from t (s): no state is held that is of an earlier time."""
        for address, time in self._held.items():
            self._held[address] = min(time, t)
        return all(time >= t for time in self._held.values())

    def forget(self) -> None:
        """The instance is gone, and all its states with it."""
        self._held.clear()

    def restore(self, instance: Any, state: Any) -> None:
        """Go back to it."""
        self._check(self._set(instance, state), f"{self._prefix}Set{self._state}", 0.0, 0.0)

    def discard(self, instance: Any, state: Any) -> None:
        """Free it."""
        self._held.pop(state.value, None)
        self._free(instance, ctypes.byref(state))

    def serialize(self, instance: Any) -> bytes:
        """The present state as bytes."""
        state = self.save(instance)
        try:
            size = _SIZE()
            status = self._size(instance, state, ctypes.byref(size))
            self._check(status, f"{self._prefix}Serialized{self._state}Size", 0.0, 0.0)
            data = ctypes.create_string_buffer(size.value)
            status = self._write(instance, state, data, size.value)
            self._check(status, f"{self._prefix}Serialize{self._state}", 0.0, 0.0)
            return data.raw
        finally:
            self.discard(instance, state)

    def deserialize(self, instance: Any, data: bytes) -> None:
        """Go to a state that serialize() gave."""
        state = ctypes.c_void_p()
        status = self._read(instance, data, len(data), ctypes.byref(state))
        self._check(status, f"{self._prefix}{self._spelling}{self._state}", 0.0, 0.0)
        try:
            self.restore(instance, state)
        finally:
            self.discard(instance, state)
