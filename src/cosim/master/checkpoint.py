"""Checkpoints: a run that is killed and resumed gives the same bytes as one that was not."""

import hashlib
import io
import json
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from gyro_cosim.component.whole_files import whole_file

from ..coupling import Algorithm
from ..network import Network
from ..slaves import Serializable, serializable
from ..systems import archive
from .recording import Recorder
from .state import RunState
from .time_grid import TimeGrid

FORMAT = 4
MARK = b"\ncosim checkpoint, sha256 of what is before:"


def fingerprint(network: Network, algorithm: Algorithm, step: float, recorder_names: tuple[str, ...]) -> str:
    """What must be the same for a checkpoint to fit: system, values, algorithm, start, step, recorded signals."""
    system = network.system
    parts = [(p.name, Path(p.source).name, sorted((k, str(v)) for k, v in p.values.items())) for p in system.components]
    wires = [(c.start, c.end) for c in system.connections]
    series = [(s.target, s.unit, hashlib.sha256(s.t.tobytes() + s.values.tobytes()).hexdigest()) for s in system.inputs]
    driven = [series, repr(system.scenario.events) if system.scenario else "", system.tolerance]
    told = json.dumps(
        [FORMAT, system.name, parts, wires, repr(algorithm), network.start, step, network.substeps, recorder_names, driven]
    )
    return hashlib.sha256(told.encode()).hexdigest()


@dataclass(frozen=True)
class Checkpoint:
    """Write the state of the run now and then. The file is replaced as a whole.

    Parameters
    ----------
    file : Path
        Where it is written, a .npz.
    every : float
        Simulated time from one to the next, s.
    """

    file: Path
    every: float = 10.0

    def __post_init__(self) -> None:
        if not self.every > 0.0:
            raise ValueError(f"the time between checkpoints must be positive, got {self.every:g} s")

    def check(self, network: Network) -> list[Serializable]:
        """The slaves, whose states can all be written; ValueError names the first of which that is not so."""
        slaves = []
        for slave in network.slaves:
            able = serializable(slave)
            if able is None:
                raise ValueError(f"a checkpoint needs components that can serialize their state, {slave.name!r} cannot")
            slaves.append(able)
        return slaves

    def write(self, fingerprint: str, network: Network, state: RunState, recorder: Recorder) -> None:
        """Write the state of a run: its own, that of its slaves and algebraic loops, and how far its results are kept."""
        arrays: dict[str, Any] = {"fingerprint": np.array(fingerprint)}
        arrays |= {f"run_{name}": value for name, value in state.arrays().items()}
        arrays |= {f"loop_{k}": J for k, J in enumerate(network.kept) if J is not None}
        arrays |= {f"recorder_{name}": value for name, value in recorder.state().items()}
        for i, slave in enumerate(self.check(network)):
            arrays[f"slave_{i}"] = np.frombuffer(slave.serialize(), dtype=np.uint8)
        content = io.BytesIO()
        np.savez(content, **arrays)
        data = content.getvalue()
        with whole_file(self.file) as beside:
            beside.write_bytes(data + MARK + hashlib.sha256(data).digest())


@dataclass(frozen=True)
class Resume:
    """Go on from a checkpoint.

    Parameters
    ----------
    file : Path
        What Checkpoint has written, in a run of the same system, values, algorithm, start, step and signals.
    """

    file: Path

    def _load(self) -> dict[str, np.ndarray]:
        """What the file holds. Nothing in it is looked at before its checksum is right."""
        where = f"checkpoint {str(self.file)!r}"
        if not self.file.is_file():
            raise ValueError(f"{where} must exist")
        data = archive.read(str(self.file))
        content, mark, digest = data[: -len(MARK) - 32], data[-len(MARK) - 32 : -32], data[-32:]
        if mark != MARK or hashlib.sha256(content).digest() != digest:
            raise ValueError(f"{where} must agree with its checksum: it is damaged, cut off, or of another version")
        try:
            with archive.opened(str(self.file)), np.load(io.BytesIO(content), allow_pickle=False) as held:
                return {name: held[name] for name in held.files}
        except Exception as error:  # numpy and zipfile fail in ways of their own
            raise ValueError(f"{where} cannot be read: {' '.join(str(error).split())}") from None

    def restore(self, fingerprint: str, network: Network, begun: RunState, recorder: Recorder, grid: TimeGrid) -> RunState:
        """Put everything back; returns the state of the run. ValueError if the checkpoint is of another run.

        begun : the state at the start of the run that goes on. grid : its communication points.
        """
        try:
            return self._restored(self._load(), fingerprint, network, begun, recorder, grid)
        except (KeyError, IndexError, TypeError, AttributeError, OverflowError) as error:  # its checksum is right, nothing else
            said = f"{type(error).__name__}: {error}"
            raise ValueError(f"checkpoint {str(self.file)!r} must hold the state of a run: {said}") from None

    def _restored(
        self, data: dict[str, np.ndarray], fingerprint: str, network: Network, begun: RunState, recorder: Recorder, grid: TimeGrid
    ) -> RunState:
        if str(data["fingerprint"]) != fingerprint:
            raise ValueError(
                f"checkpoint {str(self.file)!r} must be of this run: same system, values, algorithm, start, step and signals"
            )
        done, t = int(data["run_done"]), float(data["run_history_t"][0])
        if t > grid.stop or done > grid.n or abs(t - grid.time(done)) > 1e-6 * grid.step:
            raise ValueError(
                f"checkpoint {str(self.file)!r}, of t = {t:.9g} s, must be of a communication point of this run, which ends at "
                f"{grid.stop:.9g} s in steps of {grid.step:g} s"
            )
        for i, slave in enumerate(network.slaves):
            able = serializable(slave)
            assert able is not None  # the fingerprint says that it is the component that was written
            able.deserialize(data[f"slave_{i}"].tobytes())
        network.recall([data.get(f"loop_{k}") for k in range(len(network.kept))])
        recorder.resume(_named(data, "recorder_"))
        return begun.from_arrays(_named(data, "run_"))


def _named(data: Mapping[str, np.ndarray], beginning: str) -> dict[str, np.ndarray]:
    """What `data` holds under names with this beginning, without it."""
    return {name.removeprefix(beginning): value for name, value in data.items() if name.startswith(beginning)}
