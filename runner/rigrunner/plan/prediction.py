"""What a plan will probably show, before the rig is touched: torque against range, and disk."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

from rigrunner.api.instruments import TORQUE

if TYPE_CHECKING:
    from collections.abc import Iterable, Mapping

    from rigrunner.api.instruments import Instrument
    from rigrunner.api.planned import ExpectedReading, RecordingAction
    from rigrunner.plan.actions import Plan

_BYTES_PER_SAMPLE = 8


@dataclass(frozen=True)
class PredictedTorque:
    """The largest torque to be expected in a recording, and what the instrument can take."""

    recording: str
    frequency_hz: float
    peak_nm: float
    full_scale_nm: float

    @property
    def share(self) -> float:
        """The peak over full scale; above 1 the instrument is overloaded."""
        return self.peak_nm / self.full_scale_nm


@dataclass(frozen=True)
class Prediction:
    """What a plan will probably show."""

    torques: tuple[PredictedTorque, ...]
    """One for each recording of which an analysis says what torque to expect."""
    disk_bytes: int
    """The samples of all recordings as the journal keeps them, before compression."""

    @property
    def overloads(self) -> tuple[PredictedTorque, ...]:
        """The recordings in which the instrument would be overloaded."""
        return tuple(each for each in self.torques if each.share > 1)


def predict(
    plan: Plan, expected: Iterable[ExpectedReading], register: Mapping[str, Instrument]
) -> Prediction:
    """Return the torque to be expected in each recording, and the disk that the run needs."""
    records = {each.record.name: each.record for each in plan.recordings}
    torques = tuple(
        PredictedTorque(
            each.recording,
            records[each.recording].cycle_frequency_hz or 0.0,
            max(abs(each.low), abs(each.high)),
            known.full_scale,
        )
        for each in expected
        if (known := register.get(each.channel)) is not None and known.quantity == TORQUE
    )
    return Prediction(torques, sum(_bytes(each.record) for each in plan.recordings))


def _bytes(record: RecordingAction) -> int:
    samples = round(record.duration_s * (record.sample_rate_hz or 0.0))
    return samples * len(record.channels) * _BYTES_PER_SAMPLE
