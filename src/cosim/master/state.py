"""The state of a run: everything that changes while it goes on, but for what the slaves hold and the rows recorded."""

from collections.abc import Mapping
from dataclasses import dataclass, field, fields, replace

import numpy as np

from ..coupling import History, Memory, Step
from .energy import EnergySums


@dataclass(frozen=True, eq=False)
class RunState:
    """One value: it can be saved, compared, and handed back. Nothing that describes the run is in it.

    Parameters
    ----------
    done : int
        Macro steps completed.
    history : History
        Outputs at the last communication points.
    energy : EnergySums
        What the energy meter has summed.
    memory : mapping of str to ndarray
        What the coupling algorithm remembers.
    passes, rejections : int
        Passes over macro steps where the algorithm iterates; macro steps that were taken back.
    ended_by : str
        Why the run is over before its stop time; empty while it is not.
    frozen : ndarray
        Of every fault of a scenario, the value that an input keeps because of it; NaN where it keeps none.
    """

    done: int
    history: History
    energy: EnergySums
    memory: Memory = field(default_factory=dict)
    passes: int = 0
    rejections: int = 0
    ended_by: str = ""
    frozen: np.ndarray = field(default_factory=lambda: np.empty(0))

    def after(self, step: Step, t: float) -> "RunState":
        """The state after a macro step that ended at t (s)."""
        return replace(
            self, done=self.done + 1, history=self.history.push(t, step.Y), memory=step.memory, passes=self.passes + step.passes
        )

    def arrays(self) -> dict[str, np.ndarray]:
        """The state as named arrays, for a file; from_arrays() makes the same state of them."""
        arrays = {f"memory_{name}": value for name, value in self.memory.items()}
        arrays |= {f"energy_{f.name}": np.asarray(getattr(self.energy, f.name)) for f in fields(self.energy)}
        counters = {name: np.array(getattr(self, name)) for name in ("done", "passes", "rejections")}
        return {
            **arrays,
            **counters,
            "frozen": self.frozen,
            "history_t": np.array(self.history.t),
            "history_Y": np.array(self.history.Y),
        }

    def from_arrays(self, data: Mapping[str, np.ndarray]) -> "RunState":
        """The state that arrays() gave; what does not change in a run (which signals are held) is taken from this one."""
        for name, mine in self.arrays().items():
            theirs, many = data[name], name in ("energy_past", "history_t", "history_Y")  # of which there are few at first
            if theirs.dtype != mine.dtype or theirs.shape[many:] != mine.shape[many:] or theirs.ndim != mine.ndim:
                raise ValueError(f"{name} of a state must be {mine.dtype}, {mine.shape}, got {theirs.dtype}, {theirs.shape}")
        residual, peak, exchanged, past, step = (data[f"energy_{f.name}"] for f in fields(self.energy))
        return RunState(
            done=int(data["done"]),
            history=History(tuple(data["history_t"].tolist()), tuple(data["history_Y"]), self.history.held),
            energy=EnergySums(residual, peak, exchanged, past, float(step)),
            memory={name.removeprefix("memory_"): value for name, value in data.items() if name.startswith("memory_")},
            passes=int(data["passes"]),
            rejections=int(data["rejections"]),
            frozen=data["frozen"],
        )

    def __eq__(self, other: object) -> bool:
        """Whether both are the same to the last bit."""
        if not isinstance(other, RunState):
            return NotImplemented
        mine, theirs = self.arrays(), other.arrays()
        return (
            self.ended_by == other.ended_by
            and mine.keys() == theirs.keys()
            and all(mine[name].tobytes() == theirs[name].tobytes() for name in mine)
        )

    __hash__ = None  # type: ignore[assignment]  # it holds arrays
