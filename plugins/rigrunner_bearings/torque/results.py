"""The torque as a named result like any other: at each set-point, and its mean over them."""

from __future__ import annotations

from typing import TYPE_CHECKING

from rigrunner.api import MeasurementResult
from rigrunner.api.coordinates import CoordinateValue
from rigrunner_bearings.api.points import StartPoint
from rigrunner_bearings.torque.settings import FREQUENCY

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator, Sequence

    from rigrunner.api import Component, Estimate, ResultDefinition, RunData
    from rigrunner_bearings.api.compensations import CompensatedPoint
    from rigrunner_bearings.api.points import PeakPoint


def torque_at(
    definition: ResultDefinition,
    run: RunData,
    loaded: Sequence[PeakPoint],
    compensated: Sequence[CompensatedPoint],
    raw: Callable[[Sequence[PeakPoint]], Estimate | None],
) -> Iterator[MeasurementResult]:
    """Yield the torque of each set-point, in the order of the run; `raw` is without correction."""
    recorded = {each.name: each for each in run.recordings}
    for point, found in zip(loaded, compensated, strict=False):
        coordinates = {FREQUENCY: CoordinateValue(point.set_frequency_hz, "Hz")}
        source = None if isinstance(point, StartPoint) else recorded.get(point.recording)
        if source is not None:
            coordinates |= {
                name: CoordinateValue.of_si(
                    value, source.units.get(name, ""), source.written_in.get(name, "")
                )
                for name, value in source.coordinates.items()
            }
        yield MeasurementResult(
            of=definition,
            estimate=found.torque,
            components=found.components,
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
