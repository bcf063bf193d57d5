"""Every document is checked by the rules of SSP: nothing that a user wrote is read as a default."""

import re
import zipfile
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest
from ssp_files import HEAD, TAIL, Ssp, bound, component, connection, connections, connector, elements, ssd, value, write

from gyro_cosim import system
from gyro_cosim.ssp.rules import RuleError, check
from gyro_cosim.systems import archive

TWO = elements(component("a", "output y Real", "output count Integer"), component("b", "input u Real", "input add Integer"))


@pytest.fixture
def ssp(tmp_path: Path) -> Ssp:
    return lambda inside, **members: system(str(write(tmp_path, inside, **members)))


def noted(*notes: str, kind: str = "gyro-cosim") -> str:
    """A whole file with our annotations."""
    head = HEAD.replace("xmlns:ssd=", 'xmlns:gc="urn:gyro-cosim:1" xmlns:ssd=')
    held = "".join(f'<ssc:Annotation type="{kind}">{note}</ssc:Annotation>' for note in notes)
    return f'{head}<ssd:System name="top">{TWO}<ssd:Annotations>{held}</ssd:Annotations></ssd:System>{TAIL}'


@pytest.mark.parametrize(
    ("inside", "words"),
    [
        # each of these counted as a default once: factor 1, conversion not suppressed, no prefix, a stop that never comes
        (TWO + connections(connection("a.y", "b.u", '<ssc:LinearTransfromation factor="1000"/>')),
         "LinearTransfromation: unknown element of Connection 'LinearTransfromation'; did you mean 'LinearTransformation'"),
        (TWO + connections(connection("a.y", "b.u", '<ssc:LinearTransformation faktor="1000"/>')),
         "line 1: LinearTransformation: unknown attribute 'faktor'; did you mean 'factor'"),
        (TWO + connections(connection("a.y", "b.u", more='suppressUnitConversion="True"')),
         "Connection: suppressUnitConversion must be true, false, 1 or 0, got 'True'"),
        (bound(value("u", 1)).replace("prefix=", "prefx=") + TWO,
         "ParameterBinding: unknown attribute 'prefx'; did you mean 'prefix'"),
        (noted('<gc:StopWhen signal="a.y" above="NaN"/>'), "StopWhen: above must be a number, got 'NaN'"),
        # other places where a word may be wrong
        (TWO.replace("ssd:Connectors>", "ssd:Conectors>"), "unknown element of Component 'Conectors'; did you mean 'Connectors'"),
        (TWO.replace("<ssc:Real/>", "<ssd:Real/>"), "Real: must be of the namespace http://.*SystemStructureCommon, is of"),
        (TWO.replace("<ssc:Real/>", "<ssc:Reel/>"), "unknown element of Connector 'Reel'; did you mean 'Real'"),
        (TWO.replace("<ssc:Real/>", "<ssc:Real/><ssc:Real/>"), "Real: must stand once in Connector, this is the second"),
        (TWO.replace("kind=", "Kind=", 1), "Connector 'y': unknown attribute 'Kind'; did you mean 'kind'"),
        (bound(value("a.u", 3).replace("unit=", "units=")) + TWO.replace("<ssc:Real/>", '<ssc:Real unitt="m"/>'),
         "Real: unknown attribute 'unitt'; did you mean 'unit'"),
        (bound(value("a.u", 3).replace("value=", "valeu=")) + TWO, "Real: unknown attribute 'valeu'; did you mean 'value'"),
        (TWO + "<ssd:Connections>a.y to b.u</ssd:Connections>", "Connections: must hold no text, got 'a.y to b.u'"),
        (TWO + connections(connection("a.y", "b.u", '<ssc:LinearTransformation factor="1,5"/>')), "must be a number, got '1,5'"),
        (ssd(TWO).replace("stopTime", "stoptime"), "unknown attribute 'stoptime'; did you mean 'stopTime'"),
        (ssd(TWO).replace("ssc:BaseUnit", "ssc:BaseUnits"), "unknown element of Unit 'BaseUnits'; did you mean 'BaseUnit'"),
        (ssd(TWO).replace('<ssc:BaseUnit m="1"', '<ssc:BaseUnit M="1"'), "unknown attribute 'M'"),
        (noted('<gc:Mastre step="1"/>'), "unknown element of the annotation 'Mastre'; did you mean 'Master'"),
        (noted('<gc:Master stepp="1"/>'), "Master: unknown attribute 'stepp'; did you mean 'step'"),
        (noted('<gc:Master step="-1"/>'), "Master: step must be positive, got '-1'"),
        (noted('<gc:Master step="1"/>', kind="gyro-kosim"), "Master: an annotation of type 'gyro-cosim' must hold elements of"),
        (noted('<gc:Bond motion="a.y"/>'), "Bond: must have the attribute 'effort'"),
        (f"{HEAD}{TAIL}", "must hold a System"),
    ],
)  # fmt: skip
def test_a_misspelt_word_is_refused_with_line_and_nearest_name(ssp: Ssp, inside: str, words: str) -> None:
    with pytest.raises(ValueError, match=words) as caught:
        ssp(inside)
    assert "x.ssp" in str(caught.value)
    assert ", line 1: " in str(caught.value)


