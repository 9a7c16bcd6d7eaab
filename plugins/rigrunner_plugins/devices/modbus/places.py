"""Where a number stands in a Modbus unit, and how its registers are read.

Addresses are those of the protocol, which counts each of the four tables from 0 (MODBUS Application
Protocol Specification V1.1b3, clause 4.4). Manuals often count from 1, and put the table in front:
their register 40003 is the holding register with the address 2.
"""

from __future__ import annotations

import re
from enum import StrEnum
from typing import TYPE_CHECKING, Annotated, Literal, Self

from pydantic import BeforeValidator, Field, WithJsonSchema, model_validator

from rigrunner.api import Settings
from rigrunner_plugins.devices.modbus import words

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


def _refer(reference: int) -> tuple[Table, int]:
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
        given = [key for key in (*Table, "reference") if getattr(self, key) is not None]
        if len(given) != 1:
            got = " and ".join(given) or "none"
            raise ValueError(
                f"expected one of holding, input, coil, discrete and reference, got {got}"
            )
        if self.reference is not None:
            _refer(self.reference)
        return self

    @property
    def table(self) -> Table:
        """The table in which it stands."""
        if self.reference is not None:
            return _refer(self.reference)[0]
        return next(table for table in Table if getattr(self, table) is not None)

    @property
    def address(self) -> int:
        """The protocol's address, from 0."""
        if self.reference is not None:
            return _refer(self.reference)[1]
        return int(getattr(self, self.table))


class Number(Place):
    """A number in one or several registers, or a single bit."""

    type: words.Type | None = None
    """Type of the registers; if omitted, uint16."""
    bit: Annotated[int, Field(ge=0, le=15)] | None = None
    """One bit of a register instead of a number; 0 is the lowest."""
    word_order: Literal["big", "little"] = "big"
    """Of a number of several registers: big is the high word first."""
    byte_order: Literal["big", "little"] = "big"
    """Within each register: big, unless the instrument deviates from the standard."""

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
        return 1 if self.table.of_bits or self.type is None else words.count(self.type)

    @property
    def step(self) -> float:
        """How far two numbers are apart that it can hold; 0 for floating point."""
        return 0.0 if self.type in words.FLOATS else 1.0

    def decode(self, registers: Sequence[int]) -> float:
        """Return the number for its registers or bit; raise DeviceRejectedError if it is none."""
        if self.table.of_bits:
            return float(registers[0])
        if self.bit is not None:
            in_order = words.in_order(registers, self.word_order, self.byte_order)
            return float(in_order[0] >> self.bit & 1)
        return words.decode(registers, self.type or "uint16", self.word_order, self.byte_order)

    def encode(self, number: float) -> list[int]:
        """Return the registers or the bit for a number; raise ValueError where it does not fit."""
        if self.table.of_bits:
            # `scale` and `offset` may have left 0.9999999999 of a 1.
            if round(number, 9) not in (0.0, 1.0):
                raise ValueError(f"{number:g} does not fit into a {self.table}: 0 or 1")
            return [round(number)]
        return words.encode(number, self.type or "uint16", self.word_order, self.byte_order)


def span(address: int, count: int) -> str:
    """Return addresses in words: '3' or '3-4'."""
    return str(address) if count == 1 else f"{address}-{address + count - 1}"
