"""FMUs that promise more than they keep, as other tools' do; see c/vendor2.c and c/vendor1.c."""

import re
from pathlib import Path

from small_fmus import library, written

from gyro_cosim.fmus.compiler import host

OUTPUTS = ("tolerance", "stop", "revocable", "shortest", "longest")
PARAMETERS = {"accepts": 2, "newstep": 0, "stateless": 0, "answer": 0, "pending": 0, "start": 0}
ABLE = {
    "canInterpolateInputs": "true", "canHandleVariableCommunicationStepSize": "true", "canGetAndSetFMUstate": "true",
}  # fmt: skip


def vendor2(folder: Path, *, name: str = "vendor", flags: str = "", default: str = "", **able: str) -> Path:
    """FMI 2.0: an integrator whose promises are ABLE and `able`, and whose parameters say which it breaks.

    default : its DefaultExperiment's tolerance.
    flags : -DONCE, it can be instantiated once per process only; -DLICENCE, it misses its licence.
    """
    promises = " ".join(f'{key}="{value}"' for key, value in {**ABLE, **able}.items())
    experiment = f'<DefaultExperiment tolerance="{default}"/>' if default else ""
    variables = ['<ScalarVariable name="u" valueReference="0" causality="input"><Real start="0"/></ScalarVariable>',
                 '<ScalarVariable name="y" valueReference="1" causality="output"><Real/></ScalarVariable>']  # fmt: skip
    variables += [
        f'<ScalarVariable name="{n}" valueReference="{k}" causality="parameter" variability="fixed"><Real start="{start}"/>'
        "</ScalarVariable>"
        for k, (n, start) in enumerate(PARAMETERS.items(), 2)
    ]
    first = 2 + len(PARAMETERS)
    variables += [
        f'<ScalarVariable name="{n}" valueReference="{k}" causality="output"><Real/></ScalarVariable>'
        for k, n in enumerate(OUTPUTS, first)
    ]
    unknowns = "".join(f'<Unknown index="{k}" dependencies=""/>' for k in (2, *range(first + 1, first + 1 + len(OUTPUTS))))
    text = f"""<?xml version="1.0" encoding="UTF-8"?>
<fmiModelDescription fmiVersion="2.0" modelName="vendor" guid="vendor" generationTool="A vendor's tool">
  <CoSimulation modelIdentifier="vendor" {promises}/>{experiment}
  <ModelVariables>{"".join(variables)}</ModelVariables>
  <ModelStructure><Outputs>{unknowns}</Outputs></ModelStructure>
</fmiModelDescription>
"""
    place = f"binaries/{host().folder}/vendor{host().suffix}"
    return written(folder / f"{name}.fmu", text, place, library("vendor2.c", flags))


VENDOR_1 = """<?xml version="1.0" encoding="UTF-8"?>
<fmiModelDescription fmiVersion="1.0" modelName="vendor" modelIdentifier="vendor" guid="vendor" numberOfContinuousStates="0"
    numberOfEventIndicators="0">
  <UnitDefinitions><BaseUnit unit="rad/s"/></UnitDefinitions>
  <TypeDefinitions><Type name="Gear"><EnumerationType><Item name="low"/><Item name="high"/></EnumerationType></Type>
  </TypeDefinitions>
  <DefaultExperiment startTime="0" stopTime="1"/>
  <ModelVariables>
    <ScalarVariable name="u" valueReference="0" causality="input"><Real start="0" unit="rad/s"/></ScalarVariable>
    <ScalarVariable name="y" valueReference="1" causality="output"><Real/><DirectDependency/></ScalarVariable>
    <ScalarVariable name="minus_y" valueReference="1" causality="output" alias="negatedAlias"><Real/><DirectDependency/>
    </ScalarVariable>
    <ScalarVariable name="gain" valueReference="2" variability="parameter"><Real start="1"/></ScalarVariable>
    <ScalarVariable name="loss" valueReference="2" variability="parameter" alias="negatedAlias"><Real start="-1"/>
    </ScalarVariable>
    <ScalarVariable name="start" valueReference="3" variability="parameter"><Real start="0"/></ScalarVariable>
    <ScalarVariable name="told" valueReference="4" causality="output"><Real/><DirectDependency/></ScalarVariable>
    <ScalarVariable name="stop" valueReference="5" causality="output"><Real/><DirectDependency/></ScalarVariable>
    <ScalarVariable name="answer" valueReference="2" variability="parameter"><Integer start="0"/></ScalarVariable>
    <ScalarVariable name="text" valueReference="0" variability="parameter"><String start="it stopped"/></ScalarVariable>@OTHERS@
  </ModelVariables>
  <Implementation><CoSimulation_StandAlone><Capabilities @ABLE@/></CoSimulation_StandAlone></Implementation>
</fmiModelDescription>
"""
OTHERS_1 = """
    <ScalarVariable name="add" valueReference="0" variability="discrete" causality="input"><Integer start="3"/></ScalarVariable>
    <ScalarVariable name="count" valueReference="1" variability="discrete" causality="output"><Integer/>
      <DirectDependency><Name>add</Name></DirectDependency></ScalarVariable>
    <ScalarVariable name="gear" valueReference="0" variability="discrete" causality="internal"><Enumeration declaredType="Gear"/>
    </ScalarVariable>
    <ScalarVariable name="on" valueReference="0" variability="discrete" causality="input"><Boolean start="true"/></ScalarVariable>
    <ScalarVariable name="on_out" valueReference="1" variability="discrete" causality="output"><Boolean/>
      <DirectDependency><Name>on</Name></DirectDependency></ScalarVariable>
    <ScalarVariable name="off" valueReference="1" variability="discrete" causality="output" alias="negatedAlias"><Boolean/>
      <DirectDependency><Name>on</Name></DirectDependency></ScalarVariable>"""


def vendor1(folder: Path, *, name: str = "vendor1", others: bool = False, negated: bool = True, **able: str) -> Path:
    """FMI 1.0: an integrator, see c/vendor1.c. `others`: with integers and truth values. `negated`: with negated aliases."""
    able = {"canHandleVariableCommunicationStepSize": "true", "canInterpolateInputs": "true"} | able
    text = VENDOR_1.replace("@ABLE@", " ".join(f'{key}="{value}"' for key, value in able.items()))
    text = text.replace("@OTHERS@", OTHERS_1 if others else "")
    if not negated:
        turned = r' *<ScalarVariable name="\w+" valueReference="\d" [^>]*negatedAlias".*?</ScalarVariable>'
        text = re.sub(turned, "", text, flags=re.DOTALL)
    place = f"binaries/{host().folder}/vendor{host().suffix}"
    return written(folder / f"{name}.fmu", text, place, library("vendor1.c"))
