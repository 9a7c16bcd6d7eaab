"""What was found."""

from __future__ import annotations

from typing import Annotated, Literal

from pydantic import Field

from rigrunner.api.certificate.part import Part, Text


class StatedResult(Part):
    """An estimate with its expanded uncertainty, as printed (7.8.2.1 m, 7.8.3.1 c; GUM 7.2)."""

    value: float
    standard_uncertainty: float
    degrees_of_freedom: float | None
    """None where they are infinite."""
    coverage_factor: float
    coverage_probability: float = 0.95
    expanded_uncertainty: float
    unit: Text
    decimals: int
    """Of both printed texts: U has two significant digits (GUM 7.2.6)."""
    printed: Text
    printed_uncertainty: Text
    printed_factor: Text


class PointResult(Part):
    """The result of one set-point."""

    recording: Text
    set_frequency_hz: float
    frequency_hz: float
    load_n: float
    cycles: int
    cycles_rejected: int
    """Not in the torque, as the rule for gross errors found them."""
    raw_nm: float
    """What the sensor shows, uncompensated: the mean of the peaks that were kept."""
    printed_raw: Text
    torque: StatedResult


class Results(Part):
    """What was found (7.8.2.1 m)."""

    headline: StatedResult
    """The mean over the set-points."""
    motion: Literal["swing", "start"]
    """Whether set-points are swings at a frequency or starts from rest at a speed."""
    points: Annotated[tuple[PointResult, ...], Field(min_length=1)]


class CoordinatePart(Part):
    """Where a result holds, in one respect."""

    value: float | str
    unit: str = ""
    """Of a number; '' for a text or a count."""
    printed: Text
    """With its unit."""


class NamedResult(Part):
    """A result of an analysis that names its results, of any quantity."""

    name: Text
    symbol: str = ""
    text: Text
    """The measurand in words."""
    coordinates: dict[str, CoordinatePart] = Field({})
    """What tells it from others of its name; empty of the only one."""
    found: StatedResult
    readings: int
    """How many values it was made of."""


class Equation(Part):
    """An equation of a measurement model, in the notation of the procedure."""

    symbol: Text
    """The left side."""
    text: Text
    """The right side."""
    quantities: dict[str, str] = Field({})
    """What names in it stand for that are numbers with a unit."""


class BudgetLine(Part):
    """One input of an uncertainty budget (GUM 8)."""

    name: Text
    distribution: str
    degrees_of_freedom: float | None
    """None where they are infinite."""
    standard_uncertainty: float | None
    """Of the input; None where a line of several inputs has none."""
    unit: str
    """Of the input."""
    sensitivity: float | None
    """The result's change over the input's; None likewise."""
    contribution: float
    """To the standard uncertainty of the result, in its unit."""


class MeasurementModel(Part):
    """By which equations a named result was computed, and the budget of one of its values."""

    name: Text
    """Of the result."""
    equations: Annotated[tuple[Equation, ...], Field(min_length=1)]
    coordinates: dict[str, CoordinatePart] = Field({})
    """Where the value holds whose budget it is: the one that decides, or else the first."""
    budget: tuple[BudgetLine, ...]


class RejectedCycle(Part):
    """A cycle that the rule for gross errors left out; the raw data stay."""

    run_id: Text
    recording: Text
    cycle: int
    """From 1."""
    what: Literal["peak", "waveform"]
    rule: Text
    value_nm: float | None
    statistic: float | None
    critical: float | None
    printed_statistic: Text
    printed_critical: Text
