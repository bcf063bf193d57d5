"""cosim serve: offer a component or an FMU to a master elsewhere."""

import ssl
import sys
from pathlib import Path
from typing import Annotated

import typer

from .alone import given_alone
from .common import AsJson, Parameters, Values, console, needs, say, seconds


def command(
    source: Annotated[str, typer.Argument(metavar="COMPONENT", help="such as gyro_unit:nonlinear, a .py file or an .fmu file")],
    port: Annotated[int, typer.Option(help="TCP port; 0 takes a free one")] = 0,
    host: Annotated[str, typer.Option(help="address to listen at; the default is for this machine alone")] = "127.0.0.1",
    once: Annotated[bool, typer.Option("--once", help="end after the first master")] = False,
    fmu: Annotated[bool, typer.Option("--fmu", help="run a component of the catalogue as an FMU")] = False,
    longest: Annotated[str, typer.Option(metavar="TIME", help="the longest step that a master may ask for")] = "10 s",
    idle: Annotated[str, typer.Option(metavar="TIME", help="how long a master may be silent")] = "10 min",
    secret: Annotated[
        Path | None, typer.Option(metavar="FILE", help="serve only who knows the secret in this file, of at least 16 bytes")
    ] = None,
    certificate: Annotated[Path | None, typer.Option(metavar="FILE", help="speak TLS with this certificate (PEM)")] = None,
    key: Annotated[Path | None, typer.Option(metavar="FILE", help="its private key (PEM)")] = None,
    set_: Values = None,
    params: Parameters = None,
    as_json: AsJson = False,
) -> int:
    """Wait for masters that run a system with tcp://HOST:PORT in the place of a component, one after another.

    Without --secret whoever reaches the port is served; without --certificate all can be read on the way. The values of --set and
    --params count where a master gives none.
    """
    from ..slaves import open_slave
    from ..slaves.processes.admission import Admission, read_secret
    from ..slaves.processes.listening import listen
    from ..slaves.processes.serving import Limits

    if not 0 <= port < 65536:
        raise ValueError(f"--port must be 0 to 65535, got {port}")
    limits = Limits(idle=seconds(idle, "--idle"), longest=seconds(longest, "--longest"))
    needs("--key", key, "--certificate", certificate is not None)
    admission = Admission(None if secret is None else read_secret(secret), _context(certificate, key))
    values = given_alone(source, set_, params)
    slave = open_slave("unit", source, in_process=not fmu, values=values)

    def ready(taken: int) -> None:
        if as_json:
            say(True, lambda: {"component": source, "host": host, "port": taken, "source": f"tcp://{host}:{taken}"})
            sys.stdout.flush()
        else:
            console().print(f"{source} is at tcp://{host}:{taken}")

    try:
        listen(slave, (host, port), once=once, ready=ready, limits=limits, admission=admission, values=values)
    finally:
        slave.close()
    return 0


def _context(certificate: Path | None, key: Path | None) -> ssl.SSLContext | None:
    if certificate is None:
        return None
    context = ssl.SSLContext(ssl.PROTOCOL_TLS_SERVER)
    context.minimum_version = ssl.TLSVersion.TLSv1_2
    try:
        context.load_cert_chain(certificate, key)
    except (OSError, ssl.SSLError) as error:
        raise ValueError(f"certificate {str(certificate)!r} and its key must be PEM files: {error}") from None
    return context
