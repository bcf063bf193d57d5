"""What depends on parameters alone is computed when one changes, not in every call.

    q = prepare(p),    rhs(x, u, P),    output(x, u, P),    longest_step(x, u, P),    step(x, U, P, tau, h),    P = (p, q)

`step` does not cut: the core does, as `component.integration.step_function` defines it; a large model has none, for the core
takes its steps by calls of rhs. The operations are those of the component's functions, in the same order on the same numbers,
so the results have the same bits. A component whose functions are no SX graphs has no q: CasADi finds the parts of scalar
graphs only.
"""

from dataclasses import dataclass

import casadi as ca

from gyro_cosim.component import Component
from gyro_cosim.component.integration import EXPLICIT, is_straight, whole_step

__all__ = ["Prepared", "prepared"]


@dataclass(frozen=True, eq=False)
class Prepared:
    """The functions of a component with prepared parameters.

    Attributes
    ----------
    functions : dict of str to casadi.Function
        "rhs", "output" and what else the module's docstring names, which take P where the component's take p; "prepare" where
        there is a q.
    size : int
        Of q.
    """

    functions: dict[str, ca.Function]
    size: int


def prepared(component: Component) -> Prepared:
    """The functions of `component` in this form."""
    c = component
    graphs = {"rhs": c.rhs, "output": c.output}
    if c.longest_step is not None:
        graphs["longest_step"] = c.longest_step
    if not all(graph.is_a("SXFunction") for graph in graphs.values()):
        return Prepared(graphs | _step(c.rhs, c.method), 0)
    x, u, p = (ca.SX.sym(name, n) for name, n in zip("xup", (len(c.states), len(c.inputs), len(c.parameters)), strict=True))
    values = ca.cse([ca.densify(graph(x, u, p)) for graph in graphs.values()])  # shared by all: what one needs is prepared once
    values, symbols, parts = ca.extract_parametric(values, p)
    if not symbols:
        return Prepared(graphs | _step(c.rhs, c.method), 0)
    q = ca.vertcat(*symbols)
    P = ca.SX.sym("P", p.numel() + q.numel())
    values = ca.substitute(values, [ca.vertcat(p, q)], [P])
    functions = {name: ca.Function(name, [x, u, P], [value]) for name, value in zip(graphs, values, strict=True)}
    functions |= {"prepare": ca.Function("prepare", [p], [ca.vertcat(*parts)])}
    return Prepared(functions | _step(functions["rhs"], c.method), q.numel())


def _step(rhs: ca.Function, method: str) -> dict[str, ca.Function]:
    by_calls = method in EXPLICIT and rhs.is_a("SXFunction") and not is_straight(rhs, method)
    return {} if by_calls else {"step": whole_step(rhs, method)}
