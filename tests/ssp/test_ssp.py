"""System files: what an .ssp or .ssd says is what runs; what it says wrongly is refused with file, element and rule."""

import zipfile
from collections.abc import Callable
from pathlib import Path
from typing import Any

import oscillators
import pytest
from ssp_files import HEAD, TAIL, UNITS, Ssp, bound, component, connection, connections, connector, elements, ssd, value, write

from gyro_cosim import Connection, Jacobi, System, SystemComponent, WiringError, simulate, system
from gyro_cosim.master import open_network
from gyro_cosim.ssp.packing import pack
from gyro_cosim.systems import Exchange


@pytest.fixture
def ssp(tmp_path: Path) -> Ssp:
    """Writes x.ssp with the given System content, the FMUs mixed and arrays, and more members; reads it."""
    return lambda inside, **members: system(str(write(tmp_path, inside, **members)))


def end(plan: System) -> dict[str, float]:
    """The last values of a run in which every input is held, so that numbers stay simple."""
    return simulate(plan, step=0.01, algorithm=Jacobi(0)).trajectory.end()


TWO = elements(component("a", "output y Real", "output count Integer"), component("b", "input u Real", "input add Integer"))
# Two systems that only pass on what the other passes on; the value given to one must not go round for ever.
CIRCLE = (
    bound(value("p.in", 1))
    + elements(
        *(
            f'<ssd:System name="{name}"><ssd:Connectors>{connector("input in")}{connector("output out")}</ssd:Connectors>'
            + connections_of
            + "</ssd:System>"
            for name, connections_of in dict.fromkeys(
                "pq", f"<ssd:Connections>{connection('in', 'out')}</ssd:Connections>"
            ).items()
        ),
        component("b", "input u"),
    )
    + f"<ssd:Connections>{connection('p.out', 'q.in')}{connection('q.out', 'p.in')}{connection('p.out', 'b.u')}</ssd:Connections>"
)
START = bound(value("a.u", 3) + value("a.gain", 1))


def test_units_of_the_fmus_are_converted_and_transformations_act_on_the_target_s_unit(ssp: Ssp) -> None:
    """a.y = 3 furlongs at b.u, which counts furlongs too; b's own gain is 2."""
    wire = connection("a.y", "b.u", '<ssc:LinearTransformation factor="10" offset="1"/>')
    assert end(ssp(START + TWO + connections(wire)))["b.y"] == pytest.approx(2 * (10 * 3 + 1))


def test_connectors_may_state_units_that_only_the_file_defines(ssp: Ssp) -> None:
    """The system's connector counts ells of half a metre: 3 furlongs are 1207.008 ells, plus 100 of them."""
    inner = (
        '<ssd:System name="sub"><ssd:Connectors>' + connector("input way Real ell") + "</ssd:Connectors>"
        + elements(component("b", "input u")) + connections(connection("way", "b.u")) + "</ssd:System>"
    )  # fmt: skip
    wire = connection("a.y", "sub.way", '<ssc:LinearTransformation factor="1" offset="100"/>')
    plan = ssp(START + elements(component("a", "output y"), inner) + connections(wire))
    assert [p.name for p in plan.components] == ["a", "sub/b"]
    assert end(plan)["sub/b.y"] == pytest.approx(2 * (3 + 100 * 0.5 / 201.168))


def test_suppressed_unit_conversion_passes_the_number_on(ssp: Ssp) -> None:
    """a.y in furlongs goes into the array's metres as a bare number, or converted."""
    parts = elements(component("a", "output y"), component("c", "input u[1]", source="resources/arrays.fmu"))
    plain, bare = (connections(connection("a.y", "c.u[1]", more=more)) for more in ("", 'suppressUnitConversion="true"'))
    assert end(ssp(START + parts + plain))["c.y[1]"] == pytest.approx(3 * 201.168)
    assert end(ssp(START + parts + bare))["c.y[1]"] == pytest.approx(3)


