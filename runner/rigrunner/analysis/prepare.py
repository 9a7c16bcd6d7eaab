"""Prepares one recording: zero, spikes, cycles from the angle, gross errors.

Two kinds of methods follow. Peak methods take each cycle's raw maximum, as Wang et al. do
(Machines 2025, 13(11), 976); waveform methods take means over cycles on the crank phase. Each has
its own gross errors: a peak that disagrees, or a cycle whose whole shape does.
"""

from __future__ import annotations

from itertools import pairwise
from math import sqrt
from typing import TYPE_CHECKING

import numpy as np

from rigrunner.analysis.channels import angle_channel, load_n, set_point, torque_channel
from rigrunner.api.analysis import SwingPoint
from rigrunner.api.data import Estimate
from rigrunner.api.errors import DataError
from rigrunner.signal.averaging import robust_mean
from rigrunner.signal.cycles import Cycles, find_cycles, resample
from rigrunner.signal.spikes import hampel

if TYPE_CHECKING:
    from rigrunner.api.analysis import OutlierRule, Rejection
    from rigrunner.api.data import Array, Mask, Recording, RunData
    from rigrunner.procedure import AnalysisSpec

PHASES = 1024
LEAST_CYCLES = 5
"""With fewer, neither a gross error nor a mean's scatter can be told."""


def prepare_point(
    recording: Recording, run: RunData, spec: AnalysisSpec, rule: OutlierRule
) -> SwingPoint:
    """Return one recording prepared; raise DataError naming recording and channel."""
    name = torque_channel(recording, run.instruments)
    angle_name = angle_channel(recording)
    torque, spikes = _clean_torque(recording, name, run.zeros.get(name, 0.0), spec)
    cycles = _cycles(recording, angle_name, run.rig.eccentric_ratio)
    waveforms = resample(torque, cycles.starts, PHASES)
    peaks = _peaks(torque, cycles.starts)
    kept, rejections = _judged(recording, name, _disagreement(waveforms), rule)
    peak_kept, peak_rejections = _judged(recording, name, peaks, rule)
    angles = resample(recording.channels[angle_name], cycles.starts, PHASES)
    return SwingPoint(
        recording=recording.name,
        set_frequency_hz=set_point(recording, name, "frequency"),
        frequency_hz=_frequency(cycles, recording.rate_hz),
        load_n=load_n(recording, name),
        sample_rate_hz=recording.rate_hz,
        angle_rad=angles[kept].mean(axis=0) - cycles.offset_rad,
        torque_nm=waveforms,
        kept=kept,
        waveform_rejections=rejections,
        peak_nm=peaks,
        peak_kept=peak_kept,
        peak_rejections=peak_rejections,
        spikes=spikes,
    )


def _clean_torque(
    recording: Recording, name: str, zero_nm: float, spec: AnalysisSpec
) -> tuple[Array, int]:
    torque = _finite(recording, name) - zero_nm
    return (torque, 0) if spec.despike is None else hampel(torque, spec.despike.window)


def _cycles(recording: Recording, name: str, eccentric_ratio: float) -> Cycles:
    where = f"recording {recording.name}, {name}"
    try:
        cycles = find_cycles(_finite(recording, name), recording.rate_hz, eccentric_ratio)
    except DataError as error:
        raise DataError(f"{where}: {error.message}", hint=error.hint) from error
    if cycles.count < LEAST_CYCLES:
        raise DataError(
            f"{where}: {cycles.count} whole cycles, but {LEAST_CYCLES} are needed",
            hint="record more cycles",
        )
    return cycles


def _finite(recording: Recording, name: str) -> Array:
    values = recording.channels[name]
    if not np.isfinite(values).all():
        raise DataError(f"recording {recording.name}, {name}: a sample is not a finite number")
    return values


def _peaks(torque: Array, starts: Array) -> Array:
    """Return the greatest sample of each cycle, shape (cycles,)."""
    first = np.ceil(starts).astype(int)
    return np.array([torque[a:b].max() for a, b in pairwise(first)])


def _disagreement(waveforms: Array) -> Array:
    """Return each cycle's rms distance in N·m from the robust mean of all, shape (cycles,)."""
    mean, _ = robust_mean(waveforms, np.ones(len(waveforms), bool))
    return np.asarray(np.sqrt(np.mean((waveforms - mean) ** 2, axis=1)))


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
            hint="look at the recording: cycles that disagree so much have no common value",
        )
    return kept, rejections


def _frequency(cycles: Cycles, rate_hz: float) -> Estimate:
    """Return the mean frequency over all cycles, with the scatter between them as type A."""
    mean = rate_hz * cycles.count / (cycles.starts[-1] - cycles.starts[0])
    u = cycles.frequency_hz.std(ddof=1) / sqrt(cycles.count)
    return Estimate(float(mean), float(u), float(cycles.count - 1), "Hz")
