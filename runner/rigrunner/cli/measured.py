"""The values of `measure` steps, as tables for a terminal."""

from __future__ import annotations

from typing import TYPE_CHECKING

from rigrunner.api.coordinates import measured_column, with_unit, written_column
from rigrunner.api.readings import reading_text
from rigrunner.api.summaries import table

if TYPE_CHECKING:
    from collections.abc import Sequence

    from rigrunner.api.data import Measurement
    from rigrunner.api.limits import ValueLimit
    from rigrunner.api.readings import ReadingLimit


def measured(measurements: Sequence[Measurement]) -> str:
    """Return a table for each name: coordinates, set-points, then values; one row for each time."""
    names = dict.fromkeys(one.name for one in measurements)
    return "\n\n".join(_table(name, measurements) for name in names)


def _table(name: str, measurements: Sequence[Measurement]) -> str:
    rows = [one for one in measurements if one.name == name]
    coordinates = list(dict.fromkeys(name for one in rows for name in one.coordinates))
    setpoints = list(dict.fromkeys(member for one in rows for member in one.setpoints))
    values = list(dict.fromkeys(member for one in rows for member in one.values))
    told = list(dict.fromkeys(member for one in rows for member in one.readings))
    units = {member: unit for one in rows for member, unit in one.units.items()}
    placed = [written_column(rows, name, units.get(name, "")) for name in coordinates + setpoints]
    heads = [*coordinates, *(f"set {name}" for name in setpoints)]
    header = [with_unit(head, unit) for head, (unit, _) in zip(heads, placed, strict=True)]
    read = [measured_column(rows, member, units.get(member, "1")) for member in values]
    header += [f"{member} / {unit}" if unit else member
               for member, (unit, _) in zip(values, read, strict=True)]  # fmt: skip
    cells = [
        [column[index] for _, column in (*placed, *read)]
        + [reading_text(one.readings.get(member, "")) for member in told]
        for index, one in enumerate(rows)
    ]
    header += [with_unit(member, units.get(member, "")) for member in told]
    align = "r" * (len(header) - len(told)) + "l" * len(told)
    limits: dict[ValueLimit | ReadingLimit, None] = {}
    for one in rows:
        limits |= dict.fromkeys(one.limits) | dict.fromkeys(one.expected)
    if limits:
        header, align = [*header, "verdict"], f"{align}l"
        for cell, one in zip(cells, rows, strict=True):
            missed = [each.of for each in one.decisions if not each.passes]
            passed = "pass" if one.decisions else ""
            cell.append(f"FAIL: {', '.join(missed)}" if missed else passed)
    allowed = [f"{limit.of}: limit {limit.limits.in_words}" for limit in limits]
    return "\n".join([f"Measured: {name}", table(header, cells, align), *allowed])
