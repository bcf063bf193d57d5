"""The FMU under check as probes need it: its description, its capabilities, and fresh instances."""

import json
from collections.abc import Iterator
from contextlib import closing
from pathlib import Path
from typing import Any
from xml.etree import ElementTree

import numpy as np

from ..slaves.fmi.rows import REAL
from ..slaves.processes.telling import read_values
from .description import attribute, number
from .instance import Instance, Refused, Unloadable, real_scalars

STEPS = 10
TAG = {"cs": "CoSimulation", "me": "ModelExchange", "se": "ScheduledExecution"}
GIVEN = "given.json"  # beside the folder of the FMU: start values in the place of its own
LONG = 10  # fixed internal steps in a macro step, where the default experiment says no step


class Examined:
    """The FMU's description in the form that probes need, and fresh instances of it."""

    def __init__(self, folder: Path) -> None:
        import fmpy

        self.model, self.folder = fmpy.read_model_description(str(folder), validate=False), folder
        self.given = _given(folder.parent / GIVEN, self.model)
        self.kind = "cs" if self.model.coSimulation is not None else "me" if self.model.modelExchange is not None else "se"
        root = ElementTree.parse(folder / "modelDescription.xml").getroot()
        self._attributes = dict(root.find(TAG[self.kind]).attrib)  # type: ignore[union-attr]
        self.events_only = self.kind == "cs" and self.model.modelExchange is not None and self._wants_events()
        if self.events_only:  # probes step without event mode, so they take the other interface
            self.kind = "me"
            self._attributes = dict(root.find(TAG[self.kind]).attrib)  # type: ignore[union-attr]
        self.shifts = {v.get("name"): number(v.get("shiftDecimal")) or 0.0 for v in root.iter("Clock")}  # FMPy reads few of them
        self.unstated = {
            v.get("name")
            for v in root.iter("Clock")
            if v.get("intervalVariability") in ("fixed", "tunable")
            and {"intervalDecimal", "intervalCounter"}.isdisjoint(v.attrib)
        }
        real = real_scalars(self.model)
        self.inputs = [v.name for v in real if v.causality == "input" and v.variability == "continuous"]
        self.outputs = [v.name for v in real if v.causality == "output"]
        self.settable = [
            v for v in real if v.variability != "constant" and (v.initial in ("exact", "approx") or v.causality == "input")
        ]
        self.names = {v.name for v in real}
        self.calculated = {v.name for v in real if v.initial == "calculated"}
        self.constants = [v.name for v in real if v.variability == "constant"]
        self.fixed = [v.name for v in real if v.causality == "parameter" and v.variability == "fixed"]
        self.nominal = {v.name: abs(attribute(v, "nominal") or 1.0) for v in real}
        self.start = {v.name: number(v.start) or 0.0 for v in real}
        experiment = self.model.defaultExperiment
        step = number(experiment.stepSize) if experiment is not None else None
        span = [number(getattr(experiment, n)) for n in ("startTime", "stopTime")] if experiment is not None else [None, None]
        internal = number(self._attributes.get("fixedInternalStepSize"))
        usual = ((span[1] - (span[0] or 0.0)) / 1000 if span[1] else None) or 1e-3
        self.h = step or (usual if not internal else max(internal, min(usual, LONG * internal)))

    def can(self, *names: str) -> bool:
        """Whether the interface states one of the capabilities `names`; FMPy does not read all of them."""
        return any(self._attributes.get(name) in ("true", "1") for name in names)

    def _wants_events(self) -> bool:
        """Whether it can be instantiated with event mode only, as FMUs with clocks do."""
        if not self.can("hasEventMode"):
            return False
        answers = []
        for events in (False, True):
            try:
                with self.instance("cs", events=events):
                    answers.append(True)
            except (Refused, Unloadable):
                answers.append(False)
        return answers == [False, True]

    def instance(self, kind: str | None = None, name: str = "instance", *, events: bool = False) -> Any:
        """A context that frees the instance."""
        return closing(Instance(self.model, self.folder, kind or self.kind, name, events=events, given=self.given))

    def run(self, it: Instance, seed: int, first: int = 0, steps: int = STEPS) -> Iterator[np.ndarray]:
        """Macro steps with random held inputs; yields the outputs after each."""
        for i in range(first, first + steps):
            rng = np.random.default_rng([seed, i])
            it.set({n: self.start[n] + 0.01 * self.nominal[n] * rng.standard_normal() for n in self.inputs})
            it.step(it.start + i * self.h, self.h)
            yield it.get(self.outputs)


def _given(file: Path, model: Any) -> list[tuple[Any, list[Any]]]:
    """Variables of the model with the elements that they are given, which from now on stand as start values in the model."""
    values = read_values(json.loads(file.read_text(encoding="utf-8"))) if file.exists() else {}
    found = []
    for variable in model.modelVariables:
        if variable.name in values:
            value = values[variable.name]
            own = {"Boolean": bool, "String": str, "Binary": bytes, **dict.fromkeys(REAL, float)}.get(variable.type, int)
            elements = [own(one) for one in (value if isinstance(value, tuple) else (value,))]
            texts = [one.hex() if isinstance(one, bytes) else str(one).lower() if own is bool else str(one) for one in elements]
            variable.start = texts if variable.type in ("String", "Binary") and variable.dimensions else " ".join(texts)
            found.append((variable, elements))
    return found
