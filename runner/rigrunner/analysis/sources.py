"""What of a run the analysis looks at: its recordings, or else its single values."""

from __future__ import annotations

from math import nan
from typing import TYPE_CHECKING

import numpy as np

from rigrunner.analysis.channels import is_set, torque_channels
from rigrunner.api.data import Recording

if TYPE_CHECKING:
    from collections.abc import Iterable

    from rigrunner.api.data import Measurement, RunData


def sources(run: RunData) -> tuple[Recording, ...]:
    """Return the recordings of a run; of one without, each torque measured in motion.

    A measured torque is a recording of one sample. What else was measured, such as the room's
    temperature or a torque at rest, is no point of a sweep.
    """
    if run.recordings:
        return run.recordings
    return tuple(one for one in _as_recordings(run.measurements) if _is_point(one))


def of_this_run(run: RunData, *, loaded: bool) -> tuple[Recording, ...]:
    """Return the sources that were set to a load, or those that were set to none."""
    return tuple(one for one in sources(run) if _is_loaded(one) == loaded)


def _as_recordings(measurements: Iterable[Measurement]) -> Iterable[Recording]:
    """Yield measurements as recordings of one sample, numbered within their table."""
    for number, one in enumerate(measurements, 1):
        yield Recording(
            name=f"{one.name} {number}",
            rate_hz=nan,
            started_utc=one.utc,
            setpoints=one.setpoints,
            channels={name: np.array([value]) for name, value in one.values.items()},
            units=one.units,
            conditions=one.values,
        )


def _is_point(recording: Recording) -> bool:
    return any(is_set(recording, name, "frequency") for name in torque_channels(recording))


def _is_loaded(recording: Recording) -> bool:
    return any(is_set(recording, name, "load") for name in torque_channels(recording))
