"""What the FMUs' functions answer: states, status codes, saved states, derivatives, logging."""

from collections.abc import Callable
from ctypes import c_double

import numpy as np
import pytest
from fmu_models import COMPONENTS, random_steps
from fmu_opening import DISCARD, ERROR, Open, opened, refused

BOTH = pytest.mark.parametrize("version", ["2", "3"])


def save(it: Open) -> object:
    return it.fmu.getFMUstate() if it.version == "2" else it.fmu.getFMUState()


def restore(it: Open, state: object) -> None:
    (it.fmu.setFMUstate if it.version == "2" else it.fmu.setFMUState)(state)


def discard(it: Open, state: object) -> None:
    (it.fmu.freeFMUstate if it.version == "2" else it.fmu.freeFMUState)(state)


def serialized(it: Open, state: object) -> bytes:
    return bytes(it.fmu.serializeFMUstate(state) if it.version == "2" else it.fmu.serializeFMUState(state))


def deserialized(it: Open, data: bytes) -> object:
    return (it.fmu.deSerializeFMUstate if it.version == "2" else it.fmu.deserializeFMUState)(data)


@BOTH
@pytest.mark.parametrize("name", COMPONENTS)
@pytest.mark.parametrize("tolerance", [0.0, 1e-5])
def test_restored_state_repeats_the_run_bit_for_bit(built: Callable, name: str, version: str, tolerance: float) -> None:
    """Also from bytes, in another instance, while the first goes its own way."""
    c, path, folder = built(name, version)
    steps = random_steps(c, 0.01, 12, size=0.1)
    with opened(path, folder) as it, opened(path, folder) as other:
        it.initialize(tolerance=tolerance)
        other.initialize()
        for step in steps[:4]:
            it.step(*step)
        state, y = save(it), it.outputs()
        data = serialized(it, state)
        assert data[:8] == bytes(8)
        first = [it.step(*step) for step in steps[4:]]
        restore(it, state)
        assert np.array_equal(it.outputs(), y)
        assert np.array_equal([it.step(*step) for step in steps[4:]], first)
        moved = deserialized(other, data)
        restore(other, moved)
        assert np.array_equal([other.step(*step) for step in steps[4:]], first)
        discard(it, state)
        discard(other, moved)


@BOTH
def test_a_state_of_another_model_is_refused(built: Callable, version: str) -> None:
    (_, a, folder_a), (_, b, folder_b) = built("plain", version), built("gain", version)
    with opened(a, folder_a) as it, opened(b, folder_b) as other:
        it.initialize()
        state = save(it)
        data = serialized(it, state)
        refused(ERROR, deserialized, other, data)
        refused(ERROR, deserialized, other, data[:-1])
        discard(it, state)


@BOTH
@pytest.mark.parametrize("name", COMPONENTS)
def test_two_instances_never_touch_each_other(built: Callable, name: str, version: str) -> None:
    """Interleaved with another one that does something else, an instance gives what it gives alone."""
    c, path, folder = built(name, version)
    mine, others = (random_steps(c, 0.01, 10, seed=s, size=0.1) for s in (1, 2))
    with opened(path, folder) as it:
        it.initialize()
        alone = [it.step(*step) for step in mine]
    with opened(path, folder) as it, opened(path, folder) as other:
        it.initialize()
        other.initialize()
        together = []
        for step, distraction in zip(mine, others, strict=True):
            other.step(*distraction)
            together.append(it.step(*step))
            other.outputs()
    assert np.array_equal(alone, together)


@BOTH
@pytest.mark.parametrize("name", COMPONENTS)
def test_reset_starts_anew(built: Callable, name: str, version: str) -> None:
    c, path, folder = built(name, version)
    steps = random_steps(c, 0.01, 6, size=0.1)
    with opened(path, folder) as it:
        it.initialize()
        first = [it.outputs(), *(it.step(*step) for step in steps)]
        it.fmu.reset()
        it.initialize()
        assert np.array_equal([it.outputs(), *(it.step(*step) for step in steps)], first)


