"""Asks for the whole swings that a waveform method needs, and counts those that it keeps."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from rigrunner.api import DataError
from rigrunner_bearings.api.compensations import SwingSweep
from rigrunner_bearings.api.points import SwingPoint

if TYPE_CHECKING:
    from collections.abc import Sequence

    from rigrunner.api import Mask
    from rigrunner_bearings.api.compensations import Sweep
    from rigrunner_bearings.api.points import PeakPoint


def with_swings(sweep: Sweep) -> SwingSweep:
    """Return the sweep as one of whole swings; raise DataError if a point has none."""
    return SwingSweep(
        swings(sweep.loaded),
        swings(sweep.no_load),
        sweep.rig,
        sweep.instrument,
        sweep.fit,
        sweep.apart,
    )


def swings(points: Sequence[PeakPoint]) -> tuple[SwingPoint, ...]:
    """Return the points as swings; raise DataError naming one that has none."""
    found = tuple(point for point in points if isinstance(point, SwingPoint))
    if len(found) == len(points):
        return found
    bare = [point.recording for point in points if not isinstance(point, SwingPoint)]
    others = f" and {len(bare) - 1} more" if len(bare) > 1 else ""
    raise DataError(
        "comparing whole swings needs an angle channel (or a tacho, or an index pulse in every "
        f"cycle), and {bare[0]}{others} had none",
        hint="record the angle of the swing; peak methods can do without",
    )


def kept_cycles(point: SwingPoint) -> Mask:
    """Return which of the recorded cycles take part in a mean over cycles, shape (cycles,).

    It is `point.kept`, but where a row of the waveforms stands for several cycles.
    """
    rows = len(point.kept)
    return point.kept[np.arange(point.cycles) * rows // point.cycles]
