"""The C code of a component: CasADi's functions (FILES), the tables that the core reads (model_data.h), and the arrays in which
the functions look up numbers (model_tables.h), where they do."""

import hashlib
import re
import tempfile
from collections.abc import Mapping, Sequence
from pathlib import Path

import casadi as ca

from gyro_cosim.component import Component
from gyro_cosim.component.integration import AT_REST, METHODS, easy_fraction

from . import parametric, printing, renaming
from .table import Table

__all__ = ["FILES", "functions", "generate", "nominal", "output_order", "runs_in_lanes"]

FILES = {  # apart, so that the derivatives of a large model can be compiled beside it and with less effort
    "model.c": ("rhs", "output", "step", "longest_step", "sample", "prepare"),
    "equations.c": ("rhs", "output"),  # in place of those in model.c, where they have twins
    "rhs_derivatives.c": ("rhs_forward", "rhs_adjoint"),
    "output_derivatives.c": ("output_forward", "output_adjoint", "output_second"),
}
EQUATIONS = ("rhs", "output")
SMALL_MODEL = 2000  # instructions of rhs and output up to which the outputs' second time derivative is worth its size


def functions(table: Table, *, derivatives: bool = True) -> dict[str, ca.Function]:
    """The functions that core.h lists, by name, every result dense. Arguments are columns in the order of the table."""
    c = table.component
    model = {"rhs": c.rhs, "output": c.output}
    result = dict(parametric.prepared(c).functions)
    if c.sample is not None:
        result["sample"] = c.sample
    if not derivatives:
        return result
    symbol = ca.SX if all(f.is_a("SXFunction") for f in model.values()) else ca.MX
    x, u, p = (
        symbol.sym(name, size) for name, size in zip("xup", (len(c.states), len(c.inputs), len(c.parameters)), strict=True)
    )
    dx, du, dp = (symbol.sym("d", v.numel()) for v in (x, u, p))
    along, by = ca.vertcat(dx, du, dp), ca.vertcat(x, u, p)
    sizes = [v.numel() for v in (x, u, p)]
    for name, function in model.items():
        value = ca.densify(function(x, u, p))
        result[f"{name}_forward"] = ca.Function("f", [x, u, p, dx, du, dp], [ca.jtimes(value, by, along)])
        weight = symbol.sym("l", value.numel())
        transposed = ca.jtimes(value, by, weight, True)
        result[f"{name}_adjoint"] = ca.Function("f", [x, u, p, weight], ca.vertsplit(transposed, [0, *_sums(sizes)]))
    if output_order(table) > 1:
        u1, u2 = symbol.sym("u1", len(c.inputs)), symbol.sym("u2", len(c.inputs))
        rate = c.rhs(x, u, p)
        first = ca.jtimes(c.output(x, u, p), ca.vertcat(x, u), ca.vertcat(rate, u1))
        second = ca.jtimes(first, ca.vertcat(x, u, u1), ca.vertcat(rate, u1, u2))
        result["output_second"] = ca.Function("f", [x, u, p, u1, u2], [second])
    return result


def runs_in_lanes(component: Component, available: Mapping[str, ca.Function]) -> bool:
    """Whether all that a macro step calls is an SX graph, and no sampled part cuts the steps. available : of functions()."""
    steps = (available[n] for n in ("rhs", "output", "step", "longest_step") if n in available)
    return component.sample is None and all(function.is_a("SXFunction") for function in steps)


def _sums(sizes: Sequence[int]) -> list[int]:
    """Running sums: [n0, n0 + n1, ...]."""
    return [sum(sizes[: i + 1]) for i in range(len(sizes))]


def _dense(function: ca.Function, name: str) -> ca.Function:
    """`function` as `name`: results dense, for generated code writes non-zeros only; equal subexpressions computed once."""
    symbol = ca.SX if function.is_a("SXFunction") else ca.MX
    args = [symbol.sym(f"a{i}", function.sparsity_in(i)) for i in range(function.n_in())]
    results = [ca.densify(r) for r in function.call(args)]
    if symbol is ca.SX:
        results = ca.cse(results)
    return ca.Function(name, args, results)


