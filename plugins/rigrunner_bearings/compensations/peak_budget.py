"""What the difference of two peaks is worth: the inputs that peak methods share."""

from __future__ import annotations

from math import isinf
from typing import TYPE_CHECKING

from rigrunner.api import Distribution, Effect, Input
from rigrunner_bearings.api.points import MotionSource

if TYPE_CHECKING:
    from collections.abc import Iterable

    from rigrunner.api import Array, Estimate
    from rigrunner_bearings.api.points import PeakPoint

SAME_PHASE = (
    "Assumes that the loaded and the no-load peak fall at the same phase of the swing. They do "
    "not, so the result drifts with frequency; the uncertainty does not include this."
)
NOISY_MAXIMUM = "The maximum of noisy samples is high by the noise's extreme value."
ENTERED = (
    "Nothing showed the frequency: it is the entered one, and how far that may be off is in the "
    "uncertainty."
)
SINGLE_VALUES = (
    "Single values, whose scatter is not known: so their uncertainty is not known either."
)


def frequency_effect(slope_nm_per_hz: float, frequency_hz: Estimate) -> Effect:
    """Return the effect of an uncertain frequency on a no-load peak that depends on it."""
    frequency = Input(
        "frequency",
        frequency_hz.value,
        frequency_hz.u,
        frequency_hz.dof,
        Distribution.RECTANGULAR if isinf(frequency_hz.dof) else Distribution.T,
        "Hz",
    )
    return Effect(frequency, -slope_nm_per_hz)


def scattered_peaks(*points: PeakPoint) -> list[Array]:
    """Return what each kept cycle's peak moves the mean peak of its point by, shapes (cycles,)."""
    kept = (point.peak_nm[point.peak_kept] for point in points if point.cycles > 1)
    return [values - values.mean() for values in kept]


def notes_on(points: Iterable[PeakPoint]) -> tuple[str, ...]:
    """Return the notes on any difference of such peaks."""
    all_points = tuple(points)
    single = any(point.cycles == 1 for point in all_points)
    entered = any(point.motion is MotionSource.ENTERED for point in all_points)
    return (
        SAME_PHASE,
        *((SINGLE_VALUES,) if single else (NOISY_MAXIMUM,)),
        *((ENTERED,) if entered else ()),
    )
