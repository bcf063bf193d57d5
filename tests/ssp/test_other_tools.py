"""System files as other tools write them: read where nothing is lost, with a note; what is not followed is told."""

from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest
from ssp_files import HEAD, TAIL, Ssp, bound, component, connection, connections, connector, elements, ssd, value, write

from gyro_cosim import Jacobi, simulate, system
from gyro_cosim.network.joining import transfer
from gyro_cosim.slaves.described import described_slave
from gyro_cosim.ssp.packing import pack

OSP = "http://opensimulationplatform.com/SSP/OSPAnnotations"
TWO = elements(component("a", "output y"), component("b", "input u"))


@pytest.fixture
def ssp(tmp_path: Path) -> Ssp:
    return lambda inside, **members: system(str(write(tmp_path, inside, **members)))


def annotated(kind: str, held: str, *, inner: str = "", more: str = "") -> str:
    """A whole file with an annotation of another tool at the system, and one at the nested system."""
    below = f'<ssd:System name="sub"><ssd:Annotations>{_annotation(kind, inner)}</ssd:Annotations></ssd:System>' if inner else ""
    return (
        f'{HEAD}<ssd:System name="top">{elements(component("a"), below)}<ssd:Annotations>{_annotation(kind, held)}{more}'
        f"</ssd:Annotations></ssd:System>{TAIL}"
    )


def _annotation(kind: str, held: str) -> str:
    return f'<ssc:Annotation type="{kind}">{held}</ssc:Annotation>'


@pytest.mark.parametrize(
    ("kind", "held", "step"),
    [
        (
            "com.opensimulationplatform",
            f'<o:Algorithm xmlns:o="{OSP}"><o:FixedStepAlgorithm baseStepSize="2e-4"/></o:Algorithm>',
            2e-4,
        ),
        ("org.openmodelica", '<o:S xmlns:o="urn:oms"><o:FixedStepMaster description="oms-ma" stepSize="0.01"/></o:S>', 0.01),
    ],
)
def test_another_tool_s_macro_step_is_taken_and_told(ssp: Ssp, kind: str, held: str, step: float) -> None:
    plan = ssp(annotated(kind, held))
    assert plan.step == step
    (note,) = plan.notes
    assert f"line 1: macro step {step:g} s as {kind} states it" in note


def test_the_outermost_step_counts_ours_goes_first_and_a_solver_is_told(ssp: Ssp) -> None:
    outer, inner = (f'<o:FixedStepMaster xmlns:o="urn:oms" stepSize="{h}"/>' for h in (0.01, 0.002))
    plan = ssp(annotated("org.openmodelica", outer, inner=inner))
    assert plan.step == 0.01
    assert any("states a step of 0.002 s, which is not followed" in note for note in plan.notes)
    ours = '<ssc:Annotation type="gyro-cosim"><gc:Master xmlns:gc="urn:gyro-cosim:1" step="0.005"/></ssc:Annotation>'
    assert ssp(annotated("org.openmodelica", outer, more=ours)).step == 0.005
    solver = '<o:VariableStepSolver xmlns:o="urn:oms" description="cvode" minimumStepSize="1e-6" maximumStepSize="0.1"/>'
    plan = ssp(annotated("org.openmodelica", solver))
    assert plan.step == 1e-3
    assert "asks for VariableStepSolver cvode with steps of 1e-6 to 0.1 s, which is not followed" in plan.notes[0]
    with pytest.raises(ValueError, match="FixedStepMaster: stepSize must be positive, got '0'"):
        ssp(annotated("org.openmodelica", outer.replace("0.01", "0")))


def test_annotations_of_which_nothing_is_read_are_named(ssp: Ssp) -> None:
    (note,) = ssp(annotated("se.umu.constraints", '<k:Shaft xmlns:k="urn:k"/>')).notes
    assert note.endswith("annotations of other tools are not read: se.umu.constraints")


def test_an_element_with_an_empty_name_is_the_system(ssp: Ssp) -> None:
    inside = f"<ssd:Connectors>{connector('input way')}</ssd:Connectors>" + elements(component("b", "input u"))
    wire = '<ssd:Connection startElement="" startConnector="way" endElement="b" endConnector="u"/>'
    plan = ssp(bound(value("way", 3)) + inside + connections(wire))
    assert plan.components[0].bound == {"u": 3}
    assert 'an element called "" is read as the system itself' in plan.notes[0]


def test_units_that_nobody_defines_stand_where_nothing_is_converted(ssp: Ssp) -> None:
    """A bracketed unit means the one inside; one that is defined nowhere is as good as none, at both ends alike."""
    plan = ssp(elements(component("a", "output y Real [m]"), component("b", "input u Real [m]")))
    assert (plan.components[0].ports["y"].unit is not None, plan.notes) == (True, ())
    wires = connections(connection("a.y", "b.u"))
    plan = ssp(elements(component("a", "output y Real parsec"), component("b", "input u Real parsec")) + wires)
    assert "unit 'parsec' is not defined in the file, and is taken as not stated" in plan.notes[0]
    START = bound(value("a.u", 3) + value("a.gain", 1))
    run = simulate(ssp(START + elements(component("a", "output y Real parsec"), component("b", "input u")) + wires), step=0.01)
    assert run.trajectory.end()["b.y"] == pytest.approx(6)
    plan = ssp(bound(value("a.gain", 3, unit="[thing]")) + TWO)  # the FMU states no unit for it
    assert simulate(plan, step=0.01, algorithm=Jacobi(0)).trajectory.end()["a.y"] == pytest.approx(3 * 0.0)
    assert "unit '[thing]' is not defined in the file" in plan.notes[0]


