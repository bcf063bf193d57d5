"""Intermediate update of FMI 3.0: accuracy, early return, and what the importer may touch."""

from collections.abc import Callable

import numpy as np
import pytest
from fmpy.fmi1 import FMICallException
from fmpy.fmi3 import fmi3ValueReference
from fmu_models import in_process
from fmu_opening import ERROR, Open, opened, refused


def with_update(it: Open, update: Callable, names: list[str], *, early: bool = False) -> None:
    """Instantiate anew with an intermediate update callback."""
    it.fmu.fmi3FreeInstance(it.fmu.component)
    required = (fmi3ValueReference * len(names))(*(it.vr[n] for n in names))
    it.fmu.instantiate(earlyReturnAllowed=early, requiredIntermediateVariables=required, intermediateUpdate=update)


def test_intermediate_update_reaches_the_accuracy_of_input_derivatives(built: Callable) -> None:
    """A quadratic input, given at the times the FMU asks for, equals FMI 2.0's input derivatives; outputs come on the way."""
    c, path, folder = built("plain", "3")
    U = np.array([[0.4, 3.0, -20.0]])
    asked, seen = [], []
    with opened(path, folder) as it:

        def update(_: object, t: float, wanted: bool, readable: bool, finished: bool, *more: object) -> None:
            if wanted:
                asked.append(t)
                it.set(u=U[0, 0] + U[0, 1] * t + U[0, 2] * t * t / 2)
            if readable:
                seen.append((t, *it.get("phi", "y")))

        with_update(it, update, ["u", "phi", "y"])
        it.initialize()
        it.fmu.doStep(0.0, 0.1)
        got = it.outputs()
    assert got == pytest.approx(in_process(c, [(0.0, 0.1, U)])[0], rel=1e-12)
    assert np.all(np.diff(asked) >= 0.0)
    assert (asked[0], asked[-1]) == (0.0, pytest.approx(0.1))
    assert len(seen) == 50  # one for each internal step of 2 ms
    phi = [in_process(c, [(0.0, t, U)])[0] for t, *_ in seen[:5]]
    assert np.allclose([row[1:] for row in seen[:5]], phi, rtol=1e-9)


def test_early_return_ends_the_step_where_the_importer_wants(built: Callable) -> None:
    _, path, folder = built("plain", "3")
    with opened(path, folder) as it:

        def update(
            _: object, t: float, wanted: bool, readable: bool, finished: bool, may: bool, ask: object, until: object
        ) -> None:
            if may and t > 0.03:
                ask[0] = True

        with_update(it, update, ["u"], early=True)
        it.initialize()
        _, _, early, reached = it.fmu.doStep(0.0, 0.1)
        assert (early, reached) == (True, pytest.approx(0.032))
        assert it.get("time") == reached
        _, _, early, reached = it.fmu.doStep(reached, 0.002)
        assert reached == pytest.approx(0.034)


def test_intermediate_update_lets_only_named_variables_through(built: Callable) -> None:
    _, path, folder = built("plain", "3")
    answers = []
    with opened(path, folder) as it:

        def update(_: object, t: float, wanted: bool, *more: object) -> None:
            try:
                it.get("phi")
            except FMICallException as error:
                answers.append(error.status)

        with_update(it, update, ["u"])
        it.initialize()
        refused(ERROR, it.fmu.doStep, 0.0, 0.002)
    assert answers[0] == ERROR
