"""system_data.h: the tables of a coupled system that the C code in c/ reads."""

import hashlib
from collections.abc import Iterable, Sequence

from ..coupling import MAX_DEGREE, Algorithm, GaussSeidel
from ..network import Network
from ..slaves.fmi.intermediate_update import asked_for
from ..slaves.fmi.rows import Row
from ..systems import System
from .components import Packed
from .variables import ALGORITHMS, LEAST, TYPES, Variables

__all__ = ["carried", "prefixes", "system_data"]

PREFIX = "component_{}_"  # of the functions of a linked FMU
_C_TYPES = {
    "real": "TYPE_REAL",
    "integer": "TYPE_INTEGER",
    "enumeration": "TYPE_INTEGER",
    "boolean": "TYPE_BOOLEAN",
    "string": "TYPE_STRING",
}
_AT_START, _BETWEEN_STEPS = "INSTANTIATED | INITIALIZATION", "INSTANTIATED | INITIALIZATION | STEP"  # when it may be set
_PLAIN = ("uint32_t", "int64_t", "double", "char *const")


def system_data(
    system: System, network: Network, components: Sequence[Packed], variables: Variables, algorithm: Algorithm
) -> str:
    """The text of system_data.h, in which @TOKEN@ stands for the instantiation token.

    Parameters
    ----------
    system : System
        What is packed.
    network : Network
        Its slaves, opened.
    components : sequence of Packed
        The same.
    variables : Variables
        Of the FMU.
    algorithm : Algorithm
        What the coupling starts with.

    Returns
    -------
    str
        C code.
    """
    layout = repr([(v.name, v.kind, v.component, v.reference) for v in variables.all]).encode()
    lines = [
        f"/* The tables of {_plain(system.name)}, generated from the system. */",
        '#define TOKEN "@TOKEN@"',
        f"#define FINGERPRINT UINT64_C(0x{hashlib.sha256(layout).hexdigest()[:16]})",
        f"#define START_ALGORITHM {ALGORITHMS[algorithm.name]}",
        f"#define START_DEGREE {algorithm.degree}",
        f"#define MAX_DEGREE {MAX_DEGREE}",
        f"#define START_STEP {float(system.step)!r}",
        f"#define MIN_STEP {system.step / LEAST!r}",
        f"#define ALL_RESTORE {int(all(part.slave.can_restore for part in components))}",
        f"#define ALL_SERIALIZE {int(all(part.slave.can_serialize for part in components))}",
        f"#define ALL_DERIVE {int(variables.derivable)}",
        f"#define EVERY_LENGTH {int(all(part.model.can('canHandleVariableCommunicationStepSize') for part in components))}",
    ]
    sequence = network.sequence(algorithm.sequence) if isinstance(algorithm, GaussSeidel) else network.order
    lines += _functions(components)
    lines += _array("ComponentData", "COMPONENTS", _components(components))
    lines += _array("Wire", "WIRES", _wires(network, components))
    lines += _array("uint32_t", "Y_REFERENCES", [_reference(part, y.name) for part in components for y in part.slave.outputs])
    lines += _array("char *const", "Y_NAMES", [_text(name) for name in network.names])
    lines += _array("int64_t", "ORDER", map(str, network.order))
    lines += _array("int64_t", "SEQUENCE", map(str, sequence))
    lines += _array("int64_t", "EXCHANGE", map(str, network.initial_exchange))
    lines += _array("int64_t", "STOPS", [str(network.place(stop.signal)) for stop in system.stop_when])
    lines += _array("double", "ABOVE", [repr(float(stop.above)) for stop in system.stop_when])
    lines += _array("char *const", "STOP_SAYS", [_text(stop.says) for stop in system.stop_when])
    lines += _array("External", "EXTERNALS", _external(network, components, variables))
    lines += _array("Given", "GIVEN", _given(components))
    lines += _array("Place", "WIDE", _wide(components))
    lines += _array("uint32_t", "ASKED", [reference for part in components for reference in _asked(part)])
    lines += _array("Variable", "VARIABLES", _variables(variables))
    return "\n".join(lines) + "\n"


def _functions(components: Sequence[Packed]) -> list[str]:
    """The functions of the linked FMUs, once for each."""
    versions = {part.model.version for part in components if not part.linked}
    most = max((len(part.connected) for part in components), default=0)
    lines = [
        f"#define CARRIES_3 {int('3' in versions)}",
        f"#define MOST_WIRES {most}",
        *(["#define CARRIES"] if versions else []),
    ]
    for prefix in dict.fromkeys(prefixes(components).values()):
        lines.append(f"FUNCTIONS_2(DECLARATION_2, {prefix})")
        lines.append(f"static const Functions2 {prefix}functions = {{FUNCTIONS_2(ADDRESS_2, {prefix})}};")
    return lines


