"""Checkpoints: a run that is killed and resumed gives the same bytes as one that was not."""

import hashlib
import json
import os
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from ..coupling import Algorithm, History
from ..network import Network
from .energy import EnergyMeter
from .recording import Recorder

FORMAT = 2


def fingerprint(network: Network, algorithm: Algorithm, step: float, recorder_names: tuple[str, ...]) -> str:
    """What must be the same for a checkpoint to fit: system, values, algorithm, start, step, recorded signals."""
    system = network.system
    parts = [(p.name, Path(p.source).name, sorted((k, str(v)) for k, v in p.values.items())) for p in system.components]
    wires = [(c.start, c.end) for c in system.connections]
    told = json.dumps([FORMAT, system.name, parts, wires, repr(algorithm), network.start, step, network.substeps, recorder_names])
    return hashlib.sha256(told.encode()).hexdigest()


@dataclass(frozen=True)
class Checkpoint:
    """Write the state of the run to `file` every `every` seconds of simulated time. The file is replaced as a whole."""

    file: Path
    every: float = 10.0

    def __post_init__(self) -> None:
        if not self.every > 0.0:
            raise ValueError(f"the time between checkpoints must be positive, got {self.every:g} s")

    def check(self, network: Network) -> None:
        """ValueError naming the first component whose state cannot be written."""
        for slave in network.slaves:
            if not slave.can_serialize:
                raise ValueError(f"a checkpoint needs components that can serialize their state, {slave.name!r} cannot")

    def write(
        self,
        network: Network,
        algorithm: Algorithm,
        step: float,
        done: int,
        history: History,
        meter: EnergyMeter,
        recorder: Recorder,
    ) -> None:
        """Write the state after macro step `done`."""
        self.check(network)
        arrays: dict[str, Any] = {
            "fingerprint": np.array(fingerprint(network, algorithm, step, recorder.names)),
            "done": np.array(done),
            "history_t": np.array(history.t),
            "history_Y": np.array(history.Y),
            "iterations": np.array(history.iterations),
            "largest": network.largest,
        }
        arrays |= {f"loop_{k}": s.jacobian for k, s in enumerate(network.solvers) if s.jacobian is not None}
        if history.jacobian is not None:
            arrays["jacobian"] = history.jacobian
        arrays |= {f"meter_{name}": value for name, value in meter.state().items()}
        arrays |= {f"recorder_{name}": value for name, value in recorder.state().items()}
        for i, slave in enumerate(network.slaves):
            arrays[f"slave_{i}"] = np.frombuffer(slave.serialize(), dtype=np.uint8)
        scratch = self.file.with_name(self.file.name + ".new")
        with scratch.open("wb") as stream:
            np.savez(stream, **arrays)
            stream.flush()
            os.fsync(stream.fileno())
        scratch.replace(self.file)


@dataclass(frozen=True)
class Resume:
    """Go on from a checkpoint file."""

    file: Path

    def _load(self) -> dict[str, np.ndarray]:
        try:
            with np.load(self.file, allow_pickle=False) as data:
                return {name: data[name] for name in data.files}
        except FileNotFoundError:
            raise ValueError(f"checkpoint {str(self.file)!r} must exist") from None
        except (OSError, ValueError, EOFError) as error:
            raise ValueError(f"checkpoint {str(self.file)!r} cannot be read: {error}") from None

    def restore(
        self, network: Network, algorithm: Algorithm, step: float, history: History, meter: EnergyMeter, recorder: Recorder
    ) -> int:
        """Put everything back; returns the macro steps done. ValueError if the checkpoint is of another run."""
        data = self._load()
        if str(data["fingerprint"]) != fingerprint(network, algorithm, step, recorder.names):
            raise ValueError(
                f"checkpoint {str(self.file)!r} must be of this run: same system, values, algorithm, start, step and signals"
            )
        for i, slave in enumerate(network.slaves):
            slave.deserialize(data[f"slave_{i}"].tobytes())
        history.t, history.Y = data["history_t"].tolist(), list(data["history_Y"])
        history.iterations = int(data["iterations"])
        history.jacobian = data.get("jacobian")
        for k, solver in enumerate(network.solvers):
            solver.jacobian = data.get(f"loop_{k}")
        network.largest[:] = data["largest"]
        meter.resume({name.removeprefix("meter_"): value for name, value in data.items() if name.startswith("meter_")})
        recorder.resume({name.removeprefix("recorder_"): value for name, value in data.items() if name.startswith("recorder_")})
        return int(data["done"])
