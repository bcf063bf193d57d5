"""An FMU as a run uses it: what it is told of the run, and what it keeps of what it promises."""

from abc import abstractmethod
from collections.abc import Mapping
from types import MappingProxyType
from typing import Self

from ..base import Promised, Serializable
from ..description import SlaveDescription
from ..signal import Given, Value
from ..usage import Usage
from .description import Description
from .library import Library
from .probing import kept, untold
from .signals import described
from .structure import configured
from .unpacked import OpenedFmu


class PromisedFmu(Promised, Serializable):
    """The slave `name` on an open FMU.

    model : the FMU's own description. described : the slave as that says. given : values that decide on sizes of arrays.
    usage : how the run uses it.
    _known : for each use that was tried, what it keeps of its description, and what is to be told of that.
    """

    def __init__(self, name: str, opened: OpenedFmu, values: Mapping[str, Given] = MappingProxyType({})) -> None:
        self.name, self._opened, self.model = name, opened, configured(opened.model, name, values)
        self.given = values
        self.described = self.description = opened.description if self.model is opened.model else described(self.model)
        self.usage = Usage()
        self._known: dict[Usage, tuple[SlaveDescription, tuple[str, ...]]] = {}

    @property
    def file(self) -> tuple[str, str]:
        """Location and instantiation token of the FMU."""
        return self._opened.location, self.model.token

    @property
    def library(self) -> Library:
        """Its functions."""
        return self._opened.library

    def promise(self, usage: Usage, values: Mapping[str, Value], t: float, stop: float) -> tuple[str, ...]:
        self.usage = usage
        if usage not in self._known:
            self._known[usage] = kept(self, self._opened, usage, values, t, stop)
        description, notes = self._known[usage]
        self._adopt(description)
        return (*untold(self.name, self.model, usage), *notes)

    def like(self, other: Self, description: SlaveDescription) -> None:
        """Be used as `other` is, as an FMU that can do what `description` says."""
        self.usage = other.usage
        self._adopt(description)

    def _adopt(self, description: SlaveDescription) -> None:
        self.description = description

    @property
    def tolerance(self) -> float | None:
        """The relative tolerance that the FMU is told: the run's, else that of its own DefaultExperiment, if it has one."""
        own = float(self.model.experiment.get("tolerance", 0.0))
        return self.usage.tolerance or (own if 0.0 < own < float("inf") else None)

    @abstractmethod
    def try_derivatives(self, order: int, t: float) -> None:
        """Give the FMU derivatives of its inputs up to `order`, all zero; SlaveError where it does not take them."""


def hint(model: Description) -> str:
    """What an FMU's description says that may be why there is no instance."""
    if model.can("needsExecutionTool"):
        return f" (it needs its tool, {model.identity.get('generationTool', 'which it does not name')})"
    return " (it can be instantiated once per process only)" if model.can("canBeInstantiatedOnlyOncePerProcess") else ""
