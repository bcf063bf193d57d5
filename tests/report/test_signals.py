"""What a page holds of a run's signals: thinned without losing a peak, packed, with a fingerprint of the exact ones."""

import base64
import zlib

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from gyro_cosim.report import signals
from gyro_cosim.trajectory import Trajectory


def recorded(values: np.ndarray) -> Trajectory:
    names = tuple(f"a.y{k}" for k in range(values.shape[1]))
    return Trajectory(np.arange(len(values)) * 1e-3, names, ("m",) * len(names), values)


def unpacked(text: str, kind: str = "<f4") -> np.ndarray:
    return np.frombuffer(zlib.decompress(base64.b64decode(text)), dtype=kind)


@settings(max_examples=40, deadline=None)
@given(st.integers(1, 400), st.integers(4, 60), st.integers(0, 2**32 - 1))
def test_thinning_keeps_every_signals_extremes_and_the_order_of_time(n, rows, seed):
    values = np.random.default_rng(seed).normal(size=(n, 3))
    t, thin, group = signals.thinned(recorded(values), rows)
    assert len(t) == len(thin) <= rows
    assert (thin.min(axis=0) == values.min(axis=0)).all()
    assert (thin.max(axis=0) == values.max(axis=0)).all()
    assert (np.diff(t) >= 0).all()
    assert (group == 1) == (n <= rows)


def test_the_least_and_the_greatest_value_stand_in_the_order_in_which_they_came():
    values = np.zeros((40, 2))
    values[3, 0], values[7, 0] = 1.0, -1.0
    values[3, 1], values[7, 1] = -1.0, 1.0
    _, thin, group = signals.thinned(recorded(values), 4)
    assert group == 20
    assert thin[:2].tolist() == [[1.0, -1.0], [-1.0, 1.0]]


def test_a_document_holds_time_in_double_and_signals_in_single_precision():
    values = np.random.default_rng(1).normal(size=(11, 2))
    document = signals.document(recorded(values))
    assert (unpacked(document["t"], "<f8") == np.arange(11) * 1e-3).all()
    assert (unpacked(document["columns"][1]) == values[:, 1].astype(np.float32)).all()
    assert document["group"] == 1
    assert document["rows"] == 11


def test_a_fingerprint_is_fnv_1a_and_sees_the_last_bit():
    assert signals.fingerprint(np.zeros(0)) == "cbf29ce484222325"  # of nothing, as FNV defines it
    one = np.array([1.0, 2.0])
    other = one.copy()
    other[1] = np.nextafter(2.0, 3.0)
    assert signals.fingerprint(one) != signals.fingerprint(other)
    assert signals.fingerprint(np.array([np.frombuffer(b"foobar\0\0", dtype="<f8")[0]])) == _fnv(b"foobar\0\0")


def _fnv(data: bytes) -> str:
    state = 0xCBF29CE484222325
    for byte in data:
        state = (state ^ byte) * 0x100000001B3 % 2**64
    return f"{state:016x}"


@pytest.mark.parametrize("rows", [1, 2, 3])
def test_a_run_of_few_rows_is_whole(rows):
    t, values, group = signals.thinned(recorded(np.ones((rows, 1))))
    assert (len(t), values.shape, group) == (rows, (rows, 1), 1)
