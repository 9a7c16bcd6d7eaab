"""What the difference of two peaks is worth: the components that peak methods share, in N·m."""

from __future__ import annotations

from dataclasses import replace
from math import sqrt
from typing import TYPE_CHECKING

from rigrunner.api.analysis import Component, MotionSource
from rigrunner.signal.sensor import rectangular, undivided

if TYPE_CHECKING:
    from collections.abc import Iterable

    from rigrunner.api.analysis import PeakPoint
    from rigrunner.api.data import Estimate
    from rigrunner.api.instruments import TorqueInstrument

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
    "Single values, whose scatter is not known: the uncertainty lacks it, and is a lower bound."
)


def sensor_components(
    instrument: TorqueInstrument, gain_acts_on_nm: float, runs: int
) -> tuple[Component, ...]:
    """Return gain, non-linearity and drift of a peak, or of the difference of two runs' peaks.

    Each run has drifted on its own since its zero reading. The zero takes the offset out.
    """
    accuracy = instrument.accuracy
    drift = rectangular("zero drift", accuracy.drift)
    return (
        rectangular("sensor gain", accuracy.gain * gain_acts_on_nm),
        rectangular("sensor non-linearity", accuracy.nonlinearity * instrument.full_scale),
        replace(drift, u=drift.u * sqrt(runs)),
        *undivided(instrument),
    )


def frequency_component(slope_nm_per_hz: float, frequency_hz: Estimate) -> Component:
    """Return what not knowing the frequency makes of a no-load peak that goes with it."""
    u = abs(slope_nm_per_hz) * frequency_hz.u
    return Component("frequency", u, frequency_hz.dof, "normal", common=False)


def notes_on(points: Iterable[PeakPoint]) -> tuple[str, ...]:
    """Return what is to be said of any difference of such peaks."""
    seen = tuple(points)
    single = any(point.cycles == 1 for point in seen)
    entered = any(point.motion is MotionSource.ENTERED for point in seen)
    return (
        SAME_PHASE,
        *((SINGLE_VALUES,) if single else (NOISY_MAXIMUM,)),
        *((ENTERED,) if entered else ()),
    )
