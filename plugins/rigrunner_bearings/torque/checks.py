"""What a technician wants flagged about a run, whatever the method."""

from __future__ import annotations

from dataclasses import replace
from math import asin, degrees, inf, sin, sqrt
from typing import TYPE_CHECKING

import numpy as np

from rigrunner.api import Check
from rigrunner.api.analysis import Bias
from rigrunner.api.checks import ABOVE_ZERO, Limit, skipped
from rigrunner.signal.blocks import blocks, limits
from rigrunner_bearings.api.points import MotionSource, StartPoint, SwingPoint
from rigrunner_bearings.api.rig import rig_of
from rigrunner_bearings.signal.pulses import repetition_frequency
from rigrunner_bearings.signal.stuck_samples import longest_at, longest_stuck
from rigrunner_bearings.signal.swings import kept_cycles
from rigrunner_bearings.torque.channels import torque_channel
from rigrunner_bearings.torque.sampling import ENOUGH, samples_per_cycle

if TYPE_CHECKING:
    from collections.abc import Iterable, Iterator, Sequence

    from rigrunner.api import Recording, RunData
    from rigrunner.api.data import Samples
    from rigrunner_bearings.api.points import PeakPoint


EQUAL_AT_RAIL = 3
SHORT = 2.0
"""Equal samples in a row that are usual anywhere: noise falls on the same step of a converter."""
ENTERED_FREQUENCY = Limit(
    name="entered frequency",
    good="what was measured agrees with the entered frequency within 0.5 %",
    advice="correct the entry or the drive; where the motion was recorded, results use its own",
    unit="%",
    upper=0.5,
)
STROKE = Limit(
    name="stroke",
    good="the swing is that of the rig's eccentric within 2 %",
    advice="check eccentric, guide wheel and the angle channel's scale",
    unit="%",
    upper=2.0,
)
STEADY = Limit(
    name="steady speed",
    good="the frequency of the cycles scatters by at most 0.05 %",
    advice="look for slip in the drive and a worn or loose encoder",
    unit="%",
    upper=0.05,
)
CLIPPING = Limit(
    name="clipping",
    good=f"nowhere {EQUAL_AT_RAIL} or more equal samples at the extreme",
    advice="a clipped peak is lost: use a larger range",
    unit="1",
    upper=EQUAL_AT_RAIL - 1,
    decisive=True,
)
STUCK = Limit(
    name="stuck torque",
    good="the torque never keeps its value for longer than three times as long as is usual",
    advice="the amplifier, converter or line hangs now and then: look at the samples there",
    unit="1",
    upper=3.0,
)
RANGE = Limit(
    name="range",
    good="no torque beyond 95 % of the sensor's full scale",
    advice="use a sensor or a range with more to spare",
    unit="%",
    upper=95.0,
)
SPIKES = Limit(
    name="spikes",
    good="at most one sample per cycle was replaced as a spike",
    advice="look for electrical disturbance; the spike filter may be cutting real torque",
    unit="1",
    upper=1.0,
)
CYCLES = Limit(
    name="cycles",
    good="at least 10 cycles kept in every mean",
    advice="record 30 cycles: the mean of few is uncertain",
    unit="1",
    lower=10.0,
)
SAMPLES = Limit(
    name="samples per cycle",
    good=f"at least {ENOUGH:g} samples in every cycle",
    advice="sample faster, or leave out the highest frequencies",
    unit="1",
    lower=ENOUGH,
)
ZERO = Limit(
    name="zero",
    good="the torque was zeroed before the run",
    advice="zero the channel in the procedure's setup; its offset is in the result",
    unit="1",
    upper=0.0,
)
ZERO_DRIFT = Limit(
    name="zero drift",
    good="zero readings of both runs agree within 0.02 N·m",
    advice="let the amplifier warm up, and repeat the no-load run",
    unit="N·m",
    upper=0.02,
)
FRICTION = Limit(
    name="friction coefficient",
    good="μ = T/(F·r) is between 0.01 and 0.3 at every set-point",
    advice="check load, swing radius and the no-load run",
    unit="1",
    lower=0.01,
    upper=0.3,
)
POSITIVE = Limit(
    name="positive torque",
    good="the compensated torque is positive at every set-point",
    advice="friction cannot drive: the no-load run or the method does not fit this run",
    unit="N·m",
    lower=ABOVE_ZERO,
)
LIMITS = (
    ENTERED_FREQUENCY,
    STROKE,
    STEADY,
    CLIPPING,
    STUCK,
    RANGE,
    SPIKES,
    CYCLES,
    SAMPLES,
    ZERO,
    ZERO_DRIFT,
    FRICTION,
    POSITIVE,
)


