"""Frames between a master and a unit in another process or machine: a header, then numbers or a JSON document.

    header   4s magic b"GCRU", u8 version 1, u8 kind, u16 0, u32 length, u64 sequence; little-endian
    numbers  f64, little-endian

| kind | request payload | answer payload |
|---|---|---|
| HELLO | - | JSON: inputs, outputs, settable (lists of signals), feedthrough (rows of 0 and 1), input_degree, can_restore, ... |
| START | JSON: values, t, stop | - |
| BEGIN | as START | - |
| FINISH | - | - |
| OUTPUT | t, u (n_u) | y (n_y) |
| STEP | t, h, U (3 n_u, row by row) | no answer; what went wrong is the answer to the next request |
| SAVE | - | u64 number of the snapshot |
| RESTORE, DISCARD | u64 number | - |
| BYE | - | no answer; the unit closes |

A unit that says `messages` true in HELLO can be asked and told more, between BEGIN and the end (messages.py):

| kind | request payload | answer payload |
|---|---|---|
| TUNE | JSON: values, t | - |
| TEXTS | JSON: t | JSON: strings and binaries by name |
| GIVE_TEXTS | JSON: values, t | 1 where one is another than before, else 0 |
| EXPECT | JSON: ticks (lists of t, clocks, y, u, texts) | - |
| TAKE_TICKS | - | JSON: ticks |

An FMU in a process of its own (isolated.py) knows all this and more, and tells what it logs before the answer:

| kind | request payload | answer payload |
|---|---|---|
| OPEN | JSON: name, location | as HELLO |
| PROMISE | JSON: usage (of usage.py), values, t, stop | as HELLO, and notes (texts) |
| SERIALIZE | - | the state |
| DESERIALIZE | the state | - |
| LINEARISE | - | n_x, n_u, n_y, then A, B, C, D row by row; nothing where there is none |
| LOG | - | comes by itself: JSON: lines (lists of status, category, text), dropped (their number) |

START makes a unit ready for steps. A unit that has an initialization mode says so in HELLO with `initialization` true, and with
`initial_feedthrough` what depends on what there; it gets BEGIN, then OUTPUT at t until all components agree, then FINISH.

An answer has the kind OK, ERROR with text, or END with t where the unit asks to end the run, and the sequence number of its
request, so that one that comes too late is known. Plain sockets of the standard library: one stream between two ends needs no
more, any device can speak it (no pickle, no Python on the other side), nothing runs in a thread of its own, and a question and
its answer cost some 20 us on one machine.
"""

import json
import socket
import struct
import time
from enum import IntEnum
from math import inf
from typing import Any

import numpy as np

MAGIC, VERSION = b"GCRU", 1
HEADER = struct.Struct("<4sBBHIQ")
LONGEST = 1 << 24  # bytes of a payload
WHOLE_WITHIN = 10.0  # s that the rest of a frame may take, once its first byte is there
DIGITS = 20  # of a whole number in JSON


class Kind(IntEnum):
    """What a frame is."""

    HELLO = 1
    START = 2
    OUTPUT = 3
    STEP = 4
    SAVE = 5
    RESTORE = 6
    DISCARD = 7
    BYE = 8
    BEGIN = 9
    FINISH = 10
    OPEN = 11
    SERIALIZE = 12
    DESERIALIZE = 13
    LINEARISE = 14
    TUNE = 15
    TEXTS = 16
    GIVE_TEXTS = 17
    CHALLENGE = 18
    PROVE = 19
    PROMISE = 20
    EXPECT = 21
    TAKE_TICKS = 22
    OK = 100
    ERROR = 101
    END = 102
    LOG = 103


_VALUES = frozenset(Kind)


class ProtocolError(ValueError):
    """What came is no frame."""


class Link:
    """One end of a stream. Late bytes are kept, so that a wait that timed out can be taken up again.

    longest : bytes of a payload; a frame that announces more is none.
    """

    def __init__(self, stream: socket.socket, longest: int = LONGEST) -> None:
        self.stream, self._longest = stream, longest
        if stream.family in (socket.AF_INET, socket.AF_INET6):
            stream.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
        self._buffer = bytearray()

    def send(self, kind: Kind, sequence: int, payload: bytes = b"", timeout: float | None = None) -> None:
        """OSError where the other end is gone, TimeoutError where it takes nothing for `timeout` (s)."""
        self.stream.settimeout(timeout)
        self.stream.sendall(HEADER.pack(MAGIC, VERSION, kind, 0, len(payload), sequence) + payload)

    def receive(self, timeout: float | None = None) -> tuple[Kind, int, bytes]:
        """The next frame; TimeoutError after `timeout` (s), EOFError where the other end is gone, ProtocolError for no frame.

        A frame that has begun must be whole within WHOLE_WITHIN, or it is none.
        """
        end = None if timeout is None else time.perf_counter() + timeout
        self._fill(1, end)
        whole = time.perf_counter() + WHOLE_WITHIN
        self._fill(HEADER.size, end, whole)
        header = bytes(self._buffer[: HEADER.size])
        magic, version, kind, _, length, sequence = HEADER.unpack(header)
        if magic != MAGIC or version != VERSION or kind not in _VALUES or length > self._longest:
            raise ProtocolError(f"{header!r} is no header")
        self._fill(HEADER.size + length, end, whole)
        payload = bytes(self._buffer[HEADER.size : HEADER.size + length])
        del self._buffer[: HEADER.size + length]
        return Kind(kind), sequence, payload

    def _fill(self, wanted: int, end: float | None, whole: float = inf) -> None:
        while len(self._buffer) < wanted:
            now = time.perf_counter()
            left = min(inf if end is None else end, whole) - now
            if left <= 0.0 and now >= whole:
                raise ProtocolError(f"a frame must be whole within {WHOLE_WITHIN:g} s, has {len(self._buffer)} of {wanted} bytes")
            if left <= 0.0:
                raise TimeoutError
            self.stream.settimeout(None if left == inf else left)
            try:
                got = self.stream.recv(65536)
            except TimeoutError:
                continue
            if not got:
                raise EOFError
            self._buffer += got

    def close(self) -> None:
        """Close the stream."""
        self.stream.close()


def numbers(*parts: Any) -> bytes:
    """Numbers and arrays one after another."""
    return np.concatenate([np.ravel(part) for part in parts]).astype("<f8").tobytes()


def array(payload: bytes, size: int) -> np.ndarray:
    """The `size` numbers of a payload; ProtocolError where there are more or fewer."""
    if len(payload) != 8 * size:
        raise ProtocolError(f"{len(payload)} bytes are not {size} numbers")
    return np.frombuffer(payload, "<f8").astype(float)


def document(payload: bytes) -> dict[str, Any]:
    """The JSON object of a payload; ProtocolError where there is none, or where it is nested too deeply."""
    try:
        content = json.loads(payload, parse_int=_whole)
    except (ValueError, RecursionError) as error:
        raise ProtocolError(f"no JSON: {error}") from None
    if not isinstance(content, dict):
        raise ProtocolError("no JSON object")
    return content


def _whole(digits: str) -> int:
    if len(digits) > DIGITS:
        raise ValueError(f"a whole number must have at most {DIGITS} digits, has {len(digits)}")
    return int(digits)
