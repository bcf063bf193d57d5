"""A system as a short TOML file, to be written by hand.

    name = "pair"
    step = "1 ms"
    stop = "60 s"
    connections = [
        "vehicle.yaw_rate -> gyro.yaw_rate",
        { from = "gyro.yaw_moment", to = "vehicle.yaw_moment", factor = 1.0, offset = 0.0 },
    ]

    [components.vehicle]
    source = "vehicle:wheel_pair"               # as `cosim list` has it, or an .fmu or .py file beside this one
    parameters = { speed = "36 km/h" }

    [components.gyro]
    source = "gyro.fmu"

    [[stop_when]]
    signal = "vehicle.lateral_displacement"
    above = 0.005
    says = "the flange touches"

`start`, `description`, `[[bonds]]` with `motion` and `effort`, and `[exchange]` with `component` and `ending` may stand there,
too. `cosim pack` makes an .ssp file of it.
"""

from collections.abc import Iterable
from pathlib import Path
from typing import Any

from ..errors import unknown
from ..systems import Connection, Conversion, Exchange, PowerBond, StopWhen, System, SystemComponent
from ..systems.scenario import read_toml, seconds

KEYS = ("name", "description", "step", "start", "stop", "components", "connections", "stop_when", "bonds", "exchange")
_SCALARS = str | int | float | bool


def read_system(file: str | Path) -> System:
    """The system in a TOML file; ValueError or WiringError names file, table, key and rule."""
    file = Path(file)
    where = f"system file {str(file)!r}"
    document = read_toml(file, where)
    _check_keys(document, KEYS, where)
    components = tuple(
        _component(name, table, file.parent, f"{where}: component {name!r}")
        for name, table in _table(document, "components", where).items()
    )
    if not components:
        raise ValueError(f"{where} must hold a table [components.NAME] at least")
    names = [component.name for component in components]
    wires = tuple(_connection(given, names, where) for given in _list(document, "connections", where))
    bonds = [_checked(t, ("motion", "effort"), (), f"{where}: bonds") for t in _list(document, "bonds", where)]
    stops = [_checked(t, ("signal",), ("above", "says"), f"{where}: stop_when") for t in _list(document, "stop_when", where)]
    exchange = None
    if "exchange" in document:
        table = _checked(document["exchange"], ("component",), ("ending",), f"{where}: exchange")
        exchange = Exchange(table["component"], table.get("ending", ""))
    start = seconds(document.get("start", 0.0), where, "start")
    try:
        return System(
            name=_text(document.get("name", file.stem), f"{where}: name"),
            components=components,
            connections=wires,
            bonds=tuple(PowerBond(_split(t["motion"], names, where), _split(t["effort"], names, where)) for t in bonds),
            step=seconds(document.get("step", 1e-3), where, "step"),
            start=start,
            stop=seconds(document.get("stop", start + 1.0), where, "stop"),
            stop_when=tuple(_stop(t, names, where) for t in stops),
            exchange=exchange,
            description=_text(document.get("description", ""), f"{where}: description"),
        )
    except ValueError as error:
        raise type(error)(str(error) if str(error).startswith(where) else f"{where}: {error}") from None


def _check_keys(table: dict[str, Any], known: Iterable[str], where: str) -> None:
    for key in table:
        if key not in known:
            raise ValueError(f"{where}: {unknown('key', key, known)}")


def _table(document: dict[str, Any], key: str, where: str) -> dict[str, Any]:
    table = document.get(key, {})
    if not isinstance(table, dict):
        raise ValueError(f"{where}: {key} must be a table, got {table!r}")
    return table


def _list(document: dict[str, Any], key: str, where: str) -> list[Any]:
    found = document.get(key, [])
    if not isinstance(found, list):
        raise ValueError(f"{where}: {key} must be a list, got {found!r}")
    return found


def _text(given: Any, where: str) -> str:
    if not isinstance(given, str):
        raise ValueError(f"{where} must be text, got {given!r}")
    return given


def _checked(given: Any, needed: tuple[str, ...], more: tuple[str, ...], where: str) -> dict[str, Any]:
    """A table that has the keys needed, and no others than `more`."""
    if not isinstance(given, dict):
        raise ValueError(f"{where} must be a table, got {given!r}")
    _check_keys(given, (*needed, *more), where)
    for key in needed:
        if not isinstance(given.get(key), str):
            raise ValueError(f"{where} must say `{key}`, as text, got {given.get(key)!r}")
    return given


def _component(name: str, given: Any, folder: Path, where: str) -> SystemComponent:
    table = _checked(given, ("source",), ("parameters", "implementation"), where)
    source = table["source"]
    if source.partition("#")[0].endswith((".fmu", ".ssp", ".py", ".toml")) or ".py:" in source:
        source = str(folder / source)
    values = {}
    for key, value in _table(table, "parameters", where).items():
        several = value if isinstance(value, list) else [value]
        if not all(isinstance(one, _SCALARS) for one in several):
            raise ValueError(
                f"{where}: parameter {key!r} must be a number, text, true or false, or a list of them, got {value!r}"
            )
        values[key] = tuple(map(_told, value)) if isinstance(value, list) else _told(value)
    return SystemComponent(
        name, source, values, implementation=_text(table.get("implementation", ""), f"{where}: implementation")
    )


def _told(value: Any) -> Any:
    return str(value).lower() if isinstance(value, bool) else value


def _connection(given: Any, names: list[str], where: str) -> Connection:
    if isinstance(given, str):
        start, arrow, end = (word.strip() for word in given.partition("->"))
        if not (start and arrow and end):
            raise ValueError(f"{where}: a connection must be 'COMPONENT.OUTPUT -> COMPONENT.INPUT', got {given!r}")
        return Connection(_split(start, names, where), _split(end, names, where))
    table = _checked(given, ("from", "to"), ("factor", "offset"), f"{where}: a connection")
    for key in ("factor", "offset"):
        if isinstance(table.get(key, 0.0), bool) or not isinstance(table.get(key, 0.0), int | float):
            raise ValueError(f"{where}: {key} of {table['from']} -> {table['to']} must be a number, got {table[key]!r}")
    hop = Conversion(factor=float(table.get("factor", 1.0)), offset=float(table.get("offset", 0.0)))
    ends = _split(table["from"], names, where), _split(table["to"], names, where)
    return Connection(*ends, () if hop == Conversion() else (hop,))


def _split(signal: str, names: list[str], where: str) -> tuple[str, str]:
    owner = max((name for name in names if signal.startswith(f"{name}.")), key=len, default="")
    if not owner:
        first = signal.partition(".")[0]
        raise ValueError(f"{where}: {unknown('component', first, names)} (in {signal!r}, which must be COMPONENT.VARIABLE)")
    return owner, signal[len(owner) + 1 :]


def _stop(table: dict[str, Any], names: list[str], where: str) -> StopWhen:
    above = table.get("above", 0.5)
    if isinstance(above, bool) or not isinstance(above, int | float) or above != above:
        raise ValueError(f"{where}: above of stop_when {table['signal']} must be a number, got {above!r}")
    return StopWhen(_split(table["signal"], names, where), float(above), _text(table.get("says", table["signal"]), where))
