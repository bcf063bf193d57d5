"""cosim run --integrator-steps: what a component reaches between communication points, in a file of its own."""

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

from .. import trajectory
from ..errors import unknown
from ..network import Network
from ..slaves import InnerSteps, steps_of
from ..trajectory import Origin, Trajectory
from .common import writable
from .settings import assignment


@dataclass(frozen=True)
class Told:
    """The file of one component.

    Parameters
    ----------
    component : str
        Its name.
    file : Path
        As people wrote it.
    place : Path
        The same, absolute: an FMU may change the current folder.
    steps : InnerSteps
        Filled by the run.
    """

    component: str
    file: Path
    place: Path
    steps: InnerSteps

    def write(self, origin: Origin | None) -> Path:
        """Write what there is."""
        t, values = self.steps.arrays()
        signals = self.steps.signals
        names = tuple(f"{self.component}.{signal.name}" for signal in signals)
        Trajectory(t, names, tuple(signal.unit for signal in signals), values).save(self.place, origin)
        return self.file


def parsed(texts: Sequence[str], outputs: Sequence[Path]) -> dict[str, Path]:
    """Component -> file in "COMPONENT=FILE", several times; ValueError before any work where a file cannot be written."""
    found: dict[str, Path] = {}
    for text in texts:
        name, file = assignment(text, "--integrator-steps must be COMPONENT=FILE")
        if name in found:
            raise ValueError(f"--integrator-steps must name a component once, got {name!r} twice")
        writable(Path(file), trajectory.check_format)
        if Path(file) in (*outputs, *found.values()):
            raise ValueError(f"--integrator-steps must name a file of its own, got {file!r} twice")
        found[name] = Path(file)
    return found


def followed(files: dict[str, Path], network: Network) -> list[Told]:
    """Have the components tell their steps from now on; ValueError where one does not tell any."""
    slaves = {slave.name: slave for slave in network.slaves}
    told = []
    for name, file in files.items():
        if name not in slaves:
            raise unknown("component to tell its steps:", name, slaves)
        steps = steps_of(slaves[name])
        if steps is None:
            raise ValueError(
                f"--integrator-steps: component {name!r} must be an FMU for Model Exchange, or one of FMI 3.0 that provides "
                "intermediate update and an output to read in it, and run without --isolate"
            )
        told.append(Told(name, file, file.absolute(), steps))
    return told
