"""Breakaway torque of several starts from rest: their mean, less what the bench's supports add."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

from rigrunner.api import DataError, Effect
from rigrunner.signal.inputs import limited, model_of
from rigrunner.signal.transducer import transducer_effects
from rigrunner_bearings.api.compensations import Compensation
from rigrunner_bearings.api.points import StartPoint
from rigrunner_bearings.compensations.limits import load
from rigrunner_bearings.signal.compensated import compensated_point
from rigrunner_bearings.signal.peaks import mean_peak, scatter_effect
from rigrunner_bearings.signal.sensor import gain, reading_effects

if TYPE_CHECKING:
    from rigrunner_bearings.api.compensations import CompensatedPoint, Sweep
    from rigrunner_bearings.compensations.settings import BreakawayPeakSettings

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
            points=tuple(self._point(point, sweep) for point in starts),
            notes=(ONE_BEARING,),
        )

    def _point(self, point: StartPoint, sweep: Sweep) -> CompensatedPoint:
        """Return the mean less half the greatest fixture friction; the other half is its doubt.

        Friction between 0 and its limit has the expectation and the half-width of half of it
        (GUM 4.3.7).
        """
        raw = mean_peak(point)
        rig = self.settings.fixture_friction / 2
        effects = (
            scatter_effect("scatter between starts", raw),
            *reading_effects(sweep.instrument, zeroed=True),
            *transducer_effects(sweep.instrument, raw.value - rig, (raw.value,), slow=1.0),
            Effect(limited("fixture friction", rig, value=rig), -1.0),
        )
        scales = (gain(sweep.instrument), *((load(sweep.rig),) if point.load_n > 0 else ()))
        return compensated_point(
            model_of(raw.value - rig, effects, scales=scales),
            set_frequency_hz=point.set_frequency_hz,
            frequency_hz=point.frequency_hz.value,
            raw_nm=raw.value,
        )
