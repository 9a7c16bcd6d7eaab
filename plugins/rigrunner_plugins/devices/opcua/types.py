"""Numbers as OPC UA has them (OPC 10000-6, clause 5.1.2), by the names of its built-in types."""

from __future__ import annotations

import math
import struct
from typing import Literal, get_args

Type = Literal[
    "Boolean", "SByte", "Byte", "Int16", "UInt16", "Int32", "UInt32", "Int64", "UInt64",
    "Float", "Double",
]  # fmt: skip
TYPES: tuple[Type, ...] = get_args(Type)
_BITS = {"SByte": 8, "Int16": 16, "Int32": 32, "Int64": 64}
_UNSIGNED_BITS = {"Boolean": 1, "Byte": 8, "UInt16": 16, "UInt32": 32, "UInt64": 64}


def step(type_: Type) -> float:
    """Return how far two numbers are apart that it can hold; 0 for floating point."""
    return 0.0 if type_ in {"Float", "Double"} else 1.0


def encode(number: float, type_: Type) -> bool | int | float:
    """Return the nearest value of that type; raise ValueError where the number does not fit."""
    if not math.isfinite(number):
        raise ValueError(f"{number:g} is not a number that can be written")
    if type_ == "Double":
        return number
    if type_ == "Float":
        try:
            return float(struct.unpack("<f", struct.pack("<f", number))[0])
        except OverflowError as error:
            raise ValueError(f"{number:g} does not fit into Float") from error
    if type_ in _BITS:
        low, high = -(2 ** (_BITS[type_] - 1)), 2 ** (_BITS[type_] - 1) - 1
    else:
        low, high = 0, 2 ** _UNSIGNED_BITS[type_] - 1
    nearest = round(number)
    if not low <= nearest <= high or (type_ == "Boolean" and round(number, 9) != nearest):
        raise ValueError(f"{number:g} does not fit into {type_}: {low} to {high}")
    return bool(nearest) if type_ == "Boolean" else nearest
