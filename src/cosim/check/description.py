"""modelDescription.xml: the schema, FMPy's validation, and what both miss."""

import math
from pathlib import Path
from typing import Any

from ..slaves.fmi.rows import REAL
from ..slaves.fmi.schema import judged
from ..systems import archive as door
from .findings import Finding, Findings

ALSO_READ = ("sources/buildDescription.xml", "terminalsAndIcons/terminalsAndIcons.xml")  # by FMPy


def read(path: Path) -> tuple[Any, Findings]:
    """The description, or None if it cannot be read, and what schema and FMPy's validation say."""
    import fmpy
    from fmpy.validation import validate_model_description

    found: Findings = []
    try:
        with door.opened(str(path)) as archive:
            root = door.xml(door.held(archive, "modelDescription.xml", str(path)), "modelDescription.xml")
            for name in set(ALSO_READ) & set(archive.namelist()):
                door.xml(door.held(archive, name, str(path)), name)
    except ValueError as error:
        return None, [Finding("description", str(error))]
    version = root.get("fmiVersion", "")
    if version not in ("1.0", "2.0") and not version.startswith("3."):
        return None, [Finding("description", f"FMI version must be 1.0, 2.0 or 3.0, got {version!r}")]
    if version.startswith("3.") and "-" in version:
        found.append(Finding("description", f"FMI version {version!r} is a draft, checked as 3.0", "warning"))
    for (message, harmless), lines in _alike(judged(root, version[0])[1]).items():
        more = f" (and {len(lines) - 1} more like it)" if len(lines) > 1 else ""
        found.append(Finding("validation", f"line {lines[0]}: {message}{more}", "warning" if harmless else "fault"))
    found += _clocks(root) if version.startswith("3.") else []
    try:
        model = fmpy.read_model_description(str(path), validate=False)
    except Exception as error:  # whatever a strange file makes FMPy do
        return None, [*found, Finding("description", f"modelDescription.xml cannot be read: {type(error).__name__}: {error}")]
    try:
        problems = validate_model_description(model, validate_variable_names=True, validate_model_structure=True)
        found += [Finding("validation", str(problem).strip().splitlines()[0]) for problem in problems]
    except Exception as error:
        found.append(Finding("validation", f"FMPy's validation fails: {type(error).__name__}: {error}", "note"))
    if model.coSimulation is None and model.modelExchange is None and model.scheduledExecution is None:
        return None, [*found, Finding("description", "the FMU must offer Co-Simulation, Model Exchange or Scheduled Execution")]
    return model, found


def _alike(faults: Any) -> dict[tuple[str, bool], list[int]]:
    """The lines on which each message stands."""
    lines: dict[tuple[str, bool], list[int]] = {}
    for fault in faults:
        lines.setdefault((fault.message, fault.harmless), []).append(fault.line)
    return lines


def examined(model: Any) -> Findings:
    """Bounds, start values, nominal values, derivatives, default experiment."""
    found: Findings = []
    states = {id(v.derivative) for v in model.modelVariables if v.derivative is not None}
    for v in model.modelVariables:
        if v.type in REAL or "Int" in v.type:
            found += _numbers(v, id(v) in states)
    found += _derivatives(model)
    experiment = model.defaultExperiment
    if experiment is not None:
        start, stop, step = (number(getattr(experiment, n)) for n in ("startTime", "stopTime", "stepSize"))
        if start is not None and stop is not None and stop < start:
            found.append(Finding("experiment", f"stopTime should not be before startTime, got {stop:g} < {start:g}", "warning"))
        if step is not None and not step > 0.0:
            found.append(Finding("experiment", f"stepSize should be positive, got {step:g}", "warning"))
    return found


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


def _numbers(v: Any, is_state: bool) -> Findings:
    found: Findings = []
    where = f"variable {v.name!r}:"
    low, high, nominal = (attribute(v, n) for n in ("min", "max", "nominal"))
    values = [number(text) for text in (v.start.split() if isinstance(v.start, str) else [v.start])]
    if low is not None and high is not None and low > high:
        found.append(Finding("bounds", f"{where} min must be at most max, got {low:g} > {high:g}"))
    for value in values:
        if value is None:
            continue
        if not math.isfinite(value):
            found.append(Finding("start", f"{where} start should be finite, got {value}", "warning"))
        if low is not None and value < low:
            found.append(Finding("start", f"{where} start should be at least min {low:g}, got {value:g}", "warning"))
        if high is not None and value > high:
            found.append(Finding("start", f"{where} start should be at most max {high:g}, got {value:g}", "warning"))
    if nominal is not None and not nominal > 0.0:
        rule = "of a continuous state must be positive" if is_state else "should be positive"
        found.append(Finding("nominal", f"{where} nominal {rule}, got {nominal:g}", "fault" if is_state else "warning"))
    return found


def _derivatives(model: Any) -> Findings:
    """A derivative belongs to one continuous variable, has its unit per second, and its name if it says der(...)."""
    found: Findings = []
    units = {u.name: u.baseUnit for u in model.unitDefinitions}
    for v in model.modelVariables:
        state = v.derivative
        if state is None:
            continue
        where = f"variable {v.name!r}: derivative"
        if state is v:
            found.append(Finding("derivative", f"{where} must point to another variable, points to itself"))
            continue
        if state.variability != "continuous":
            text = f"{where} must point to a continuous variable, {state.name!r} is {state.variability}"
            found.append(Finding("derivative", text))
        named = v.name[4:-1] if v.name.startswith("der(") and v.name.endswith(")") and "," not in v.name else state.name
        if named != state.name:
            text = f"{where} must point to {named!r} as its name says, points to {state.name!r}"
            found.append(Finding("derivative", text, "fault" if model.variableNamingConvention == "structured" else "warning"))
        mine, its = (units.get(_unit(x)) for x in (v, state))
        if mine is not None and its is not None and (mine.factor == its.factor == 1.0):
            differ = [k for k in ("kg", "m", "A", "K", "mol", "cd") if getattr(mine, k) != getattr(its, k)]
            if differ or mine.s != its.s - 1:
                text = f"{where}: its unit {_unit(v)!r} should be that of {state.name!r} per second, {_unit(state)!r}/s"
                found.append(Finding("derivative", text, "warning"))
    return found


def _clocks(root: Any) -> Findings:
    """Clocks of FMI 3.0 say when they tick, and clocked variables name clocks; FMPy does not read all of it."""
    found: Findings = []
    variables = [v for v in root.iterfind("ModelVariables/*") if v.get("valueReference") is not None]
    clocks = {v.get("valueReference") for v in variables if v.tag == "Clock"}
    for v in variables:
        for reference in (v.get("clocks") or "").split():
            if reference not in clocks:
                text = f"variable {v.get('name')!r}: its clocks must be clocks, value reference {reference} is none"
                found.append(Finding("clocks", text))
        if v.tag != "Clock":
            continue
        where, kind, interval = f"clock {v.get('name')!r}", v.get("intervalVariability"), number(v.get("intervalDecimal"))
        if kind == "constant" and interval is None and v.get("intervalCounter") is None:
            found.append(Finding("clocks", f"{where} must have an interval, as intervalVariability {kind!r} says"))
        if interval is not None and not interval > 0.0:
            found.append(Finding("clocks", f"{where} must have a positive interval, got {interval:g} s"))
        if kind == "triggered" and interval is not None:
            found.append(Finding("clocks", f"{where} is triggered and should have no interval, got {interval:g} s", "warning"))
    return found


def _unit(v: Any) -> Any:
    return v.unit or (v.declaredType.unit if v.declaredType is not None else None)
