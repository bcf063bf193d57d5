"""The contract between the parts: a component, its table of variables, and its CasADi functions.

`vehicle` and `gyro_unit` make components; `fmus` turns one into an FMU, `cosim` runs one in this process. None of the
four imports another: they share only what stands in this package.

Public: what `__all__` names, the units in `component.units`, and the names of the energy signals,
`component.variables.BALANCE`. The other modules serve exporter and master: `integration` and `methods` (the internal step),
`do_step` (the macro step), `calling` (fast repeated calls) and `zip_files`.
"""

from importlib import import_module
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from .building import build
    from .model import Bond, Component
    from .variables import Variable, input_, output, parameter, state

__all__ = ["Bond", "Component", "Variable", "build", "input_", "output", "parameter", "state"]

_HOMES = {
    "building": ("build",),
    "model": ("Bond", "Component"),
    "variables": ("Variable", "input_", "output", "parameter", "state"),
}


def __getattr__(name: str) -> Any:
    """Load CasADi only for those who make or run a component: reading units, as every command does, must stay quick."""
    for module, names in _HOMES.items():
        if name in names:
            return getattr(import_module(f".{module}", __name__), name)
    raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
