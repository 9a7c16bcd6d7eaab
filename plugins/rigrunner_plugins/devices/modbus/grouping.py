"""Several numbers in as few requests as the registers' neighbourhood allows."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from collections.abc import Iterable

    from rigrunner_plugins.devices.modbus.places import Number, Table

_MOST_REGISTERS = 125
_MOST_BITS = 2000
"""In one request (MODBUS Application Protocol Specification V1.1b3, clauses 6.1 to 6.4)."""


@dataclass(frozen=True)
class Span:
    """Registers or bits of one table that follow upon each other."""

    table: Table
    address: int
    count: int

    def holds(self, number: Number) -> bool:
        """Say whether all of a number lies within."""
        return (
            number.table is self.table
            and self.address <= number.address
            and number.address + number.count <= self.address + self.count
        )


def spans(numbers: Iterable[Number], *, together: bool) -> list[Span]:
    """Return what is to be read: each number lies wholly within one span.

    Only what touches or overlaps is read together: a register between two that a unit does not
    have would make it refuse both.
    """
    found: list[Span] = []
    wanted = {(number.table, number.address, number.count) for number in numbers}
    for table, address, count in sorted(wanted):
        last = found[-1] if found else None
        end = address + count
        most = _MOST_BITS if table.of_bits else _MOST_REGISTERS
        if (
            last is not None
            and last.table is table
            and (together and address <= last.address + last.count)
            and end - last.address <= most
        ):
            longer = max(end - last.address, last.count)
            found[-1] = Span(table, last.address, longer)
        else:
            found.append(Span(table, address, count))
    return found