def prefixes(components: Sequence[Packed]) -> dict[str, str]:
    """Prefix of the functions of each linked FMU.

    Parameters
    ----------
    components : sequence of Packed
        Of the system.

    Returns
    -------
    dict of str to str
        By location of the FMU.
    """
    linked = dict.fromkeys(part.location for part in components if part.linked)
    return {location: PREFIX.format(k) for k, location in enumerate(linked)}


def _components(components: Sequence[Packed]) -> list[str]:
    rows, codes, first_wire, first_y, first_asked = [], prefixes(components), 0, 0, 0
    places = carried(components)
    for i, part in enumerate(components):
        n_u, n_y = len(part.connected), len(part.slave.outputs)
        code = f"&{codes[part.location]}functions" if part.linked else "NULL"
        folder = "NULL" if part.linked else _text(places[i])
        every_length, n_asked = int(part.model.can("canHandleVariableCommunicationStepSize")), len(_asked(part))
        library = _text(part.model.interfaces["CoSimulation"]["modelIdentifier"])
        rows.append(
            f"{_text(part.name)}, {_text(part.model.token)}, {part.model.version}, {code}, {folder}, {library}, {n_u}, {n_y}, "
            f"{first_wire}, {first_y}, {part.slave.input_degree}, {int(part.feeds_through)}, {int(part.slave.can_restore)}, "
            f"{every_length}, {int(part.slave.counts_events)}, {n_asked}, {first_asked}"
        )
        first_wire, first_y, first_asked = first_wire + n_u, first_y + n_y, first_asked + n_asked
    return rows


def carried(components: Sequence[Packed]) -> dict[int, str]:
    """Where each carried FMU lies below resources/; those of one file share a place unless they refuse a second instance.

    Parameters
    ----------
    components : sequence of Packed
        Of the system.

    Returns
    -------
    dict of int to str
        By place among the components.
    """
    first: dict[str, int] = {}
    places = {}
    for i, part in enumerate(components):
        if not part.linked:
            alone = part.model.can("canBeInstantiatedOnlyOncePerProcess")
            places[i] = f"fmus/{i if alone else first.setdefault(part.location, i)}"
    return places


def _asked(part: Packed) -> list[str]:
    """References of the inputs that a carried FMU of FMI 3.0 asks for within a step."""
    return [str(row.reference) for row in asked_for(part.model)] if part.model.version == "3" else []


def _wide(components: Sequence[Packed]) -> list[str]:
    """Enumerations of FMI 3.0, which have 64 bits."""
    return [
        f"{i}, {row.reference}"
        for i, part in enumerate(components)
        for row in part.model.rows
        if part.model.version == "3" and row.type == "Enumeration"
    ]


def _wires(network: Network, components: Sequence[Packed]) -> list[str]:
    return [
        f"{_reference(part, part.slave.inputs[place].name)}, {source}, {factor!r}, {offset!r}"
        for i, part in enumerate(components)
        for source, place, factor, offset in network.wires(i)
    ]


def _external(network: Network, components: Sequence[Packed], variables: Variables) -> list[str]:
    return [
        f"{i}, {_reference(components[i], components[i].slave.inputs[j].name)}, {float(network.start_inputs(i)[j])!r}"
        for i, j in variables.external
    ]


def _given(components: Sequence[Packed]) -> list[str]:
    rows = []
    for i, part in enumerate(components):
        for row, value in part.given:
            number = f"0.0, {_text(value)}" if isinstance(value, str) else f"{float(value)!r}, NULL"
            rows.append(f"{i}, {_C_TYPES[TYPES[row.type]]}, {row.reference}, {number}")
    return rows


def _variables(variables: Variables) -> list[str]:
    rows = []
    for v in variables.all:
        often = v.kind == "input" or v.variability == "tunable"
        settable = "0" if v.start is None else _BETWEEN_STEPS if often else _AT_START
        of = f"{v.kind.upper()}, {_C_TYPES[v.type]}, {v.component}, {v.reference}, {v.index}"
        rows.append(f"{of}, {settable}, {_text(v.name)}")
    return rows


def _reference(part: Packed, name: str) -> str:
    row: Row = next(row for row in part.model.rows if row.name == name)
    return str(row.reference)


def _array(kind: str, name: str, rows: Iterable[str]) -> list[str]:
    """A table and N_..., its length; C has none of length 0."""
    rows = list(rows)
    elements = [row if kind in _PLAIN else f"{{{row}}}" for row in rows or ["0"]]
    return [f"#define N_{name} {len(rows)}", f"static const {kind} {name}[] = {{", *(f"    {e}," for e in elements), "};"]


def _text(value: str) -> str:
    """A C string."""
    plain = "".join(chr(b) if 32 <= b < 127 and chr(b) not in '"\\?' else f"\\{b:03o}" for b in value.encode())
    return f'"{plain}"'


def _plain(name: str) -> str:
    return "".join(c if c.isalnum() or c in " -_." else "_" for c in name)
