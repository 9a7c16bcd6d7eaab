"""Every answer that a Wire may carry round-trips exactly through a line of the tape."""

from __future__ import annotations

import base64
import builtins
import contextlib
import json
import math
import zlib

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from rigrunner.api.errors import (
    AbortedError,
    DataError,
    DeviceLostError,
    DeviceRejectedError,
    DeviceTimeoutError,
    MissingPackageError,
)
from rigrunner.tape.codec import decode, decode_error, encode, encode_error

ARRAYS = arrays(np.float64, st.integers(0, 20), elements=st.floats(width=64))
SINGLE = st.none() | st.booleans() | st.integers() | st.floats() | st.text() | st.binary() | ARRAYS
ANSWERS = st.recursive(
    SINGLE,
    lambda inner: st.lists(inner, max_size=4) | st.dictionaries(st.text(), inner, max_size=4),
)


def same(one, other):
    """Return whether two answers are identical, bit by bit and in type."""
    if type(one) is not type(other):
        return False
    match one:
        case list():
            return len(one) == len(other) and all(map(same, one, other))
        case dict():
            return list(one) == list(other) and all(same(one[name], other[name]) for name in one)
        case np.ndarray():
            return (one.dtype, one.shape, one.tobytes()) == (
                other.dtype, other.shape, other.tobytes(),
            )  # fmt: skip
        case float():
            return (math.isnan(one) and math.isnan(other)) or one.hex() == other.hex()
        case _:
            return one == other


@given(ANSWERS)
def test_answer_round_trips_to_the_last_bit(answer):
    line = json.dumps(encode(answer), allow_nan=False)
    assert same(decode(json.loads(line)), answer)


@pytest.mark.parametrize("dtype", ["<f8", ">f8", "<f4", "<i2", ">u2", "|b1"])
def test_array_dtype_round_trips_in_native_byte_order(dtype):
    values = np.array([0, 1, 2, 250], dtype=dtype)
    decoded = decode(encode(values))
    assert decoded.dtype == np.dtype(dtype).newbyteorder("=")
    assert decoded.tolist() == values.tolist()
    decoded[0] = 1  # it is writable: a driver may change it


def test_numpy_scalars_are_encoded_as_plain_numbers():
    assert encode([np.float64(0.1), np.int16(3), np.bool_(1)]) == [0.1, 3, True]


@pytest.mark.parametrize(
    "answer", [(1, 2), {1: 2}, object(), np.array(["a"]), np.array([object()]), 1j, {"a": {2}}]
)
def test_unsupported_answer_is_refused(answer):
    with pytest.raises(TypeError, match="cannot be kept on tape"):
        encode(answer)


@pytest.mark.parametrize(
    "stored",
    [{}, {"flaot": "nan"}, {"bytes": "$"}, {"float": "much"}, {"map": [1]},
     {"array": "|O", "shape": [1], "data": "eJwDAAAAAAE="}, {"array": "<f8", "shape": [1]},
     {"array": "<f8", "shape": [3], "data": "eJwDAAAAAAE="}, {"array": "<f8", "shape": [10**12],
     "data": ""}, {"array": "<f8", "shape": [-1], "data": ""}, {"array": 1, "shape": 1, "data": 1}],
)  # fmt: skip
def test_invalid_stored_answer_is_a_data_error(stored):
    with pytest.raises(DataError):
        decode(stored)


@pytest.mark.parametrize(
    "error",
    [DeviceTimeoutError("no answer", hint="is it on?"), DeviceLostError("unplugged"),
     MissingPackageError("no visa"), KeyError("torque"), KeyboardInterrupt()],
)  # fmt: skip
def test_error_round_trips_with_its_notes(error):
    error.add_note("seen twice")
    decoded = decode_error(json.loads(json.dumps(encode_error(error))))
    assert type(decoded) is type(error)
    assert str(decoded) == str(error)
    assert decoded.__notes__ == ["seen twice"]


def test_error_with_other_arguments_keeps_its_message():
    stored = encode_error(UnicodeDecodeError("ascii", b"\xff", 0, 1, "not in range"))
    decoded = decode_error(stored)
    assert isinstance(decoded, RuntimeError)
    assert "UnicodeDecodeError: 'ascii' codec can't decode byte 0xff" in str(decoded)


def test_error_of_an_unknown_class_is_restored_as_its_nearest_base():
    class BridgeError(DeviceRejectedError):
        pass

    class PollError(builtins.ValueError):
        pass

    assert type(decode_error(encode_error(BridgeError("no")))) is DeviceRejectedError
    assert type(decode_error(encode_error(PollError("no")))) is ValueError
    assert decode_error(encode_error(AbortedError("x", by="me"))).exit_code == 20


JSON = st.recursive(
    st.none() | st.booleans() | st.integers() | st.floats(allow_nan=False) | st.text(),
    lambda inner: (
        st.lists(inner, max_size=3)
        | st.dictionaries(
            st.sampled_from(["array", "shape", "data", "float", "bytes", "map", "x"]), inner
        )
    ),
    max_leaves=12,
)


@given(JSON)
def test_any_json_is_an_answer_or_a_data_error(stored):
    with contextlib.suppress(DataError):
        decode(stored)


def test_array_larger_than_its_shape_is_refused():
    bomb = base64.b64encode(zlib.compress(bytes(10**7))).decode()
    with pytest.raises(DataError):
        decode({"array": "<f8", "shape": [1], "data": bomb})


@pytest.mark.parametrize("name", ["SystemExit", "GeneratorExit", "BaseException"])
def test_exits_are_not_restored_from_a_tape(name):
    with pytest.raises(DataError, match="no error of the class"):
        decode_error({"class": name})
    assert encode_error(getattr(builtins, name)("x"))["class"] == "RuntimeError"


@pytest.mark.parametrize("stored", [{}, {"class": "print"}, {"class": "os"}, {"class": "ExitCode"}])
def test_name_of_no_error_class_is_refused(stored):
    with pytest.raises(DataError, match="no error of the class"):
        decode_error(stored)
