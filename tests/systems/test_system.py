"""Systems: what is wired wrongly is refused with one line that names it; .ssd files say the same as Python."""

from dataclasses import replace
from itertools import pairwise
from pathlib import Path

import numpy as np
import oscillators
import pytest

from gyro_cosim import Connection, PowerBond, System, SystemComponent, WiringError, simulate, ssp, system
from gyro_cosim.master import open_network
from gyro_cosim.systems import Exchange, catalogue

GAIN = f"{oscillators.HERE}:crossed"


def wired(*connections: Connection, sources: tuple[str, ...] = (GAIN, GAIN), bonds: tuple[PowerBond, ...] = ()) -> System:
    """Components a, b, ... with the given connections."""
    return System("s", tuple(SystemComponent(n, s) for n, s in zip("abcdef", sources, strict=False)), connections, bonds)


@pytest.mark.parametrize(
    ("make", "words"),
    [
        (lambda: wired(Connection(("a", "y"), ("x", "u"))), "names component 'x'"),
        (
            lambda: wired(Connection(("a", "y"), ("b", "u")), Connection(("b", "y"), ("b", "u"))),
            r"b\.u must have one source, has two",
        ),
        (lambda: System("s", (SystemComponent("a", GAIN), SystemComponent("a", GAIN)), ()), "'a' twice"),
        (lambda: wired(Connection(("a", "z"), ("b", "u"))), "unknown output of 'a': 'z'"),
        (lambda: wired(Connection(("a", "y"), ("b", "z"))), "unknown input of 'b': 'z'"),
        (
            lambda: wired(Connection(("a", "y"), ("b", "force")), sources=(GAIN, f"{oscillators.HERE}:left")),
            r"units must fit: a\.y is in '1', b\.force in 'N'",
        ),
        (lambda: wired(bonds=(PowerBond(("a", "nothing"), ("b", "y")),)), r"unknown signal of a power bond: 'a\.nothing'"),
        (lambda: wired(bonds=(PowerBond(("a", "y"), ("b", "y")),)), r"motion a\.y must be connected to 'b'"),
    ],
)
def test_wrong_wiring_is_refused(make: object, words: str) -> None:
    with pytest.raises(ValueError, match=words):
        open_network(make(), in_process=True)  # type: ignore[operator]


def test_chain_with_feedthrough_is_evaluated_from_source_to_end() -> None:
    """Five gains in a chain listed backwards: one pass of outputs must still carry the value through."""
    names = "abcde"
    parts = tuple(SystemComponent(n, GAIN, {"gain": 2.0} | ({"u": 1.5} if n == "a" else {})) for n in reversed(names))
    chain = System("s", parts, tuple(Connection((a, "y"), (b, "u")) for a, b in pairwise(names)))
    assert simulate(chain, step=0.5, stop=1.0, in_process=True).trajectory["e.y"] == pytest.approx(1.5 * 2**5)


def test_values_and_variants_address_one_component_or_all_of_one_beginning() -> None:
    two = System("s", (SystemComponent("gyro_front", "gyro_unit:linear"), SystemComponent("gyro_rear", "gyro_unit:linear")), ())
    changed = two.with_value("gyro.rotor_speed", "2000rpm").with_source("gyro_rear", "nonlinear")
    assert [p.source for p in changed.components] == ["gyro_unit:linear", "gyro_unit:nonlinear"]
    assert all(p.values["rotor_speed"] == "2000rpm" for p in changed.components)
    with pytest.raises(ValueError, match="unknown component of system 's': 'vehicle'"):
        two.with_value("vehicle.speed", 1.0)


def test_a_system_says_what_is_exchanged_in_it_and_in_which_size() -> None:
    curve = system("lrt-curve")
    assert (curve.exchange, curve.exchanged()) == (Exchange("gyro", "_full"), "gyro")
    sources = {name: [c.source for c in curve.with_source(name, "off").components] for name in ("gyro", "gyro_rear")}
    assert sources["gyro"] == ["vehicle:lrt", "gyro_unit:off_full", "gyro_unit:off_full"]
    assert sources["gyro_rear"] == ["vehicle:lrt", "gyro_unit:nonlinear_full", "gyro_unit:off_full"]
    assert curve.with_source("gyro", "gyro_unit:off").components[1].source == "gyro_unit:off"
    assert curve.with_source("vehicle", "lrt_rough").components[0].source == "vehicle:lrt_rough"
    silent = replace(curve, exchange=None)  # no rule about endings beside the one that the system states
    assert silent.with_source("gyro", "off").components[1].source == "gyro_unit:off"
    assert silent.exchanged("gyro") == "gyro"
    with pytest.raises(ValueError, match=r"^system 'lrt-curve' does not say which component is exchanged: name one"):
        silent.exchanged()
    for wrong in (lambda: curve.exchanged("gear"), lambda: replace(curve, exchange=Exchange("gear"))):
        with pytest.raises(ValueError, match="unknown component of system 'lrt-curve': 'gear'"):
            wrong()


