"""What a technician wants flagged about a run, whatever the method."""

from __future__ import annotations

from math import asin, degrees, sin
from typing import TYPE_CHECKING

import numpy as np

from rigrunner.analysis.channels import torque_channel
from rigrunner.api.analysis import Check, MotionSource, SwingPoint

if TYPE_CHECKING:
    from collections.abc import Iterable, Iterator, Mapping

    from rigrunner.api.analysis import PeakPoint
    from rigrunner.api.data import Array, Recording, RunData
    from rigrunner.api.instruments import TorqueInstrument

FREQUENCY_TOLERANCE = 0.005
STROKE_TOLERANCE = 0.02
FULL_SCALE_SHARE = 0.95
EQUAL_AT_RAIL = 3
SPIKES_PER_CYCLE = 1.0
ZERO_DRIFT_NM = 0.02
FEW_CYCLES = 10
PLAUSIBLE_FRICTION = (0.01, 0.3)


def run_checks(run: RunData, points: tuple[PeakPoint, ...], prefix: str = "") -> Iterator[Check]:
    """Yield the checks of one run and its prepared points, their names with that prefix."""
    yield _listed(
        f"{prefix}entered frequency",
        "the angle agrees with the entered frequency within 0.5 %",
        (_wrong_frequency(point) for point in points),
        "the results use the frequency of the angle; correct the entry or the drive",
    )
    yield _listed(
        f"{prefix}stroke",
        f"the swing is that of the rig's eccentric, ±{degrees(asin(run.rig.eccentric_ratio)):.3f}°,"
        " within 2 %",
        (_wrong_stroke(point, run.rig.eccentric_ratio) for point in points),
        "check eccentric, guide wheel and the angle channel's scale",
    )
    yield _listed(
        f"{prefix}range",
        "no sample is clipped or near the sensor's full scale",
        (_clipped(recording, run) for recording in run.recordings),
        "a clipped peak is lost: use a larger range",
    )
    yield _listed(
        f"{prefix}spikes",
        "at most one sample per cycle was replaced as a spike",
        (_spiky(point) for point in points),
        "look for electrical disturbance; the spike filter may be cutting real torque",
    )
    yield _listed(
        f"{prefix}cycles",
        f"each set-point has at least {FEW_CYCLES} cycles",
        (_few_cycles(point) for point in points),
        "record 30 cycles: the mean of few is uncertain",
    )
    yield _zeroed(run, prefix)


def zero_drift_check(run: RunData, no_load: RunData) -> Check:
    """Compare the zero readings of a run and its no-load run, in N·m."""
    drifts = {
        channel: zero - no_load.zeros[channel]
        for channel, zero in run.zeros.items()
        if channel in no_load.zeros
    }
    return _listed(
        "zero drift",
        f"zero readings of both runs agree within {ZERO_DRIFT_NM} N·m",
        (
            f"{channel} {drift:+.4f} N·m" if abs(drift) > ZERO_DRIFT_NM else None
            for channel, drift in drifts.items()
        ),
        "let the amplifier warm up, and repeat the no-load run",
    )


def friction_check(
    torques_nm: Mapping[float, float], load_n: float, swing_radius_m: float
) -> Check:
    """Check mu = T / (F r) of the compensated torque at each frequency in Hz."""
    low, high = PLAUSIBLE_FRICTION
    friction = {f: torque / (load_n * swing_radius_m) for f, torque in torques_nm.items()}
    return _listed(
        "friction coefficient",
        f"μ = T/(F·r) is between {low} and {high} at every set-point",
        (f"{f:g} Hz μ = {mu:.4f}" if not low <= mu <= high else None for f, mu in friction.items()),
        "check load, swing radius and the no-load run",
    )


def positive_check(torques_nm: Mapping[float, float]) -> Check:
    """Check that no compensated torque is zero or negative."""
    return _listed(
        "positive torque",
        "the compensated torque is positive at every set-point",
        (f"{f:g} Hz {torque:.4f} N·m" if torque <= 0 else None for f, torque in torques_nm.items()),
        "friction cannot drive: the no-load run or the method does not fit this run",
    )


def _wrong_frequency(point: PeakPoint) -> str | None:
    measured, entered = point.frequency_hz.value, point.set_frequency_hz
    if abs(measured - entered) <= FREQUENCY_TOLERANCE * abs(entered):
        return None
    return f"{point.recording} entered {entered:g} Hz, angle says {measured:.4g} Hz"


def _wrong_stroke(point: PeakPoint, ratio: float) -> str | None:
    if not isinstance(point, SwingPoint) or point.motion is not MotionSource.ANGLE:
        return None
    measured = sin(_amplitude(point.angle_rad))
    if abs(measured / ratio - 1) <= STROKE_TOLERANCE:
        return None
    return f"{point.recording} swings ±{degrees(asin(measured)):.3f}°"


def _amplitude(angle_rad: Array) -> float:
    return float(angle_rad.max() - angle_rad.min()) / 2


def _clipped(recording: Recording, run: RunData) -> str | None:
    channel = torque_channel(recording, run.instruments)
    torque = recording.channels[channel]
    if _equal_at_extreme(torque):
        return f"{recording.name} has {EQUAL_AT_RAIL} or more equal samples at its extreme"
    instrument = run.instruments.get(channel)
    if instrument is not None and _beyond(torque, instrument):
        return f"{recording.name} exceeds 95 % of {instrument.full_scale:g} N·m"
    return None


def _equal_at_extreme(torque: Array) -> bool:
    return any(
        _longest_run(torque == extreme) >= EQUAL_AT_RAIL for extreme in (torque.max(), torque.min())
    )


def _longest_run(flags: Array) -> int:
    edges = np.diff(np.concatenate([[0], flags.astype(np.int8), [0]]))
    return int((np.flatnonzero(edges < 0) - np.flatnonzero(edges > 0)).max())


def _beyond(torque: Array, instrument: TorqueInstrument) -> bool:
    """Return whether two neighbours are beyond on the same side: a single spike is not."""
    limit = FULL_SCALE_SHARE * instrument.full_scale
    beyond = (torque > limit).astype(int) - (torque < -limit).astype(int)
    return bool(np.any(beyond[1:] * beyond[:-1] > 0))


def _spiky(point: PeakPoint) -> str | None:
    if point.spikes <= SPIKES_PER_CYCLE * point.cycles:
        return None
    return f"{point.recording} {point.spikes} samples in {point.cycles} cycles"


def _few_cycles(point: PeakPoint) -> str | None:
    return None if point.cycles >= FEW_CYCLES else f"{point.recording} {point.cycles} cycles"


def _zeroed(run: RunData, prefix: str) -> Check:
    channels = sorted({torque_channel(each, run.instruments) for each in run.recordings})
    return _listed(
        f"{prefix}zero",
        "the torque was zeroed before the run",
        (None if channel in run.zeros else channel for channel in channels),
        "zero the channel in the procedure's setup; its offset is in the result",
    )


def _listed(name: str, good: str, found: Iterable[str | None], advice: str) -> Check:
    bad = [text for text in found if text is not None]
    return Check(name, ok=not bad, text="; ".join(bad) or good, advice=advice if bad else "")
