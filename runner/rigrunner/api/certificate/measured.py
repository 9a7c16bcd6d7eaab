"""Measured values that have limits, each with its judgement."""

from __future__ import annotations

from typing import Annotated, Literal

from pydantic import Field

from rigrunner.api.certificate.part import Part, Text


class MeasuredValue(Part):
    """One measured value with its limit."""

    table: Text
    """The table of measured values that it is in."""
    row: int
    """From 1."""
    utc: Text
    setpoints: dict[str, str] = Field({})
    """What was set, with units, by drive."""
    of: Text
    """The value: a channel, or a statistic of a recorded one."""
    value: float
    lower: float | None
    upper: float | None
    unit: str
    """The SI unit of the value and its bounds."""
    printed: Text
    """The value with its unit, as the procedure states the limit."""
    printed_limit: Text
    verdict: Literal["pass", "fail"]


class MeasuredLimits(Part):
    """The limits on measured values (7.8.6): simple acceptance of each value as it was read."""

    verdict: Literal["pass", "fail"]
    reason: Text
    """In a sentence, as the run has it."""
    judged: int
    """How many values have a limit."""
    missed: int
    values: Annotated[tuple[MeasuredValue, ...], Field(min_length=1)]
    """Those out of limits first where they are too many to be listed whole."""
