"""Which faults of a description against FMI's schema do harm: one judgement for running and checking."""

from collections.abc import Callable

import pytest
from lxml import etree

from gyro_cosim.slaves.fmi.description import parse
from gyro_cosim.slaves.fmi.schema import judged

FMI2 = """<fmiModelDescription fmiVersion="2.0" modelName="m" guid="g" generationDateAndTime="2026-11-25T10:00:00Z">
<CoSimulation modelIdentifier="m"/>
<ModelVariables>
 <ScalarVariable name="u" valueReference="0" causality="input"><Real start="2"/>
  <Annotations><Tool name="t"/></Annotations></ScalarVariable>
 <ScalarVariable name="y" valueReference="1" causality="output"><Real unit="m"/></ScalarVariable>
</ModelVariables>
<ModelStructure><Outputs><Unknown index="2"/></Outputs></ModelStructure>
</fmiModelDescription>"""
FMI3 = """<fmiModelDescription fmiVersion="3.0" modelName="m" instantiationToken="g">
<CoSimulation modelIdentifier="m"/>
<ModelVariables>
 <Float64 name="time" valueReference="0" causality="independent"/>
 <Float64 name="u" valueReference="1" causality="input" start="2"/>
</ModelVariables><ModelStructure/></fmiModelDescription>"""

HARMLESS = {
    "date with underscores": (FMI2, "2026-11-25T10:00:00Z", "2026_11_25"),
    "vendor attribute": (FMI2, 'name="y"', 'name="y" acme_id="7"'),
    "attribute in a tool's own element": (FMI2, '<Tool name="t"/>', '<Tool name="t" order="1"/>'),
    "two in the same place": (FMI2, '<Tool name="t"/>', '<Tool name="t" a="1"/><Tool/>'),
    "empty list": (FMI2, "</Outputs>", "</Outputs><Derivatives/>"),
    "annotations where aliases belong": (
        FMI3, '<Float64 name="u" valueReference="1" causality="input" start="2"/>',
        '<Float64 name="u" valueReference="1" causality="input" start="2"><Alias name="v"/><Annotations>'
        '<Annotation type="x" order="1"/></Annotations></Float64>',
    ),
}  # fmt: skip
HARMFUL = {
    "value that FMI does not know": (FMI2, 'causality="input"', 'causality="both"'),
    "misspelt attribute": (FMI2, 'start="2"', 'stat="2"'),
    "attribute on the wrong element": (FMI2, '<ScalarVariable name="u"', '<ScalarVariable start="3" name="u"'),
    "unknown element": (FMI2, "</ModelVariables>", "<Extra/></ModelVariables>"),
    "missing attribute": (FMI2, 'modelIdentifier="m"', ""),
    "harmful behind a harmless one": (FMI2, '<Tool name="t"/>', '<Tool name="t" a="1"/></Annotations><Real/><Annotations>'),
}


@pytest.fixture
def changed() -> Callable[[tuple[str, str, str]], bytes]:
    def make(case: tuple[str, str, str]) -> bytes:
        text, old, new = case
        assert old in text
        return text.replace(old, new, 1).encode()

    return make


@pytest.mark.parametrize("case", HARMLESS)
def test_a_fault_that_changes_nothing_read_is_told_and_the_fmu_read(changed: Callable[..., bytes], case: str) -> None:
    text = HARMLESS[case][0]
    whole, broken = parse("x.fmu", text.encode()), parse("x.fmu", changed(HARMLESS[case]))
    assert broken.schema_faults
    assert all(fault.startswith("line ") and "\n" not in fault for fault in broken.schema_faults)
    assert [(r.reference, r.start, r.unit) for r in broken.rows if r.name in ("u", "y")] == [
        (r.reference, r.start, r.unit) for r in whole.rows if r.name in ("u", "y")
    ]


@pytest.mark.parametrize("case", HARMFUL)
def test_a_fault_that_could_change_something_is_refused(changed: Callable[..., bytes], case: str) -> None:
    data = changed(HARMFUL[case])
    with pytest.raises(ValueError, match=r"must keep the schema of FMI [23]\.0: line \d+: "):
        parse("x.fmu", data)
    _, faults = judged(etree.fromstring(data), "2")
    assert any(not fault.harmless for fault in faults)


def test_a_description_that_keeps_the_schema_is_left_alone() -> None:
    root = etree.fromstring(FMI2)
    assert judged(root, "2") == (root, ())
