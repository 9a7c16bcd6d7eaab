"""Breakaway torque of several starts from rest: their mean, less what the bench's supports add."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

from rigrunner.api.analysis import CompensatedPoint, Compensation, StartPoint
from rigrunner.api.data import Estimate
from rigrunner.api.errors import DataError
from rigrunner.signal.peaks import mean_peak
from rigrunner.signal.sensor import reading_components, rectangular
from rigrunner.signal.uncertainty import combine

if TYPE_CHECKING:
    from rigrunner.api.analysis import Sweep
    from rigrunner.api.instruments import TorqueInstrument
    from rigrunner_plugins.compensations.breakaway_peak_settings import BreakawayPeakSettings

MEASURAND = "breakaway torque from rest"
ONE_BEARING = (
    "The scatter is that of repeated starts of one bearing in one set-up, after the same rest. "
    "Breakaway torque grows with the time at rest and changes as the bearing runs in."
)
REVERSALS = (
    "breakaway_peak needs starts from rest, and these are swings: what is measured at their "
    "reversals is another torque"
)


@dataclass(frozen=True)
class BreakawayPeak:
    """The mean of starts; satisfies `rigrunner.api.analysis.CompensationMethod`."""

    settings: BreakawayPeakSettings

    def __call__(self, sweep: Sweep) -> Compensation:
        """Return torque per speed; raise DataError where swings were recorded, not starts."""
        starts = [point for point in sweep.loaded if isinstance(point, StartPoint)]
        if len(starts) < len(sweep.loaded):
            raise DataError(REVERSALS, hint="say 'starts: {}' under analysis if they are starts")
        return Compensation(
            measurand=MEASURAND,
            points=tuple(self._point(point, sweep.instrument) for point in starts),
            notes=(ONE_BEARING,),
        )

    def _point(self, point: StartPoint, instrument: TorqueInstrument) -> CompensatedPoint:
        """Return the mean less half the greatest fixture friction; the other half is its doubt.

        Friction between 0 and its limit has the expectation and the half-width of half of it
        (GUM 4.3.7).
        """
        raw, scatter = mean_peak(point)
        rig = self.settings.fixture_friction / 2
        components = (
            *(replace(part, name="scatter between starts") for part in scatter),
            *reading_components(instrument, raw, zeroed=True),
            rectangular("fixture friction", rig),
        )
        u, dof = combine(components)
        return CompensatedPoint(
            set_frequency_hz=point.set_frequency_hz,
            frequency_hz=point.frequency_hz.value,
            raw_nm=raw,
            rig_nm=rig,
            torque=Estimate(raw - rig, u, dof),
            components=components,
        )