def test_nested_systems_are_flattened_through_connectors_on_every_level(ssp: Ssp) -> None:
    """a.count goes in through two systems, b.count comes out through one."""
    inner = (
        '<ssd:System name="in"><ssd:Connectors>' + connector("input n") + connector("output m") + "</ssd:Connectors>"
        + elements(component("b", "input add", "output count"))
        + connections(connection("n", "b.add"), connection("b.count", "m")) + "</ssd:System>"
    )  # fmt: skip
    outer = (
        '<ssd:System name="out"><ssd:Connectors>' + connector("input n") + connector("output m") + "</ssd:Connectors>"
        + elements(inner) + connections(connection("in.n", "n"), connection("m", "in.m")) + "</ssd:System>"  # either direction
    )  # fmt: skip
    parts = elements(component("a", "output count"), outer, component("c", "input add"))
    plan = ssp(parts + connections(connection("a.count", "out.n"), connection("out.m", "c.add")))
    assert {(c.start, c.end) for c in plan.connections} == {
        (("out/in/b", "count"), ("c", "add")), (("a", "count"), ("out/in/b", "add")),
    }  # fmt: skip
    found = end(plan)
    assert found["a.count"] == 10
    assert found["out/in/b.count"] == 10 + sum(range(10))  # held: one step behind


def test_transformations_on_several_levels_act_in_the_order_of_the_way(ssp: Ssp) -> None:
    inner = (
        '<ssd:System name="sub"><ssd:Connectors>' + connector("input way") + "</ssd:Connectors>"
        + elements(component("b", "input u"))
        + connections(connection("way", "b.u", '<ssc:LinearTransformation factor="2" offset="3"/>')) + "</ssd:System>"
    )  # fmt: skip
    wire = connection("a.y", "sub.way", '<ssc:LinearTransformation factor="10" offset="1"/>')
    plan = ssp(START + elements(component("a", "output y"), inner) + connections(wire))
    assert end(plan)["sub/b.y"] == pytest.approx(2 * (2 * (10 * 3 + 1) + 3))


def test_mapping_tables_turn_numbers_into_numbers(ssp: Ssp) -> None:
    table = "".join(f'<ssc:MapEntry source="{k}" target="{10 * k}"/>' for k in range(11))
    wire = connection("a.count", "b.add", f"<ssc:IntegerMappingTransformation>{table}</ssc:IntegerMappingTransformation>")
    assert end(ssp(TWO + connections(wire)))["b.count"] == 10 + 10 * sum(range(10))
    not_ = '<ssc:MapEntry source="true" target="false"/><ssc:MapEntry source="false" target="true"/>'
    parts = elements(component("a", "output on_out"), component("b", "input on"))
    wire = connection("a.on_out", "b.on", f"<ssc:BooleanMappingTransformation>{not_}</ssc:BooleanMappingTransformation>")
    found = end(ssp(parts + connections(wire)))
    assert (found["a.on_out"], found["b.on_out"]) == (1, 0)


def test_parameters_of_every_type_come_from_files_with_prefix_and_mapping(ssp: Ssp) -> None:
    """Units by name and as the set defines them; names that are not there are ignored; later and higher ones win."""
    ssv = (
        '<ssv:ParameterSet version="1.0" name="p" xmlns:ssv="http://ssp-standard.org/SSP1/SystemStructureParameterValues" '
        'xmlns:ssc="http://ssp-standard.org/SSP1/SystemStructureCommon"><ssv:Parameters>'
        + value("length", 804.672, unit="yardish") + value("kind", "fast", "Enumeration") + value("go", "false", "Boolean")
        + value("more", 7, "Integer") + value("words", "so so", "String") + value("unheard_of", 1)
        + '</ssv:Parameters><ssv:Units><ssc:Unit name="yardish"><ssc:BaseUnit m="1" factor="0.5"/></ssc:Unit></ssv:Units>'
        "</ssv:ParameterSet>"
    )  # fmt: skip
    targets = {"length": "u", "kind": "mode", "go": "on", "more": "add", "words": "text", "unheard_of": "nothing"}
    linear = '<ssc:LinearTransformation factor="2" offset="1"/>'
    entries = "".join(
        f'<ssm:MappingEntry source="a.{s}" target="a.{t}">{linear if s == "length" else ""}</ssm:MappingEntry>'
        for s, t in targets.items()
    )
    mapping = f'<ssd:ParameterMapping><ssm:ParameterMapping version="1.0">{entries}</ssm:ParameterMapping></ssd:ParameterMapping>'
    binding = bound("", prefix="a.", mapping=mapping, source="resources/p.ssv")
    own = bound(value("gain", 5) + value("u", 77) + value("add", 99, "Integer"))  # the system's u and add win over these
    plan = ssp(binding + elements(component("a", "output y", more=own)), resources__p_dot_ssv=ssv)
    found = end(plan)
    assert found["a.y"] == pytest.approx(5 * (2 * 2 + 1))  # 804.672 half metres are 2 furlongs
    assert (found["a.mode_out"], found["a.on_out"], found["a.count"]) == (5, 0, 0)
    with open_network(plan) as network:
        assert network.values[0]["text"] == "so so"
        assert network.values[0]["add"] == 7


