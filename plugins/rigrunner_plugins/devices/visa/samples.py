"""Samples out of what an instrument sends: interleaved, binary or as text."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from rigrunner.api import DeviceRejectedError
from rigrunner_plugins.devices.text.numbers import OVERLOAD, NumberInText, shown

if TYPE_CHECKING:
    from rigrunner.api import Array
    from rigrunner_plugins.devices.visa.settings import Stream

_CODES = {"float32": "f4", "float64": "f8", "int16": "i2", "int32": "i4"}
_PLAIN = NumberInText()


def samples_in(data: bytes, stream: Stream, query: str) -> Array:
    """Return the samples, of shape (n, channels), as the instrument's numbers.

    Raises DeviceRejectedError for data that are no whole number of samples, and for an overload.
    """
    numbers = _numbers(data, stream, query)
    channels = len(stream.channels)
    if numbers.size % channels:
        raise DeviceRejectedError(
            f"'{query}' gives {numbers.size} numbers, which is not a multiple of {channels}"
            f" channels: {', '.join(stream.channels)}",
            hint="which channels does the instrument record?",
        )
    values = numbers.reshape(-1, channels)
    wrong = np.argwhere(~(np.abs(values) < OVERLOAD))
    if len(wrong):
        sample, channel = wrong[0]
        raise DeviceRejectedError(
            f"{stream.channels[channel]} is {values[sample, channel]:g} in sample {sample} of a"
            " block: the instrument says overload or 'not a number'",
            hint="choose a larger range, or look at the wiring",
        )
    return values


def _numbers(data: bytes, stream: Stream, query: str) -> Array:
    if stream.format == "ascii":
        text = data.decode()
        what = f"in the answer to '{query}', {shown(text)}, a sample"
        fields = text.split(",") if text.strip() else []
        return np.array([_PLAIN.number_in(each, what) for each in fields], dtype=np.float64)
    code = _CODES[stream.format]
    size = int(code[1])
    if len(data) % size:
        raise DeviceRejectedError(
            f"the block that answers '{query}' has {len(data)} bytes,"
            f" which is not a multiple of the {size} of {stream.format}",
            hint="is `format` right?",
        )
    order = "<" if stream.byte_order == "little" else ">"
    return np.frombuffer(data, dtype=order + code).astype(np.float64)
