"""The address of a number in a Modbus unit, and how its registers are read.

Addresses are those of the protocol, which counts each of the four tables from 0 (MODBUS Application
Protocol Specification V1.1b3, clause 4.4). Manuals often count from 1, and put the table in front:
their register 40003 is the holding register with the address 2.

The standard fixes the order of the bytes within a register, high byte first (clause 4.2), and
leaves the order of the registers of longer numbers to the maker.
"""

from __future__ import annotations

import math
import re
import struct
from enum import StrEnum
from typing import TYPE_CHECKING, Annotated, Literal, Self

from pydantic import BeforeValidator, Field, WithJsonSchema, model_validator

from rigrunner.api import DeviceRejectedError, Settings

if TYPE_CHECKING:
    from collections.abc import Sequence


def _read_word(value: object) -> object:
    if isinstance(value, str) and re.fullmatch(r"0[xX][0-9a-fA-F]+", value):
        return int(value, 16)
    return value


Word = Annotated[
    int,
    BeforeValidator(_read_word),
    Field(ge=0, le=0xFFFF),
    WithJsonSchema(
        {
            "anyOf": [
                {"type": "integer", "minimum": 0, "maximum": 0xFFFF},
                {"type": "string", "pattern": "^0[xX][0-9a-fA-F]{1,4}$"},
            ]
        }
    ),
]
"""16 bits, as manuals write them: an address or what a register holds, 1151 or 0x047F."""
_REFERENCE_DIGITS = (5, 6)
_FLOATS = ("float32", "float64")
_CODES = {
    "int16": ">h",
    "uint16": ">H",
    "int32": ">i",
    "uint32": ">I",
    "float32": ">f",
    "float64": ">d",
}
"""Of the types of numbers, as `struct` has them."""


class Table(StrEnum):
    """The four tables of a unit (clause 4.3)."""

    COIL = "coil"
    DISCRETE = "discrete"
    HOLDING = "holding"
    INPUT = "input"

    @property
    def writable(self) -> bool:
        """Whether it can be written."""
        return self in (Table.COIL, Table.HOLDING)

    @property
    def of_bits(self) -> bool:
        """Whether it holds single bits rather than registers of 16."""
        return self in (Table.COIL, Table.DISCRETE)


_BY_DIGIT = {"1": Table.DISCRETE, "3": Table.INPUT, "4": Table.HOLDING}


def _parse_reference(reference: int) -> tuple[Table, int]:
    digits = str(reference)
    table = _BY_DIGIT.get(digits[0])
    address = int(digits[1:] or "0") - 1
    if table is None or len(digits) not in _REFERENCE_DIGITS or not 0 <= address <= 0xFFFF:  # noqa: PLR2004  (16 bits)
        raise ValueError(
            f"reference is {reference}, expected 1xxxx (discrete), 3xxxx (input) or 4xxxx"
            " (holding), with 5 or 6 digits and counted from 1"
        )
    return table, address


class Place(Settings):
    """A table and an address: one of the first five keys."""

    holding: Word | None = None
    """Address of a holding register, counted from 0 as the protocol does."""
    input: Word | None = None
    """Address of an input register, counted from 0."""
    coil: Word | None = None
    """Address of a coil, counted from 0."""
    discrete: Word | None = None
    """Address of a discrete input, counted from 0."""
    reference: int | None = None
    """Notation of many manuals, counted from 1: 40003 is the holding register with address 2."""

    unit_id: Annotated[int, Field(ge=0, le=255)] | None = None
    """Address of another unit on the same line; if omitted, that of the instrument."""

    @model_validator(mode="after")
    def _is_one_place(self) -> Self:
        given_keys = [key for key in (*Table, "reference") if getattr(self, key) is not None]
        if len(given_keys) != 1:
            got = " and ".join(given_keys) or "none"
            raise ValueError(
                f"expected one of holding, input, coil, discrete and reference, got {got}"
            )
        if self.reference is not None:
            _parse_reference(self.reference)
        return self

    @property
    def table(self) -> Table:
        """Its table."""
        if self.reference is not None:
            return _parse_reference(self.reference)[0]
        return next(table for table in Table if getattr(self, table) is not None)

    @property
    def address(self) -> int:
        """The protocol's address, from 0."""
        if self.reference is not None:
            return _parse_reference(self.reference)[1]
        return int(getattr(self, self.table))


