"""FMPy: a plain Python loop over its FMU2Slave, which is how its users couple FMUs."""

import shutil

from case import answer, asked, timed
from fmpy import extract, read_model_description
from fmpy.fmi2 import FMU2Slave


def main() -> None:
    """Jacobi, or Gauss-Seidel in the order of the FMUs."""
    case = asked()
    folders = {name: extract(path) for name, path in case.fmus.items()}
    slaves, reference = {}, {}
    for name, folder in folders.items():
        description = read_model_description(folder)
        reference[name] = {v.name: v.valueReference for v in description.modelVariables}
        slave = slaves[name] = FMU2Slave(
            guid=description.guid, modelIdentifier=description.coSimulation.modelIdentifier, unzipDirectory=folder,
            instanceName=name,
        )  # fmt: skip
        slave.instantiate()
        slave.setupExperiment(startTime=0.0, stopTime=case.stop)
        slave.enterInitializationMode()
        slave.exitInitializationMode()
    wires = [(slaves[a], [reference[a][out]], slaves[b], [reference[b][into]], a) for a, out, b, into in case.connections]
    outputs = [(slaves[name], [reference[name][out] for out in outs]) for name, outs in case.outputs.items()]
    logged: list[list[float]] = []

    def jacobi() -> None:
        stepped = list(slaves.values())
        for n in range(case.steps):
            for source, out, target, into, _ in wires:
                target.setReal(into, source.getReal(out))
            for slave in stepped:
                slave.doStep(n * case.step, case.step)
            if case.log:
                logged.append([value for slave, refs in outputs for value in slave.getReal(refs)])

    def gauss_seidel() -> None:
        order = [(slave, [w[:4] for w in wires if w[4] == name]) for name, slave in slaves.items()]
        for source, out, target, into, _ in wires:
            target.setReal(into, source.getReal(out))
        for n in range(case.steps):
            for slave, leaving in order:
                slave.doStep(n * case.step, case.step)
                for source, out, target, into in leaving:
                    target.setReal(into, source.getReal(out))
            if case.log:
                logged.append([value for slave, refs in outputs for value in slave.getReal(refs)])

    seconds = timed(gauss_seidel if case.algorithm == "gauss-seidel" else jacobi)
    answer(seconds, dict(zip(case.names(), (v for slave, refs in outputs for v in slave.getReal(refs)), strict=True)))
    for slave in slaves.values():
        slave.terminate()
        slave.freeInstance()
    for folder in folders.values():
        shutil.rmtree(folder)


main()
