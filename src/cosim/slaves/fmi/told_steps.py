"""An FMU of FMI 3.0 that tells the steps of its own integrator, by intermediate update, where somebody asks for them."""

from typing import Any

from ..inner_steps import Following, InnerSteps
from ..signal import Signal
from .fmu import FmuSlave
from .intermediate_update import Intermediate, asked_for, told_of
from .library import Library
from .signals import names


class SteppingFmu(FmuSlave, Following):
    """What intermediate update asks and tells.

    _answers : of the present step. _inner : where the steps are kept; None where nobody wants them.
    """

    _answers: Intermediate
    _inner: InnerSteps | None

    def _bind_intermediate(self, library: Library) -> None:
        """Answer what it asks for, and hear nothing."""
        self._answers, self._inner = Intermediate(library, asked_for(self.model)), None

    @property
    def inner_signals(self) -> tuple[Signal, ...]:
        told = {name for row in told_of(self.model) for name in names(row)}
        return tuple(signal for signal in self.outputs if signal.name in told)

    def follow(self) -> InnerSteps:
        self._inner = steps = InnerSteps(self.inner_signals)
        self._answers = Intermediate(self.library, asked_for(self.model), told_of(self.model), steps.add)
        return steps

    def _forget_steps(self) -> None:
        """For a run that begins."""
        if self._inner is not None:
            self._inner.go_back()

    def save(self) -> Any:
        return *super().save(), None if self._inner is None else self._inner.mark()

    def restore(self, snapshot: Any) -> None:
        super().restore(snapshot)
        if self._inner is not None:
            self._inner.go_back(snapshot[2])
