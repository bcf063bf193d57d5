"""Who may speak to a unit, where a network is not trusted: TLS of the standard library, and a secret that both sides know.

With a secret the unit sends CHALLENGE with 32 random bytes; the master answers PROVE with 32 of its own and HMAC-SHA256 of both
under the secret; OK brings the unit's HMAC over them, so that the master, too, knows who answers. The secret itself never
crosses the network. What follows is authentic only with TLS, which also hides it.
"""

import contextlib
import hmac
import secrets
import socket
import ssl
from dataclasses import dataclass
from pathlib import Path

from .protocol import Kind, Link, ProtocolError

__all__ = ["Admission", "read_secret"]

WANTED = b"must be asked with the secret that it knows: tcp://HOST:PORT?secret=FILE"
NONCE, SHORTEST = 32, 16  # bytes of a challenge, and of a secret at least
PATIENCE = 10.0  # s that a handshake may take
LARGEST = 1 << 24  # bytes of a frame


@dataclass(frozen=True)
class Admission:
    """What a stream must pass before the first frame of a run: nothing, where both are None."""

    secret: bytes | None = None
    context: ssl.SSLContext | None = None

    def admit(self, stream: socket.socket) -> Link:
        """The unit's side. OSError, EOFError or ProtocolError where the other end does not pass."""
        stream.settimeout(PATIENCE)
        link = Link(stream if self.context is None else self.context.wrap_socket(stream, server_side=True), LARGEST)
        if self.secret is not None:
            ours = secrets.token_bytes(NONCE)
            link.send(Kind.CHALLENGE, 0, ours, PATIENCE)
            kind, sequence, answer = link.receive(PATIENCE)
            theirs, proof = answer[:NONCE], answer[NONCE:]
            if kind != Kind.PROVE or not hmac.compare_digest(proof, _proof(self.secret, b"master", ours, theirs)):
                with contextlib.suppress(OSError):
                    link.send(Kind.ERROR, sequence, WANTED, PATIENCE)
                raise ProtocolError("the secret is not known there")
            link.send(Kind.OK, sequence, _proof(self.secret, b"unit", ours, theirs), PATIENCE)
        return link

    def enter(self, stream: socket.socket, host: str) -> Link:
        """The master's side; ProtocolError says what is wrong."""
        stream.settimeout(PATIENCE)
        link = Link(stream if self.context is None else self.context.wrap_socket(stream, server_hostname=host))
        if self.secret is None:
            return link
        kind, _, theirs = link.receive(PATIENCE)
        if kind == Kind.ERROR:
            raise ProtocolError(theirs.decode(errors="replace"))
        if kind != Kind.CHALLENGE or len(theirs) != NONCE:
            raise ProtocolError("it does not ask for the secret that was given")
        ours = secrets.token_bytes(NONCE)
        link.send(Kind.PROVE, 0, ours + _proof(self.secret, b"master", theirs, ours), PATIENCE)
        kind, _, proof = link.receive(PATIENCE)
        if kind != Kind.OK or not hmac.compare_digest(proof, _proof(self.secret, b"unit", theirs, ours)):
            raise ProtocolError("it does not know the secret")
        return link


def read_secret(file: Path) -> bytes:
    """The secret in a file; ValueError where it is too short to be one."""
    try:
        secret = file.read_bytes().strip()
    except OSError as error:
        raise ValueError(f"secret {str(file)!r} must be a file that can be read: {error.strerror}") from None
    if len(secret) < SHORTEST:
        raise ValueError(f"secret {str(file)!r} must have at least {SHORTEST} bytes, has {len(secret)}")
    return secret


def _proof(secret: bytes, who: bytes, first: bytes, second: bytes) -> bytes:
    return hmac.digest(secret, who + first + second, "sha256")