def output_order(table: Table) -> int:
    """Highest time derivative of the outputs that the FMU gives: 2, or 1 where its code would dwarf the model's."""
    c = table.component
    if not (c.rhs.is_a("SXFunction") and c.output.is_a("SXFunction")):
        return 1
    return 2 if c.rhs.n_instructions() + c.output.n_instructions() <= SMALL_MODEL else 1


def generate(table: Table, identifier: str, *, derivatives: bool = True) -> dict[str, str]:
    """Generate the C code of the model.

    Parameters
    ----------
    table : Table
        The FMU's variables.
    identifier : str
        What the names of the functions start with: a C identifier.
    derivatives : bool
        Whether the directional derivatives are wanted.

    Returns
    -------
    dict of str to str
        Text by file name. In model_data.h, @TOKEN@ stands for the instantiation token.

    Raises
    ------
    ValueError, RuntimeError
        If we have, or CasADi has, no C code for one of the component's functions.
    """
    available = functions(table, derivatives=derivatives)
    work = dict.fromkeys(("ARG", "RES", "IW", "W"), 1)
    for function in available.values():
        work["ARG"], work["RES"] = max(work["ARG"], function.n_in()), max(work["RES"], function.n_out())
    twins = [n for n in EQUATIONS if available[n].is_a("SXFunction") and printing.has_twins(available[n])]
    files = {}
    for file, names in FILES.items():
        here = {name: available[name] for name in names if name in available and (file == "equations.c") == (name in twins)}
        texts = {f"{identifier}_{name}": function for name, function in here.items() if function.is_a("SXFunction")}
        others = {f"{identifier}_{name}": function for name, function in here.items() if not function.is_a("SXFunction")}
        side_by_side = bool(twins) and file != "model.c" and not others  # CasADi prints for single numbers
        static, cut = "static " * (file == "model.c"), file not in ("model.c", "equations.c")
        files[file] = printing.file(texts, prefix=static, side_by_side=side_by_side, apart=cut)
        if others:
            files[file] += _by_casadi(table, identifier + file.removeprefix("model").removesuffix(".c"), others, work)
    apart = [n for file, names in FILES.items() if file != "model.c" for n in names if n in available and n not in EQUATIONS]
    arrays = printing.arrays(f for f in available.values() if f.is_a("SXFunction"))
    files |= {"model_tables.h": arrays} if arrays else {}
    return files | {"model_data.h": _data(table, identifier, work, available, [*twins, *apart])}


def _by_casadi(table: Table, stem: str, functions: Mapping[str, ca.Function], work: dict[str, int]) -> str:
    """C code by CasADi's own generator for what is no SX function; `work` grows to what it needs. stem : of its helpers."""
    generator = ca.CodeGenerator(f"{stem}.c", {"with_header": True, "with_export": False, "casadi_int": "int"})
    for name, function in functions.items():
        generator.add(_dense(function, name))
    with tempfile.TemporaryDirectory() as scratch:
        generator.generate(scratch + "/")
        text, header = (Path(scratch, f"{stem}.{suffix}").read_text() for suffix in "ch")
    if "#error" in text:
        raise RuntimeError(f"component {table.component.spec!r}: CasADi cannot generate C code for one of its functions")
    for kind in work:
        work[kind] = max([work[kind], *(int(n) for n in re.findall(rf"_SZ_{kind} (\d+)", header))])
    return renaming.with_our_mathematics(text, f"component {table.component.spec!r}")