def test_arrays_strings_and_bytes_of_fmi_3_take_values(ssp: Ssp) -> None:
    values = value("u", "1 2 3", "Float64") + value("gain", "4 5 6", "Float64") + value("blob", "00 01 02", "Binary")
    values += value("huge", 2**40, "UInt64") + value("single", 0.25, "Float32") + value("tiny", -3, "Int8")
    plan = ssp(
        elements(component("c", source="resources/arrays.fmu", more=bound(values))).replace(
            "<ssd:Connectors></ssd:Connectors>", ""
        )
    )
    found = end(plan)
    assert [found[f"c.y[{i}]"] for i in (1, 2, 3)] == [4, 10, 18]
    assert (found["c.huge_out"], found["c.single_out"], found["c.tiny_out"], found["c.length"]) == (2**40, 0.25, -3, 3)


def test_ssp_2_writes_arrays_of_text_element_by_element(ssp: Ssp) -> None:
    label = (
        '<ssv:Parameter name="label"><ssv:String><ssv:Value value="three"/><ssv:Value value="x y"/></ssv:String></ssv:Parameter>'
    )
    own = bound(label + value("u", "1 2 3", "Float64"))
    plan = ssp(ssd(elements(component("c", source="resources/arrays.fmu", more=own))).replace('version="1.0"', 'version="2.0"'))
    found = end(plan)
    assert found["c.length"] == len("three") + len("x y")
    assert found["c.total"] == 6


def test_values_given_to_a_system_s_connector_reach_the_components_behind_it(ssp: Ssp) -> None:
    inner = (
        '<ssd:System name="sub"><ssd:Connectors>' + connector("input size Real ell") + "</ssd:Connectors>"
        + elements(component("a", "input u"), component("b", "input u"))
        + connections(connection("size", "a.u"), connection("size", "b.u", '<ssc:LinearTransformation factor="3"/>'))
        + "</ssd:System>"
    )  # fmt: skip
    plan = ssp(bound(value("sub.size", 402.336)) + elements(inner))
    found = end(plan)  # 402.336 ells are 1 furlong
    assert (found["sub/a.y"], found["sub/b.y"]) == (pytest.approx(2), pytest.approx(6))


def test_a_system_may_hold_other_system_files_and_itself_once_more_by_id(ssp: Ssp, tmp_path: Path) -> None:
    twin = '<ssd:System name="one" id="part">' + elements(component("a")) + "</ssd:System>"
    again = '<ssd:Component name="two" source="#part" type="application/x-ssp-definition"/>'
    other = (
        '<ssd:Component name="three" source="resources/sub.ssd" type="application/x-ssp-definition">'
        + bound(value("m.gain", 4))
        + "</ssd:Component>"
    )
    below = ssd(elements(component("m", source="arrays.fmu"))).replace("arrays.fmu", "mixed.fmu")
    plan = ssp(elements(twin, again, other), resources__sub_dot_ssd=below)
    assert [p.name for p in plan.components] == ["one/a", "two/a", "three/m"]
    assert plan.components[2].bound == {"gain": 4}
    inside = (tmp_path / "x.ssp").read_bytes()
    nested = '<ssd:Component name="deep" source="resources/in.ssp" type="application/x-ssp-package"/>'
    plan = ssp(elements(nested), resources__in_dot_ssp=inside)
    assert plan.components[0].name == "deep/one/a"
    assert plan.components[0].source.endswith("x.ssp#resources/in.ssp#resources/mixed.fmu")
    assert end(plan)["deep/two/a.count"] == 10


