"""What each compensation needs of a run; loads without numpy."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from rigrunner_bearings.api.requirements import TorqueRequirements

if TYPE_CHECKING:
    from rigrunner_bearings.compensations.settings import (
        EnergySettings,
        PaperPeakSettings,
        PeakSameFrequencySettings,
        TemplateInverseSettings,
    )

LEAST_FREQUENCIES = 4
"""Without load, to learn the rig's resonance."""


def of_paper_peak(settings: PaperPeakSettings) -> TorqueRequirements:
    """Return what the compensation `paper_peak` needs."""
    if settings.coefficients == "published":
        return TorqueRequirements(starts=False)
    return TorqueRequirements(starts=False, fit=True, points=1, within_no_load_range=True)


def of_peak_same_frequency(settings: PeakSameFrequencySettings) -> TorqueRequirements:
    """Return what the compensation `peak_same_frequency` needs."""
    return TorqueRequirements(starts=False, frequency_match=settings.frequency_match)


def of_template_inverse(settings: TemplateInverseSettings) -> TorqueRequirements:
    """Return what the compensation `template_inverse` needs."""
    return TorqueRequirements(
        starts=False,
        phase=True,
        points=LEAST_FREQUENCIES,
        frequency_match=settings.frequency_match,
    )


def of_model_inverse(_: Any) -> TorqueRequirements:
    """Return what the compensation `model_inverse` needs."""
    return TorqueRequirements(
        starts=False, phase=True, points=LEAST_FREQUENCIES, within_no_load_range=True
    )


def of_energy(settings: EnergySettings) -> TorqueRequirements:
    """Return what the compensation `energy` needs."""
    return TorqueRequirements(starts=False, phase=True, frequency_match=settings.frequency_match)


def of_breakaway_peak(_: Any) -> TorqueRequirements:
    """Return what the compensation `breakaway_peak` needs."""
    return TorqueRequirements(starts=True)
