"""What the compensations can be told; loads without numpy."""

from __future__ import annotations

from typing import Annotated

from pydantic import Field

from rigrunner.api.settings import Angle, Frequency, Ratio, Settings

DEGREE = 0.017453292519943295


class WaveformSettings(Settings):
    """Of every method that compares whole swings of the loaded and the no-load run."""

    frequency_match: Annotated[
        Ratio,
        Field(gt=0, le=0.05, description="how far the measured frequencies of a pair may differ"),
    ] = 0.02


class InverseSettings(Settings):
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
    support_load_dependence: Annotated[
        Ratio, Field(ge=0, description="of the support's friction, by which the load may raise it")
    ] = 0.01
    low_pass_tolerance: Annotated[
        Ratio, Field(ge=0, description="of the low-pass filter's corner frequency")
    ] = 0.02
    support_load_growth: Annotated[
        Ratio,
        Field(gt=-1, description="of the support's friction, as the load is known to raise it"),
    ] = 0.0
    mains_frequency: Annotated[
        Frequency, Field(gt=0, description="of the mains, whose hum is taken out")
    ] = 50.0


class TemplateInverseSettings(InverseSettings, WaveformSettings):
    """Of the compensation `template_inverse`."""


class EnergySettings(WaveformSettings):
    """Of the compensation `energy`."""

    support_load_dependence: Annotated[
        Ratio, Field(ge=0, description="of the support's friction, by which the load may raise it")
    ] = 0.01