@pytest.mark.parametrize("name", list(catalogue.systems()))
def test_every_built_in_system_names_what_is_exchanged(name: str) -> None:
    """Those without a gyro unit have nothing to exchange."""
    known = None if "-bare" in name else Exchange("gyro", "" if name == "wheel-pair" else "_full")
    assert system(name).exchange == known


def test_power_bonds_are_found_from_units_where_the_system_states_none() -> None:
    pair = oscillators.pair()
    bare = System(pair.name, pair.components, (pair.connections[1], pair.connections[2]))
    with open_network(bare, in_process=True) as network:
        assert [b.name for b in network.bonds] == ["left.velocity x right.force"]


@pytest.mark.parametrize("name", list(catalogue.systems()))
def test_every_built_in_system_states_units_that_its_components_have(name: str) -> None:
    """The connectors written in the .ssd file agree with the tables of the components that stand behind it."""
    from lxml import etree

    root = etree.parse(str(catalogue.systems()[name])).getroot()
    plan = system(name)
    for element, part in zip(root.iterfind(".//ssd:Component", ssp.NAMESPACES), plan.components, strict=True):
        rows = {v.name: v for v in catalogue.component(part.source).variables}
        for connector in element.iterfind(".//ssd:Connector", ssp.NAMESPACES):
            (real,) = connector
            assert rows[connector.get("name")].causality == connector.get("kind")
            assert rows[connector.get("name")].unit == real.get("unit")


def test_units_are_converted_on_the_way(tmp_path: Path) -> None:
    """A foreign slave that speaks rpm drives one that listens in rad/s."""
    from gyro_cosim.network import Network
    from gyro_cosim.slaves.in_process import ComponentSlave

    source = ComponentSlave("a", oscillators.crossed())
    source.description = replace(source.description, outputs=(replace(source.outputs[0], unit="rpm"),))
    target = ComponentSlave("gyro", catalogue.component("gyro_unit:linear"))
    plan = System("s", (SystemComponent("a", GAIN, {"u": 60.0}), SystemComponent("gyro", "gyro_unit:linear")),
                  (Connection(("a", "y"), ("gyro", "yaw_rate")),))  # fmt: skip
    network = Network(plan, [source, target])
    Y = network.initialize(0.0, 1.0)
    C = np.vstack([Y, np.zeros((2, Y.size))])
    assert network.inputs(1, C)[0, 0] == pytest.approx(2 * np.pi)


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("<a", "must be well-formed XML"),
        ("<a/>", "must hold an SSP SystemStructureDescription"),
        ("<!DOCTYPE x [<!ENTITY e SYSTEM 'file:///etc/passwd'>]><x>&e;</x>", "must have no document type"),
        (f"<s:SystemStructureDescription xmlns:s='{ssp.NAMESPACES['ssd']}'/>", "must hold a System"),
    ],
)
def test_system_files_that_cannot_be_used_are_refused(tmp_path: Path, text: str, words: str) -> None:
    file = tmp_path / "bad.ssd"
    file.write_text(text)
    with pytest.raises(ValueError, match=words):
        system(str(file))


def test_an_ssd_file_elsewhere_finds_components_by_their_fmu_names(tmp_path: Path) -> None:
    file = tmp_path / "mine.ssd"
    file.write_text(catalogue.systems()["wheel-pair"].read_text())
    assert system(str(file)) == system("wheel-pair")


def test_wiring_error_is_wrong_use() -> None:
    assert issubclass(WiringError, ValueError)


def test_a_vehicle_file_is_a_system_of_its_own(tmp_path: Path) -> None:
    file = tmp_path / "coach.toml"
    file.write_text('[vehicle]\nname = "coach"\n', encoding="utf-8")
    alone = system(str(file))
    assert [(c.name, c.source) for c in alone.components] == [("vehicle", str(file))]
    assert (alone.name, alone.step) == ("coach", 1e-3)
