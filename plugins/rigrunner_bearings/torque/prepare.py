"""Prepares one recording: zero, spikes, cycles from the motion, gross errors.

Two kinds of methods follow. Peak methods take each cycle's raw maximum, as Wang et al. do
(Machines 2025, 13(11), 976); waveform methods take means over cycles on the crank phase. Each has
its own gross errors: a peak that disagrees, or a cycle whose whole shape does.
"""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from rigrunner.api import DataError
from rigrunner.api.analysis.requirements import LEAST_CYCLES
from rigrunner.signal.averaging import robust_mean
from rigrunner.signal.extremes import extremes
from rigrunner.signal.spikes import despiked
from rigrunner_bearings.api.points import MotionSource, PeakPoint, SwingPoint
from rigrunner_bearings.torque.channels import load_n, set_frequency, torque_channel
from rigrunner_bearings.torque.clocks import alignment_u_s
from rigrunner_bearings.torque.motion import entered_frequency, find_motion
from rigrunner_bearings.torque.reading import torque_reading
from rigrunner_bearings.torque.waveforms import row_of, waveforms

if TYPE_CHECKING:
    from rigrunner.api import Array, Mask, OutlierRule, Recording, Rejection, RunData
    from rigrunner_bearings.torque.settings import TorqueSettings


def prepare_point(
    recording: Recording, run: RunData, spec: TorqueSettings, rule: OutlierRule
) -> PeakPoint:
    """Return one recording prepared: a SwingPoint where its motion was recorded.

    Raises DataError naming recording and channel.
    """
    if recording.samples == 1:
        return _single_value(recording, run)
    name = torque_channel(recording, run.instruments)
    torque, spikes = torque_reading(recording, name, run), 0
    if spec.despike is not None:
        torque, spikes = despiked(torque, spec.despike.window, spec.despike.threshold)
    motion = find_motion(recording, run, torque)
    # The greatest sample of each cycle.
    peaks = extremes(torque, np.ceil(motion.starts).astype(np.intp))[1]
    kept, rejections = _judged(recording, name, peaks, rule)
    point = PeakPoint(
        recording=recording.name,
        set_frequency_hz=set_frequency(recording, name),
        frequency_hz=motion.frequency_hz,
        load_n=load_n(recording, name),
        peak_nm=peaks,
        peak_kept=kept,
        peak_rejections=rejections,
        spikes=spikes,
        motion=motion.source,
    )
    if motion.mean_angle is None:
        return point
    torque_nm = waveforms(torque, motion.starts)
    # By each row's rms distance in N·m from the robust mean of all.
    mean, _ = robust_mean(torque_nm, np.ones(len(torque_nm), bool))
    apart_nm = np.sqrt(np.mean((torque_nm - mean) ** 2, axis=1))
    kept, rejections = _judged(recording, name, np.asarray(apart_nm), rule)
    return SwingPoint(
        **vars(point),
        sample_rate_hz=recording.rate_hz,
        angle_rad=motion.mean_angle(kept[row_of(point.cycles)]),
        torque_nm=torque_nm,
        kept=kept,
        # By the first cycle of each row.
        waveform_rejections=tuple(
            replace(rejection, index=-(-rejection.index * point.cycles // len(kept)))
            for rejection in rejections
        ),
        phase_u_rad=motion.phase_u_rad,
        phase_common_u_rad=motion.phase_common_u_rad,
        alignment_u_s=alignment_u_s(recording, name, motion.channel),
    )


def _single_value(recording: Recording, run: RunData) -> PeakPoint:
    """Return a value that was measured once: no cycle, no scatter, the frequency as entered."""
    name = torque_channel(recording, run.instruments)
    entered_hz = set_frequency(recording, name)
    return PeakPoint(
        recording=recording.name,
        set_frequency_hz=entered_hz,
        frequency_hz=entered_frequency(entered_hz),
        load_n=load_n(recording, name),
        peak_nm=np.asarray(torque_reading(recording, name, run)),
        peak_kept=np.ones(1, bool),
        motion=MotionSource.ENTERED,
    )


def _judged(
    recording: Recording, name: str, values: Array, rule: OutlierRule
) -> tuple[Mask, tuple[Rejection, ...]]:
    """Return which cycles the rule keeps by these values (cycles,), and its rejections."""
    try:
        rejections = tuple(rule(values))
    except DataError as error:
        where = f"recording {recording.name}, {name}"
        raise DataError(f"{where}: {error.message}", hint=error.hint) from error
    kept = np.ones(len(values), bool)
    kept[[rejection.index for rejection in rejections]] = False
    if kept.sum() < LEAST_CYCLES:
        raise DataError(
            f"recording {recording.name}, {name}: of {len(kept)} cycles only {kept.sum()} remain "
            f"after gross errors, but {LEAST_CYCLES} are needed",
            hint="look at the recording: cycles that differ so much have no common value",
        )
    return kept, rejections
