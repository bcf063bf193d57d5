"""FMUs for Model Exchange only: the hopper of c/hopper.c in both versions, and one of our own as others may export it."""

import re
import zipfile
from pathlib import Path

import small_fmus

from gyro_cosim.fmus.compiler import host

# name, type, causality, variability, start; value references count from 1, 0 is the time
ROWS = (
    ("h", "Real", "output", "continuous", "1"), ("v", "Real", "output", "continuous", "0"),
    ("speck", "Real", "output", "continuous", "1e-6"), ("der(h)", "Real", "local", "continuous", ""),
    ("der(v)", "Real", "local", "continuous", ""), ("der(speck)", "Real", "local", "continuous", ""),
    ("u", "Real", "input", "continuous", "0"), ("e", "Real", "parameter", "fixed", "0.7"),
    ("period", "Real", "parameter", "fixed", "0"), ("last", "Integer", "parameter", "fixed", "0"),
    ("every", "Integer", "parameter", "fixed", "0"), ("fault", "Integer", "parameter", "fixed", "0"),
    ("kick", "Integer", "input", "discrete", "0"), ("impacts", "Integer", "output", "discrete", ""),
    ("ticks", "Integer", "output", "discrete", ""), ("nudges", "Integer", "output", "discrete", ""),
    ("above", "Integer", "output", "discrete", ""),
)  # fmt: skip
OUTPUTS = [k for k, row in enumerate(ROWS, 1) if row[2] == "output"]
RATES = (4, 5, 6)


def hopper(folder: Path, version: int, *, restores: bool = True, hears: bool = True, tolerance: float | None = 1e-9) -> Path:
    """FMI 2.0 or 3.0. restores : it says that it can save its state. hears : it wants to hear of steps of the integrator."""
    experiment = "" if tolerance is None else f'<DefaultExperiment tolerance="{tolerance}"/>'
    text = (_two if version == 2 else _three)(str(restores).lower(), hears, experiment)
    place = host().folder if version == 2 else host().name
    file = folder / f"hopper{version}{'' if restores else '_fixed'}{'' if hears else '_deaf'}.fmu"
    return small_fmus.written(file, text, f"binaries/{place}/hopper{host().suffix}", small_fmus.library("hopper.c"))


def _two(restores: str, hears: bool, experiment: str) -> str:
    variables = []
    for k, (name, kind, causality, variability, start) in enumerate(ROWS, 1):
        derivative = f' derivative="{k - 3}"' if k in RATES else ""
        stated = f' start="{start}"' if start else ""
        initial = ' initial="exact"' if start and causality == "output" else ""
        about = f'name="{name}" valueReference="{k}" causality="{causality}" variability="{variability}"{initial}'
        variables.append(f"<ScalarVariable {about}><{kind}{stated}{derivative}/></ScalarVariable>")
    outputs, rates = ("".join(f'<Unknown index="{k}" dependencies=""/>' for k in places) for places in (OUTPUTS, RATES))
    return f"""<fmiModelDescription fmiVersion="2.0" modelName="hopper" guid="hopper" numberOfEventIndicators="2">
<ModelExchange modelIdentifier="hopper" canGetAndSetFMUstate="{restores}"
  completedIntegratorStepNotNeeded="{str(not hears).lower()}"/>
<LogCategories><Category name="logStatusError"/></LogCategories>{experiment}
<ModelVariables>{"".join(variables)}</ModelVariables>
<ModelStructure><Outputs>{outputs}</Outputs><Derivatives>{rates}</Derivatives></ModelStructure></fmiModelDescription>"""


def _three(restores: str, hears: bool, experiment: str) -> str:
    kinds = {"Real": "Float64", "Integer": "Int32"}
    variables = ['<Float64 name="time" valueReference="0" causality="independent" variability="continuous"/>']
    for k, (name, kind, causality, variability, start) in enumerate(ROWS, 1):
        derivative = f' derivative="{k - 3}"' if k in RATES else ""
        stated = f' start="{start}"' if start else ""
        initial = ' initial="exact"' if start and causality == "output" else ""
        about = f'name="{name}" valueReference="{k}" causality="{causality}" variability="{variability}"{initial}'
        variables.append(f"<{kinds[kind]} {about}{stated}{derivative}/>")
    variables.append('<Float64 name="z" valueReference="30" causality="local"><Dimension start="2"/></Float64>')
    rows = [f'<Output valueReference="{k}" dependencies=""/>' for k in OUTPUTS]
    rows += [f'<ContinuousStateDerivative valueReference="{k}" dependencies=""/>' for k in RATES]
    rows.append('<EventIndicator valueReference="30"/>')
    return f"""<fmiModelDescription fmiVersion="3.0" modelName="hopper" instantiationToken="hopper">
<ModelExchange modelIdentifier="hopper" canGetAndSetFMUState="{restores}" needsCompletedIntegratorStep="{str(hears).lower()}"/>
<LogCategories><Category name="logStatusError"/></LogCategories>{experiment}
<ModelVariables>{"".join(variables)}</ModelVariables>
<ModelStructure>{"".join(rows)}</ModelStructure></fmiModelDescription>"""


def without(fmu: Path, file: Path, *attributes: str) -> Path:
    """A copy of an FMU whose description lacks these attributes, and Co-Simulation."""
    with zipfile.ZipFile(fmu) as source, zipfile.ZipFile(file, "w") as target:
        for name in source.namelist():
            data = source.read(name)
            if name == "modelDescription.xml":
                text = re.sub(r"<CoSimulation\b([^>]*/>|.*?</CoSimulation>)", "", data.decode(), flags=re.S)
                for attribute in attributes:
                    text = re.sub(rf'\s{attribute}="[^"]*"', "", text)
                data = text.encode()
            target.writestr(name, data)
    return file
