"""cosim info: what an FMU or a system holds."""

from collections.abc import Sequence
from dataclasses import asdict
from typing import Annotated, Any

import typer
from rich.table import Table

from ..network import Network
from ..network.redundancy import Redundant, redundant_states
from ..slaves import SlaveDescription
from ..slaves.base import Linearisable
from ..slaves.described import described_slave
from ..slaves.fmi.description import Description, load
from ..slaves.fmi.rows import Row
from ..slaves.fmi.signals import described
from ..systems import archive, catalogue
from ..systems.riding import Riding, inertia_on_carriers
from .common import AsJson, Gyro, Parameters, Swaps, Values, Vehicle, chosen_system, is_system, say, tell

CAPABILITIES = (
    "canHandleVariableCommunicationStepSize", "canInterpolateInputs", "maxOutputDerivativeOrder", "canGetAndSetFMUstate",
    "canSerializeFMUstate", "providesDirectionalDerivative", "canGetAndSetFMUState", "canSerializeFMUState",
    "providesDirectionalDerivatives", "providesAdjointDerivatives", "providesIntermediateUpdate", "hasEventMode",
    "mightReturnEarlyFromDoStep", "canReturnEarlyAfterIntermediateUpdate", "needsExecutionTool",
    "canBeInstantiatedOnlyOncePerProcess", "fixedInternalStepSize",
)  # fmt: skip


def command(
    name: Annotated[str, typer.Argument(metavar="FILE|SYSTEM", help="an .fmu, .ssp or .ssd file, a system, or a component")],
    vehicle: Vehicle = None,
    gyro: Gyro = None,
    swap: Swaps = None,
    set_: Values = None,
    params: Parameters = None,
    as_json: AsJson = False,
) -> int:
    """Print what an FMU or a component holds, or a system: its graph, algebraic loops and power bonds.

    No binary of an FMU is loaded. A component is made, which runs its Python file. A system is shown with what --vehicle, --gyro,
    --swap, --set and --params make of it.
    """
    if not is_system(name):
        given = {"--vehicle": vehicle, "--gyro": gyro, "--swap": swap, "--set": set_, "--params": params}
        for option, value in given.items():
            if value:
                raise ValueError(f"{option} must be given with a system, {name!r} is none: cosim params shows its values")
    if name.endswith(".fmu"):
        description = load(name)
        found = fmu_document(name, description)
        say(as_json, lambda: found, *_fmu_words(found))
    elif not is_system(name) and _is_component(name):
        found = component_document(name)
        say(as_json, lambda: found, *_component_words(found))
    else:
        plan = chosen_system(name, gyro, set_, vehicle=vehicle, swaps=swap, params=params)
        tell(plan.notes)
        carried = inertia_on_carriers(plan)
        with Network(plan, [described_slave(c.name, c.source, c.implementation, c.given) for c in plan.components]) as network:
            found = {**system_document(network), "riding": [{**asdict(one), "right": one.right} for one in carried]}
        say(as_json, lambda: found, *_system_words(found), *_riding_words(carried))
    return 0


def _riding_words(carried: Sequence[Riding]) -> list[str]:
    """What of the units' inertia is lost or counted twice; one line where nothing is."""
    wrong = [f"WARNING: {one.words()}" for one in carried if not one.right]
    units = ", ".join(dict.fromkeys(one.unit for one in carried))
    return wrong or [f"inertia of {units} on {carried[0].carrier}: all there, once"] if carried else []


def _is_component(name: str) -> bool:
    head = name.rpartition(":")[0] if ":" in name and not name.endswith(".py") else name
    return head.endswith(".py") or head in catalogue.components() or catalogue.described_by(name) is not None


