"""What follows from the limits of the values that a step found."""

from __future__ import annotations

from typing import TYPE_CHECKING

from rigrunner.api.events import LimitMissed, Note

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator, Mapping, Sequence

    from rigrunner.api.limits import ValueLimit
    from rigrunner.api.readings import Reading, ReadingLimit

Remark = tuple[type[Note], str]
"""An event on a value with a limit, and its text."""


def remarks_on(
    limits: Sequence[ValueLimit],
    values: Mapping[str, float],
    where: Callable[[], str] | None = None,
) -> Iterator[Remark]:
    """Yield what is to be put on record of values: which are out of limits, which are marginal.

    `values` are in SI units, by the name that the limits have for them; `where` says of what point.
    """
    for limit in limits:
        value = values[limit.of]
        if limit.limits.margin(value) >= limit.marginal:
            continue
        found = limit.decision(value)
        if found.passes and not found.marginal:  # as of an infinite value without a limit there
            continue
        place = "" if where is None else f"at {where()}: "
        yield (Note if found.passes else LimitMissed), f"{place}{found.reason}"


def missed_of(
    expected: Sequence[ReadingLimit], readings: Mapping[str, Reading]
) -> Iterator[Remark]:
    """Yield what is to be put on record of readings that are not what they have to be."""
    for limit in expected:
        found = limit.decision(readings[limit.of])
        if not found.passes:
            yield LimitMissed, found.reason