def test_no_name_in_a_file_can_be_misspelt_unnoticed(ssp: Ssp) -> None:
    """Every name of an element or attribute in turn, with its last letter doubled, wherever it stands."""
    wire = connection("a.y", "b.u", '<ssc:LinearTransformation factor="2" offset="1"/>', 'suppressUnitConversion="true"')
    mapping = '<ssd:ParameterMapping><ssm:ParameterMapping version="1.0"><ssm:MappingEntry source="u" target="a.u"/>'
    mapping += "</ssm:ParameterMapping></ssd:ParameterMapping>"
    text = ssd(bound(value("u", 1, unit="ell"), mapping=mapping) + TWO + connections(wire))
    assert ssp(text).components[0].bound != {}
    names = [m.end(1) for m in re.finditer(r"(?<=[< ])((?:ss[dcvm]:)?[A-Za-z]+)(?==\"|=\'|[ />])", text)]
    assert len(names) > 60
    for end in names:
        with pytest.raises(ValueError, match=r"x\.ssp"):
            ssp(text[:end] + text[end - 1] + text[end:])


def test_documents_beside_the_system_file_are_checked_too(ssp: Ssp) -> None:
    names = {kind: f'xmlns:{kind}="http://ssp-standard.org/SSP1/SystemStructureParameter{of}"'
             for kind, of in (("ssv", "Values"), ("ssm", "Mapping"))}  # fmt: skip
    held = f"<ssv:Parameters>\n{value('x', 1)}</ssv:Parameters>"
    ssv = f'<ssv:ParameterSet version="1.0" name="p" {names["ssv"]}>{held}</ssv:ParameterSet>'
    ssm = (
        f'<ssm:ParameterMapping version="1.0" {names["ssm"]}>\n<ssm:MappingEntry source="x" target="a.u"/></ssm:ParameterMapping>'
    )
    mapping = '<ssd:ParameterMapping source="m.ssm"/>'
    inside = bound("", source="p.ssv", mapping=mapping) + TWO
    assert ssp(inside, p_dot_ssv=ssv, m_dot_ssm=ssm).components[0].bound == {"u": 1}
    with pytest.raises(ValueError, match=r"p\.ssv', line 2: Real: unknown attribute 'valeu'"):
        ssp(inside, p_dot_ssv=ssv.replace(" value=", " valeu="), m_dot_ssm=ssm)
    with pytest.raises(ValueError, match=r"m\.ssm', line 2: MappingEntry 'x': unknown attribute 'tarket'; did you mean 'target'"):
        ssp(inside, p_dot_ssv=ssv, m_dot_ssm=ssm.replace("target=", "tarket="))


def test_what_the_rules_say_is_what_the_standard_s_schema_says() -> None:
    """Of every element the attributes and children, read from the schema that FMPy ships (SSP 1.0), are known to the rules."""
    import importlib.util

    from lxml import etree

    from gyro_cosim.ssp import rules

    (place,) = importlib.util.find_spec("fmpy").submodule_search_locations  # type: ignore[union-attr]
    xs, table = "{http://www.w3.org/2001/XMLSchema}", rules._rules()
    kinds = {
        "ssd": "Description",
        "ssc": "Common",
        "ssv": "ParameterValues",
        "ssm": "ParameterMapping",
        "ssb": "SignalDictionary",
    }
    seen = 0
    for kind, name in kinds.items():
        for element in etree.parse(str(Path(place) / "ssp" / "schema" / f"SystemStructure{name}.xsd")).iter(f"{xs}element"):
            own = f"{kind}:{element.get('name')}"
            inner = element.find(f"{xs}complexType")
            if inner is None or element.get("name") is None or own in ("ssc:Content", "ssc:Annotation"):
                continue
            known = [rule for key, rule in table.items() if key == own or key.endswith(f"/{own}")]
            if own == "ssc:Enumeration":
                known = [({"name": "!"}, {})]
            assert known, own
            for attribute in inner.findall(f"{xs}attribute"):
                assert all(attribute.get("name") in attributes for attributes, _ in known), (own, attribute.get("name"))
                seen += 1
    assert seen > 60


