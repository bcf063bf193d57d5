"""An instance of the FMU under check, with one interface for FMI 2.0 and 3.0, Co-Simulation and Model Exchange."""

import ctypes
import re
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from ..slaves.fmi.rows import REAL
from .description import number

FMI3_TYPES = {"Boolean": "Boolean", "String": "String", "Binary": "Binary", "Clock": "Clock", "Enumeration": "Int64"}


class Refused(Exception):
    """A call that the FMU did not answer with OK or Warning."""


class Unloadable(Exception):
    """A library that this machine cannot load, with the loader's own reason."""


class Instance:
    """A fresh instance. `kind` is "cs", "me" or "se"; `events`: event mode is used (FMI 3.0).

    given : variables and their elements that it starts with.
    """

    def __init__(
        self, model: Any, folder: Path, kind: str, name: str = "instance", *, events: bool = False,
        given: Sequence[tuple[Any, Sequence[Any]]] = (),
    ) -> None:  # fmt: skip
        from fmpy.fmi2 import FMU2Model, FMU2Slave
        from fmpy.fmi3 import FMU3Model, FMU3ScheduledExecution, FMU3Slave

        self.goes_back = False  # whether a saved state may be restored, which every step then says
        self._given = given
        self.model, self.kind, self.version = model, kind, model.fmiVersion[0]
        self.interface = {"cs": model.coSimulation, "me": model.modelExchange, "se": model.scheduledExecution}[kind]
        classes = {
            "2cs": FMU2Slave, "2me": FMU2Model, "3cs": FMU3Slave, "3me": FMU3Model, "3se": FMU3ScheduledExecution,
        }  # fmt: skip
        try:
            self.fmu = classes[self.version + kind](
                guid=model.guid, modelIdentifier=self.interface.modelIdentifier, unzipDirectory=str(folder), instanceName=name
            )
        except AttributeError as error:
            raise Refused(f"the library must have every function of FMI: {error}") from None
        except Exception as error:  # FMPy wraps the loader's own
            raise Unloadable(re.sub(r"^Failed to load shared library .*?\. (?=\S)", "", str(error))) from None
        self.reals = real_scalars(model)
        self.reference = {v.name: v.valueReference for v in model.modelVariables}
        more = {"eventModeUsed": True} if events else {}
        self.call("Instantiate", lambda: self.fmu.instantiate(**self._silent(), **more))

    def _silent(self) -> dict[str, Any]:
        """Callbacks that say nothing."""
        if self.version == "3":
            return {"logMessage": lambda *_: None}
        from fmpy.fmi2 import defaultCallbacks, fmi2CallbackFunctions, fmi2CallbackLoggerTYPE

        callbacks = fmi2CallbackFunctions.from_buffer_copy(defaultCallbacks)
        callbacks.logger = fmi2CallbackLoggerTYPE(lambda *_: None)
        return {"callbacks": callbacks}

    def call(self, name: str, call: Any) -> Any:
        """The answer of an FMI function; Refused where its status is no good."""
        try:
            return call()
        except Exception as error:  # FMPy raises bare Exceptions
            raise Refused(str(error) or name) from None

    def initialize(self, values: Mapping[str, float] | None = None, *, stay: bool = False) -> "Instance":
        """Start values, then initialization mode, and beyond it unless `stay`."""
        for variable, elements_ in self._given:
            self.put(variable, elements_)
        self.set(values or {})
        experiment = self.model.defaultExperiment
        self.start = (number(experiment.startTime) if experiment is not None else None) or 0.0
        if self.version == "2":
            self.call("fmi2SetupExperiment", lambda: self.fmu.setupExperiment(startTime=self.start))
            self.call("fmi2EnterInitializationMode", self.fmu.enterInitializationMode)
        else:
            self.call("fmi3EnterInitializationMode", lambda: self.fmu.enterInitializationMode(startTime=self.start))
        if not stay:
            self.finish()
        return self

    def finish(self) -> None:
        """Leave initialization mode; with Model Exchange go to continuous-time mode."""
        self.call("ExitInitializationMode", self.fmu.exitInitializationMode)
        if self.kind == "me":
            for _ in range(100):
                info = self.call("NewDiscreteStates", self._update)
                if not info:
                    break
            self.call("EnterContinuousTimeMode", self.fmu.enterContinuousTimeMode)

    def _update(self) -> bool:
        return bool((self.fmu.newDiscreteStates() if self.version == "2" else self.fmu.updateDiscreteStates())[0])

    def set(self, values: Mapping[str, float]) -> None:
        setter = self.fmu.setReal if self.version == "2" else self.fmu.setFloat64
        if values:
            refs = [self.reference[n] for n in values]
            self.call("set", lambda: setter(refs, list(values.values())))

    def get(self, names: Sequence[str]) -> np.ndarray:
        getter = self.fmu.getReal if self.version == "2" else self.fmu.getFloat64
        refs = [self.reference[n] for n in names]
        return np.array(self.call("get", lambda: getter(refs)) if refs else [], dtype=float)

    def values(self, variable: Any, given: Sequence[Any] | None = None) -> list[Any]:
        """The elements of a variable of any type, which are set first where they are given."""
        if given is not None:
            self.put(variable, given)
        more = (elements(variable),) if self.version == "3" and variable.type != "Clock" else ()
        get = getattr(self.fmu, f"get{self._suffix(variable)}")
        return list(self.call(f"get {variable.name}", lambda: get([variable.valueReference], *more)))

    def put(self, variable: Any, given: Sequence[Any]) -> None:
        """Set all elements of a variable of any type."""
        put = getattr(self.fmu, f"set{self._suffix(variable)}")
        self.call(f"set {variable.name}", lambda: put([variable.valueReference], list(given)))

    def _suffix(self, variable: Any) -> str:
        """As the functions for its type are called."""
        kind = str(variable.type)
        return FMI3_TYPES.get(kind, kind) if self.version == "3" else {"Enumeration": "Integer"}.get(kind, kind)

    def step(self, t: float, h: float) -> None:
        result = self.call("doStep", lambda: self.fmu.doStep(t, h, not self.goes_back))
        if self.version == "3" and result is not None and result[2]:
            raise Refused("doStep returns early, which was not allowed")

    def directional(self, unknown: Sequence[str], known: Sequence[str], seed: Sequence[float]) -> np.ndarray:
        refs = [self.reference[n] for n in unknown], [self.reference[n] for n in known]
        return np.array(self.call("directional", lambda: self.fmu.getDirectionalDerivative(*refs, list(seed))))

    def adjoint(self, unknown: Sequence[str], known: Sequence[str], seed: Sequence[float]) -> np.ndarray:
        refs = [self.reference[n] for n in unknown], [self.reference[n] for n in known]
        return np.array(self.call("adjoint", lambda: self.fmu.getAdjointDerivative(*refs, list(seed), len(known))))

    def save(self) -> Any:
        return self.call("get state", self.fmu.getFMUstate if self.version == "2" else self.fmu.getFMUState)

    def restore(self, state: Any) -> None:
        self.call("set state", lambda: (self.fmu.setFMUstate if self.version == "2" else self.fmu.setFMUState)(state))

    def discard(self, state: Any) -> None:
        self.call("free state", lambda: (self.fmu.freeFMUstate if self.version == "2" else self.fmu.freeFMUState)(state))

    def serialized(self, state: Any) -> bytes:
        serialize = self.fmu.serializeFMUstate if self.version == "2" else self.fmu.serializeFMUState
        return bytes(self.call("serialize state", lambda: serialize(state)))

    def deserialized(self, data: bytes) -> Any:
        read = self.fmu.deSerializeFMUstate if self.version == "2" else self.fmu.deserializeFMUState
        return self.call("deserialize state", lambda: read(data))

    def continuous_states(self, n: int) -> np.ndarray:
        x = np.zeros(n)
        self.call("get states", lambda: self.fmu.getContinuousStates(_pointer(x), n))
        return x

    def set_continuous_states(self, x: np.ndarray) -> None:
        self.call("set states", lambda: self.fmu.setContinuousStates(_pointer(x), x.size))

    def state_derivatives(self, n: int) -> np.ndarray:
        rates = np.zeros(n)
        getter = self.fmu.getDerivatives if self.version == "2" else self.fmu.getContinuousStateDerivatives
        self.call("get derivatives", lambda: getter(_pointer(rates), n))
        return rates

    def reset(self) -> None:
        self.call("reset", self.fmu.reset)

    def close(self) -> None:
        """End and free the instance; the library stays loaded, for other instances may be alive."""
        free = self.fmu.fmi2FreeInstance if self.version == "2" else self.fmu.fmi3FreeInstance
        if self.fmu.component:
            free(self.fmu.component)
            self.fmu.component = None


def _pointer(array: np.ndarray) -> Any:
    return array.ctypes.data_as(ctypes.POINTER(ctypes.c_double))


def elements(variable: Any) -> int:
    """How many elements a variable has as its dimensions start."""
    size = 1
    for dimension in variable.dimensions or ():
        start = dimension.start if dimension.start is not None else dimension.variable.start
        size *= int(start)
    return size


def real_scalars(model: Any) -> list[Any]:
    """The variables that the probes of numbers can handle: real, and no array."""
    return [v for v in model.modelVariables if v.type in REAL and v.type != "Float32" and not v.dimensions]
