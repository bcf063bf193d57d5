"""FMUs that misbehave, built from c/hostile2.c: one library, and a file in each FMU that says how and where it does."""

import tempfile
import zipfile
from dataclasses import dataclass
from functools import cache
from pathlib import Path

from gyro_cosim import Connection, System, SystemComponent
from gyro_cosim.fmus.compiler import compile_libraries, host

STEPS, AT = 100, 50  # macro steps of system(), and the one in which it misbehaves at the hook `step`

_DESCRIPTION = """<?xml version="1.0" encoding="UTF-8"?>
<fmiModelDescription fmiVersion="2.0" modelName="hostile" guid="hostile">
  <CoSimulation modelIdentifier="hostile" canHandleVariableCommunicationStepSize="true"/>
  <ModelVariables>
    <ScalarVariable name="u" valueReference="0" causality="input"><Real start="0"/></ScalarVariable>
    <ScalarVariable name="y" valueReference="1" causality="output"><Real/></ScalarVariable>
  </ModelVariables>
  <ModelStructure><Outputs><Unknown index="2" dependencies=""/></Outputs></ModelStructure>
</fmiModelDescription>
"""


@dataclass(frozen=True)
class Kind:
    """How an FMU misbehaves, and what is right then.

    name : BEHAVIOUR@HOOK. ends : None where the run must end well with all results, else how many rows there are at least.
    beyond : why a process cannot survive it, in this process; empty where it can.
    """

    name: str
    ends: int | None
    beyond: str = ""


def build(folder: Path, kind: str) -> Path:
    """The FMU of a kind, in `folder`."""
    file = folder / f"{kind.replace('@', '-at-')}.fmu"
    with zipfile.ZipFile(file, "w") as members:
        members.writestr("modelDescription.xml", _DESCRIPTION)
        members.writestr(f"binaries/{host().folder}/hostile{host().suffix}", _library())
        members.writestr("resources/kind", kind)
    return file


def system(folder: Path, kind: str) -> System:
    """The FMU of a kind beside one that behaves, joined."""
    parts = (SystemComponent("bad", str(build(folder, kind))), SystemComponent("good", str(build(folder, "good@nowhere"))))
    wires = (Connection(("good", "y"), ("bad", "u")), Connection(("bad", "y"), ("good", "u")))
    return System("hostile", parts, wires, step=0.01, stop=0.01 * STEPS)


@cache
def _library() -> bytes:
    with tempfile.TemporaryDirectory() as scratch:
        source = Path(__file__).parent / "c" / "hostile2.c"
        (Path(scratch) / "hostile.c").write_bytes(source.read_bytes())
        options = ("-O1", "-w", "-std=gnu11", "-pthread")
        libraries = ("m", "dl", "pthread")
        made = compile_libraries(
            Path(scratch), {"hostile.c": "-O1"}, "hostile", {host(): True}, libraries=libraries, options=options
        )
        return made[host()]
