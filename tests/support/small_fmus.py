"""Small hand-made FMUs for behaviours that the exporter's do not have: every type, arrays, foreign units, failures."""

import importlib.util
import re
import shutil
import tempfile
import zipfile
from functools import cache
from pathlib import Path

from gyro_cosim.fmus.compiler import compile_libraries, host

FAULTS = {"none": 0, "discard": 1, "error": 2, "fatal": 3, "nan": 4, "crash": 5, "hang": 6, "exit": 7, "start": 8}

MIXED = """<?xml version="1.0" encoding="UTF-8"?>
<fmiModelDescription fmiVersion="2.0" modelName="mixed" guid="mixed">
  <CoSimulation modelIdentifier="mixed"/>
  <UnitDefinitions>
    <Unit name="furlong"><BaseUnit m="1" factor="201.168"/></Unit>
    <Unit name="chain"><BaseUnit m="1" factor="20.1168"/></Unit>
    <Unit name="cubit"/>
    <Unit name="uphill"><BaseUnit m="1" offset="100"/></Unit>
  </UnitDefinitions>
  <TypeDefinitions>
    <SimpleType name="Mode"><Enumeration>
      <Item name="off" value="1"/><Item name="slow" value="2"/><Item name="fast" value="5"/>
    </Enumeration></SimpleType>
  </TypeDefinitions>
  <ModelVariables>
    <ScalarVariable name="u" valueReference="0" causality="input"><Real start="0" unit="@IN@"/></ScalarVariable>
    <ScalarVariable name="y" valueReference="1" causality="output"><Real unit="@OUT@"/></ScalarVariable>
    <ScalarVariable name="gain" valueReference="2" causality="parameter" variability="fixed">
      <Real start="2"/></ScalarVariable>
    <ScalarVariable name="fault_at" valueReference="3" causality="parameter" variability="fixed">
      <Real start="0.05"/></ScalarVariable>
    <ScalarVariable name="add" valueReference="0" causality="input" variability="discrete">
      <Integer start="0"/></ScalarVariable>
    <ScalarVariable name="count" valueReference="1" causality="output" variability="discrete"><Integer/></ScalarVariable>
    <ScalarVariable name="mode" valueReference="2" causality="input" variability="discrete">
      <Enumeration declaredType="Mode" start="1"/></ScalarVariable>
    <ScalarVariable name="mode_out" valueReference="3" causality="output" variability="discrete">
      <Enumeration declaredType="Mode"/></ScalarVariable>
    <ScalarVariable name="fault" valueReference="4" causality="parameter" variability="fixed">
      <Integer start="0"/></ScalarVariable>
    <ScalarVariable name="on" valueReference="0" causality="input" variability="discrete">
      <Boolean start="true"/></ScalarVariable>
    <ScalarVariable name="on_out" valueReference="1" causality="output" variability="discrete"><Boolean/></ScalarVariable>
    <ScalarVariable name="text" valueReference="0" causality="input" variability="discrete">
      <String start=""/></ScalarVariable>
  </ModelVariables>
  <ModelStructure>
    <Outputs><Unknown index="2" dependencies=""/><Unknown index="6" dependencies=""/><Unknown index="8" dependencies=""/>
      <Unknown index="11" dependencies=""/></Outputs>
  </ModelStructure>
</fmiModelDescription>
"""

ARRAYS = """<?xml version="1.0" encoding="UTF-8"?>
<fmiModelDescription fmiVersion="3.0" modelName="arrays" instantiationToken="arrays">
  <CoSimulation modelIdentifier="arrays"/>
  <UnitDefinitions><Unit name="m"><BaseUnit m="1"/></Unit></UnitDefinitions>
  <TypeDefinitions>
    <EnumerationType name="Mode"><Item name="off" value="1"/><Item name="fast" value="5"/></EnumerationType>
  </TypeDefinitions>
  <ModelVariables>
    <Float64 name="time" valueReference="0" causality="independent" variability="continuous"/>
    <Float64 name="u" valueReference="1" causality="input" start="0" unit="m"><Dimension start="3"/></Float64>
    <Float64 name="y" valueReference="2" causality="output" unit="m"><Dimension start="3"/></Float64>
    <Float64 name="gain" valueReference="3" causality="parameter" variability="fixed" start="1 1 1">
      <Dimension start="3"/></Float64>
    <Float64 name="total" valueReference="4" causality="output"/>
    <Float32 name="single" valueReference="5" causality="input" start="0"/>
    <Float32 name="single_out" valueReference="6" causality="output"/>
    <Int8 name="tiny" valueReference="7" causality="input" variability="discrete" start="0"/>
    <Int8 name="tiny_out" valueReference="8" causality="output" variability="discrete"/>
    <UInt64 name="huge" valueReference="9" causality="input" variability="discrete" start="0"/>
    <UInt64 name="huge_out" valueReference="10" causality="output" variability="discrete"/>
    <Boolean name="on" valueReference="11" causality="input" variability="discrete" start="false"/>
    <Boolean name="on_out" valueReference="12" causality="output" variability="discrete"/>
    <Enumeration name="mode" valueReference="13" causality="input" variability="discrete" declaredType="Mode" start="1"/>
    <Enumeration name="mode_out" valueReference="14" causality="output" variability="discrete" declaredType="Mode"/>
    <String name="label" valueReference="15" causality="parameter" variability="fixed">
      <Dimension start="2"/><Start value="a"/><Start value="b"/></String>
    <Binary name="blob" valueReference="16" causality="parameter" variability="fixed"><Start value="00ff"/></Binary>
    <Int32 name="length" valueReference="17" causality="output" variability="discrete"/>
    <Boolean name="leave_early" valueReference="18" causality="parameter" variability="fixed" start="false"/>
    <Boolean name="ask_end" valueReference="19" causality="parameter" variability="fixed" start="false"/>
    <Boolean name="beyond" valueReference="21" causality="parameter" variability="fixed" start="false"/>
    <Clock name="tick" valueReference="20" causality="input" intervalVariability="triggered"/>
  </ModelVariables>
  <ModelStructure>
    <Output valueReference="2" dependencies=""/><Output valueReference="4" dependencies=""/>
    <Output valueReference="6" dependencies=""/><Output valueReference="8" dependencies=""/>
    <Output valueReference="10" dependencies=""/><Output valueReference="12" dependencies=""/>
    <Output valueReference="14" dependencies=""/><Output valueReference="17" dependencies=""/>
  </ModelStructure>
</fmiModelDescription>
"""


