"""Ecos, through its Python package ecospy: its fixed-step algorithm, which is Jacobi with held inputs."""

import ctypes
import sys
import tempfile
from pathlib import Path

from case import answer, asked, timed


def load_threads() -> None:
    """Load the library that Ecos needs and does not bring, from the package `tbb` if the machine has none of its own."""
    for file in (Path(sys.prefix) / "lib" / "libtbb.so.12", Path("libtbb.so.12")):
        try:
            ctypes.CDLL(str(file), mode=ctypes.RTLD_GLOBAL)
        except OSError:
            continue
        return


def main() -> None:
    """Logging: its CSV writer, the only one it has."""
    case = asked()
    load_threads()
    from ecospy import EcosSimulation, EcosSimulationStructure

    with tempfile.TemporaryDirectory() as scratch, EcosSimulationStructure() as structure:
        for name, path in case.fmus.items():
            structure.add_model(name, path)
        for a, out, b, into in case.connections:
            structure.make_real_connection(f"{a}::{out}", f"{b}::{into}")
        with EcosSimulation(structure=structure, step_size=case.step) as simulation:
            if case.log:
                names = [f"{name}::{out}" for name, outs in case.outputs.items() for out in outs]
                simulation.add_csv_writer(str(Path(scratch) / "log.csv"), identifiers=names)
            simulation.init()
            seconds = timed(lambda: simulation.step(case.steps))
            end = {f"{n}.{out}": simulation.get_real(f"{n}::{out}") for n, outs in case.outputs.items() for out in outs}
            simulation.terminate()
    answer(seconds, end)


main()