def run_checks(run: RunData, points: tuple[PeakPoint, ...], prefix: str = "") -> Iterator[Check]:
    """Yield the checks of one run and its prepared points, their names with that prefix."""
    swings = [point for point in points if isinstance(point, SwingPoint)]
    cyclic = [point for point in points if point.cycles > 1]
    yield motion_check(points, prefix)
    yield ENTERED_FREQUENCY.check((_wrong_frequency(point, run) for point in cyclic), prefix)
    rig = rig_of(run)
    angles = [point for point in swings if point.motion is MotionSource.ANGLE]
    yield STROKE.check((_wrong_stroke(point, rig.eccentric_ratio) for point in angles), prefix)
    yield STEADY.check(map(_unsteady, angles), prefix)
    clipped = CLIPPING.check((_clipped(recording, run) for recording in run.recordings), prefix)
    # A converter's coarse zero while a bearing rests before its start is no lost peak.
    yield replace(clipped, decisive=clipped.decisive and bool(swings))
    yield STUCK.check(
        (_stuck(point, run) for point in cyclic if not isinstance(point, StartPoint)), prefix
    )
    yield RANGE.check((_full_scale_used(recording, run) for recording in run.recordings), prefix)
    yield SPIKES.check(map(_spikes_per_cycle, points), prefix)
    yield CYCLES.check(map(_cycles, cyclic), prefix)
    yield SAMPLES.check(map(_samples, swings), prefix)
    torques = sorted({torque_channel(recording, run.instruments) for recording in run.recordings})
    yield ZERO.check(((float(name not in run.zeros), name) for name in torques), prefix)


def zero_drift_check(run: RunData, no_load: RunData) -> Check:
    """Compare the zero readings of a run and its no-load run, in N·m."""
    drifts = {
        channel: zero - no_load.zeros[channel]
        for channel, zero in run.zeros.items()
        if channel in no_load.zeros
    }
    return ZERO_DRIFT.check(
        (abs(drift), f"{channel} {drift:+.4f} N·m") for channel, drift in drifts.items()
    )


def friction_check(
    torques_nm: Sequence[tuple[float, float]], loads_n: Sequence[float], swing_radius_m: float
) -> Check:
    """Check mu = T / (F r) at each set-point: its frequency in Hz and torque, and its load."""
    if min(loads_n) <= 0:
        return skipped(FRICTION.name, "the run has no load")
    return FRICTION.check(
        (mu := torque / (load_n * swing_radius_m), f"{f:g} Hz μ = {mu:.4f}")
        for (f, torque), load_n in zip(torques_nm, loads_n, strict=True)
    )


def positive_check(torques_nm: Iterable[tuple[float, float]]) -> Check:
    """Check that no compensated torque is zero or negative: frequency in Hz, torque.

    One that is not positive is off by what it lacks to those of the others, at least.
    """
    points = list(torques_nm)
    usual = float(np.median([abs(torque) for _, torque in points]))
    check = POSITIVE.check((torque, f"{f:g} Hz {torque:.4f} N·m") for f, torque in points)
    lacking = [(f, torque - usual if torque <= 0 else 0.0) for f, torque in points]
    return replace(
        check, biases=tuple(Bias(f"{f:g} Hz", bias, abs(bias) / 2) for f, bias in lacking)
    )


def _wrong_frequency(point: PeakPoint, run: RunData) -> tuple[float, str]:
    measured, entered = seen_frequency_hz(point, run), point.set_frequency_hz
    percent = 100 * abs(measured - entered) / abs(entered)
    source = f"{SEEN[point.motion]} {measured:.4g} Hz"
    return percent, f"{point.recording} entered {entered:g} Hz, {source}"


