"""The value that crosses every wall: a component, its table of variables, and its CasADi functions.

`vehicle` and `gyro_unit` make components; `fmus` turns one into an FMU, `cosim` runs one in this process. None of the
four imports another: they share only what stands in this package.
"""

from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from .model import Bond, Component, build
    from .variables import Variable, input_, output, parameter, state

__all__ = ["Bond", "Component", "Variable", "build", "input_", "output", "parameter", "state"]


def __getattr__(name: str) -> Any:
    """Load CasADi only for those who make or run a component: reading units, as every command does, must stay quick."""
    if name not in __all__:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    from . import model, variables

    return getattr(model if hasattr(model, name) else variables, name)
