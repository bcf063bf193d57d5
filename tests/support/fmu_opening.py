"""FMUs opened with FMPy, for the exporter's tests."""

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import fmpy
import numpy as np
import pytest
from fmpy.fmi1 import FMICallException
from fmpy.fmi2 import FMU2Model, FMU2Slave
from fmpy.fmi3 import FMU3Model, FMU3Slave
from fmu_models import COMPONENTS

from gyro_cosim import fmus
from gyro_cosim.component import Component

DISCARD, ERROR = 2, 3  # what functions of FMI return


class Open:
    """An instance of an FMU: `fmu` is FMPy's, `vr` maps names to value references."""

    def __init__(self, path: Path, folder: Path, kind: str) -> None:
        self.description = fmpy.read_model_description(str(path), validate=False)
        self.version = self.description.fmiVersion[0]
        interface = self.description.coSimulation if kind == "cs" else self.description.modelExchange
        classes = {"2cs": FMU2Slave, "2me": FMU2Model, "3cs": FMU3Slave, "3me": FMU3Model}
        self.fmu = classes[self.version + kind](
            guid=self.description.guid, modelIdentifier=interface.modelIdentifier, unzipDirectory=str(folder), instanceName="it"
        )
        self.vr = {v.name: v.valueReference for v in self.description.modelVariables}
        self.names = {c: [v.name for v in self.description.modelVariables if v.causality == c] for c in ("input", "output")}
        self.fmu.instantiate()

    def initialize(self, start: float = 0.0, stop: float | None = None, **values: float) -> "Open":
        """Set start values and go to the stepping mode."""
        self.set(**values)
        if self.version == "2":
            self.fmu.setupExperiment(startTime=start, stopTime=stop)
            self.fmu.enterInitializationMode()
        else:
            self.fmu.enterInitializationMode(startTime=start, stopTime=stop)
        self.fmu.exitInitializationMode()
        return self

    def set(self, **values: float) -> None:
        names = list(values)
        setter = self.fmu.setReal if self.version == "2" else self.fmu.setFloat64
        if names:
            setter([self.vr[n] for n in names], [values[n] for n in names])

    def get(self, *names: str) -> np.ndarray:
        getter = self.fmu.getReal if self.version == "2" else self.fmu.getFloat64
        return np.array(getter([self.vr[n] for n in names]))

    def outputs(self) -> np.ndarray:
        return self.get(*self.names["output"])

    def step(self, t: float, h: float, U: np.ndarray | None = None) -> np.ndarray:
        """Set inputs (and, in FMI 2, their derivatives), do a step, return the outputs."""
        refs = [self.vr[n] for n in self.names["input"]]
        if U is not None and refs:
            self.set(**dict(zip(self.names["input"], U[:, 0], strict=True)))
            if self.version == "2" and U[:, 1:].any():
                n = len(refs)
                values = [*U[:, 1], *U[:, 2]]
                self.fmu.setRealInputDerivatives([*refs, *refs], [*[1] * n, *[2] * n], values)
        self.fmu.doStep(t, h)
        return self.outputs()

    def close(self) -> None:
        self.fmu.freeInstance()


def refused(status: int, call: Callable, *arguments: object, **options: object) -> None:
    """Call a function of an FMU that must return `status`, which FMPy raises."""
    with pytest.raises(FMICallException) as caught:
        call(*arguments, **options)
    assert caught.value.status == status


@contextmanager
def opened(path: Path, folder: Path, kind: str = "cs") -> Iterator[Any]:
    """An instance that is freed at the end; `folder` is where the FMU gets unpacked."""
    if not (folder / "modelDescription.xml").exists():
        fmpy.extract(str(path), str(folder))
    it = Open(path, folder, kind)
    try:
        yield it
    finally:
        it.close()


@pytest.fixture(scope="session")
def built(tmp_path_factory: pytest.TempPathFactory) -> Callable[[str, str], tuple[Component, Path, Path]]:
    """(component, FMU, folder to unpack it in) by name and FMI version; each is exported once."""
    made: dict[str, tuple[Component, list[Path]]] = {}

    def build(name: str, version: str = "2") -> tuple[Component, Path, Path]:
        if name not in made:
            component = COMPONENTS[name]()
            made[name] = component, fmus.export(component, tmp_path_factory.mktemp("fmu"), fmi=("2", "3"))
        component, paths = made[name]
        path = paths["23".index(version)]
        return component, path, path.parent / f"unpacked{version}"

    return build