class Number(Place):
    """A number in one or several registers, or a single bit."""

    type: Literal["int16", "uint16", "int32", "uint32", "float32", "float64"] | None = None
    """Type of the registers; if omitted, uint16."""
    bit: Annotated[int, Field(ge=0, le=15)] | None = None
    """One bit of a register instead of a number; 0 is the lowest."""
    word_order: Literal["big", "little"] = "big"
    """Word order of a number in several registers; big: high word first."""
    byte_order: Literal["big", "little"] = "big"
    """Byte order within each register: big, unless the instrument deviates from the standard."""

    @model_validator(mode="after")
    def _is_one_number(self) -> Self:
        if self.table.of_bits and (self.type or self.bit is not None):
            raise ValueError(f"a {self.table} is one bit: it has neither type nor bit")
        if self.type is not None and self.bit is not None:
            raise ValueError("type and bit are given, expected one of them")
        if self.address + self.count - 1 > 0xFFFF:  # noqa: PLR2004  (16 bits)
            raise ValueError(f"{self.count} registers from {self.address} end beyond 65535")
        return self

    @property
    def count(self) -> int:
        """How many registers or bits it takes."""
        return 1 if self.table.of_bits else struct.calcsize(self._code) // 2

    @property
    def step(self) -> float:
        """How far two numbers are apart that it can hold; 0 for floating point."""
        return 0.0 if self.type in _FLOATS else 1.0

    def decode(self, registers: Sequence[int]) -> float:
        """Return the number for its registers or bit; raise DeviceRejectedError if it is none."""
        if self.table.of_bits:
            return float(registers[0])
        words = self._reorder(registers)
        if self.bit is not None:
            return float(words[0] >> self.bit & 1)
        raw = struct.pack(f">{len(words)}H", *words)
        number = float(struct.unpack(self._code, raw)[0])
        if not math.isfinite(number):
            raise DeviceRejectedError(
                f"the registers hold {raw.hex(' ', 2)}, no finite {self.type}",
                hint="do type, word_order and byte_order match the manual?",
            )
        return number

    def encode(self, number: float) -> list[int]:
        """Return the registers or the bit for a number; raise ValueError where it does not fit."""
        if self.table.of_bits:
            # `scale` and `offset` may have left 0.9999999999 of a 1.
            if round(number, 9) not in (0.0, 1.0):
                raise ValueError(f"{number:g} does not fit into a {self.table}: 0 or 1")
            return [round(number)]
        type_ = self.type or "uint16"
        try:
            raw = struct.pack(self._code, number if type_ in _FLOATS else round(number))
        except (struct.error, OverflowError, ValueError) as error:
            message = f"{number:g} does not fit into {type_}"
            if type_ not in _FLOATS:
                bits = 16 * self.count
                lowest = 0 if type_ == f"uint{bits}" else -(2 ** (bits - 1))
                message += f": {lowest} to {lowest + 2**bits - 1}"
            raise ValueError(message) from error
        return self._reorder(struct.unpack(f">{len(raw) // 2}H", raw))

    @property
    def _code(self) -> str:
        return _CODES[self.type or "uint16"]

    def _reorder(self, registers: Sequence[int]) -> list[int]:
        """Return registers in the standard's order; the same again turns them back."""
        words = list(registers)
        if self.byte_order == "little":
            words = [(word & 0xFF) << 8 | word >> 8 for word in words]
        return words[::-1] if self.word_order == "little" else words


def address_text(address: int, count: int) -> str:
    """Return addresses in words: '3' or '3-4'."""
    return str(address) if count == 1 else f"{address}-{address + count - 1}"
