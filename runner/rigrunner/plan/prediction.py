"""What a plan will probably show, before the rig is touched: torque against range, and disk."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

from rigrunner.api.member import Member
from rigrunner.api.quantity import Quantity
from rigrunner.plan.needs import channels_of
from rigrunner.procedure.limits import torque_limits

if TYPE_CHECKING:
    from rigrunner.api.rig import RigDescription
    from rigrunner.plan.actions import Plan, Recording
    from rigrunner.procedure import LoadedProcedure
    from rigrunner.station import LoadedStation

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
    """One for each recording of a torque in cyclic motion, of a rig whose design is known."""
    disk_bytes: int
    """The samples of all recordings as the journal keeps them, before compression."""

    @property
    def overloads(self) -> tuple[PredictedTorque, ...]:
        """The recordings in which the instrument would be overloaded."""
        return tuple(each for each in self.torques if each.share > 1)


def predict(procedure: LoadedProcedure, station: LoadedStation, plan: Plan) -> Prediction:
    """Return the torque to be expected in each recording, and the disk that the run needs."""
    highest = (limit.max for _, limit in torque_limits(procedure))
    bearing_nm = max((each.si for each in highest if isinstance(each, Quantity)), default=0.0)
    records = [each.record for each in plan.recordings]
    torques = tuple(
        PredictedTorque(record.name, frequency_hz, rig_nm + bearing_nm, known.full_scale)
        for record in records
        if (frequency_hz := record.cycle_frequency_hz)
        and (rig_nm := rig_torque_nm(station.rig, frequency_hz)) is not None
        for channel in channels_of(record, "torque")
        if (known := station.register.get(Member(record.role, channel)))
    )
    return Prediction(torques, sum(map(_bytes, records)))


def rig_torque_nm(rig: RigDescription, frequency_hz: float) -> float | None:
    """Return an upper estimate of what the rig itself puts on the sensor; None: it is not known.

    Inertia, friction and damping of the supports at their greatest, which do not fall together:
    J max|alpha| + T0 + b max|omega| (torque balance of the spindle; Wang et al. 2025, section 2).
    """
    if rig.inertia is None or rig.support_friction is None or rig.support_damping is None:
        return None
    if not rig.swings:
        return None
    ratio = rig.eccentric_ratio
    from rigrunner.signal.kinematics import max_acceleration, max_speed  # noqa: PLC0415  (numpy)

    inertia_nm = rig.inertia * max_acceleration(frequency_hz, ratio)
    damping_nm = rig.support_damping * max_speed(frequency_hz, ratio)
    return inertia_nm + rig.support_friction + damping_nm


def _bytes(record: Recording) -> int:
    samples = round(record.duration_s * (record.sample_rate_hz or 0.0))
    return samples * len(record.channels) * _BYTES_PER_SAMPLE
