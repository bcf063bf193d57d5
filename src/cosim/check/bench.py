"""The FMU under check as probes need it: its description, its capabilities, and fresh instances."""

from collections.abc import Callable
from pathlib import Path
from xml.etree import ElementTree

from cosim.check.description import attribute, number
from cosim.check.subject import real_scalars

Say = Callable[[str], None]
STEPS = 10


class Bench:
    """The FMU's description in the form that probes need, and fresh instances of it."""

    def __init__(self, folder: Path) -> None:
        import fmpy

        self.model, self.folder = fmpy.read_model_description(str(folder), validate=False), folder
        self.kind = "cs" if self.model.coSimulation is not None else "me"
        root = ElementTree.parse(folder / "modelDescription.xml").getroot()
        self._attributes = dict(root.find("CoSimulation" if self.kind == "cs" else "ModelExchange").attrib)  # type: ignore[union-attr]
        real = real_scalars(self.model)
        self.inputs = [v.name for v in real if v.causality == "input" and v.variability == "continuous"]
        self.outputs = [v.name for v in real if v.causality == "output"]
        self.settable = [
            v for v in real if v.variability != "constant" and (v.initial in ("exact", "approx") or v.causality == "input")
        ]
        self.names = {v.name for v in real}
        self.nominal = {v.name: abs(attribute(v, "nominal") or 1.0) for v in real}
        self.start = {v.name: number(v.start) or 0.0 for v in real}
        experiment = self.model.defaultExperiment
        step = number(experiment.stepSize) if experiment is not None else None
        span = [number(getattr(experiment, n)) for n in ("startTime", "stopTime")] if experiment is not None else [None, None]
        self.h = step or ((span[1] - (span[0] or 0.0)) / 1000 if span[1] else None) or 1e-3

    def can(self, *names: str) -> bool:
        """Whether the interface states one of the capabilities `names`; FMPy does not read all of them."""
        return any(self._attributes.get(name) in ("true", "1") for name in names)
