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
        Field(
            gt=0,
            le=0.05,
            description="largest difference between the measured frequencies of a pair",
        ),
    ] = 0.02


class SupportSettings(Settings):
    """What is known of the support's friction under load, where the station says nothing of it."""

    support_load_growth: Annotated[
        Ratio | None,
        Field(
            gt=-1,
            description="known increase of the support's friction with the load; 0 if only "
            "support_load_dependence is given",
        ),
    ] = None
    support_load_dependence: Annotated[
        Ratio | None,
        Field(
            ge=0,
            description="limit of the change of the support's friction with the load, beyond "
            "support_load_growth; without either, the range in the literature is assumed",
        ),
    ] = None

    @model_validator(mode="after")
    def _has_a_limit(self) -> Self:
        refuse_growth_without_limit(self.support_load_growth, self.support_load_dependence)
        return self


class InverseSettings(SupportSettings):
    """Settings of `model_inverse`, and of all compensations that undo the drive line.

    Mismatch, dependence and tolerance are limits (half-widths of rectangular distributions):
    replace them with those of your rig.
    """

    window: Annotated[
        Angle,
        Field(gt=0, description="travel after a reversal in which the starting torque is searched"),
    ] = DEGREE
    inertia_mismatch: Annotated[
        Ratio,
        Field(ge=0, description="limit of the difference of the inertia between the two runs"),
    ] = 0.001
    low_pass_tolerance: Annotated[
        Ratio, Field(ge=0, description="limit of error of the low-pass filter's corner frequency")
    ] = 0.02
    mains_frequency: Annotated[
        Frequency, Field(gt=0, description="frequency of the mains, whose hum is removed")
    ] = 50.0


class TemplateInverseSettings(InverseSettings, WaveformSettings):
    """Settings of the compensation `template_inverse`."""


class EnergySettings(SupportSettings, WaveformSettings):
    """Settings of the compensation `energy`."""


class PaperPeakSettings(Settings):
    """Settings of the compensation `paper_peak`."""

    coefficients: Annotated[
        Literal["published", "refit"],
        Field(
            description="coefficients of Eq. (1): those of the authors' rig, or fitted to this "
            "rig's no-load run"
        ),
    ] = "refit"


class PeakSameFrequencySettings(Settings):
    """Settings of the compensation `peak_same_frequency`."""

    frequency_match: Annotated[
        Ratio,
        Field(gt=0, le=0.05, description="largest difference between the frequencies of a pair"),
    ] = 0.01


class BreakawayPeakSettings(Settings):
    """Settings of the compensation `breakaway_peak`."""

    fixture_friction: Annotated[
        Torque,
        Field(
            ge=0,
            description="largest torque that the bench's supports add; half of it is subtracted",
        ),
    ] = 0.0
