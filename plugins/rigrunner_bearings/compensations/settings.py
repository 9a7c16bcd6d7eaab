"""The settings of the compensations; loads without numpy."""

from __future__ import annotations

from typing import Annotated, Literal, Self

from pydantic import Field, model_validator

from rigrunner.api import Angle, Frequency, Ratio, Settings, Torque
from rigrunner_bearings.api.rig import refuse_growth_without_limit

DEGREE = 0.017453292519943295


class WaveformSettings(Settings):
    """Of every method that compares whole swings of the loaded and the no-load run."""

    frequency_match: Annotated[
        Ratio,
        Field(gt=0, le=0.05, description="how far the measured frequencies of a pair may differ"),
    ] = 0.02


class SupportSettings(Settings):
    """What is known of the support's friction under load, where the station says nothing of it."""

    support_load_growth: Annotated[
        Ratio | None,
        Field(
            gt=-1,
            description="of the support's friction, as the load is known to raise it; "
            "0 where only support_load_dependence is given",
        ),
    ] = None
    support_load_dependence: Annotated[
        Ratio | None,
        Field(
            ge=0,
            description="limit of what the load may change the support's friction by, beyond "
            "support_load_growth; without either, between nothing and what the literature has",
        ),
    ] = None

    @model_validator(mode="after")
    def _has_a_limit(self) -> Self:
        refuse_growth_without_limit(self.support_load_growth, self.support_load_dependence)
        return self


class InverseSettings(SupportSettings):
    """Of the compensation `model_inverse`, and of every other that undoes the drive line.

    Mismatch, dependence and tolerance are limits, as half-widths of rectangular distributions:
    replace them by what is known of your rig.
    """

    window: Annotated[
        Angle, Field(gt=0, description="how far after a reversal the starting torque is looked for")
    ] = DEGREE
    inertia_mismatch: Annotated[
        Ratio, Field(ge=0, description="of the inertia, between the two runs")
    ] = 0.001
    low_pass_tolerance: Annotated[
        Ratio, Field(ge=0, description="of the low-pass filter's corner frequency")
    ] = 0.02
    mains_frequency: Annotated[
        Frequency, Field(gt=0, description="of the mains, whose hum is taken out")
    ] = 50.0


class TemplateInverseSettings(InverseSettings, WaveformSettings):
    """Of the compensation `template_inverse`."""


class EnergySettings(SupportSettings, WaveformSettings):
    """Of the compensation `energy`."""


class PaperPeakSettings(Settings):
    """Of the compensation `paper_peak`."""

    coefficients: Annotated[
        Literal["published", "refit"],
        Field(description="of Eq. (1): the authors' rig, or fitted to this rig's no-load run"),
    ] = "refit"


class PeakSameFrequencySettings(Settings):
    """Of the compensation `peak_same_frequency`."""

    frequency_match: Annotated[
        Ratio, Field(gt=0, le=0.05, description="how far the frequencies of a pair may differ")
    ] = 0.01


class BreakawayPeakSettings(Settings):
    """Of the compensation `breakaway_peak`."""

    fixture_friction: Annotated[
        Torque,
        Field(ge=0, description="the most that the bench's own supports add; half is taken off"),
    ] = 0.0
