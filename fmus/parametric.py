"""What depends on parameters alone is computed when one changes, not in every call.

    q = prepare(p),    rhs(x, u, P),    output(x, u, P),    step(x, U, P, tau, h),    P = (p, q)

The operations are those of the component's functions, in the same order on the same numbers, so the results have the same bits.
A component whose functions are no SX graphs has no q: CasADi finds the parts of scalar graphs only.
"""

from dataclasses import dataclass

import casadi as ca

from gyro_cosim.component import Component
from gyro_cosim.component.integration import step_function

__all__ = ["Prepared", "prepared"]


@dataclass(frozen=True, eq=False)
class Prepared:
    """The functions of a component with prepared parameters.

    Attributes
    ----------
    functions : dict of str to casadi.Function
        "rhs", "output" and "step", which take P where the component's take p, and, where there is a q, "prepare".
    size : int
        Of q.
    """

    functions: dict[str, ca.Function]
    size: int


def prepared(component: Component) -> Prepared:
    """The functions of `component` in this form."""
    c = component
    plain = {"step": c.step, "rhs": c.rhs, "output": c.output}
    graphs = [c.rhs, c.output, *([c.longest_step] if c.longest_step is not None else [])]
    if not all(graph.is_a("SXFunction") for graph in graphs):
        return Prepared(plain, 0)
    x, u, p = (ca.SX.sym(name, n) for name, n in zip("xup", (len(c.states), len(c.inputs), len(c.parameters)), strict=True))
    values = ca.cse([ca.densify(graph(x, u, p)) for graph in graphs])  # shared by all: what one needs is prepared once
    values, symbols, parts = ca.extract_parametric(values, p)
    if not symbols:
        return Prepared(plain, 0)
    q = ca.vertcat(*symbols)
    P = ca.SX.sym("P", p.numel() + q.numel())
    rhs, output, *longest = (
        ca.Function(graph.name(), [x, u, P], [value])
        for graph, value in zip(graphs, ca.substitute(values, [ca.vertcat(p, q)], [P]), strict=True)
    )
    step = step_function(rhs, c.method, longest[0] if longest else None)
    functions = {"step": step, "rhs": rhs, "output": output, "prepare": ca.Function("prepare", [p], [ca.vertcat(*parts)])}
    return Prepared(functions, q.numel())
