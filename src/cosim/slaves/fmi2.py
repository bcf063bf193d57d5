"""An FMI 2.0 Co-Simulation FMU as a slave: FMPy reads and loads it, the run calls its functions directly."""

import ctypes
import shutil
import tempfile
import zipfile
from collections.abc import Mapping
from math import isfinite
from pathlib import Path
from typing import Any

import fmpy
import numpy as np
from fmpy.fmi2 import (
    FMU2Slave,
    fmi2CallbackAllocateMemoryTYPE,
    fmi2CallbackFreeMemoryTYPE,
    fmi2CallbackFunctions,
    fmi2CallbackLoggerTYPE,
)

from cosim.errors import SlaveError
from cosim.slaves.base import RawFmi2, Signal, Slave

STATUS = ("ok", "warning", "discard", "error", "fatal", "pending")
_DOUBLES = ctypes.POINTER(ctypes.c_double)
_REFERENCES = ctypes.POINTER(ctypes.c_uint)


class Fmi2Slave(Slave):
    """Opens the FMU in a temporary folder that close() removes. Signals are its Real inputs and outputs."""

    def __init__(self, name: str, file: Path) -> None:
        self.name = name
        self._file = file
        self._log: list[str] = []
        self._running = False
        description = _read_description(file)
        self._description = description
        folder = self._folder = Path(tempfile.mkdtemp(prefix="cosim-"))
        try:
            _unpack(file, folder)
            library = (
                folder / "binaries" / fmpy.platform / (description.coSimulation.modelIdentifier + fmpy.sharedLibraryExtension)
            )
            if not library.is_file():
                held = sorted(p.name for p in (folder / "binaries").glob("*")) if (folder / "binaries").is_dir() else []
                raise ValueError(f"FMU {str(file)!r} must hold a binary for {fmpy.platform}, has {', '.join(held) or 'none'}")
            try:
                self._fmu = FMU2Slave(
                    guid=description.guid,
                    modelIdentifier=description.coSimulation.modelIdentifier,
                    unzipDirectory=str(folder),
                    instanceName=name,
                    libraryPath=str(library),
                )
            except Exception as error:  # FMPy raises bare Exceptions
                raise ValueError(f"FMU {str(file)!r}: its binary cannot be loaded: {error}") from error
        except BaseException:
            shutil.rmtree(folder, ignore_errors=True)
            raise
        try:
            self._describe(description)
            self._bind()
        except BaseException:
            self.close()
            raise

    def _describe(self, description: Any) -> None:
        cosimulation = description.coSimulation
        self.can_restore = bool(cosimulation.canGetAndSetFMUstate)
        self.can_serialize = self.can_restore and bool(cosimulation.canSerializeFMUstate)
        self._differentiable = bool(cosimulation.providesDirectionalDerivative)
        derivatives = bool(cosimulation.canInterpolateInputs)
        self.input_degree = 2 if derivatives else 0
        self._reference = {v.name: v.valueReference for v in description.modelVariables}
        self._type = {v.name: v.type for v in description.modelVariables}
        real = [v for v in description.modelVariables if v.type == "Real"]
        self.inputs = tuple(_signal(v, "input") for v in real if v.causality == "input")
        self.outputs = tuple(_signal(v, "output") for v in real if v.causality == "output")
        self.settable = {
            v.name: _signal(v, "parameter" if v.causality == "parameter" else "input" if v.causality == "input" else "state")
            for v in description.modelVariables
            if v.type in ("Real", "Integer", "Boolean", "Enumeration")
            and (v.causality in ("parameter", "input") or v.initial in ("exact", "approx"))
            and v.variability != "constant"
        }
        place = {s.name: i for i, s in enumerate(self.inputs)}
        row = {s.name: i for i, s in enumerate(self.outputs)}
        self.feedthrough = np.zeros((len(self.outputs), len(self.inputs)), dtype=bool)
        stated = {unknown.variable.name: unknown.dependencies for unknown in description.outputs}
        for name, i in row.items():
            dependencies = stated.get(name)
            if dependencies is None:
                self.feedthrough[i, :] = True  # the standard: not stated means on everything
            else:
                for known in dependencies:
                    if known.name in place:
                        self.feedthrough[i, place[known.name]] = True

    def _bind(self) -> None:
        """Fixed arrays and foreign functions for the calls of every step."""
        n_u, n_y = len(self.inputs), len(self.outputs)
        self._u, self._y = np.zeros(n_u), np.zeros(n_y)
        self._du = np.zeros(2 * n_u)
        u_refs = [self._reference[s.name] for s in self.inputs]
        self._u_refs = (ctypes.c_uint * n_u)(*u_refs)
        self._du_refs = (ctypes.c_uint * (2 * n_u))(*u_refs, *u_refs)
        self._du_orders = (ctypes.c_int * (2 * n_u))(*[1] * n_u, *[2] * n_u)
        self._y_refs = (ctypes.c_uint * n_y)(*(self._reference[s.name] for s in self.outputs))
        self._u_pointer, self._y_pointer, self._du_pointer = (a.ctypes.data_as(_DOUBLES) for a in (self._u, self._y, self._du))
        library, pointer, size = self._fmu.dll, ctypes.c_void_p, ctypes.c_size_t

        def function(name: str, *types: Any) -> Any:
            found = library[name]  # an own handle: its argument types are ours to state
            found.argtypes, found.restype = [pointer, *types], ctypes.c_int
            return found

        self._set_real = function("fmi2SetReal", _REFERENCES, size, _DOUBLES)
        self._get_real = function("fmi2GetReal", _REFERENCES, size, _DOUBLES)
        self._do_step = function("fmi2DoStep", ctypes.c_double, ctypes.c_double, ctypes.c_int)
        self._set_derivatives = function("fmi2SetRealInputDerivatives", _REFERENCES, size, ctypes.POINTER(ctypes.c_int), _DOUBLES)

    def initialize(self, values: Mapping[str, float], t: float, stop: float) -> None:
        self._free_instance()
        self._log.clear()
        self._guard(t, "instantiation", lambda: self._fmu.instantiate(callbacks=self._callbacks(), loggingOn=True))
        for name, value in values.items():
            self._guard(t, f"setting {name!r}", lambda name=name, value=value: self._set(name, value))
        self._guard(t, "fmi2SetupExperiment", lambda: self._fmu.setupExperiment(startTime=t, stopTime=stop))
        self._guard(t, "fmi2EnterInitializationMode", self._fmu.enterInitializationMode)
        self._guard(t, "fmi2ExitInitializationMode", self._fmu.exitInitializationMode)
        self._running, self._orders = True, 0
        self._instance = self._fmu.component
        self.raw = self._raw()
        if self.inputs:
            self._check(self._get_real(self._instance, self._u_refs, self._u.size, self._u_pointer), "fmi2GetReal", t, 0.0)

    def _set(self, name: str, value: float) -> None:
        reference = [self._reference[name]]
        if self._type[name] == "Real":
            self._fmu.setReal(reference, [value])
        elif self._type[name] == "Boolean":
            self._fmu.setBoolean(reference, [bool(value)])
        else:
            self._fmu.setInteger(reference, [int(value)])

    def output(self, u: np.ndarray, t: float) -> np.ndarray:
        if self._u.size:
            self._u[:] = u
            self._check(self._set_real(self._instance, self._u_refs, self._u.size, self._u_pointer), "fmi2SetReal", t, 0.0)
        self._check(self._get_real(self._instance, self._y_refs, self._y.size, self._y_pointer), "fmi2GetReal", t, 0.0)
        if not isfinite(np.add.reduce(self._y)):
            for signal, value in zip(self.outputs, self._y, strict=True):
                if not np.isfinite(value):
                    raise SlaveError(self.name, t, 0.0, f"output {signal.name!r} must be finite, got {value}", self._said())
        return self._y.copy()

    def step(self, U: np.ndarray, t: float, h: float) -> None:
        instance = self._instance
        if self._u.size:
            self._u[:] = U[0]
            self._check(self._set_real(instance, self._u_refs, self._u.size, self._u_pointer), "fmi2SetReal", t, h)
            if self.input_degree:
                if self._orders < 2:  # an FMU hears of a derivative from when it first differs from zero
                    self._orders = 2 if U[2].any() else 1 if U[1].any() else self._orders
                if self._orders:
                    self._du[:] = U[1:].ravel()
                    n = self._orders * self._u.size
                    status = self._set_derivatives(instance, self._du_refs, n, self._du_orders, self._du_pointer)
                    self._check(status, "fmi2SetRealInputDerivatives", t, h)
        self._check(self._do_step(instance, t, h, 1 - self.can_restore), "fmi2DoStep", t, h)

    def save(self) -> Any:
        return self._fmu.getFMUstate()

    def restore(self, snapshot: Any) -> None:
        self._fmu.setFMUstate(snapshot)

    def discard(self, snapshot: Any) -> None:
        self._fmu.freeFMUstate(snapshot)

    def serialize(self) -> bytes:
        if not self.can_serialize:
            raise ValueError(f"component {self.name!r} must be able to serialize its state, FMU {str(self._file)!r} cannot")
        state = self._fmu.getFMUstate()
        try:
            return bytes([self._orders]) + bytes(self._fmu.serializeFMUstate(state))
        finally:
            self._fmu.freeFMUstate(state)

    def deserialize(self, data: bytes) -> None:
        if not self.can_serialize:
            raise ValueError(f"component {self.name!r} must be able to serialize its state, FMU {str(self._file)!r} cannot")
        state = self._fmu.deSerializeFMUstate(data[1:])
        try:
            self._fmu.setFMUstate(state)
            self._orders = data[0]
        finally:
            self._fmu.freeFMUstate(state)

    def jacobian(self) -> np.ndarray | None:
        if not self._differentiable:
            return None
        found = np.zeros((len(self.outputs), len(self.inputs)))
        for j in np.flatnonzero(self.feedthrough.any(axis=0)).tolist():
            found[:, j] = self._fmu.getDirectionalDerivative(list(self._y_refs), [self._u_refs[j]], [1.0])
        return found

    def _raw(self) -> RawFmi2:
        def address(function: Any) -> int:
            return ctypes.cast(function, ctypes.c_void_p).value or 0

        def array(references: Any, kind: Any) -> np.ndarray:
            return np.array(references, dtype=kind)

        instance = self._instance if isinstance(self._instance, int) else self._instance.value
        return RawFmi2(
            instance, address(self._set_real), address(self._get_real), address(self._do_step),
            address(self._set_derivatives) if self.input_degree else 0,
            array(self._u_refs, np.uint32), array(self._y_refs, np.uint32),
            array(self._du_refs, np.uint32), array(self._du_orders, np.int32), 1 - self.can_restore, self._check,
        )  # fmt: skip

    def close(self) -> None:
        self._free_instance()
        if self._folder.is_dir():
            self._fmu.freeLibrary()
            shutil.rmtree(self._folder, ignore_errors=True)

    def _free_instance(self) -> None:
        if self._fmu.component is None:
            return
        if self._running:
            self._running = False
            try:
                self._fmu.terminate()
            except Exception as error:  # a failed FMU may refuse; the run's own error is the one to report
                self._log.append(str(error))
        self._fmu.fmi2FreeInstance(self._fmu.component)  # FMPy's freeInstance would unload the library too
        self._fmu.component = self.raw = None

    def _check(self, status: int, call: str, t: float, h: float) -> None:
        if status > 1:
            self._running = False
            raise SlaveError(self.name, t, h, f"{call} answered {STATUS[status] if status < 6 else status}", self._said())

    def _guard(self, t: float, what: str, call: Any) -> None:
        """A call through FMPy, whose failures are bare Exceptions."""
        try:
            call()
        except Exception as error:
            raise SlaveError(self.name, t, 0.0, f"{what} failed: {error}", self._said()) from error

    def _said(self) -> str:
        return "; ".join(self._log[-3:])

    def _callbacks(self) -> fmi2CallbackFunctions:
        """Callbacks that keep what the FMU logs, and allocate as FMPy does."""
        log = self._log

        def logger(environment: Any, instance: bytes, status: int, category: bytes, message: bytes) -> None:
            if status > 0 and len(log) < 1000:
                log.append((message or b"").decode(errors="replace"))

        callbacks = fmi2CallbackFunctions()
        callbacks.logger = fmi2CallbackLoggerTYPE(logger)
        callbacks.allocateMemory = fmi2CallbackAllocateMemoryTYPE(fmpy.calloc)
        callbacks.freeMemory = fmi2CallbackFreeMemoryTYPE(fmpy.free)
        return callbacks


