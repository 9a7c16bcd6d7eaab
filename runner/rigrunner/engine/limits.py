"""Whether the values that a step found are what they may be."""

from __future__ import annotations

from math import inf, nextafter
from typing import TYPE_CHECKING

from rigrunner.api.errors import DataError

if TYPE_CHECKING:
    from collections.abc import Iterator, Mapping, Sequence

    from rigrunner.api.quantity import Quantity, Unit
    from rigrunner.plan.actions import Limit


def judge(limits: Sequence[Limit], values: Mapping[str, float]) -> list[str]:
    """Return which values are marginal, in words; raise DataError with those beyond limits.

    `values` are in SI units, by 'role.channel'.
    """
    near = [limit for limit in limits if not _is_clear(limit, values[limit.member])]
    if not near:
        return []
    beyond = [text for limit in near if (text := _beyond(limit, values[limit.member]))]
    if beyond:
        raise DataError("; ".join(beyond))
    return [text for limit in near if (text := _marginal(limit, values[limit.member]))]


Clear = tuple[str, float, float]
"""A channel, and the least and the greatest value of which nothing is to be said."""


def clear_ranges(limits: Sequence[Limit]) -> tuple[Clear, ...]:
    """Return for each limit between which values `judge` would say nothing, to be asked often.

    Where a rounding could matter the range is narrower by it: what is outside is to be judged.
    """
    return tuple((each.member, _lowest(each), _highest(each)) for each in limits)


def _lowest(limit: Limit) -> float:
    if limit.minimum is None:
        return -inf
    least = limit.minimum.si + limit.marginal
    return nextafter(least, inf) if limit.marginal else least


def _highest(limit: Limit) -> float:
    if limit.maximum is None:
        return inf
    greatest = limit.maximum.si - limit.marginal
    return nextafter(greatest, -inf) if limit.marginal else greatest


def _is_clear(limit: Limit, value: float) -> bool:
    """Say whether nothing is to be said of a value."""
    low, high = limit.minimum, limit.maximum
    return (low is None or value - low.si >= limit.marginal) and (
        high is None or value - high.si <= -limit.marginal
    )


def _beyond(limit: Limit, value: float) -> str:
    for wanted, bound, sign in _bounds(limit):
        if sign * (value - bound.si) > 0:
            return f"{_shown(limit, value, bound.unit)}, allowed is {bound} or {wanted}"
    return ""


def _marginal(limit: Limit, value: float) -> str:
    for wanted, bound, sign in _bounds(limit):
        if sign * (value - bound.si) > -limit.marginal:
            return f"{_shown(limit, value, bound.unit)}, marginal: allowed is {bound} or {wanted}"
    return ""


def _bounds(limit: Limit) -> Iterator[tuple[str, Quantity, int]]:
    if limit.minimum is not None:
        yield "more", limit.minimum, -1
    if limit.maximum is not None:
        yield "less", limit.maximum, 1


def _shown(limit: Limit, value: float, unit: Unit) -> str:
    number = (value - unit.offset) / unit.factor
    return f"{limit.member} is {number:.4g} {unit.symbol}"
