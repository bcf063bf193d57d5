"""Instances of an FMI 3.0 FMU, by Co-Simulation or Model Exchange."""

import ctypes
import os
from collections.abc import Callable
from typing import Any

from .intermediate_update import Intermediate
from .library import POINTER, REFERENCES, SIZE
from .unpacked import OpenedFmu

_LOG = ctypes.CFUNCTYPE(None, POINTER, ctypes.c_int, ctypes.c_char_p, ctypes.c_char_p)


class Instantiation:
    """The function that makes them. told : called with status, category and text of what an instance logs."""

    def __init__(self, opened: OpenedFmu, told: Callable[[int, bytes | None, bytes | None], None]) -> None:
        self._log = _LOG(lambda _, *line: told(*line))
        resources = f"{opened.folder / 'resources'}{os.sep}".encode()
        self._begin = opened.model.token.encode(), resources, False, True
        self._exchanged = opened.model.exchanged
        kinds = ctypes.c_char_p, ctypes.c_char_p, ctypes.c_char_p, ctypes.c_bool, ctypes.c_bool
        if self._exchanged:
            self._call = opened.library.function("fmi3InstantiateModelExchange", *kinds, POINTER, POINTER, result=POINTER)
        else:
            self._call = opened.library.function(
                "fmi3InstantiateCoSimulation", *kinds, ctypes.c_bool, ctypes.c_bool, REFERENCES, SIZE, POINTER, POINTER, POINTER,
                result=POINTER,
            )  # fmt: skip

    def instance(self, name: str, answers: Intermediate, *, with_events: bool) -> Any:
        """A new one, or None. answers : to what it asks within a step. with_events : event mode and early return are allowed."""
        begin = name.encode(), *self._begin
        if self._exchanged:
            return self._call(*begin, None, self._log)
        asked = answers.references, answers.count
        return self._call(*begin, with_events, with_events, *asked, None, self._log, answers.callback)
