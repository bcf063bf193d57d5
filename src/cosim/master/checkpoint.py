"""Checkpoints: a run that is killed and resumed gives the same bytes as one that was not."""

import hashlib
import json
import os
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from ..coupling import Algorithm
from ..network import Network
from ..slaves import Serializable, serializable
from .recording import Recorder
from .state import RunState

FORMAT = 4


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
        scratch = self.file.with_name(self.file.name + ".new")
        with scratch.open("wb") as stream:
            np.savez(stream, **arrays)
            stream.flush()
            os.fsync(stream.fileno())
        scratch.replace(self.file)


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
        try:
            with np.load(self.file, allow_pickle=False) as data:
                return {name: data[name] for name in data.files}
        except FileNotFoundError:
            raise ValueError(f"checkpoint {str(self.file)!r} must exist") from None
        except (OSError, ValueError, EOFError) as error:
            raise ValueError(f"checkpoint {str(self.file)!r} cannot be read: {error}") from None

    def restore(self, fingerprint: str, network: Network, begun: RunState, recorder: Recorder) -> RunState:
        """Put everything back; returns the state of the run. ValueError if the checkpoint is of another run.

        begun : the state at the start of the run that goes on.
        """
        data = self._load()
        if str(data["fingerprint"]) != fingerprint:
            raise ValueError(
                f"checkpoint {str(self.file)!r} must be of this run: same system, values, algorithm, start, step and signals"
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
