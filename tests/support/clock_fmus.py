"""FMUs of FMI 3.0 with clocks: c/clocks3.c, with an input clock of any kind, for Co-Simulation or Model Exchange."""

from pathlib import Path

import small_fmus

from gyro_cosim.fmus.compiler import host

FROM_PARAMETERS = "from parameters"  # fixed, and no interval is stated
KINDS = ("constant", "fixed", "tunable", "changing", "countdown", FROM_PARAMETERS)

DESCRIPTION = """<?xml version="1.0" encoding="UTF-8"?>
<fmiModelDescription fmiVersion="3.0" modelName="clocks" instantiationToken="clocks">
  @WAYS@
  <ModelVariables>
    <Float64 name="time" valueReference="0" causality="independent" variability="continuous"/>
    <Clock name="every" valueReference="1" causality="input" intervalVariability="@KIND@" @INTERVAL@/>
    <Clock name="go" valueReference="2" causality="input" intervalVariability="triggered"/>
    <Clock name="out" valueReference="3" causality="output" intervalVariability="triggered" clocks="1 2"/>
    <Float64 name="u" valueReference="4" causality="input" variability="discrete" start="0" clocks="2"/>
    <Float64 name="v" valueReference="5" causality="input" variability="discrete" start="1" clocks="1"/>
    <Int32 name="ticks" valueReference="6" causality="output" initial="exact" start="0" clocks="1"/>
    <Int32 name="goes" valueReference="7" causality="output" initial="exact" start="0" clocks="2"/>
    <Float64 name="sum" valueReference="8" causality="output" variability="discrete" initial="exact" start="0"/>
    <Float64 name="last" valueReference="9" causality="output" variability="discrete" initial="exact" start="0"/>
    <Float64 name="held" valueReference="10" causality="output" variability="discrete" initial="exact" start="0"/>
    <Binary name="letter" valueReference="11" causality="input" clocks="2"><Start value=""/></Binary>
    <Binary name="answer" valueReference="12" causality="output" clocks="3"/>
    <Int32 name="each" valueReference="13" causality="parameter" variability="fixed" start="2"/>
    <Float64 name="x" valueReference="14" causality="output" variability="continuous" initial="exact" start="0"/>
    <Float64 name="der(x)" valueReference="15" causality="local" variability="continuous" derivative="14"/>
    <Float64 name="interval" valueReference="16" causality="parameter" variability="tunable" start="0.1"/>
    <Int32 name="kind" valueReference="17" causality="parameter" variability="fixed" start="0"/>
    <Float64 name="plain" valueReference="18" causality="input" variability="continuous" start="0"/>
  </ModelVariables>
  <ModelStructure>
    <Output valueReference="3"/><Output valueReference="6" dependencies=""/><Output valueReference="7" dependencies=""/>
    <Output valueReference="8" dependencies=""/><Output valueReference="9" dependencies=""/>
    <Output valueReference="10" dependencies=""/><Output valueReference="12" dependencies=""/>
    <Output valueReference="14" dependencies=""/>
    <ContinuousStateDerivative valueReference="15" dependencies="10"/>
    <InitialUnknown valueReference="15" dependencies=""/>
  </ModelStructure>
</fmiModelDescription>
"""


def clocks(
    folder: Path, kind: str = "constant", *, exchange: bool = False, variable: bool = True, events_only: bool = False
) -> Path:
    """An FMU whose clock `every` is of a kind, one of KINDS; its place in there must be given to the parameter `kind`.

    exchange : by Model Exchange. variable : its communication steps may vary. events_only : by both, where Co-Simulation wants
    event mode.
    """
    can = 'modelIdentifier="clocks" canGetAndSetFMUState="true" canSerializeFMUState="true"'
    able = f'canHandleVariableCommunicationStepSize="{str(variable).lower()}" hasEventMode="true"'
    ways = [f"<ModelExchange {can}/>"] * (exchange or events_only) + [f"<CoSimulation {can} {able}/>"] * (not exchange)
    stated = {"constant": 'intervalDecimal="0.1"', "tunable": 'intervalDecimal="0.1"'}
    interval = {**stated, "fixed": 'intervalDecimal="0.1" shiftDecimal="0.05"'}.get(kind, "")
    text = DESCRIPTION.replace("@WAYS@", "".join(ways)).replace("@INTERVAL@", interval)
    text = text.replace("@KIND@", "fixed" if kind == FROM_PARAMETERS else kind)
    of = f"{kind.replace(' ', '_')}{'_exchange' if exchange else ''}{'' if variable else '_even'}{'_events' * events_only}"
    file = folder / f"clocks_{of}.fmu"
    place = f"binaries/{host().name}/clocks{host().suffix}"
    library = small_fmus.library("clocks3.c", "-DEVENTS_ONLY" if events_only else "", more="rest3.c")
    return small_fmus.written(file, text, place, library)
