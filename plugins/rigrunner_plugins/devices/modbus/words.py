"""Numbers as registers of 16 bits.

The standard fixes the order of the bytes within a register, high byte first (MODBUS Application
Protocol Specification V1.1b3, clause 4.2), and leaves the order of the registers of longer numbers
to the maker.
"""

from __future__ import annotations

import math
import struct
from typing import TYPE_CHECKING, Literal

from rigrunner.api import DeviceRejectedError

if TYPE_CHECKING:
    from collections.abc import Sequence

Type = Literal["int16", "uint16", "int32", "uint32", "float32", "float64"]
Order = Literal["big", "little"]
FLOATS = ("float32", "float64")
_CODES: dict[Type, str] = {
    "int16": ">h",
    "uint16": ">H",
    "int32": ">i",
    "uint32": ">I",
    "float32": ">f",
    "float64": ">d",
}


def count(type_: Type) -> int:
    """Return how many registers a number takes."""
    return struct.calcsize(_CODES[type_]) // 2


def decode(registers: Sequence[int], type_: Type, word_order: Order, byte_order: Order) -> float:
    """Return the number; raise DeviceRejectedError for what is not a finite number."""
    raw = struct.pack(f">{len(registers)}H", *in_order(registers, word_order, byte_order))
    number = float(struct.unpack(_CODES[type_], raw)[0])
    if not math.isfinite(number):
        raise DeviceRejectedError(
            f"the registers hold {raw.hex(' ', 2)}, no finite {type_}",
            hint="do type, word_order and byte_order match the manual?",
        )
    return number


def encode(number: float, type_: Type, word_order: Order, byte_order: Order) -> list[int]:
    """Return the registers for the nearest number that they can hold; raise ValueError."""
    try:
        raw = struct.pack(_CODES[type_], number if type_ in FLOATS else round(number))
    except (struct.error, OverflowError, ValueError) as error:
        raise ValueError(f"{number:g} does not fit into {type_}{_bounds(type_)}") from error
    registers = struct.unpack(f">{len(raw) // 2}H", raw)
    return in_order(registers, word_order, byte_order)


def in_order(registers: Sequence[int], word_order: Order, byte_order: Order) -> list[int]:
    """Return registers in the standard's order; the same again turns them back."""
    turned = [_swapped(word) for word in registers] if byte_order == "little" else list(registers)
    return turned[::-1] if word_order == "little" else turned


def _swapped(word: int) -> int:
    return (word & 0xFF) << 8 | word >> 8


def _bounds(type_: Type) -> str:
    if type_ in FLOATS:
        return ""
    bits = 16 * count(type_)
    low, high = (0, 2**bits - 1) if type_[0] == "u" else (-(2 ** (bits - 1)), 2 ** (bits - 1) - 1)
    return f": {low} to {high}"
