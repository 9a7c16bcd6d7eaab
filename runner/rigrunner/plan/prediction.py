"""What a plan will probably show, before the rig is touched: readings against range, and disk."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from collections.abc import Iterable, Mapping

    from rigrunner.api.instruments import Instrument
    from rigrunner.api.planned import ExpectedReading, RecordingAction
    from rigrunner.api.unit_tables import Unit
    from rigrunner.plan.actions import Plan

_BYTES_PER_SAMPLE = 8  # float64


@dataclass(frozen=True)
class PredictedReading:
    """The greatest value that a channel will probably show in a recording, and its full scale."""

    recording: str
    cycle_frequency_hz: float | None
    """Frequency of the cycles of the recording; None if it has none."""
    channel: str
    peak: float
    """The greatest amount to be expected."""
    full_scale: float
    unit: str
    """Unit of both, as the station states the full scale."""

    @property
    def share(self) -> float:
        """The peak over full scale; above 1 the instrument is overloaded."""
        return self.peak / self.full_scale


@dataclass(frozen=True)
class Prediction:
    """What a plan will probably show."""

    readings: tuple[PredictedReading, ...]
    """One for each recording and channel of which an analysis says what to expect."""
    disk_bytes: int
    """The samples of all recordings as the journal keeps them, before compression."""

    @property
    def overloads(self) -> tuple[PredictedReading, ...]:
        """The readings that would overload their instrument."""
        return tuple(each for each in self.readings if each.share > 1)


def predict(
    plan: Plan, expected: Iterable[ExpectedReading], register: Mapping[str, Instrument]
) -> Prediction:
    """Return the readings to be expected in each recording, and the disk that the run needs.

    A channel has none without an instrument, without a full scale, and on a scale whose zero is
    arbitrary, such as °C: a share of full scale means nothing there.
    """
    records = {recorded.record.name: recorded.record for recorded in plan.recordings}
    readings = tuple(
        _reading(reading, records[reading.recording], instrument)
        for reading in expected
        if (instrument := register.get(reading.channel)) is not None
        and instrument.full_scale > 0
        and _full_scale_unit(instrument).offset == 0
    )
    samples = (
        round(record.duration_s * (record.sample_rate_hz or 0.0)) * len(record.channels)
        for record in (recorded.record for recorded in plan.recordings)
    )
    return Prediction(readings, _BYTES_PER_SAMPLE * sum(samples))


def _reading(
    expected: ExpectedReading, record: RecordingAction, instrument: Instrument
) -> PredictedReading:
    unit = _full_scale_unit(instrument)
    return PredictedReading(
        recording=expected.recording,
        cycle_frequency_hz=record.cycle_frequency_hz,
        channel=expected.channel,
        peak=max(abs(expected.low), abs(expected.high)) / unit.factor,
        full_scale=instrument.full_scale / unit.factor,
        unit=unit.symbol,
    )


def _full_scale_unit(instrument: Instrument) -> Unit:
    if instrument.full_scale_ is not None:
        return instrument.full_scale_.unit
    if instrument.range_ is not None:
        return instrument.range_.max.unit
    return instrument.points[0].applied.unit
