"""Intermediate update of FMI 3.0 FMUs: within a step the FMU asks for its inputs at a time, and tells how far it has come."""

import ctypes
from collections.abc import Callable, Sequence
from typing import Any

import numpy as np

from .description import Description
from .library import POINTER, REFERENCES, SIZE, Library
from .rows import Row

_UPDATE = ctypes.CFUNCTYPE(
    None, POINTER, ctypes.c_double, ctypes.c_bool, ctypes.c_bool, ctypes.c_bool, ctypes.c_bool,
    ctypes.POINTER(ctypes.c_bool), ctypes.POINTER(ctypes.c_double),
)  # fmt: skip


def asked_for(description: Description) -> Sequence[Row]:
    """The continuous inputs, if the FMU asks for all of them within a step; else none."""
    rows = [r for r in description.rows if r.causality == "input" and r.type in ("Float64", "Float32")]
    smooth = [r for r in rows if r.variability == "continuous"]
    offered = all(r.type == "Float64" and r.intermediate for r in smooth)
    return smooth if offered and description.can("providesIntermediateUpdate") else ()


def told_of(description: Description) -> list[Row]:
    """The outputs that the FMU tells at the end of each step of its integrator."""
    able = description.can("providesIntermediateUpdate") and not description.exchanged
    return [r for r in description.rows if able and r.causality == "output" and r.type == "Float64" and r.intermediate]


class Intermediate:
    """What an FMU that asks for `rows` is answered, from the input polynomial of the step, and what it tells of `told`.

    references, count : of both, for instantiation; callback : its intermediateUpdate, None where there is neither.
    status : the worst that setting an answer, or reading what is told, has had in this step.
    hear : called with a time (s) and the values of `told` at the end of each step of the integrator.
    """

    def __init__(
        self, library: Library, rows: Sequence[Row], told: Sequence[Row] = (),
        hear: Callable[[float, Sequence[float]], None] | None = None,
    ) -> None:  # fmt: skip
        self.count, self._asked, self._told = len(rows) + len(told), len(rows), len(told)
        self.references = (ctypes.c_uint * self.count)(*(r.reference for r in (*rows, *told)))
        self._told_references = (ctypes.c_uint * self._told)(*(r.reference for r in told))
        self._values, self._hear = (ctypes.c_double * sum(r.size for r in told))(), hear
        self.status = 0
        self._value = (ctypes.c_double * sum(r.size for r in rows))()
        self._polynomial: list[tuple[float, float, float]] = []  # value, slope, half the curvature; empty where constant
        self._origin, self._instance = 0.0, None
        self._set = library.function("fmi3SetFloat64", POINTER, REFERENCES, SIZE, POINTER, SIZE)
        self._get = library.function("fmi3GetFloat64", POINTER, REFERENCES, SIZE, POINTER, SIZE)
        self.callback = _UPDATE(self._on_update) if rows or hear is not None else None

    def begin(self, instance: Any, U: np.ndarray, t: float) -> None:
        """A step of `instance` from t (s) with the polynomial U, shape (3, size of the rows), follows."""
        self._instance, self._origin, self.status, self._polynomial = instance, t, 0, []
        if U[1:].any():
            self._polynomial = [*zip(U[0].tolist(), U[1].tolist(), (U[2] / 2).tolist(), strict=True)]

    def _on_update(
        self, environment: Any, time: float, set_requested: bool, get_allowed: bool, step_finished: bool, can_return: bool,
        early_return_requested: Any, early_return_time: Any,
    ) -> None:  # fmt: skip
        early_return_requested[0] = False
        if set_requested and self._polynomial:
            s = time - self._origin
            self._value[:] = [u0 + s * (u1 + s * u2) for u0, u1, u2 in self._polynomial]
            status = self._set(self._instance, self.references, self._asked, self._value, len(self._value))
            self.status = max(self.status, status)
        if step_finished and get_allowed and self._hear is not None:
            status = self._get(self._instance, self._told_references, self._told, self._values, len(self._values))
            self.status = max(self.status, status)
            self._hear(time, self._values[:])
