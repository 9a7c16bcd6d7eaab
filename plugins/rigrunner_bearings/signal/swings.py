"""Requires the whole swings that a waveform method needs, and selects the cycles that count."""

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
    swing_points = tuple(point for point in points if isinstance(point, SwingPoint))
    if len(swing_points) == len(points):
        return swing_points
    without_swing = [point.recording for point in points if not isinstance(point, SwingPoint)]
    more = f" and {len(without_swing) - 1} more" if len(without_swing) > 1 else ""
    raise DataError(
        "comparing whole swings needs an angle channel (or a tacho, or an index pulse in every "
        f"cycle), and {without_swing[0]}{more} had none",
        hint="record the angle of the swing; peak methods can do without",
    )


def kept_cycles(point: SwingPoint) -> Mask:
    """Return which of the recorded cycles take part in a mean over cycles, shape (cycles,).

    It is `point.kept`, but where a row of the waveforms stands for several cycles.
    """
    rows = len(point.kept)
    return point.kept[np.arange(point.cycles) * rows // point.cycles]