def test_an_undeclared_prefix_is_declared_for_the_reader(ssp: Ssp) -> None:
    held = '<osp:Algorithm><osp:FixedStepAlgorithm baseStepSize="0.02"/></osp:Algorithm>'
    plan = ssp(annotated("com.opensimulationplatform", held))
    assert plan.step == 0.02
    assert "the namespace prefix osp is not declared" in plan.notes[0]
    with pytest.raises(ValueError, match="must be well-formed XML"):
        ssp(ssd(TWO)[:-20])


def test_an_fmu_behind_a_proxy_of_this_machine_runs_here(ssp: Ssp) -> None:
    plan = ssp(elements(component("a", source="proxyfmu://localhost?file=resources/mixed.fmu")))
    assert plan.components[0].source.endswith("x.ssp#resources/mixed.fmu")
    assert "behind proxyfmu runs here" in plan.notes[0]
    with pytest.raises(ValueError, match="source must be a file of this machine, got 'proxyfmu://rig:9090"):
        ssp(elements(component("a", source="proxyfmu://rig:9090?file=mixed.fmu")))
    with pytest.raises(ValueError, match="source must lie inside the archive"):
        ssp(elements(component("a", source="proxyfmu://localhost?file=../../mixed.fmu")))


def test_run_says_what_a_binding_could_not_apply(
    cosim_json: Callable[..., Any], cosim: Callable[..., Any], tmp_path: Path
) -> None:
    """Names of elements that are not there, names that an FMU has not, and what a mapping has no entry for."""
    values = value("a.gain", 2) + value("c.gain", 2) + value("a.gian", 3)
    file = write(tmp_path, bound(values) + TWO)
    code, out, err = cosim("run", str(file))
    assert code == 0, err
    out = " ".join(out.split())
    assert "not used, for nothing in the system is called so: 'c.gain'" in out
    assert "note: not used, for 'a' has nothing to be set by that name: gian (did you mean 'gain'?)" in out
    notes = cosim_json("run", str(file))["notes"]
    assert notes == cosim_json("info", str(file))["notes"]
    assert len(notes) == 2
    mapping = '<ssd:ParameterMapping><ssm:ParameterMapping version="1.0"><ssm:MappingEntry source="on" target="a.gain"/>'
    mapping += "</ssm:ParameterMapping></ssd:ParameterMapping>"
    notes = cosim_json("info", str(write(tmp_path, bound(value("own", 2), mapping=mapping) + TWO)))["notes"]
    assert any("not in the parameter set, and so without effect: 'on' (did you mean 'own'?)" in note for note in notes)
    assert any("not used, for the mapping has no entry: 'own'" in note for note in notes)


def test_items_of_enumerations_are_mapped_by_name(ssp: Ssp) -> None:
    """In a connection to the numbers of both ends' items; in a parameter mapping as text. Misspelt ones have the nearest name."""
    entries = "".join(f'<ssc:MapEntry source="{a}" target="{b}"/>' for a, b in (("slow", "fast"), ("fast", "slow")))
    change = f"<ssc:EnumerationMappingTransformation>{entries}</ssc:EnumerationMappingTransformation>"
    two = elements(component("a", "output mode_out"), component("b", "input mode"))
    plan = ssp(two + connections(connection("a.mode_out", "b.mode", change)))
    fmu = described_slave("a", plan.components[0].source).description
    ends = [next(s for s in signals if s.name == name) for signals, name in ((fmu.outputs, "mode_out"), (fmu.inputs, "mode"))]
    assert transfer(plan.connections[0], *ends).table == {2.0: 5.0, 5.0: 2.0}  # the numbers of slow and fast
    packed = system(str(pack(plan, Path(plan.components[0].source.partition("#")[0]).with_name("again.ssp"))))
    assert transfer(packed.connections[0], *ends).table == {2.0: 5.0, 5.0: 2.0}
    entry = f'<ssm:MappingEntry source="own" target="a.mode">{change}</ssm:MappingEntry>'
    mapping = f'<ssd:ParameterMapping><ssm:ParameterMapping version="1.0">{entry}</ssm:ParameterMapping></ssd:ParameterMapping>'
    assert ssp(bound(value("own", "slow", "Enumeration"), mapping=mapping) + two).components[0].bound == {"mode": "fast"}
    wrong = connections(connection("a.mode_out", "b.mode", change.replace('target="fast"', 'target="fest"')))
    with pytest.raises(ValueError, match=r"unknown item of b\.mode: 'fest'; did you mean 'fast'"):
        simulate(ssp(two + wrong))
    with pytest.raises(ValueError, match=r"a mapping of items must be between enumerations, b\.add is an integer"):
        simulate(ssp(elements(component("a", "output mode_out"), component("b", "input add"))
                     + connections(connection("a.mode_out", "b.add", change))))  # fmt: skip
