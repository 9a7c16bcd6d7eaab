"""Curves as binary frames: a JSON header and float32 arrays, little-endian."""

from __future__ import annotations

import json
import struct
from typing import TYPE_CHECKING, Any

import numpy as np

if TYPE_CHECKING:
    from collections.abc import Mapping

    from numpy.typing import NDArray

_ALIGN = 4


def frame(header: Mapping[str, Any], arrays: Mapping[str, NDArray[np.floating[Any]]]) -> bytes:
    """Return a frame; each array is of shape (n,)."""
    listed = [[name, len(values)] for name, values in arrays.items()]
    text = json.dumps({**header, "arrays": listed}, allow_nan=False).encode()
    text += b" " * (-len(text) % _ALIGN)
    parts = [np.ascontiguousarray(values, "<f4").tobytes() for values in arrays.values()]
    return struct.pack("<I", len(text)) + text + b"".join(parts)
