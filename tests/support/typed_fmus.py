"""FMUs for what crosses a connection besides plain numbers: elements of arrays, strings, binaries, structural parameters."""

from pathlib import Path

from small_fmus import library, written

from gyro_cosim.fmus.compiler import host

_REALS = "".join(
    f'<ScalarVariable name="{name}[{i + 1}]" valueReference="{first + i}" causality="{kind}">'
    f'<Real{start} unit="m"/></ScalarVariable>'
    for name, first, kind, start in (("x", 0, "input", ' start="0"'), ("s", 3, "output", ""))
    for i in (2, 0, 1)  # in no order of theirs
)

TYPES_2 = f"""<?xml version="1.0" encoding="UTF-8"?>
<fmiModelDescription fmiVersion="2.0" modelName="types" guid="types">
  <CoSimulation modelIdentifier="types" canGetAndSetFMUstate="true" canSerializeFMUstate="true"/>
  <UnitDefinitions><Unit name="m"><BaseUnit m="1"/></Unit></UnitDefinitions>
  <ModelVariables>{_REALS}
    <ScalarVariable name="level" valueReference="6" causality="input"><Real start="0"/></ScalarVariable>
    <ScalarVariable name="level_out" valueReference="7" causality="output"><Real/></ScalarVariable>
    <ScalarVariable name="whole" valueReference="0" causality="input" variability="discrete">
      <Integer start="0" max="100"/></ScalarVariable>
    <ScalarVariable name="whole_out" valueReference="1" causality="output" variability="discrete"><Integer/></ScalarVariable>
    <ScalarVariable name="length" valueReference="2" causality="output" variability="discrete"><Integer/></ScalarVariable>
    <ScalarVariable name="steps" valueReference="3" causality="output" variability="discrete" initial="calculated">
      <Integer/></ScalarVariable>
    <ScalarVariable name="on" valueReference="0" causality="input" variability="discrete">
      <Boolean start="false"/></ScalarVariable>
    <ScalarVariable name="on_out" valueReference="1" causality="output" variability="discrete"><Boolean/></ScalarVariable>
    <ScalarVariable name="heard" valueReference="0" causality="input" variability="discrete"><String start=""/></ScalarVariable>
    <ScalarVariable name="said" valueReference="1" causality="output" variability="discrete"><String/></ScalarVariable>
    <ScalarVariable name="news" valueReference="2" causality="output" variability="discrete"><String/></ScalarVariable>
  </ModelVariables>
  <ModelStructure><Outputs>
    <Unknown index="4" dependencies="1"/><Unknown index="5" dependencies="2"/><Unknown index="6" dependencies="3"/>
    <Unknown index="8" dependencies="7"/><Unknown index="10" dependencies="9"/><Unknown index="11" dependencies="15"/>
    <Unknown index="12" dependencies=""/><Unknown index="14" dependencies="13"/><Unknown index="16" dependencies="15"/>
    <Unknown index="17" dependencies=""/>
  </Outputs></ModelStructure>
</fmiModelDescription>
"""

TYPES_3 = """<?xml version="1.0" encoding="UTF-8"?>
<fmiModelDescription fmiVersion="3.0" modelName="types" instantiationToken="types">
  <CoSimulation modelIdentifier="types" hasEventMode="@EVENTS@"/>
  <UnitDefinitions><Unit name="m"><BaseUnit m="1"/></Unit></UnitDefinitions>
  <ModelVariables>
    <Float64 name="time" valueReference="0" causality="independent" variability="continuous"/>
    <UInt64 name="n" valueReference="1" causality="structuralParameter" variability="fixed" start="3" min="1" max="5"/>
    <Float64 name="x" valueReference="2" causality="input" start="0" unit="m"><Dimension valueReference="1"/></Float64>
    <Float64 name="y" valueReference="3" causality="output" unit="m"><Dimension valueReference="1"/></Float64>
    <Float64 name="grid" valueReference="4" causality="output"><Dimension valueReference="1"/><Dimension start="2"/></Float64>
    <Float64 name="w" valueReference="5" causality="parameter" variability="fixed" start="1 2 3">
      <Dimension valueReference="1"/></Float64>
    <Float64 name="sum" valueReference="6" causality="output"/>
    <String name="heard" valueReference="7" causality="input"><Start value="nothing"/></String>
    <String name="said" valueReference="8" causality="output"/>
    <Binary name="blob" valueReference="9" causality="input"><Start value=""/></Binary>
    <Binary name="copy" valueReference="10" causality="output"/>
  </ModelVariables>
  <ModelStructure>
    <Output valueReference="3" dependencies="2"/><Output valueReference="4" dependencies=""/>
    <Output valueReference="6" dependencies=""/><Output valueReference="8" dependencies="7"/>
    <Output valueReference="10" dependencies="9"/>
  </ModelStructure>
</fmiModelDescription>
"""


def types_2(folder: Path) -> Path:
    """FMI 2.0: variables x[1] ... x[3], strings, an integer and a boolean; see c/types2.c."""
    return written(folder / "types2.fmu", TYPES_2, f"binaries/{host().folder}/types{host().suffix}", library("types2.c"))


def types_3(folder: Path, *, events: bool = False) -> Path:
    """FMI 3.0: arrays of n elements, strings and binaries, with event mode or without; see c/types3.c."""
    text = TYPES_3.replace("@EVENTS@", str(events).lower())
    file = folder / f"types3{'_events' if events else ''}.fmu"
    return written(file, text, f"binaries/{host().name}/types{host().suffix}", library("types3.c"))
