"""The other end: offers a slave to a master over a stream, until that one leaves. See protocol.py for the frames."""

import json
import socket
import struct
import sys
from dataclasses import fields
from typing import Any

from ...errors import EndRequest, RunError
from .. import open_slave
from ..base import Signal, Slave
from . import child
from .protocol import Kind, Link, ProtocolError, array, document, numbers

CARRIED = ("name", "kind", "unit", "start", "min", "max", "meaning", "smooth", "type")


def carried(signal_: Signal) -> dict[str, Any]:
    """A signal as HELLO tells it."""
    known = {f.name for f in fields(signal_)}
    return {name: getattr(signal_, name) for name in CARRIED if name in known}


def introduction(slave: Slave) -> dict[str, Any]:
    """What HELLO is answered with."""
    initial = slave.feedthrough if slave.initial_feedthrough is None else slave.initial_feedthrough
    return {
        "inputs": [carried(s) for s in slave.inputs], "outputs": [carried(s) for s in slave.outputs],
        "settable": [carried(s) for s in slave.settable.values()], "feedthrough": slave.feedthrough.astype(int).tolist(),
        "initial_feedthrough": initial.astype(int).tolist(), "input_degree": slave.input_degree,
        "can_restore": slave.can_restore, "initialization": True,
    }  # fmt: skip


def serve(slave: Slave, link: Link) -> None:
    """Answer a master until it says BYE or is gone. The slave stays open."""
    failed, ended = "", b""
    snapshots: dict[int, Any] = {}
    count = 0
    while True:
        try:
            kind, sequence, payload = link.receive()
        except (EOFError, OSError, ProtocolError):
            return
        if kind == Kind.BYE:
            return
        answer = b""
        try:
            if kind in (Kind.START, Kind.BEGIN):
                failed, ended = "", b""
                given = document(payload)
                values = {n: tuple(v) if isinstance(v, list) else v for n, v in given["values"].items()}
                begin = slave.initialize if kind == Kind.START else slave.begin
                begin(values, float(given["t"]), float(given["stop"]))
            elif failed or ended:
                pass
            elif kind == Kind.FINISH:
                slave.finish()
            elif kind == Kind.HELLO:
                answer = json.dumps(introduction(slave)).encode()
            elif kind == Kind.OUTPUT:
                t, *u = array(payload, 1 + len(slave.inputs))
                answer = numbers(slave.output(array(numbers(u), len(slave.inputs)), float(t)))
            elif kind == Kind.STEP:
                whole = array(payload, 2 + 3 * len(slave.inputs))
                slave.step(whole[2:].reshape(3, -1), float(whole[0]), float(whole[1]))
            elif kind == Kind.SAVE:
                count += 1
                snapshots[count] = slave.save()
                answer = struct.pack("<Q", count)
            elif kind == Kind.RESTORE:
                slave.restore(snapshots[struct.unpack("<Q", payload)[0]])
            elif kind == Kind.DISCARD:
                slave.discard(snapshots.pop(struct.unpack("<Q", payload)[0]))
        except EndRequest as request:
            ended = numbers(request.t)
        except (RunError, ValueError, KeyError, struct.error) as error:
            failed = str(error)
        if kind == Kind.STEP:
            continue
        try:
            told = (Kind.ERROR, failed.encode()) if failed else (Kind.END, ended) if ended else (Kind.OK, answer)
            link.send(told[0], sequence, told[1])
        except OSError:
            return


def listen(slave: Slave, address: tuple[str, int], *, once: bool = False, ready: Any = None) -> None:
    """Offer the slave at (host, port) to one master after another; `ready` is called with the port that was taken."""
    with socket.create_server(address) as server:
        if ready is not None:
            ready(server.getsockname()[1])
        while True:
            stream, _ = server.accept()
            link = Link(stream)
            try:
                serve(slave, link)
            finally:
                link.close()
            if once:
                return


def main(source: str, descriptor: int) -> None:
    """The child of gyro_cosim.slaves.processes.remote: serves on an inherited socket."""
    link = Link(socket.socket(fileno=descriptor))
    try:
        slave = open_slave("unit", source, in_process=True)
    except Exception as error:  # whatever is wrong with the unit, the master shall hear of it
        _, sequence, _ = link.receive()
        link.send(Kind.ERROR, sequence, str(error).encode())
        return
    try:
        serve(slave, link)
    finally:
        slave.close()


if __name__ == "__main__":
    if child.belongs():
        main(sys.argv[1], int(sys.argv[2]))