def component_document(spec: str) -> dict[str, Any]:
    """A component of the catalogue, or of a Python file, as JSON holds it."""
    spec = catalogue.resolve(spec)
    d = described_slave(spec, spec).description
    causes = {**{s.name: s for s in d.settable.values()}, **{s.name: s for s in d.outputs}}
    return {
        "component": spec,
        "variables": [
            {
                "name": s.name, "causality": s.kind, "type": s.type, "unit": s.unit,
                "start": "" if s.start is None else repr(s.start), "min": s.min, "max": s.max, "description": s.meaning,
            }
            for s in causes.values()
        ],
        "direct_feedthrough": _through(d),
    }  # fmt: skip


def _component_words(found: dict[str, Any]) -> list[str | Table]:
    head = f"{found['component']} (cosim params {found['component']} says where its values come from)"
    depends = [f"{entry['output']} depends directly on {', '.join(entry['inputs'])}" for entry in found["direct_feedthrough"]]
    return [head, *depends, "", _variables(found["variables"])]


def _through(d: SlaveDescription) -> list[dict[str, Any]]:
    return [
        {"output": y.name, "inputs": [u.name for u, feeds in zip(d.inputs, row, strict=True) if feeds]}
        for y, row in zip(d.outputs, d.feedthrough, strict=True)
        if row.any()
    ]


def fmu_document(file: str, d: Description) -> dict[str, Any]:
    """An FMU as JSON holds it."""
    with archive.opened(file) as members:
        names = members.namelist()
    binaries = sorted({n.split("/")[1] for n in names if n.startswith("binaries/") and not n.endswith("/")})
    needed = {tag: {k: attributes[k] for k in CAPABILITIES if k in attributes} for tag, attributes in d.interfaces.items()}
    return {
        "file": file,
        "fmi": d.version + ".0",
        "model": d.model,
        "description": d.identity.get("description", ""),
        "tool": d.identity.get("generationTool", ""),
        "interfaces": needed,
        "platforms": binaries,
        "sources": any(n.startswith("sources/") for n in names),
        "experiment": dict(d.experiment),
        "variables": [_variable(row) for row in d.rows],
        "direct_feedthrough": _through(described(d)),
    }


def _variable(row: Row) -> dict[str, Any]:
    bounds = {key: value for key, value in (("min", row.min), ("max", row.max)) if value is not None}
    shape = {"shape": list(row.shape)} if row.shape else {}
    items = {"items": dict(row.items)} if row.items else {}
    return {
        "name": row.name, "causality": row.causality, "variability": row.variability, "type": row.type, "unit": row.unit,
        "start": " ".join(row.start), "description": row.description, **bounds, **shape, **items,
    }  # fmt: skip


def _fmu_words(found: dict[str, Any]) -> list[str | Table]:
    lines = [f"{found['model']}: FMI {found['fmi']}, {' and '.join(found['interfaces'])}"]
    if found["description"]:
        lines.append(found["description"])
    lines.append(f"binaries for {', '.join(found['platforms']) or 'no platform'}{', with sources' if found['sources'] else ''}")
    for tag, attributes in found["interfaces"].items():
        able = [k if v in ("true", "1") else f"{k} = {v}" for k, v in attributes.items() if v not in ("false", "0")]
        lines.append(f"{tag}: {', '.join(able) or 'no capability'}")
    if found["experiment"]:
        lines.append("default experiment: " + ", ".join(f"{k} {v}" for k, v in found["experiment"].items()))
    for entry in found["direct_feedthrough"]:
        lines.append(f"{entry['output']} depends directly on {', '.join(entry['inputs'])}")
    return [*lines, "", _variables(found["variables"])]


def _variables(found: list[dict[str, Any]]) -> Table:
    table = Table("variable", "causality", "type", "unit", "start", "", box=None, pad_edge=False)
    for v in found:
        kind = v["type"] + (f"[{','.join(map(str, v['shape']))}]" if "shape" in v else "")
        start = v["start"] if len(v["start"]) <= 24 else v["start"][:21] + "..."
        table.add_row(v["name"], v["causality"], kind, v["unit"], start, v["description"])
    return table


