"""An instance of the FMU under check, with one interface for FMI 2.0 and 3.0, Co-Simulation and Model Exchange."""

import ctypes
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from ..slaves.fmi.description import REAL
from .description import number


class Refused(Exception):
    """A call that the FMU did not answer with OK or Warning."""


class Instance:
    """A fresh instance; real scalar variables only. `kind` is "cs" or "me"."""

    def __init__(self, model: Any, folder: Path, kind: str, name: str = "instance") -> None:
        from fmpy.fmi2 import FMU2Model, FMU2Slave
        from fmpy.fmi3 import FMU3Model, FMU3Slave

        self.model, self.kind, self.version = model, kind, model.fmiVersion[0]
        self.interface = model.coSimulation if kind == "cs" else model.modelExchange
        classes = {"2cs": FMU2Slave, "2me": FMU2Model, "3cs": FMU3Slave, "3me": FMU3Model}
        self._fmu = classes[self.version + kind](
            guid=model.guid, modelIdentifier=self.interface.modelIdentifier, unzipDirectory=str(folder), instanceName=name
        )
        self.reference = {v.name: v.valueReference for v in model.modelVariables}
        self._call("Instantiate", lambda: self._fmu.instantiate(**self._silent()))

    def _silent(self) -> dict[str, Any]:
        """Callbacks that say nothing."""
        if self.version == "3":
            return {"logMessage": lambda *_: None}
        from fmpy.fmi2 import defaultCallbacks, fmi2CallbackFunctions, fmi2CallbackLoggerTYPE

        callbacks = fmi2CallbackFunctions.from_buffer_copy(defaultCallbacks)
        callbacks.logger = fmi2CallbackLoggerTYPE(lambda *_: None)
        return {"callbacks": callbacks}

    def _call(self, name: str, call: Any) -> Any:
        try:
            return call()
        except Exception as error:  # FMPy raises bare Exceptions
            raise Refused(str(error) or name) from None

    def initialize(self, values: Mapping[str, float] | None = None, *, stay: bool = False) -> "Instance":
        """Start values, then initialization mode, and beyond it unless `stay`."""
        self.set(values or {})
        experiment = self.model.defaultExperiment
        self.start = (number(experiment.startTime) if experiment is not None else None) or 0.0
        if self.version == "2":
            self._call("fmi2SetupExperiment", lambda: self._fmu.setupExperiment(startTime=self.start))
            self._call("fmi2EnterInitializationMode", self._fmu.enterInitializationMode)
        else:
            self._call("fmi3EnterInitializationMode", lambda: self._fmu.enterInitializationMode(startTime=self.start))
        if not stay:
            self.finish()
        return self

    def finish(self) -> None:
        """Leave initialization mode; with Model Exchange go to continuous-time mode."""
        self._call("ExitInitializationMode", self._fmu.exitInitializationMode)
        if self.kind == "me":
            for _ in range(100):
                info = self._call("NewDiscreteStates", self._update)
                if not info:
                    break
            self._call("EnterContinuousTimeMode", self._fmu.enterContinuousTimeMode)

    def _update(self) -> bool:
        return bool((self._fmu.newDiscreteStates() if self.version == "2" else self._fmu.updateDiscreteStates())[0])

    def set(self, values: Mapping[str, float]) -> None:
        setter = self._fmu.setReal if self.version == "2" else self._fmu.setFloat64
        if values:
            refs = [self.reference[n] for n in values]
            self._call("set", lambda: setter(refs, list(values.values())))

    def get(self, names: Sequence[str]) -> np.ndarray:
        getter = self._fmu.getReal if self.version == "2" else self._fmu.getFloat64
        refs = [self.reference[n] for n in names]
        return np.array(self._call("get", lambda: getter(refs)) if refs else [], dtype=float)

    def step(self, t: float, h: float) -> None:
        result = self._call("doStep", lambda: self._fmu.doStep(t, h))
        if self.version == "3" and result is not None and result[2]:
            raise Refused("doStep returns early, which was not allowed")

    def directional(self, unknown: Sequence[str], known: Sequence[str], seed: Sequence[float]) -> np.ndarray:
        refs = [self.reference[n] for n in unknown], [self.reference[n] for n in known]
        return np.array(self._call("directional", lambda: self._fmu.getDirectionalDerivative(*refs, list(seed))))

    def adjoint(self, unknown: Sequence[str], known: Sequence[str], seed: Sequence[float]) -> np.ndarray:
        refs = [self.reference[n] for n in unknown], [self.reference[n] for n in known]
        return np.array(self._call("adjoint", lambda: self._fmu.getAdjointDerivative(*refs, list(seed), len(known))))

    def save(self) -> Any:
        return self._call("get state", self._fmu.getFMUstate if self.version == "2" else self._fmu.getFMUState)

    def restore(self, state: Any) -> None:
        self._call("set state", lambda: (self._fmu.setFMUstate if self.version == "2" else self._fmu.setFMUState)(state))

    def discard(self, state: Any) -> None:
        self._call("free state", lambda: (self._fmu.freeFMUstate if self.version == "2" else self._fmu.freeFMUState)(state))

    def serialized(self, state: Any) -> bytes:
        serialize = self._fmu.serializeFMUstate if self.version == "2" else self._fmu.serializeFMUState
        return bytes(self._call("serialize state", lambda: serialize(state)))

    def deserialized(self, data: bytes) -> Any:
        read = self._fmu.deSerializeFMUstate if self.version == "2" else self._fmu.deserializeFMUState
        return self._call("deserialize state", lambda: read(data))

    def continuous_states(self, n: int) -> np.ndarray:
        x = np.zeros(n)
        self._call("get states", lambda: self._fmu.getContinuousStates(_pointer(x), n))
        return x

    def set_continuous_states(self, x: np.ndarray) -> None:
        self._call("set states", lambda: self._fmu.setContinuousStates(_pointer(x), x.size))

    def state_derivatives(self, n: int) -> np.ndarray:
        rates = np.zeros(n)
        getter = self._fmu.getDerivatives if self.version == "2" else self._fmu.getContinuousStateDerivatives
        self._call("get derivatives", lambda: getter(_pointer(rates), n))
        return rates

    def reset(self) -> None:
        self._call("reset", self._fmu.reset)

    def close(self) -> None:
        """End and free the instance; the library stays loaded, for other instances may be alive."""
        free = self._fmu.fmi2FreeInstance if self.version == "2" else self._fmu.fmi3FreeInstance
        if self._fmu.component:
            free(self._fmu.component)
            self._fmu.component = None


def _pointer(array: np.ndarray) -> Any:
    return array.ctypes.data_as(ctypes.POINTER(ctypes.c_double))


def real_scalars(model: Any) -> list[Any]:
    """The variables that the probes can handle: real, and no array."""
    return [v for v in model.modelVariables if v.type in REAL and v.type != "Float32" and not v.dimensions]