FOLLOWER_2 = """<?xml version="1.0" encoding="UTF-8"?>
<fmiModelDescription fmiVersion="2.0" modelName="follower" guid="follower">
  <CoSimulation modelIdentifier="follower"/>
  <ModelVariables>
    <ScalarVariable name="u" valueReference="0" causality="input"><Real start="0"/></ScalarVariable>
    <ScalarVariable name="gain" valueReference="1" causality="parameter" variability="fixed"><Real start="1"/></ScalarVariable>
    <ScalarVariable name="bias" valueReference="2" causality="parameter" variability="fixed"><Real start="0"/></ScalarVariable>
    <ScalarVariable name="decay" valueReference="3" causality="parameter" variability="fixed"><Real start="1"/></ScalarVariable>
    <ScalarVariable name="silent" valueReference="4" causality="parameter" variability="fixed"><Real start="0"/></ScalarVariable>
    <ScalarVariable name="y" valueReference="5" causality="output"><Real/></ScalarVariable>
    <ScalarVariable name="seen" valueReference="6" causality="output"><Real/></ScalarVariable>
  </ModelVariables>
  <ModelStructure>
    <Outputs><Unknown index="6" dependencies=""/><Unknown index="7" dependencies=""/></Outputs>
    @INITIAL@
  </ModelStructure>
</fmiModelDescription>
"""

FOLLOWER_3 = """<?xml version="1.0" encoding="UTF-8"?>
<fmiModelDescription fmiVersion="3.0" modelName="follower" instantiationToken="follower">
  <CoSimulation modelIdentifier="follower"/>
  <ModelVariables>
    <Float64 name="u" valueReference="0" causality="input" start="0"/>
    <Float64 name="gain" valueReference="1" causality="parameter" variability="fixed" start="1"/>
    <Float64 name="bias" valueReference="2" causality="parameter" variability="fixed" start="0"/>
    <Float64 name="decay" valueReference="3" causality="parameter" variability="fixed" start="1"/>
    <Float64 name="silent" valueReference="4" causality="parameter" variability="fixed" start="0"/>
    <Float64 name="y" valueReference="5" causality="output"/>
    <Float64 name="seen" valueReference="6" causality="output"/>
    <Float64 name="time" valueReference="7" causality="independent" variability="continuous"/>
  </ModelVariables>
  <ModelStructure>
    <Output valueReference="5" dependencies=""/><Output valueReference="6" dependencies=""/>
    @INITIAL@
  </ModelStructure>
</fmiModelDescription>
"""

BALL = """<?xml version="1.0" encoding="UTF-8"?>
<fmiModelDescription fmiVersion="3.0" modelName="ball" instantiationToken="ball">
  <CoSimulation modelIdentifier="ball" canGetAndSetFMUState="true" canSerializeFMUState="true"
    canHandleVariableCommunicationStepSize="true" mightReturnEarlyFromDoStep="@EVENTS@" hasEventMode="@EVENTS@"/>
  <ModelVariables>
    <Float64 name="time" valueReference="0" causality="independent" variability="continuous"/>
    <Float64 name="h" valueReference="1" causality="output" initial="exact" start="1"/>
    <Float64 name="v" valueReference="2" causality="output" initial="exact" start="0"/>
    <Float64 name="e" valueReference="3" causality="parameter" variability="fixed" start="0.7"/>
    <Float64 name="period" valueReference="4" causality="parameter" variability="fixed" start="0"/>
    <Int32 name="last" valueReference="5" causality="parameter" variability="fixed" start="0"/>
    <Int32 name="restless" valueReference="6" causality="parameter" variability="fixed" start="0"/>
    <Int32 name="stubborn" valueReference="7" causality="parameter" variability="fixed" start="0"/>
    <Int32 name="kick" valueReference="8" causality="input" variability="discrete" start="0"/>
    <Int32 name="impacts" valueReference="9" causality="output" variability="discrete"/>
    <Int32 name="ticks" valueReference="10" causality="output" variability="discrete"/>
    @CLOCK@
  </ModelVariables>
  <ModelStructure>
    <Output valueReference="1" dependencies=""/><Output valueReference="2" dependencies=""/>
    <Output valueReference="9" dependencies=""/><Output valueReference="10" dependencies=""/>
    <InitialUnknown valueReference="9" dependencies=""/><InitialUnknown valueReference="10" dependencies=""/>
  </ModelStructure>
</fmiModelDescription>
"""