@BOTH
def test_wrong_calls_are_errors_and_a_saved_state_or_reset_recovers(built: Callable, version: str) -> None:
    """Negative and wrong steps, unknown and unsettable variables: fmiError; then only restoring or resetting helps."""
    _, path, folder = built("plain", version)
    with opened(path, folder) as it:
        it.initialize(stop=1.0)
        state, y = save(it), it.outputs()
        setter = it.fmu.setReal if version == "2" else it.fmu.setFloat64
        getter = it.fmu.getReal if version == "2" else it.fmu.getFloat64
        for call in (
            lambda: it.fmu.doStep(0.0, -0.1), lambda: it.fmu.doStep(0.0, 0.0), lambda: it.fmu.doStep(0.5, 0.1),
            lambda: it.fmu.doStep(0.0, 1.5), lambda: it.fmu.doStep(0.0, float("nan")), lambda: it.set(phi=1.0),
            lambda: it.set(y=1.0), lambda: it.set(internal_step=1e-3), lambda: setter([999], [1.0]), lambda: getter([999]),
            it.fmu.exitInitializationMode,
        ):  # fmt: skip
            refused(ERROR, call)
            refused(ERROR, it.fmu.doStep, 0.0, 0.1)  # not before the instance is put right
            restore(it, state)
            assert np.array_equal(it.outputs(), y)
        it.fmu.doStep(0.0, 0.1)
        refused(ERROR, it.fmu.doStep, 0.0, 0.1)
        it.fmu.reset()
        it.initialize()
        it.fmu.doStep(0.0, 0.1)
        discard(it, state)


@BOTH
def test_refused_values_change_nothing(built: Callable, version: str) -> None:
    """NaN, and parameters outside min and max: fmiDiscard, and the instance goes on as if nothing had been said."""
    _, path, folder = built("plain", version)
    with opened(path, folder) as it:
        it.initialize()
        y = it.outputs()
        for values in ({"u": float("nan")}, {"k": -1.0}, {"k": 2e6}, {"u": 7.0, "k": -1.0}, {"u": float("inf")}):
            refused(DISCARD, it.set, **values)
        assert list(it.get("u", "k")) == [0.0, 9.0]
        it.set(k=0.0)  # the bound itself
        it.set(k=1e6)
        it.set(k=9.0)
        assert np.array_equal(it.outputs(), y)
        it.fmu.doStep(0.0, 0.1)


@BOTH
def test_a_step_that_overflows_is_discarded(built: Callable, version: str) -> None:
    """x' = x^2 leaves the doubles shortly after t = 1. FMI 2.0 then wants a restored state, FMI 3.0 goes on as it was."""
    _, path, folder = built("autonomous", version)
    with opened(path, folder) as it:
        it.initialize()
        it.fmu.doStep(0.0, 0.9)
        state, x = save(it), it.outputs()
        refused(DISCARD, it.fmu.doStep, 0.9, 1.0)
        if version == "2":
            value = c_double()
            it.fmu.fmi2GetRealStatus(it.fmu.component, 2, value)  # fmi2LastSuccessfulTime
            assert value.value == 0.9
            refused(ERROR, it.fmu.doStep, 0.9, 0.01)
            restore(it, state)
        assert np.array_equal(it.outputs(), x)
        it.fmu.doStep(0.9, 0.01)
        assert it.outputs() == pytest.approx(1 / (1 - 0.91), rel=1e-5)
        discard(it, state)


@pytest.mark.parametrize(("name", "values"), [("implicit growth", {"internal_step": 10.0}), ("autonomous", {"tolerance": 1e-9})])
def test_a_step_that_does_not_converge_is_discarded(built: Callable, name: str, values: dict[str, float]) -> None:
    """Newton without a solution, and a tolerance that cannot be met near a pole: said, not hidden."""
    _, path, folder = built(name)
    with opened(path, folder) as it:
        it.initialize(**values)
        state = save(it)
        refused(DISCARD, it.fmu.doStep, 0.0, 3.0)
        restore(it, state)
        discard(it, state)
        it.fmu.doStep(0.0, 1e-6)