def system_document(network: Network) -> dict[str, Any]:
    """A system as JSON holds it."""
    system = network.system
    units = dict(zip(network.names, network.units, strict=True))
    wires = []
    for i, slave in enumerate(network.slaves):
        for k, j, factor, offset in network.wires(i):
            signal = slave.inputs[j]
            wires.append({
                "from": network.names[k], "to": f"{slave.name}.{signal.name}", "unit_from": units[network.names[k]],
                "unit_to": signal.unit, "factor": factor, "offset": offset,
            })  # fmt: skip
    driven = {wire["to"] for wire in wires}
    components = []
    for component, slave in zip(system.components, network.slaves, strict=True):
        ignored = sorted(name for name in component.bound if name not in slave.description.settable)
        given = {**{n: v for n, v in component.bound.items() if n in slave.description.settable}, **component.values}
        components.append({
            "name": component.name, "source": component.source,
            "inputs": [s.name for s in slave.inputs], "outputs": [s.name for s in slave.outputs],
            "open_inputs": [s.name for s in slave.inputs if f"{slave.name}.{s.name}" not in driven],
            "input_degree": slave.description.input_degree, "can_restore": slave.description.can_restore,
            "can_serialize": slave.description.can_serialize,
            "values": {name: str(slave.description.settable[name].value(value)) for name, value in given.items()},
            "ignored_values": ignored,
        })  # fmt: skip
    return {
        "system": system.name,
        "description": system.description,
        "step": system.step,
        "start": system.start,
        "stop": system.stop,
        "notes": list(network.notes),
        "components": components,
        "connections": wires,
        "loops": list(network.loops),
        "initial_loops": list(network.initial_loops),
        "bonds": [bond.name for bond in network.bonds],
        "order": [network.slaves[i].name for i in network.order],
        "redundant_states": [str(twice) for twice in _redundant(network)],
    }


def _redundant(network: Network) -> tuple[Redundant, ...]:
    """What is integrated twice among the components in this process, which are started for that by themselves."""
    system = network.system
    for slave, values in zip(network.slaves, network.values, strict=True):
        if isinstance(slave, Linearisable):
            slave.initialize(values, system.start, system.stop)
    return redundant_states(network)


def _system_words(found: dict[str, Any]) -> list[str | Table]:
    lines: list[str | Table] = [f"{found['system']}: {found['description']}" if found["description"] else found["system"]]
    span = (f"from t = {found['start']:g} s " if found["start"] else "") + f"to t = {found['stop']:g} s"
    lines.append(f"macro step {found['step']:g} s {span}, evaluated in the order {', '.join(found['order'])}")
    table = Table("component", "source", "inputs", "outputs", "values", box=None, pad_edge=False)
    for component in found["components"]:
        values = ", ".join(f"{name} = {value}" for name, value in component["values"].items())
        numbers = str(len(component["inputs"])), str(len(component["outputs"]))
        table.add_row(component["name"], component["source"], *numbers, values)
    wires = Table("from", "", "to", box=None, pad_edge=False)
    for wire in found["connections"]:
        same = wire["factor"] == 1.0 and wire["offset"] == 0.0
        change = "" if same else f" x {wire['factor']:.6g}" + (f" + {wire['offset']:.6g}" if wire["offset"] else "")
        ends = [f"{wire[end]} [{wire[f'unit_{end}']}]" if wire[f"unit_{end}"] else wire[end] for end in ("from", "to")]
        wires.add_row(ends[0], f"->{change}", ends[1])
    lines += ["", table, "", wires, ""]
    for component in found["components"]:
        if component["open_inputs"]:
            lines.append(f"inputs of {component['name']} that keep their start values: {', '.join(component['open_inputs'])}")
    lines += [f"note: {note}" for note in found["notes"]]
    lines += [f"algebraic loop: {loop}" for loop in found["loops"]] or ["algebraic loops: none"]
    lines += [f"algebraic loop in initialization mode: {loop}" for loop in found["initial_loops"]]
    lines += [f"power bond: {bond}" for bond in found["bonds"]] or ["power bonds: none"]
    lines += [f"WARNING: {text}" for text in found["redundant_states"]]
    return lines