@pytest.mark.parametrize(
    ("inside", "words"),
    [
        (elements(component("a", source="resources/none.fmu")), r"line 1: Component 'a': FMU .*none\.fmu' must exist"),
        (elements(component("a", source="../up.fmu")), "Component 'a': source must lie inside the archive"),
        (elements(component("a", source="/etc/x.fmu")), "source must be a relative path, got '/etc/x.fmu'"),
        (elements(component("a", source="file:///etc/x.fmu")), "source must be a relative path"),
        (elements(component("a").replace("source=", "type='text/plain' source=")), "Component 'a': type must be application"),
        (elements(component("a").replace("source=", "implementation='ScheduledExecution' source=")),
         "implementation must not be ScheduledExecution"),
        (elements(component("a"), component("a")), "Component 'a': element names must differ"),
        (elements("<ssd:SignalDictionaryReference name='d' dictionary='x'/>"), "unknown signal dictionary 'x'"),
        (elements(component("a", "input u", "input u")), "Connector 'u': connector names must differ"),
        (elements(component("a", "bothways u")), "Connector 'u': kind must be one of input, output"),
        (elements(component("a", "inout u"), component("b", "output y")) + connections(connection("b.y", "a.u")),
         "connector 'u' of component 'a' must be one of input, .* to be connected, is inout"),
        (elements(component("a", "output y Real parsec"), component("b", "input u Real ell"))
         + connections(connection("a.y", "b.u")),
         "unit 'parsec' must be defined in the Units of the file to go from 'parsec' to 'ell'"),
        (TWO + connections(connection("a.y", "z.u")), "the system must have an element 'z', has none"),
        (TWO + connections(connection("a.nothing", "b.u")), "component 'a' must have a connector 'nothing', has none"),
        (TWO + connections(connection("a.y", "a.count")), r"a\.y and a\.count both give a value"),
        (TWO + connections(connection("a.y", "b.u"), connection("a.y", "b.u")),
         r"input b\.u must have one source, has two: a\.y and a\.y"),
        (TWO + connections(connection("a.y", "b.u", '<ssc:LinearTransformation factor="x"/>')),
         "factor must be a number, got 'x'"),
        (TWO + connections("<ssd:Connection startElement='a'/>"), "Connection: must have the attribute 'startConnector'"),
        (CIRCLE, r"a chain of connectors must begin at a component, that of b\.u runs in a circle"),
        (bound("", source="resources/p.ssv") + TWO, r"ParameterBinding .*: file .*p\.ssv' must exist"),
        (bound(value("a.u", "much")) + TWO, "Parameter 'a.u': value must be a number, got 'much'"),
        (ssd(TWO).replace('version="1.0" name="test"', 'version="3.0" name="test"'), "must be of SSP 1.0 or 2.0, got '3.0'"),
        (ssd(TWO).replace('startTime="0"', 'startTime="2"'), "stopTime must be after startTime, got 0.1 and 2"),
        (ssd(TWO)[:-9], "must be well-formed XML"),
    ],
)  # fmt: skip
def test_files_that_are_wrong_are_refused_with_file_element_and_rule(ssp: Ssp, inside: str, words: str) -> None:
    with pytest.raises(ValueError, match=words) as caught:
        ssp(inside)
    assert "x.ssp" in str(caught.value)
    assert "\n" not in str(caught.value)


@pytest.mark.parametrize(
    ("inside", "words"),
    [
        (bound(value("a.u", 1, unit="parsec")) + TWO,
         "a.u: unit 'parsec' is defined nowhere and cannot be expressed in 'furlong'"),
        (elements(component("a", "output u")), r"connector a\.u must be an input as in the FMU, the system file says output"),
        (elements(component("a", "input nothing")), r"unknown input of 'a' \(.*x\.ssp#resources/mixed\.fmu\): 'nothing'"),
        (elements(component("a", "output y Integer")), r"connector a\.y must be a real as in the FMU, .* says Integer"),
        (elements(component("a", "output y Real pound")), r"connector a\.y must have a unit that fits 'furlong', .* 'pound'"),
        (elements(component("a", "output y"), component("b", "input add")) + connections(connection("a.y", "b.add")),
         r"types must fit: a\.y is a real, b\.add an integer"),
        (elements(component("a", "output mode_out"), component("b", "input on")) + connections(connection("a.mode_out", "b.on")),
         r"types must fit: a\.mode_out is an enumeration, b\.on a boolean"),
        (elements(component("a", "output count"), component("b", "input text"))
         + connections(connection("a.count", "b.text", '<ssc:LinearTransformation factor="2"/>')),
         r"types must fit: a\.count is of type integer, b\.text of type string"),
    ],
)  # fmt: skip
def test_what_does_not_fit_the_fmus_is_refused(ssp: Ssp, inside: str, words: str) -> None:
    with pytest.raises(WiringError if "unknown" not in words and "parsec" not in words else ValueError, match=words):
        simulate(ssp(inside))