@BOTH
@pytest.mark.parametrize("name", [n for n in COMPONENTS if n not in ("autonomous",)])
def test_directional_and_adjoint_derivatives_are_exact(built: Callable, name: str, version: str) -> None:
    """Against central differences of the component's own functions, at a random point, with random seeds."""
    c, path, folder = built(name, version)
    rng = np.random.default_rng(3)
    x, u, p = (v + 0.1 * rng.standard_normal(v.size) for v in (c.start_state, c.start_input, c.start_parameters * 0))
    p = c.start_parameters
    names = [[v.name for v in rows] for rows in (c.states, c.inputs, c.parameters)]
    unknown = [v.name for v in c.outputs] + [f"der({v.name})" for v in c.states if v.variability == "continuous"]
    kept = [i for i, v in enumerate(c.states) if v.variability == "continuous"]

    def values(z: np.ndarray) -> np.ndarray:
        parts = np.split(z, np.cumsum([x.size, u.size])[:2])
        return np.concatenate([np.array(c.output(*parts)).ravel(), np.array(c.rhs(*parts)).ravel()[kept]])

    z = np.concatenate([x, u, p])
    scale = np.maximum(np.abs(z), 1e-3) * 1e-5
    jacobian = np.column_stack([(values(z + d) - values(z - d)) / (2 * d.max()) for d in np.diag(scale)])
    known = [n for part in names for n in part]
    with opened(path, folder) as it:
        it.initialize(**dict(zip(known, z, strict=True)))
        it.set(**dict(zip(names[1], u, strict=True)))
        seed = rng.standard_normal(len(known))
        got = it.fmu.getDirectionalDerivative([it.vr[n] for n in unknown], [it.vr[n] for n in known], list(seed))
        size = np.abs(jacobian) @ np.abs(seed) + 1e-9
        assert np.all(np.abs(got - jacobian @ seed) < 1e-6 * size)
        if version == "3":
            weight = rng.standard_normal(len(unknown))
            back = it.fmu.getAdjointDerivative([it.vr[n] for n in unknown], [it.vr[n] for n in known], list(weight), len(known))
            assert np.dot(back, seed) == pytest.approx(np.dot(weight, got), rel=1e-12)


@BOTH
@pytest.mark.parametrize("name", ["plain", "gyro_unit:nonlinear"])
def test_output_derivatives_are_the_outputs_slopes(built: Callable, name: str, version: str) -> None:
    """First and second time derivative after a step, against differences of the outputs over short steps that follow."""
    c, path, folder = built(name, version)
    degree = 2 if version == "2" else 0
    rng = np.random.default_rng(5)
    U = rng.standard_normal((len(c.inputs), 3)) * ([1, 1, 1] if degree else [1, 0, 0])
    h, e = 0.01, 1e-4

    def after(*lengths: float) -> tuple[np.ndarray, np.ndarray]:
        with opened(path, folder) as it:
            it.initialize(internal_step=1e-3)
            y = it.step(0.0, sum(lengths), U)
            refs = [it.vr[n] for n in it.names["output"]]
            read = it.fmu.getRealOutputDerivatives if version == "2" else it.fmu.getOutputDerivatives
            return y, np.array([read(refs, [order] * len(refs)) for order in (1, 2)])

    (low, _), (y, rates), (high, _) = after(h - e), after(h), after(h + e)
    size = 1 + np.abs(rates)
    assert np.all(np.abs((high - low) / (2 * e) - rates[0]) < 1e-4 * size[0])
    assert np.all(np.abs((high - 2 * y + low) / e**2 - rates[1]) < 1e-3 * size[1])


@BOTH
def test_log_categories_choose_what_is_told(built: Callable, version: str) -> None:
    """Events of the sampled part only when asked for; a discarded step says why."""
    _, path, folder = built("sampled", version)
    said: list[tuple[int, str, str]] = []
    with opened(path, folder) as it:
        free = it.fmu.fmi2FreeInstance if version == "2" else it.fmu.fmi3FreeInstance
        free(it.fmu.component)
        if version == "2":
            from fmpy.fmi2 import defaultCallbacks, fmi2CallbackFunctions, fmi2CallbackLoggerTYPE

            callbacks = fmi2CallbackFunctions.from_buffer_copy(defaultCallbacks)
            callbacks.logger = fmi2CallbackLoggerTYPE(lambda e, i, s, c, m: said.append((s, c.decode(), m.decode())))
            it.fmu.instantiate(callbacks=callbacks)
        else:
            it.fmu.instantiate(logMessage=lambda e, s, c, m: said.append((s, c.decode(), m.decode())))
        it.initialize(wish=1.0)
        it.fmu.doStep(0.0, 0.01)
        assert said == []
        it.fmu.setDebugLogging(True, ["logEvents"])
        it.fmu.doStep(0.01, 0.02)
        assert said == [(0, "logEvents", f"sample {k} at {0.007 * k:.9g} s") for k in (2, 3, 4)]
        said.clear()
        it.fmu.setDebugLogging(True, ["logStatusDiscard"])
        refused(DISCARD, it.set, wish=float("nan"))
        assert [row[:2] for row in said] == [(2, "logStatusDiscard")]
        assert "wish" in said[0][2]
        refused(ERROR, it.fmu.setDebugLogging, True, ["nonsense"])