# What the follower says of y and seen in initialization mode: on what they depend, that they are unknown there, nothing.
INITIAL = {
    "stated": ((6, "1 2 3"), (7, "1")),
    "anything": ((6, None), (7, None)),
    "nothing": (),
}


def follower(folder: Path, version: int, *, says: str = "stated") -> Path:
    """FMI 2.0 or 3.0: x(0) = gain u + bias, then x' = -decay x; `says` is a key of INITIAL."""
    rows = []
    for index, known in INITIAL[says]:
        # FMI 2.0 counts variables from 1, FMI 3.0 takes their references, here from 0
        numbers = None if known is None else " ".join(str(int(k) - (version == 3)) for k in known.split())
        depends = "" if numbers is None else f' dependencies="{numbers}"'
        rows.append(f'<InitialUnknown valueReference="{index - 1}"{depends}/>' if version == 3 else
                    f'<Unknown index="{index}"{depends}/>')  # fmt: skip
    initial = "".join(rows) if version == 3 else f"<InitialUnknowns>{''.join(rows)}</InitialUnknowns>" if rows else ""
    text = (FOLLOWER_3 if version == 3 else FOLLOWER_2).replace("@INITIAL@", initial)
    place = host().name if version == 3 else host().folder
    file = folder / f"follower{version}.{says}.fmu"
    return written(file, text, f"binaries/{place}/follower{host().suffix}", library("follower.c"))


def ball(folder: Path, *, events: bool = True, clock: bool = False, smooth: bool = False, refuses: bool = False) -> Path:
    """FMI 3.0: a bouncing ball with event mode, or one that deals with its events itself; see c/ball3.c.

    smooth : it shows h and v only, none of its integers. refuses : it is not instantiated with the event mode that it has.
    """
    tick = '<Clock name="clock" valueReference="11" causality="input" intervalVariability="triggered"/>' if clock else ""
    text = BALL.replace("@EVENTS@", str(events).lower()).replace("@CLOCK@", tick)
    if smooth:
        text = re.sub(r' *<(Int32 name="(kick|impacts|ticks)"|(Output|InitialUnknown) valueReference="(9|10)").*?/>', "", text)
    if refuses:
        place = f"binaries/{host().name}/ball{host().suffix}"
        return written(folder / "ball_refuses.fmu", text, place, library("ball3.c", "-DREFUSES"))
    file = folder / f"ball{'' if events else '_alone'}{'_clock' if clock else ''}{'_smooth' if smooth else ''}.fmu"
    return written(file, text, f"binaries/{host().name}/ball{host().suffix}", library("ball3.c"))


def mixed(folder: Path, *, name: str = "mixed", unit_in: str = "furlong", unit_out: str = "furlong") -> Path:
    """FMI 2.0: every type, faults on demand (`fault`, one of FAULTS, from t = `fault_at` on), units only it knows."""
    text = MIXED.replace("@IN@", unit_in).replace("@OUT@", unit_out)
    return written(folder / f"{name}.fmu", text, f"binaries/{host().folder}/mixed{host().suffix}", library("mixed2.c"))


def arrays(folder: Path, *, name: str = "arrays") -> Path:
    """FMI 3.0: arrays and every type."""
    return written(folder / f"{name}.fmu", ARRAYS, f"binaries/{host().name}/arrays{host().suffix}", library("arrays3.c"))


def written(file: Path, description: str, place: str, library: bytes) -> Path:
    """An FMU of a description and a library."""
    with zipfile.ZipFile(file, "w") as archive:
        archive.writestr("modelDescription.xml", description)
        archive.writestr(place, library)
    return file


@cache
def library(source: str, flags: str = "", more: str = "") -> bytes:
    """A file of c/, or two, compiled into one library for this machine."""
    sources = [one for one in (source, more) if one]
    spec = importlib.util.find_spec("fmpy")
    assert spec is not None
    assert spec.submodule_search_locations
    with tempfile.TemporaryDirectory() as scratch:
        for header in (Path(spec.submodule_search_locations[0]) / "c-code").glob("fmi*.h"):
            shutil.copy(header, scratch)
        for one in sources:
            shutil.copy(Path(__file__).parent / "c" / one, scratch)
        of = dict.fromkeys(sources, "-O1")
        (found,) = compile_libraries(Path(scratch), of, "small", {host(): True}, options=flags.split()).values()
    return found
