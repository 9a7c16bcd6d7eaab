"""Several numbers in as few requests as the registers' neighbourhood allows."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from collections.abc import Iterable

    from rigrunner_plugins.devices.modbus.places import Number, Table

# Below every unit id, so that numbers without one can be sorted among the others.
_OWN = -1
MOST_REGISTERS = 125
_MOST_BITS = 2000
"""In one request (MODBUS Application Protocol Specification V1.1b3, clauses 6.1 to 6.4)."""


@dataclass(frozen=True)
class Span:
    """Registers or bits of one table that follow upon each other."""

    table: Table
    address: int
    count: int
    unit_id: int | None = None
    """Of another unit than the instrument's own."""

    @property
    def end(self) -> int:
        """The address behind its last one."""
        return self.address + self.count

    def holds(self, number: Number) -> bool:
        """Return whether all of a number lies within."""
        return (
            number.unit_id == self.unit_id
            and number.table is self.table
            and self.address <= number.address
            and number.address + number.count <= self.end
        )


def spans(numbers: Iterable[Number], *, together: bool) -> list[Span]:
    """Return the spans to read: each number lies wholly within one.

    Only what touches or overlaps is read together: a register between two that a unit does not
    have would make it refuse both.
    """
    merged: list[Span] = []
    places = {(number.table, number.address, number.count, number.unit_id) for number in numbers}
    for number in sorted(
        places, key=lambda place: (_OWN if place[3] is None else place[3], *place[:3])
    ):
        new = Span(*number)
        last = merged[-1] if merged else new
        most = _MOST_BITS if new.table.of_bits else MOST_REGISTERS
        if (
            together
            and merged
            and (last.unit_id, last.table) == (new.unit_id, new.table)
            and new.address <= last.end
            and new.end - last.address <= most
        ):
            merged[-1] = replace(last, count=max(last.count, new.end - last.address))
        else:
            merged.append(new)
    return merged
