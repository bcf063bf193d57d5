"""What a sweep has to know of the components before it begins: which values its axes may take, which signals there are."""

from collections.abc import Mapping, Sequence
from types import TracebackType
from typing import Any

from ..errors import unknown
from ..master import open_network
from ..network import Network
from ..systems import System
from ..trajectory import matching
from .axes import Value

MEASURES = ("end", "max", "rms")  # of each signal


class SystemQuery:
    """The system with each of its variants, opened to ask what there is. units : column -> unit of what was asked for."""

    def __init__(self, system: System, variants: Mapping[str, Sequence[str]]) -> None:
        for target in variants:
            system.addressed(target)
        first = {target: names[0] for target, names in variants.items() if names}
        others = [{**first, t: name} for t, names in variants.items() for name in names[1:]]
        self._system = system
        self._open: list[Network] = []
        self.units: dict[str, str] = {}
        try:
            for chosen in [first, *others]:
                varied = system
                for target, variant in chosen.items():
                    varied = varied.with_source(target, variant)
                self._open.append(open_network(varied))
        except BaseException:
            self.close()
            raise

    def value(self, target: str, text: str | float) -> Value:
        """`text` in the unit of the variable that `target` names; all variants must agree about it."""
        self._system.with_value(target, text)
        name, _, variable = target.partition(".")
        answers: set[tuple[Any, str]] = set()
        for network in self._open:
            for slave in network.slaves:
                if slave.name in self._system.addressed(name):
                    known = slave.description
                    answers.add((known.start_values(slave.name, {variable: text})[variable], known.settable[variable].unit))
        if len(answers) > 1:
            raise ValueError(f"axis {target!r} must have the same unit everywhere, has {', '.join(unit for _, unit in answers)}")
        ((value, self.units[target]),) = answers
        if not isinstance(value, str | float | int):
            raise ValueError(f"axis {target!r} must take single numbers or text, not arrays or bytes")
        return value

    def signals(self, patterns: Sequence[str]) -> tuple[str, ...]:
        """Outputs of any variant that match a pattern; their measures' units are noted."""
        units = {name: unit for network in self._open for name, unit in zip(network.names, network.units, strict=True)}
        meant: set[str] = set()
        for pattern in patterns:
            matched = matching(pattern, units)
            if not matched:
                raise unknown("signal", pattern, units)
            meant.update(matched)
        chosen = tuple(name for name in units if not patterns or name in meant)
        self.units |= {f"{name}.{measure}": units[name] for name in chosen for measure in MEASURES if units[name]}
        return chosen

    def __enter__(self) -> "SystemQuery":
        return self

    def __exit__(self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None) -> None:
        self.close()

    def close(self) -> None:
        """Close what was opened."""
        for network in self._open:
            network.close()
