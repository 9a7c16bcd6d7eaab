"""Measured values with limits, each with its verdict."""

from __future__ import annotations

from typing import Annotated, Literal

from pydantic import Field

from rigrunner.api.certificate.part import Part, Text


class MeasuredValue(Part):
    """One measured value with its limit."""

    table: Text
    """Name of its table."""
    row: int
    """From 1."""
    utc: Text
    setpoints: dict[str, str] = Field({})
    """Set-points with units, by drive."""
    of: Text
    """The channel, or the statistic of a recorded channel."""
    value: float
    lower: float | None
    upper: float | None
    unit: str
    """SI unit of the value and its limits."""
    printed: Text
    """The value in the unit of the limit in the procedure."""
    printed_limit: Text
    verdict: Literal["pass", "fail"]


class MeasuredLimits(Part):
    """The limits on measured values (7.8.6): simple acceptance of each value as read."""

    verdict: Literal["pass", "fail"]
    reason: Text
    """One sentence, from the run."""
    judged: int
    """Number of values with a limit."""
    missed: int
    values: Annotated[tuple[MeasuredValue, ...], Field(min_length=1)]
    """The values; if they are too many for the list, those out of limits first."""
