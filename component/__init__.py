"""The value that crosses every wall: a component, its table of variables, and its CasADi functions.

`vehicle` and `gyro_unit` make components; `fmus` turns one into an FMU, `cosim` runs one in this process. None of the
four imports another: they share only what stands in this package.
"""

from component.model import Bond, Component, build
from component.variables import Variable, input_, output, parameter, state

__all__ = ["Bond", "Component", "Variable", "build", "input_", "output", "parameter", "state"]
