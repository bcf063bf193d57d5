"""FMUs that promise more than they keep, as other tools' do; see c/vendor2.c and c/vendor1.c."""

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
