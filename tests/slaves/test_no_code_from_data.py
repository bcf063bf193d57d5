"""No code from data: what an FMU's process sends is read as numbers and JSON, and its folder lends it no modules."""

import json
import socket
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any

import hostile
import numpy as np
import pytest

from gyro_cosim import SlaveError, simulate
from gyro_cosim.slaves import open_slave
from gyro_cosim.slaves.processes import child, protocol
from gyro_cosim.slaves.processes.protocol import Kind, Link, ProtocolError, document
from gyro_cosim.slaves.processes.telling import carried_values, described, introduction, read_values

pytestmark = pytest.mark.skipif(sys.platform == "win32", reason="FMUs are isolated on Linux and macOS")


@pytest.mark.parametrize(
    ("kind", "words"),
    [
        ("pickle@step", r"malformed frame in step: b'.*builtin.*' is no header"),
        ("half-frame@step", "malformed frame in step: a frame must be whole within 0.3 s, has 12 of 20 bytes"),
        ("false-frame@step", "malformed frame in step: OK with number 65535 answers nothing"),
    ],
)
def test_what_an_fmu_writes_to_its_parent_ends_the_run_in_one_line(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, kind: str, words: str
) -> None:
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(protocol, "WHOLE_WITHIN", 0.3)
    with pytest.raises(SlaveError, match=rf"component 'bad' failed at t = 0\.49 s .*{words}") as caught:
        simulate(hostile.system(tmp_path, kind), isolate=True)
    assert len(caught.value.partial.trajectory) == hostile.AT
    assert not (tmp_path / "RAN").exists()


@pytest.mark.parametrize("how", ["isolate", "process"])
def test_a_file_beside_the_user_shadows_no_module(tmp_path: Path, cosim: Callable[..., Any], how: str) -> None:
    for name in ("numpy.py", "json.py", "gyro_cosim.py"):
        (tmp_path / name).write_text("import os\nopen('RAN', 'w').close()\n")
    unit = ("--gyro", "process:gyro_unit:nonlinear") if how == "process" else ("--isolate",)
    code, _, err = cosim("run", "wheel-pair", *unit, "--stop", "0.01")
    assert (code, err) == (0, "")
    assert not (tmp_path / "RAN").exists()


def test_the_safe_path_has_no_current_folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(sys, "path", ["", ".", str(tmp_path), "/somewhere"])
    assert child.safe_path() == ["/somewhere"]


def test_an_introduction_and_values_arrive_as_they_were() -> None:
    slave = open_slave("unit", "gyro_unit:nonlinear", in_process=True)
    told = described(document(json.dumps(introduction(slave)).encode()))
    assert (told.inputs, told.outputs, told.settable) == (
        slave.description.inputs,
        slave.description.outputs,
        slave.description.settable,
    )
    np.testing.assert_array_equal(told.feedthrough, slave.description.feedthrough)
    values = {"a": 1.5, "b": "text", "c": b"\x00\xff", "d": (1.0, 2.0)}
    assert read_values(carried_values(values)) == values


GOOD = {"inputs": [], "outputs": [], "settable": [], "feedthrough": [], "input_degree": 0, "can_restore": False}
SIGNAL = {"name": "u", "kind": "input", "unit": ""}


@pytest.mark.parametrize(
    ("told", "words"),
    [
        ({"inputs": None}, "inputs must be a list of signals, got None"),
        ({"inputs": ["u"]}, "inputs must hold objects, got 'u'"),
        ({"inputs": [{**SIGNAL, "kind": "trap"}]}, "kind must be one of input, output, parameter, state, got 'trap'"),
        ({"inputs": [{**SIGNAL, "name": 3}]}, "name must be a text, got 3"),
        ({"inputs": [SIGNAL, SIGNAL], "feedthrough": []}, "inputs must have names of their own"),
        ({"inputs": [{**SIGNAL, "start": 10**400}]}, "start must be a number"),
        ({"inputs": [{**SIGNAL, "shape": [10**5] * 8}]}, "shape must be whole numbers"),
        ({"inputs": [{**SIGNAL, "definition": ["m", 0, [0] * 8, 0]}]}, "definition must be name, factor, dimension, offset"),
        ({"feedthrough": [[0]]}, "feedthrough must be 0 rows of 0 times 0 or 1"),
        ({"input_degree": True}, "input_degree must be 0, 1 or 2, got True"),
        ({"can_restore": "yes"}, "can_restore must be true or false, got 'yes'"),
    ],
)
def test_an_introduction_that_lies_is_refused(told: dict[str, Any], words: str) -> None:
    with pytest.raises(ProtocolError, match=words):
        described({**GOOD, **told})


@pytest.mark.parametrize("text", [b"[" * 100_000, b'{"a":' * 100_000, b'{"t": ' + b"9" * 400 + b"}", b"[]", b"\xff"])
def test_json_beyond_all_limits_is_refused(text: bytes) -> None:
    with pytest.raises(ProtocolError):
        document(text)


@pytest.mark.parametrize("value", [None, True, float("nan"), 10**400, {"hex": "zz"}, {"hex": 3}, [[1.0]]])
def test_a_value_that_is_none_is_refused(value: Any) -> None:
    with pytest.raises(ProtocolError, match="value 'a' must be"):
        read_values({"a": value})


def test_a_frame_that_is_too_long_for_its_end_is_none() -> None:
    here, there = socket.socketpair()
    with here, there:
        Link(there).send(Kind.OK, 1, b"x" * 101)
        with pytest.raises(ProtocolError, match="is no header"):
            Link(here, longest=100).receive(1.0)