def _data(table: Table, identifier: str, work: dict[str, int], available: Mapping[str, ca.Function], apart: Sequence[str]) -> str:
    """model_data.h: sizes, start values, bounds, the table; `apart`: the functions in files of their own."""
    c = table.component
    states, inputs, parameters = c.states, c.inputs, table.parameters
    order = METHODS[c.method].order
    output_state = [c.output_states.get(v.name, -1) for v in c.outputs]
    rows = []
    for row in table.rows:
        v = row.variable
        changes = v is not None and (
            v.variability in ("tunable", "continuous") if v.is_state or row.kind == "parameter" else True
        )
        rows.append(f'    {{{row.kind.upper()}, {row.index}, {int(changes)}, "{row.name}"}},')
    layout = repr([(r.kind, r.index, r.name) for r in table.rows]).encode()
    lines = [
        f"/* The tables of {c.spec}, generated from the component. */",
        "#ifndef MODEL_DATA_H",
        "#define MODEL_DATA_H",
        f"#define MODEL(name) {identifier}_##name",
        '#define TOKEN "@TOKEN@"',
        f"#define FINGERPRINT UINT64_C(0x{hashlib.sha256(layout).hexdigest()[:16]})",
        f"#define N_X {len(states)}",
        f"#define N_U {len(inputs)}",
        f"#define N_Y {len(c.outputs)}",
        f"#define N_P {len(parameters)}",
        f"#define N_P_MODEL {len(c.parameters)}",
        f"#define N_Q {available['prepare'].size1_out(0) if 'prepare' in available else 0}",
        f"#define N_CONTINUOUS {len(table.continuous)}",
        f"#define N_VARIABLES {len(table.rows)}",
        f"#define INTERNAL_STEP {len(c.parameters)}",
        f"#define TOLERANCE {len(c.parameters) + 1}",
        f"#define ERROR_DIVISOR {2**order - 1}.0",
        f"#define EASY {_number(easy_fraction(order))}",
        f"#define AT_REST {_number(AT_REST)}",
        f"#define MAX_OUTPUT_ORDER {output_order(table)}",
        f"#define WORK_ARGUMENTS {work['ARG']}",
        f"#define WORK_RESULTS {work['RES']}",
        f"#define WORK_INTEGERS {work['IW']}",
        f"#define WORK_REALS {work['W']}",
    ]
    lines += ["#if !defined(LANES) || LANES == 1"]
    lines += [f"int {identifier}_{name}(const double **, double **, int *, double *, int);" for name in apart]
    lines += ["#endif"]
    lines += ["#define STEP_BY_RK4"] if "step" not in available else []
    lines += ["#define LONGEST_STEP"] if "longest_step" in available else []
    lines += [] if runs_in_lanes(c, available) else ["#define NO_LANES"]
    if c.sample_period is not None:
        lines.append(f"#define SAMPLE_PERIOD {_number(c.sample_period)}")
    arrays: list[tuple[str, list[float]]] = [
        ("START_X", [v.start for v in states]),
        ("NOMINAL_X", [nominal(v.nominal) for v in states]),
        ("START_U", [v.start for v in inputs]),
        ("START_P", [v.start for v in parameters]),
        ("MIN_P", [-_LARGE if v.min is None else v.min for v in parameters]),
        ("MAX_P", [_LARGE if v.max is None else v.max for v in parameters]),
    ]
    lines += [f"static const double {name}[] = {{{', '.join(map(_number, values or [0.0]))}}};" for name, values in arrays]
    lines += [
        f"static const int {name}[] = {{{', '.join(map(str, values or [-1]))}}};"
        for name, values in (("CONTINUOUS_X", list(table.continuous)), ("OUTPUT_STATE", output_state))
    ]
    lines += ["#define ROWS \\", *(row + " \\" for row in rows), "", "#endif", ""]
    return "\n".join(lines)


_LARGE = 1.7976931348623157e308  # the largest double: no bound


def _number(value: float) -> str:
    return repr(float(value))


def nominal(value: float | None) -> float:
    """The nominal size of a state; FMI's default is 1."""
    return abs(value) if value else 1.0
