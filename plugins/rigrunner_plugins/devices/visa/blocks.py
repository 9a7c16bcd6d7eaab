"""Arbitrary blocks of IEEE 488.2-1992: 8.7.9 of definite length, 8.7.10 of indefinite length."""

from __future__ import annotations

from rigrunner.api import DeviceRejectedError


def digits_of_length(start: bytes, query: str) -> int:
    """Return how many digits the length has, from the first two bytes: #3 says three.

    Raises DeviceRejectedError for what is no block, and for one of indefinite length.
    """
    if start[:1] != b"#" or not start[1:2].isdigit():
        raise DeviceRejectedError(
            f"the answer to '{query}' begins with {start!r}, a block begins with # and a digit",
            hint="is the instrument set to binary data, as `format` says? or is it `ascii`?",
        )
    if start[1:2] == b"0":
        raise DeviceRejectedError(
            f"the answer to '{query}' is a block of indefinite length, whose end cannot be told",
            hint="set the instrument to blocks of definite length, or use GPIB, USB or VXI-11",
        )
    return int(start[1:2])


def data_length(digits: bytes, query: str) -> int:
    """Return how many bytes of data follow; raise DeviceRejectedError for what is not a number."""
    if not digits.isdigit():
        raise DeviceRejectedError(
            f"the block that answers '{query}' says {digits!r} where its length should be"
        )
    return int(digits)


def whole_block(message: bytes, query: str) -> bytes:
    """Return the data of a message that is a block; raise DeviceRejectedError.

    One of indefinite length ends with a line feed and the end of the message.
    """
    if message[:2] == b"#0" and message.endswith(b"\n"):
        return message[2:-1]
    begin = 2 + digits_of_length(message[:2], query)
    length = data_length(message[2:begin], query)
    data, rest = message[begin : begin + length], message[begin + length :]
    if len(data) < length or rest.strip(b"\r\n"):
        raise DeviceRejectedError(
            f"the block that answers '{query}' has {len(message) - begin} bytes of data,"
            f" it says {length}"
        )
    return data