def exchange(*elements: str) -> str:
    """A system file with these Exchange elements in its annotations."""
    notes = "".join(f'<ssc:Annotation type="gyro-cosim">{element}</ssc:Annotation>' for element in elements)
    head = HEAD.replace("xmlns:ssd=", 'xmlns:gc="urn:gyro-cosim:1" xmlns:ssd=')
    return f'{head}<ssd:System name="top">{TWO}<ssd:Annotations>{notes}</ssd:Annotations></ssd:System>{UNITS}{TAIL}'


def test_a_file_says_what_is_exchanged_or_nothing(ssp: Ssp) -> None:
    assert ssp(TWO).exchange is None
    assert ssp(exchange('<gc:Exchange component="b"/>')).exchange == Exchange("b", "")
    assert ssp(exchange('<gc:Exchange component="a" ending="_full"/>')).exchange == Exchange("a", "_full")


@pytest.mark.parametrize(
    ("inside", "words"),
    [
        (('<gc:Exchange component="c"/>',), "line 1: Exchange: component must be one of the system, got 'c'"),
        (('<gc:Exchange ending="_full"/>',), "line 1: Exchange: must have the attribute 'component'"),
        (('<gc:Exchange component="a"/>', '<gc:Exchange component="b"/>'), "a system must have one Exchange at most"),
        (('<gc:Exchange component="a" suffix="_full"/>',), "Exchange: unknown attribute 'suffix'; known: component, ending"),
    ],
)
def test_what_is_exchanged_must_be_there_and_be_said_once(ssp: Ssp, inside: tuple[str, ...], words: str) -> None:
    with pytest.raises(ValueError, match=words) as caught:
        ssp(exchange(*inside))
    assert "x.ssp" in str(caught.value)


def test_archives_that_are_wrong_are_refused_and_nothing_lands_outside(tmp_path: Path) -> None:
    text = tmp_path / "text.ssp"
    text.write_text("no zip")
    empty, outside, bomb = (tmp_path / f"{name}.ssp" for name in ("empty", "outside", "bomb"))
    entity = '<!DOCTYPE x [<!ENTITY a "aaaa"><!ENTITY b "&a;&a;">]><x>&b;</x>'
    for file, member, content in (
        (empty, "readme.txt", ""), (outside, "../../out.txt", "x"), (bomb, "SystemStructure.ssd", entity),
    ):  # fmt: skip
        with zipfile.ZipFile(file, "w") as archive:
            archive.writestr(member, content)
    for file, words in (
        (text, "must be a zip archive"), (empty, "must hold SystemStructure.ssd"), (outside, "must lie inside the archive"),
        (bomb, "must have no document type declaration"), (tmp_path / "none.ssp", "must exist"),
    ):  # fmt: skip
        with pytest.raises(ValueError, match=words) as caught:
            system(str(file))
        assert file.name in str(caught.value)
    assert not (tmp_path.parent / "out.txt").exists()
    assert not (tmp_path.parent.parent / "out.txt").exists()


def test_info_spells_out_algebraic_loops(cosim_json: Callable[..., Any], ssp: Ssp, tmp_path: Path) -> None:
    gain = f"{oscillators.HERE}:crossed"
    ring = System("ring", (SystemComponent("a", gain, {"gain": 0.5}), SystemComponent("b", gain, {"gain": 0.5})),
                  (Connection(("a", "y"), ("b", "u")), Connection(("b", "y"), ("a", "u"))))  # fmt: skip
    pack(ring, tmp_path / "ring.ssp")
    (loop,) = cosim_json("info", str(tmp_path / "ring.ssp"))["loops"]
    assert loop in ("a.y -> b.y -> a.y", "b.y -> a.y -> b.y")
