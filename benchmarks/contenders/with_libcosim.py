"""libcosim, through its Python package libcosimpy: its fixed-step algorithm, which is Jacobi with held inputs."""

from case import answer, asked, timed
from libcosimpy.CosimEnums import CosimVariableType
from libcosimpy.CosimExecution import CosimExecution
from libcosimpy.CosimObserver import CosimObserver
from libcosimpy.CosimSlave import CosimLocalSlave


def main() -> None:
    """Logging: its time-series observer, in memory."""
    case = asked()
    execution = CosimExecution.from_step_size(step_size=round(case.step * 1e9))  # it counts in nanoseconds
    slaves = {name: CosimLocalSlave(fmu_path=path, instance_name=name) for name, path in case.fmus.items()}
    place = {name: execution.add_local_slave(slave) for name, slave in slaves.items()}
    reference = {name: {v.name.decode(): v.reference for v in execution.slave_variables(index)} for name, index in place.items()}
    for a, out, b, into in case.connections:
        if execution.connect_real_variables(place[a], reference[a][out], place[b], reference[b][into]) != 0:
            raise RuntimeError(f"{a}.{out} cannot be connected to {b}.{into}")
    last = CosimObserver.create_last_value()
    execution.add_observer(observer=last)
    if case.log:
        series = CosimObserver.create_time_series(buffer_size=case.steps + 1)
        execution.add_observer(observer=series)
        for name, outs in case.outputs.items():
            for out in outs:
                series.start_time_series(place[name], reference[name][out], CosimVariableType.REAL)

    def loop() -> None:
        if not execution.step(case.steps - 1):
            raise RuntimeError("a step failed")

    execution.step(1)  # loads and initializes
    seconds = timed(loop) * case.steps / (case.steps - 1)
    end = {
        f"{name}.{out}": value
        for name, outs in case.outputs.items()
        for out, value in zip(outs, last.last_real_values(place[name], [reference[name][o] for o in outs]), strict=True)
    }
    answer(seconds, end)


main()