def _wrong_stroke(point: SwingPoint, ratio: float) -> tuple[float, str]:
    amplitude_rad = float(point.angle_rad.max() - point.angle_rad.min()) / 2
    measured = sin(amplitude_rad)
    words = (
        f"{point.recording} swings ±{degrees(asin(measured)):.3f}°"
        f" in place of ±{degrees(asin(ratio)):.3f}°"
    )
    return 100 * abs(measured / ratio - 1), words


def _unsteady(point: SwingPoint) -> tuple[float, str]:
    """Return the standard deviation of one cycle's frequency, from that of the mean, in percent."""
    scatter = point.frequency_hz.u * sqrt(point.frequency_hz.dof + 1)
    percent = 100 * scatter / point.frequency_hz.value
    return percent, f"{point.recording} scatters by {percent:.2f} %"


def _clipped(recording: Recording, run: RunData) -> tuple[float, str]:
    torque = recording.channels[torque_channel(recording, run.instruments)]
    equal = longest_at(torque, limits(torque))
    return equal, f"{recording.name} has {equal} equal samples at its extreme"


def _stuck(point: PeakPoint, run: RunData) -> tuple[float, str]:
    """Return the longest run of equal samples over what is usual in a cycle of the recording.

    A coarse converter, or a logger that repeats its samples, does so in every cycle. What is usual
    is held to a quarter of a cycle: a torque that swings keeps no value for a whole one.
    """
    recording = next(recording for recording in run.recordings if recording.name == point.recording)
    torque = recording.channels[torque_channel(recording, run.instruments)]
    stuck = longest_stuck(torque, point.cycles)
    usual = min(max(float(np.median(stuck)), SHORT), len(torque) / point.cycles / (STUCK.upper + 1))
    words = f"{point.recording} keeps one value for {stuck.max()} samples, {usual:.0f} are usual"
    return float(stuck.max()) / usual, words


def _full_scale_used(recording: Recording, run: RunData) -> tuple[float, str]:
    """Return how much of full scale is used, by two neighbours: a single spike does not count."""
    channel = torque_channel(recording, run.instruments)
    instrument = run.instruments.get(channel)
    if instrument is None:
        return 0.0, ""
    peak = _peak_of_pairs(recording.channels[channel])
    percent = 100 * peak / instrument.full_scale
    return percent, f"{recording.name} reaches {percent:.0f} % of {instrument.full_scale:g} N·m"


def _peak_of_pairs(torque: Samples) -> float:
    peak, last = -inf, np.empty(0)
    for _, part in blocks(torque):
        pairs = np.concatenate([last, part])
        upper, lower = np.minimum(pairs[1:], pairs[:-1]), np.maximum(pairs[1:], pairs[:-1])
        if len(pairs) > 1:
            peak = max(peak, upper.max(), -lower.min())
        last = part[-1:]
    return float(peak) if peak > -inf else 0.0


def _spikes_per_cycle(point: PeakPoint) -> tuple[float, str]:
    words = f"{point.recording} {point.spikes} samples in {point.cycles} cycles"
    return point.spikes / point.cycles, words


def _cycles(point: PeakPoint) -> tuple[float, str]:
    kept = kept_cycles(point) if isinstance(point, SwingPoint) else point.peak_kept
    return int(kept.sum()), f"{point.recording} {kept.sum()} of {point.cycles} cycles"


def _samples(point: SwingPoint) -> tuple[float, str]:
    count = samples_per_cycle(point)
    return count, f"{point.recording} {count:.0f}"


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
    texts = dict.fromkeys(
        SINGLE if point.cycles == 1 else FALLBACKS.get(point.motion, "") for point in points
    )
    stand_ins = "; ".join(text for text in texts if text)
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
    recording = next(recording for recording in run.recordings if recording.name == point.recording)
    torque = recording.channels[torque_channel(recording, run.instruments)]
    return repetition_frequency(torque, recording.rate_hz, point.set_frequency_hz)
