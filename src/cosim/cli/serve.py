"""cosim serve: offer a component or an FMU to a master elsewhere."""

from typing import Annotated

import typer

from .common import console


def command(
    source: Annotated[str, typer.Argument(metavar="COMPONENT", help="such as gyro_unit:nonlinear, a .py file or an .fmu file")],
    port: Annotated[int, typer.Option(help="TCP port; 0 takes a free one")] = 0,
    host: Annotated[str, typer.Option(help="address to listen at; the default is for this machine alone")] = "127.0.0.1",
    once: Annotated[bool, typer.Option("--once", help="end after the first master")] = False,
    fmu: Annotated[bool, typer.Option("--fmu", help="run a component of the catalogue as an FMU")] = False,
) -> int:
    """Wait for masters that run a system with tcp://HOST:PORT in the place of a component, one after another.

    There is no encryption and no password: let other machines reach it only in a network that you trust.
    """
    from ..slaves import open_slave
    from ..slaves.processes.serving import listen

    if not 0 <= port < 65536:
        raise ValueError(f"--port must be 0 to 65535, got {port}")
    slave = open_slave("unit", source, in_process=not fmu)
    try:
        listen(
            slave, (host, port), once=once,
            ready=lambda taken: console().print(f"{source} is at tcp://{host}:{taken}"),
        )  # fmt: skip
    finally:
        slave.close()
    return 0
