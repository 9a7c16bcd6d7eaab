"""The sources of an analysis: the recordings of a run, or else its single values."""

from __future__ import annotations

from dataclasses import replace
from math import nan
from typing import TYPE_CHECKING, Any

import numpy as np

from rigrunner.api import DataError, Recording
from rigrunner.api.coordinates import matches, mixed_labels
from rigrunner.api.member import channel_of
from rigrunner_bearings.torque.channels import is_set

if TYPE_CHECKING:
    from collections.abc import Iterable, Mapping

    from rigrunner.api import Measurement, RunData


def chosen(run: RunData, where: Mapping[str, Any]) -> RunData:
    """Return a run with the recordings and rows that have these counters and labels alone."""
    if not where:
        return run
    recordings = tuple(x for x in run.recordings if matches(x.coordinates, where))
    rows = tuple(x for x in run.measurements if matches(x.coordinates, where))
    return replace(run, recordings=recordings, measurements=rows)


def require_one_label(recordings: Iterable[Recording]) -> None:
    """Raise DataError where sources with the same set-points differ by a label.

    They are not the same thing measured again, and have no common mean.
    """
    mixed = mixed_labels(
        (recording.setpoints, recording.coordinates, recording.units) for recording in recordings
    )
    if mixed:
        raise DataError(
            f"recordings with the same set-points would be averaged: {mixed}",
            hint="say which ones the analysis is of: 'where: {phase: final}' under 'analysis'",
        )


def sources(run: RunData) -> tuple[Recording, ...]:
    """Return the recordings of a run; of one without, each torque measured in motion.

    A measured torque is a recording of one sample. What else was measured, such as the room's
    temperature or a torque at rest, is no point of a sweep.
    """
    if run.recordings:
        return run.recordings
    return tuple(row for row in _as_recordings(run.measurements) if is_set(row, "frequency"))


def of_this_run(run: RunData, *, loaded: bool) -> tuple[Recording, ...]:
    """Return the sources that were set to a load, or those that were set to none."""
    return tuple(recording for recording in sources(run) if is_set(recording, "load") == loaded)


def _as_recordings(measurements: Iterable[Measurement]) -> Iterable[Recording]:
    """Yield measurements as recordings of one sample, numbered within their table."""
    for number, measurement in enumerate(measurements, 1):
        yield Recording(
            name=f"{measurement.name} {number}",
            rate_hz=nan,
            started_utc=measurement.utc,
            setpoints=measurement.setpoints,
            channels={
                name: np.array([value])
                for name, value in measurement.values.items()
                if name == channel_of(name)  # and no statistic of samples
            },
            units=measurement.units,
            conditions=measurement.values,
            coordinates=measurement.coordinates,
        )
