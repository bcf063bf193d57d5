"""CasADi's own C code calls our mathematics, and a step of a large model, which is written in C, ends at rest as any other."""

import re

import casadi as ca
import numpy as np
import pytest
from fmu_models import COMPONENTS, Compiled

from gyro_cosim.component import build, state
from gyro_cosim.fmus import code
from gyro_cosim.fmus.printing import UnknownOperationError
from gyro_cosim.fmus.renaming import with_our_mathematics
from gyro_cosim.fmus.table import Table


def test_calls_are_renamed_and_nothing_else() -> None:
    text = "w = sin(x) + casadi_sin(x) + fmax (a, pow(b, 2)); /* log */ y.exp = tan_of(z); zz_rhs(x);"
    assert with_our_mathematics(text, "c") == (
        "w = gc_sin(x) + casadi_sin(x) + gc_fmax (a, gc_pow(b, 2)); /* log */ y.exp = tan_of(z); zz_rhs(x);"
    )


def test_what_our_mathematics_lacks_is_named() -> None:
    with pytest.raises(UnknownOperationError, match=r"^component 'a:b': our mathematics has no 'lgamma'$"):
        with_our_mathematics("y = lgamma(x);", "component 'a:b'")


@pytest.mark.parametrize("name", ["radau", "rosenbrock"])
def test_implicit_steps_call_no_library_of_mathematics(name: str) -> None:
    files = code.generate(Table(COMPONENTS[name]()), "c")
    assert "gc_sqrt(" in files["model.c"]
    assert "gc_cos(" in files["model.c"]
    assert not re.search(r"(?<!\w)(sqrt|sin|cos|fabs|fmax|pow|exp|log)\s*\(", files["model.c"])


def test_an_operation_that_we_lack_is_named_when_a_component_is_exported() -> None:
    c = build(
        name="odd", variant="one", description="", equations="", internal_step=1e-3,
        variables=[state("x", "1", "state", start=0.1, is_output=True)], model=lambda s: ({"x": ca.erfinv(s["x"])}, {}),
    )  # fmt: skip
    with pytest.raises(UnknownOperationError, match="'erfinv'"):
        code.generate(Table(c), "c")


def test_a_state_of_a_large_model_at_rest_is_zero() -> None:
    """By fmus/c/rk4.c and by the definition: below 1e-100, and nothing above."""

    def model(s: object) -> tuple[dict[str, ca.SX], dict[str, ca.SX]]:
        x = ca.vertcat(*(s[f"x{i}"] for i in range(3)))  # type: ignore[index]
        slow = 1 + 1e-3 * sum(ca.cos(k * x[0]) for k in range(1, 500))
        return {f"x{i}": -x[i] * slow for i in range(3)}, {}

    c = build(
        name="large", variant="one", description="", equations="", internal_step=1e-3, model=model,
        variables=[state(f"x{i}", "1", "state", is_output=True) for i in range(3)],
    )  # fmt: skip
    assert c.rhs.n_instructions() > 1000
    arguments = np.array([1e-101, -1e-99, 3e-310]), np.zeros((0, 3)), c.start_parameters, 0.0, 1e-3
    ends = Compiled(c).step(*arguments)
    assert list(ends[[0, 2]]) == [0.0, 0.0]
    assert -1e-99 < ends[1] < -0.99e-99
    assert np.array(c.step(*arguments)).ravel() == pytest.approx(ends, rel=1e-14)