def test_what_only_ssp_2_has_is_known_and_checked_too(ssp: Ssp) -> None:
    """Dimensions, also by another connector, clocks and their attributes, structural parameters, integers of all sizes."""
    clock = '<ssc:Clock intervalVariability="constant" intervalDecimal="0.1"/>'
    several = "".join(
        f'<ssd:Connector name="{name}" kind="{kind}">{held}</ssd:Connector>'
        for name, kind, held in (
            ("n", "structuralParameter", "<ssc:UInt64/>"), ("tick", "input", clock),
            ("u", "input", '<ssc:Float64/><ssc:Dimension sizeConnector="n"/><ssc:Dimension size="2"/><ssd:Clock name="tick"/>'),
        )
    )  # fmt: skip
    text = ssd(f"<ssd:Connectors>{several}</ssd:Connectors>").replace('version="1.0"', 'version="2.0"')
    assert ssp(text).components == ()
    for wrong, words in (
        ("sizeConnector", "Dimension: unknown attribute 'sizeConector'; did you mean 'sizeConnector'"),
        ('intervalVariability="constant"', "Clock: intervalVariability must be one of constant, fixed, .* got 'konstant'"),
    ):
        with pytest.raises(ValueError, match=words):
            ssp(text.replace(wrong, wrong.replace("sizeConn", "sizeCon").replace('"constant', '"konstant')))


def test_a_fault_has_its_element() -> None:
    root = archive.xml(ssd(TWO).replace("<ssc:Real/>", "<ssc:Rael/>").encode(), "x")
    with pytest.raises(RuleError) as caught:
        check(root)
    assert caught.value.element.tag.endswith("}Rael")


def test_a_system_file_never_names_python_code_and_info_loads_none(
    tmp_path: Path, cosim: Callable[..., Any], monkeypatch: pytest.MonkeyPatch
) -> None:
    """Neither a Python file nor the binary of an FMU runs on being looked at."""
    (tmp_path / "my.py").write_text("open('ran', 'w')")
    (tmp_path / "s.ssd").write_text(ssd(elements(component("a", source="my.py"))))
    for command in ("info", "run"):
        code, _, err = cosim(command, "s.ssd")
        assert code == 2
        assert "Component 'a': source must be an FMU, whose name ends in .fmu, got 'my.py'" in err
    assert not (tmp_path / "ran").exists()
    file = write(tmp_path, TWO + connections(connection("a.y", "b.u")))

    def refuse(*_: object) -> None:
        raise AssertionError("a binary was loaded")

    monkeypatch.setattr("gyro_cosim.slaves.fmi.library.Library.__init__", refuse)
    code, out, err = cosim("info", str(file))
    assert code == 0, err
    assert "a.y [furlong]  ->  b.u [furlong]" in out


def test_connectors_of_a_signal_dictionary_pass_values_on(ssp: Ssp) -> None:
    """Two references to one dictionary, in the system and in a nested one, share its entries; units are those of the entries."""
    entry = '<ssb:DictionaryEntry name="way"><ssc:Real unit="ell"/></ssb:DictionaryEntry>'
    space = 'xmlns:ssb="http://ssp-standard.org/SSP1/SystemStructureSignalDictionary"'
    units = '<ssb:Units><ssc:Unit name="ell"><ssc:BaseUnit m="1" factor="0.5"/></ssc:Unit></ssb:Units>'
    bus = f'<ssb:SignalDictionary version="1.0" {space}>{entry}{units}</ssb:SignalDictionary>'
    held = f'<ssd:SignalDictionaries><ssd:SignalDictionary name="bus">{bus}</ssd:SignalDictionary></ssd:SignalDictionaries>'

    def reference(of: str, entry: str = "way") -> str:
        return (
            f'<ssd:SignalDictionaryReference name="{of}" dictionary="bus"><ssd:Connectors>{connector(f"inout {entry}")}'
            "</ssd:Connectors></ssd:SignalDictionaryReference>"
        )

    inner = f'<ssd:System name="sub">{elements(component("b", "input u"), reference("in"))}'
    inner += (
        connections(connection("b.u", "in.way", '<ssc:LinearTransformation factor="2"/>')) + "</ssd:System>"
    )  # either way round
    plan = ssp(elements(component("a", "output y"), reference("out"), inner) + connections(connection("a.y", "out.way")) + held)
    (wire,) = plan.connections
    assert (wire.start, wire.end) == (("a", "y"), ("sub/b", "u"))
    assert [(c.end and c.end.factor, c.factor) for c in wire.conversions] == [(0.5, 1.0), (None, 2.0)]
    with pytest.raises(ValueError, match="unknown entry of signal dictionary 'bus': 'wya'; did you mean 'way'"):
        ssp(elements(reference("out", "wya")) + held)


def test_an_ssp_with_one_system_file_of_another_name_is_read_and_with_two_asks_which(tmp_path: Path) -> None:
    file = tmp_path / "x.ssp"
    with zipfile.ZipFile(file, "w") as members:
        members.writestr("plant.ssd", ssd(""))
    (note,) = system(str(file)).notes
    assert "plant.ssd is read in place of SystemStructure.ssd" in note
    with zipfile.ZipFile(file, "a") as members:
        members.writestr("other.ssd", ssd(""))
    with pytest.raises(ValueError, match=r"must hold SystemStructure\.ssd; it holds plant\.ssd, other\.ssd"):
        system(str(file))
