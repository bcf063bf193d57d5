"""modelDescription.xml: the schema, FMPy's validation, and what both miss."""

import math
from pathlib import Path
from typing import Any

from ..slaves.fmi.description import REAL
from .archive import Findings


def read(path: Path) -> tuple[Any, Findings]:
    """The description, or None if it cannot be read, and the faults that schema and FMPy's validation find."""
    import fmpy
    from fmpy.validation import validate_fmu

    findings: Findings = []
    try:
        problems = validate_fmu(str(path))
    except Exception as error:  # whatever a strange file makes the validator do
        problems = [f"the validator fails: {type(error).__name__}: {error}"]
    for problem in problems:
        lines = [line.strip(" -") for line in str(problem).splitlines()]
        findings += [("validation", line) for line in lines if line and not line.endswith(":")] or [("validation", str(problem))]
    try:
        model = fmpy.read_model_description(str(path), validate=False)
    except Exception as error:
        return None, [*findings, ("description", f"modelDescription.xml cannot be read: {type(error).__name__}: {error}")]
    if model.fmiVersion[:1] not in ("2", "3"):
        return None, [*findings, ("description", f"FMI version must be 2.0 or 3.0, got {model.fmiVersion!r}")]
    if model.coSimulation is None and model.modelExchange is None:
        return None, [*findings, ("description", "the FMU must offer Co-Simulation or Model Exchange")]
    return model, findings


def faults(model: Any) -> Findings:
    """Bounds, start values, nominal values, derivative indices, default experiment."""
    findings: Findings = []
    for v in model.modelVariables:
        if v.type in REAL or "Int" in v.type:
            findings += _numbers(v)
    findings += _derivatives(model)
    experiment = model.defaultExperiment
    if experiment is not None:
        start, stop, step = (number(getattr(experiment, n)) for n in ("startTime", "stopTime", "stepSize"))
        if start is not None and stop is not None and stop < start:
            findings.append(("experiment", f"stopTime must not be before startTime, got {stop:g} < {start:g}"))
        if step is not None and not step > 0.0:
            findings.append(("experiment", f"stepSize must be positive, got {step:g}"))
    return findings


def number(text: Any) -> float | None:
    """The number in an attribute; None where there is none or it is no number."""
    try:
        return None if text in (None, "") else float(text)
    except (TypeError, ValueError):
        return None


def attribute(variable: Any, name: str) -> float | None:
    """A numeric attribute of a variable, or of its type where the variable does not state it."""
    stated = number(getattr(variable, name, None))
    declared = variable.declaredType
    return stated if stated is not None or declared is None else number(getattr(declared, name, None))


def _numbers(v: Any) -> Findings:
    findings: Findings = []
    low, high, nominal = (attribute(v, n) for n in ("min", "max", "nominal"))
    values = [number(text) for text in (v.start.split() if isinstance(v.start, str) else [v.start])]
    if low is not None and high is not None and low > high:
        findings.append(("bounds", f"variable {v.name!r}: min must be at most max, got {low:g} > {high:g}"))
    for value in values:
        if value is None:
            continue
        if not math.isfinite(value):
            findings.append(("start", f"variable {v.name!r}: start must be finite, got {value}"))
        if low is not None and value < low:
            findings.append(("start", f"variable {v.name!r}: start must be at least min {low:g}, got {value:g}"))
        if high is not None and value > high:
            findings.append(("start", f"variable {v.name!r}: start must be at most max {high:g}, got {value:g}"))
    if nominal is not None and not nominal > 0.0:
        findings.append(("nominal", f"variable {v.name!r}: nominal must be positive, got {nominal:g}"))
    return findings


def _derivatives(model: Any) -> Findings:
    """A derivative belongs to one continuous variable, has its unit per second, and its name if it says der(...)."""
    findings: Findings = []
    units = {u.name: u.baseUnit for u in model.unitDefinitions}
    owner: dict[str, str] = {}
    for v in model.modelVariables:
        state = v.derivative
        if state is None:
            continue
        where = f"variable {v.name!r}: derivative"
        if state is v:
            findings.append(("derivative", f"{where} must point to another variable, points to itself"))
            continue
        if state.name in owner:
            findings.append(
                ("derivative", f"{where} points to {state.name!r}, which has the derivative {owner[state.name]!r} already")
            )
        owner[state.name] = v.name
        if state.variability != "continuous":
            findings.append(("derivative", f"{where} must point to a continuous variable, {state.name!r} is {state.variability}"))
        if v.name.startswith("der(") and v.name.endswith(")") and "," not in v.name and v.name[4:-1] != state.name:
            findings.append(("derivative", f"{where} must point to {v.name[4:-1]!r} as its name says, points to {state.name!r}"))
        mine, its = (units.get(_unit(x)) for x in (v, state))
        if mine is not None and its is not None and (mine.factor == its.factor == 1.0):
            differ = [k for k in ("kg", "m", "A", "K", "mol", "cd") if getattr(mine, k) != getattr(its, k)]
            if differ or mine.s != its.s - 1:
                findings.append(
                    (
                        "derivative",
                        f"{where}: its unit {_unit(v)!r} must be that of {state.name!r} per second, {_unit(state)!r}/s",
                    )
                )
    return findings


def _unit(v: Any) -> Any:
    return v.unit or (v.declaredType.unit if v.declaredType is not None else None)
