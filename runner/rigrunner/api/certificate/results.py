"""The results."""

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
    """Decimals of both printed texts: U has two significant digits (GUM 7.2.6)."""
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
    """Cycles that the rule for gross errors excluded from the torque."""
    raw_nm: float
    """The uncompensated value of the sensor: the mean of the peaks that were not excluded."""
    printed_raw: Text
    torque: StatedResult


class Results(Part):
    """The results of a sweep (7.8.2.1 m)."""

    headline: StatedResult
    """The mean over the set-points."""
    motion: Literal["swing", "start"]
    """Whether set-points are swings at a frequency or starts from rest at a speed."""
    points: Annotated[tuple[PointResult, ...], Field(min_length=1)]


class CoordinatePart(Part):
    """One coordinate of the place of a result."""

    value: float | str
    unit: str = ""
    """Unit of a number; '' for a text or a count."""
    printed: Text
    """With its unit."""


class NamedResult(Part):
    """A named result of an analysis, of any quantity."""

    name: Text
    symbol: str = ""
    text: Text
    """The measurand in words."""
    coordinates: dict[str, CoordinatePart] = Field({})
    """Distinguish it from others of its name; empty for the only one."""
    found: StatedResult
    readings: int
    """Number of values that it was calculated from."""


class Equation(Part):
    """An equation of a measurement model, in the notation of the procedure."""

    symbol: Text
    """The left side."""
    text: Text
    """The right side."""
    quantities: dict[str, str] = Field({})
    """Names in it that stand for a number with a unit."""


class BudgetLine(Part):
    """One input of an uncertainty budget (GUM 8)."""

    name: Text
    distribution: str
    degrees_of_freedom: float | None
    """None where they are infinite."""
    standard_uncertainty: float | None
    """Standard uncertainty of the input; None for a line of several inputs."""
    unit: str
    """Unit of the input."""
    sensitivity: float | None
    """Change of the result per change of the input; None for several inputs."""
    contribution: float
    """Contribution to the standard uncertainty of the result, in its unit."""


class MeasurementModel(Part):
    """The equations of a named result, and the budget of one of its values."""

    name: Text
    """Name of the result."""
    equations: Annotated[tuple[Equation, ...], Field(min_length=1)]
    coordinates: dict[str, CoordinatePart] = Field({})
    """The place of the value with this budget: the deciding one, or else the first."""
    budget: tuple[BudgetLine, ...]


class RejectedCycle(Part):
    """A cycle that the rule for gross errors excluded; the raw data keep it."""

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
