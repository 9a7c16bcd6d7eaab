"""Prepares recordings of starts from rest: one breakaway torque from each, gross errors marked."""

from __future__ import annotations

from math import sqrt
from typing import TYPE_CHECKING

import numpy as np

from rigrunner.api import DataError, Estimate
from rigrunner.signal.spikes import hampel
from rigrunner_bearings.api.points import MotionSource, StartPoint
from rigrunner_bearings.api.requirements import LEAST_STARTS
from rigrunner_bearings.signal.starts import find_start
from rigrunner_bearings.torque.channels import (
    finite,
    motion_channel,
    place_of_start,
    role_of,
    torque_channel,
)
from rigrunner_bearings.torque.reading import torque_reading

if TYPE_CHECKING:
    from collections.abc import Iterable

    from rigrunner.api import OutlierRule, Recording, RunData
    from rigrunner_bearings.signal.starts import Start
    from rigrunner_bearings.torque.settings import StartsSpec, TorqueSettings


def prepare_starts(
    recordings: Iterable[Recording],
    run: RunData,
    starts_spec: StartsSpec,
    spec: TorqueSettings,
    rule: OutlierRule,
) -> tuple[StartPoint, ...]:
    """Return one point for each speed and load at which there were starts.

    Its peaks are the breakaway torques, one from each recording. Raises DataError naming the
    recording that shows no start, or where there are too few.
    """
    groups: dict[tuple[float, float], list[Recording]] = {}
    for recording in recordings:
        role = role_of(torque_channel(recording, run.instruments))
        groups.setdefault(place_of_start(recording.setpoints, role), []).append(recording)
    return tuple(
        _point(
            place, group, [_start(recording, run, starts_spec, spec) for recording in group], rule
        )
        for place, group in groups.items()
    )


def _start(
    recording: Recording, run: RunData, starts_spec: StartsSpec, spec: TorqueSettings
) -> tuple[Start, int]:
    """Return what the recording shows, and how many of its samples were spikes."""
    torque = torque_channel(recording, run.instruments)
    source, angle = motion_channel(recording)
    if source is not MotionSource.ANGLE:
        raise DataError(
            f"recording {recording.name} has no angle channel, and a start needs one",
            hint="record the angle of rotation, such as tester.angle",
        )
    torque_nm = np.asarray(torque_reading(recording, torque, run))
    spikes = 0
    if spec.despike is not None:
        torque_nm, spikes = hampel(torque_nm, spec.despike.window, spec.despike.threshold)
    rate_hz, angle_rad = recording.rate_hz, np.asarray(finite(recording, angle))
    try:
        start = find_start(angle_rad, torque_nm, rate_hz, starts_spec.window, starts_spec.smoothing)
    except DataError as error:
        where = f"recording {recording.name}, {angle}"
        raise DataError(f"{where}: {error.message}", hint=error.hint) from error
    return start, spikes


def _point(
    place: tuple[float, float],
    group: list[Recording],
    starts: list[tuple[Start, int]],
    rule: OutlierRule,
) -> StartPoint:
    name = group[0].name if len(group) == 1 else f"{group[0].name} to {group[-1].name}"
    peaks = np.array([start.breakaway_nm for start, _ in starts])
    if len(peaks) < LEAST_STARTS:
        raise DataError(
            f"recording {name}: {len(peaks)} starts, but {LEAST_STARTS} are needed",
            hint="record more starts at the same speed",
        )
    rejections = tuple(rule(peaks))
    kept = np.ones(len(peaks), bool)
    kept[[rejection.index for rejection in rejections]] = False
    set_hz, load_n = place
    frequencies_hz = [start.frequency_hz for start, _ in starts]
    u = float(np.std(frequencies_hz, ddof=1)) / sqrt(len(frequencies_hz))
    return StartPoint(
        recording=name,
        set_frequency_hz=set_hz,
        frequency_hz=Estimate(float(np.mean(frequencies_hz)), u, len(frequencies_hz) - 1, "Hz"),
        load_n=load_n,
        peak_nm=peaks,
        peak_kept=kept,
        peak_rejections=rejections,
        spikes=sum(spikes for _, spikes in starts),
    )
