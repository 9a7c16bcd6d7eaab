"""The consequences of limits of the values of a step."""

from __future__ import annotations

from typing import TYPE_CHECKING

from rigrunner.api.events import LimitMissed, Note

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator, Mapping, Sequence

    from rigrunner.api.limits import ValueLimit
    from rigrunner.api.readings import Reading, ReadingLimit

Remark = tuple[type[Note], str]
"""An event on a limited value, and its text."""


def remarks_on(
    limits: Sequence[ValueLimit],
    values: Mapping[str, float],
    where: Callable[[], str] | None = None,
) -> Iterator[Remark]:
    """Yield the events for values out of limits and for marginal values.

    `values` are in SI units, by their names in the limits; `where` is the place.
    """
    for limit in limits:
        value = values[limit.of]
        # Most values are far within the limits: the text of a decision would take longer.
        if limit.limits.margin(value) >= limit.marginal:
            continue
        decision = limit.decision(value)
        if decision.passes and not decision.marginal:  # an infinite value without a limit there
            continue
        place = "" if where is None else f"at {where()}: "
        yield (Note if decision.passes else LimitMissed), f"{place}{decision.reason}"


def missed_of(
    expected: Sequence[ReadingLimit], readings: Mapping[str, Reading]
) -> Iterator[Remark]:
    """Yield the events for readings that are not as expected."""
    for limit in expected:
        decision = limit.decision(readings[limit.of])
        if not decision.passes:
            yield LimitMissed, decision.reason
