"""Encodes an answer or an exception for a line of a tape, without loss."""

from __future__ import annotations

import base64
import builtins
import math
import zlib
from collections.abc import Mapping
from typing import Any

import numpy as np

from rigrunner.api import errors
from rigrunner.api.errors import AbortedError, DataError, RigrunnerError

_NUMBERS = "biuf"
"""Types of arrays that can be stored: booleans, integers and real numbers."""
_LARGEST = 2**32
"""Bytes of one array."""


def encode(answer: object) -> Any:
    """Return an answer as JSON; raise TypeError for unsupported types.

    Supported are None, booleans, integers, real numbers, texts, bytes, arrays of numbers, and lists
    and mappings by name of these. Every JSON object states its type.
    """
    match answer:
        # First: numbers of NumPy are no ints, and its float64 is a float.
        case np.generic():
            return encode(answer.item())
        case None | bool() | int() | str():
            return answer
        case float():
            return answer if math.isfinite(answer) else {"float": str(answer)}
        case list():
            return [encode(item) for item in answer]
        case _:
            return _encode_tagged(answer)


def decode(stored: Any) -> Any:
    """Return the answer that `encode` stored; raise DataError for anything else."""
    if isinstance(stored, list):
        return [decode(item) for item in stored]
    if not isinstance(stored, dict):
        return stored
    try:
        return _decode_tagged(stored)
    except (
        ValueError, TypeError, KeyError, AttributeError, OverflowError, MemoryError, zlib.error,
    ) as error:  # fmt: skip
        raise DataError(f"an answer cannot be read: {error}") from error


def encode_error(error: BaseException) -> dict[str, Any]:
    """Return an exception as JSON: the nearest class that a replay knows, and its text."""
    # "is": a class of a plugin may have the name of one of ours.
    nearest = next(
        (kind for kind in type(error).__mro__ if _error_class(kind.__name__) is kind), RuntimeError
    )
    if isinstance(error, RigrunnerError):
        fields = {"message": error.message, "hint": error.hint}
        if isinstance(error, AbortedError):
            fields["by"] = error.by
    else:
        plain = len(error.args) == 1 and isinstance(error.args[0], str)
        fields = {"message": error.args[0] if plain else str(error)}
    notes = list(getattr(error, "__notes__", ()))
    return {"class": nearest.__name__, **fields, **({"notes": notes} if notes else {})}


def decode_error(stored: Mapping[str, Any]) -> BaseException:
    """Return the exception that `encode_error` stored; raise DataError for anything else."""
    kind = _error_class(str(stored.get("class")))
    message = str(stored.get("message", ""))
    if kind is None:
        raise DataError(f"there is no error of the class {stored.get('class')!r}")
    hint = str(stored.get("hint", ""))
    if issubclass(kind, AbortedError):
        error: BaseException = kind(message, hint=hint, by=str(stored.get("by", "")))
    elif issubclass(kind, RigrunnerError):
        error = kind(message, hint=hint)
    else:
        try:
            error = kind(message)
        except TypeError:  # such as UnicodeDecodeError, which needs more than a message
            error = RuntimeError(f"{kind.__name__}: {message}")
    for note in stored.get("notes", ()):
        error.add_note(str(note))
    return error


def _encode_tagged(answer: object) -> dict[str, Any]:
    match answer:
        case bytes() | bytearray():
            return {"bytes": base64.b64encode(answer).decode()}
        case np.ndarray():
            return _encode_array(answer)
        case Mapping():
            return {"map": {_name(name): encode(item) for name, item in answer.items()}}
        case _:
            raise TypeError(f"a {type(answer).__name__} cannot be kept on tape")


def _encode_array(array: np.ndarray[Any, Any]) -> dict[str, Any]:
    """Store bytes of equal weight side by side: so they pack to about the size of the array."""
    if array.dtype.kind not in _NUMBERS:
        raise TypeError(f"an array of {array.dtype} cannot be kept on tape")
    little = np.ascontiguousarray(array, array.dtype.newbyteorder("<"))
    columns = np.frombuffer(little.tobytes(), np.uint8).reshape(-1, little.itemsize)
    packed = zlib.compress(columns.T.tobytes(), 1)
    return {
        "array": little.dtype.str,
        "shape": list(array.shape),
        "data": base64.b64encode(packed).decode(),
    }


def _decode_array(stored: Mapping[str, Any]) -> np.ndarray[Any, Any]:
    dtype, shape = np.dtype(str(stored["array"])), [int(length) for length in stored["shape"]]
    if dtype.kind not in _NUMBERS:
        raise ValueError(f"{dtype} is no kind of number")
    size = dtype.itemsize * math.prod(shape)
    if not 0 <= size <= _LARGEST:
        raise ValueError(f"an array of the shape {shape} is too large")
    packed = base64.b64decode(stored["data"], validate=True)
    # No more than it says, and one byte to notice that: a small text can unpack to very much.
    unpacked = zlib.decompressobj().decompress(packed, size + 1)
    columns = np.frombuffer(unpacked, np.uint8)
    content = columns.reshape(dtype.itemsize, -1).T.tobytes()
    array = np.frombuffer(content, dtype).reshape(shape)
    return array.astype(dtype.newbyteorder("="))  # a copy, which may be written to


def _decode_tagged(stored: Mapping[str, Any]) -> Any:
    match stored:
        case {"float": text}:
            return float(text)
        case {"bytes": text}:
            return base64.b64decode(text, validate=True)
        case {"array": _}:
            return _decode_array(stored)
        case {"map": mapping}:
            return {name: decode(item) for name, item in mapping.items()}
        case _:
            raise ValueError(f"{', '.join(stored) or 'nothing'} stands for no answer")


def _name(name: object) -> str:
    if not isinstance(name, str):
        raise TypeError(f"a mapping by {type(name).__name__} cannot be kept on tape")
    return name


def _error_class(name: str) -> type[BaseException] | None:
    """Return one of our errors, or one of Python's, by name."""
    for module in (errors, builtins):
        kind = getattr(module, name, None)
        # Not SystemExit: no tape may end the program.
        if isinstance(kind, type) and issubclass(kind, (Exception, KeyboardInterrupt)):
            return kind
    return None
