"""The results of a run: its torque at each set-point, and the mean with what they share."""

from __future__ import annotations

from typing import TYPE_CHECKING

from rigrunner.api import MeasurementResult
from rigrunner.api.coordinates import CoordinateValue
from rigrunner.signal.inputs import model_of
from rigrunner.signal.propagation import propagate
from rigrunner.signal.transducer import transducer_effects
from rigrunner_bearings.api.points import StartPoint
from rigrunner_bearings.signal.mean_model import mean_model, mean_of_models
from rigrunner_bearings.signal.peaks import mean_peak, scatter_effect
from rigrunner_bearings.signal.sensor import gain, reading_effects
from rigrunner_bearings.torque.settings import FREQUENCY

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator, Sequence

    from rigrunner.api import Component, Estimate, Instrument, ResultDefinition, RunData
    from rigrunner_bearings.api.compensations import CompensatedPoint, Compensation
    from rigrunner_bearings.api.points import PeakPoint


LEAST_FOR_SCATTER = 2


def compensated_mean(points: Sequence[CompensatedPoint]) -> Estimate:
    """Return the mean of the compensated torque over the set-points."""
    return propagate(mean_model(points)).estimate


def budget_of_mean(points: Sequence[CompensatedPoint]) -> tuple[Component, ...]:
    """Return the budget of that mean, a line for each that the points have."""
    return propagate(mean_model(points)).components


def without_scatter(
    loaded: Sequence[PeakPoint], no_load: Sequence[PeakPoint], compensation: Compensation
) -> str:
    """Return which single values leave type A unknown, as a sentence; '' where none do.

    A no-load value that goes into a fitted curve has its scatter about that curve.
    """
    used = loaded if compensation.curve is not None else (*loaded, *no_load)
    names = dict.fromkeys(
        f"{point.set_frequency_hz:g} Hz"
        for point in used
        if point.peak_kept.sum() < LEAST_FOR_SCATTER
    )
    if not names:
        return ""
    return (
        f"A single value shows no scatter (at {', '.join(names)}): the uncertainty lacks its "
        "type A part, and no probability can be stated."
    )


def raw_peak_mean(points: Sequence[PeakPoint], instrument: Instrument, *, zeroed: bool) -> Estimate:
    """Return the mean over the set-points of the raw peaks, with the sensor's uncertainty."""
    models = []
    for point in points:
        peak = mean_peak(point)
        effects = (
            scatter_effect("scatter between cycles", peak),
            *reading_effects(instrument, zeroed=zeroed),
            *transducer_effects(instrument, peak.value, (peak.value,), slow=1.0),
        )
        models.append(model_of(peak.value, effects, scales=(gain(instrument),)))
    return propagate(mean_of_models(models)).estimate


def torque_at(
    definition: ResultDefinition,
    run: RunData,
    loaded: Sequence[PeakPoint],
    compensated: Sequence[CompensatedPoint],
    raw: Callable[[Sequence[PeakPoint]], Estimate | None],
) -> Iterator[MeasurementResult]:
    """Yield the torque of each set-point, in the order of the run; `raw` is without correction."""
    recordings = {recording.name: recording for recording in run.recordings}
    for point, compensated_point in zip(loaded, compensated, strict=False):
        coordinates = {FREQUENCY: CoordinateValue(point.set_frequency_hz, "Hz")}
        source = None if isinstance(point, StartPoint) else recordings.get(point.recording)
        if source is not None:
            coordinates |= {
                name: CoordinateValue.of_si(
                    value, source.units.get(name, ""), source.written_in.get(name, "")
                )
                for name, value in source.coordinates.items()
            }
        yield MeasurementResult(
            of=definition,
            estimate=compensated_point.torque,
            components=compensated_point.components,
            coordinates=coordinates,
            readings=int(point.peak_kept.sum()),
            uncorrected=raw([point]),
        )


def mean_torque(
    definition: ResultDefinition,
    loaded: Sequence[PeakPoint],
    mean: Estimate,
    components: tuple[Component, ...],
    raw: Estimate | None,
) -> MeasurementResult:
    """Return the mean over the set-points, in which what they share counts once."""
    return MeasurementResult(
        of=definition,
        estimate=mean,
        components=components,
        readings=sum(int(point.peak_kept.sum()) for point in loaded),
        uncorrected=raw,
    )
