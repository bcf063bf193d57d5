"""Inputs of higher degree for FMI 3.0 FMUs: by intermediate update the FMU asks, within a step, for its inputs at a time."""

import ctypes
from collections.abc import Sequence
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


class IntermediateInputs:
    """What an FMU that asks for `rows` is answered, from the input polynomial of the step.

    references, count : of the inputs, for instantiation; callback : its intermediateUpdate, None where it asks for nothing.
    status : the worst that setting an answer has had in this step.
    """

    def __init__(self, library: Library, rows: Sequence[Row]) -> None:
        self.count = len(rows)
        self.references = (ctypes.c_uint * self.count)(*(r.reference for r in rows))
        self.status = 0
        self._value = (ctypes.c_double * sum(r.size for r in rows))()
        self._polynomial: list[tuple[float, float, float]] = []  # value, slope, half the curvature; empty where constant
        self._origin, self._instance = 0.0, None
        self._set = library.function("fmi3SetFloat64", POINTER, REFERENCES, SIZE, POINTER, SIZE)
        self.callback = _UPDATE(self._on_update) if rows else None

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
            status = self._set(self._instance, self.references, self.count, self._value, len(self._value))
            self.status = max(self.status, status)