def _read_description(file: Path) -> Any:
    """The model description of an FMI 2.0 Co-Simulation FMU; ValueError names the file and what is wrong with it."""
    if not file.is_file():
        raise ValueError(f"FMU {str(file)!r} must exist")
    if not zipfile.is_zipfile(file):
        raise ValueError(f"FMU {str(file)!r} must be a zip archive")
    try:
        description = fmpy.read_model_description(str(file))
    except Exception as error:  # FMPy raises bare Exceptions, of several lines
        reason = " ".join(str(error).split()) or type(error).__name__
        raise ValueError(f"FMU {str(file)!r}: its model description cannot be used: {reason}") from error
    if not description.fmiVersion.startswith("2"):
        raise ValueError(f"FMU {str(file)!r} must be FMI 2.0, got FMI {description.fmiVersion}")
    if description.coSimulation is None:
        raise ValueError(f"FMU {str(file)!r} must offer Co-Simulation, offers Model Exchange only")
    return description


def _unpack(file: Path, folder: Path) -> None:
    """Binaries, resources and the description, and no member that points outside."""
    with zipfile.ZipFile(file) as archive:
        for member in archive.namelist():
            if not (folder / member).resolve().is_relative_to(folder.resolve()):
                raise ValueError(f"FMU {str(file)!r}: member {member!r} must lie inside the archive")
        wanted = ("binaries/", "resources/", "modelDescription.xml")
        archive.extractall(folder, [m for m in archive.namelist() if m.startswith(wanted)])


def _signal(variable: Any, kind: Any) -> Signal:
    def number(value: Any) -> float | None:
        return None if value in (None, "") or variable.type in ("String", "Boolean") else float(value)

    declared = getattr(variable, "declaredType", None)

    def attribute(name: str) -> Any:
        value = getattr(variable, name, None)
        return getattr(declared, name, None) if value in (None, "") and declared is not None else value

    return Signal(
        variable.name, kind, attribute("unit") or "", number(variable.start), number(attribute("min")),
        number(attribute("max")), variable.description or "",
    )  # fmt: skip
