"""What is to be said of how a run's motion was known."""

from __future__ import annotations

from typing import TYPE_CHECKING

from rigrunner.api import Check
from rigrunner_bearings.api.points import MotionSource
from rigrunner_bearings.signal.pulses import repetition_frequency
from rigrunner_bearings.torque.channels import torque_channel

if TYPE_CHECKING:
    from collections.abc import Iterable

    from rigrunner.api import RunData
    from rigrunner_bearings.api.points import PeakPoint

SEEN = {
    MotionSource.ANGLE: "angle says",
    MotionSource.TACHO: "tacho says",
    MotionSource.INDEX: "index pulses say",
    MotionSource.ENTERED: "torque repeats at",
}
FALLBACKS = {
    MotionSource.TACHO: "frequency and phase are from the tacho, with a larger uncertainty",
    MotionSource.INDEX: "frequency and phase are from one index pulse per cycle, with a larger "
    "uncertainty",
    MotionSource.ENTERED: "cycles were cut by the entered frequency, and only peak methods apply",
}
SINGLE = "single values at entered frequencies, whose scatter is unknown; only peak methods apply"


def motion_check(points: Iterable[PeakPoint], prefix: str = "") -> Check:
    """Return whether an angle channel showed the motion, or what stood for it."""
    found = dict.fromkeys(_stand_in(point) for point in points)
    stand_ins = "; ".join(text for text in found if text)
    return Check(
        f"{prefix}angle channel",
        ok=not stand_ins,
        text=f"no angle channel: {stand_ins}" if stand_ins else "frequency and phase are its own",
        advice="record the angle of the swing" if stand_ins else "",
    )


def seen_frequency_hz(point: PeakPoint, run: RunData) -> float:
    """Return the measured frequency; where only one was entered, that of the torque itself."""
    if point.motion is not MotionSource.ENTERED:
        return point.frequency_hz.value
    recording = next(each for each in run.recordings if each.name == point.recording)
    torque = recording.channels[torque_channel(recording, run.instruments)]
    return repetition_frequency(torque, recording.rate_hz, point.set_frequency_hz)


def _stand_in(point: PeakPoint) -> str:
    return SINGLE if point.cycles == 1 else FALLBACKS.get(point.motion, "")
