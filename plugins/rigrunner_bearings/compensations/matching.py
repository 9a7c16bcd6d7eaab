"""Finds for each loaded point the no-load point of the same measured frequency."""

from __future__ import annotations

from functools import partial
from typing import TYPE_CHECKING, TypeVar

from rigrunner.api import DataError
from rigrunner_bearings.api.points import PeakPoint

if TYPE_CHECKING:
    from collections.abc import Sequence


Point = TypeVar("Point", bound=PeakPoint)


def pairs(
    loaded: Sequence[Point], no_load: Sequence[Point], tolerance: float
) -> tuple[tuple[Point, Point], ...]:
    """Return (loaded, no-load) for every loaded point, the nearest within the relative tolerance.

    By the measured frequency, never the entered one. Raises DataError that names the frequencies
    without a partner.
    """
    nearest = [
        (point, min(no_load, key=partial(_distance, point), default=None)) for point in loaded
    ]
    missing = [
        f"{point.frequency_hz.value:.4g} Hz ({point.recording})"
        for point, partner in nearest
        if partner is None or _distance(point, partner) > tolerance
    ]
    if missing:
        recorded = ", ".join(f"{point.frequency_hz.value:.4g} Hz" for point in no_load)
        raise DataError(
            f"no no-load recording within {tolerance:.1%} of {', '.join(missing)}; "
            f"the no-load run has {recorded or 'no points'}",
            hint="record the no-load sweep at the same frequencies",
        )
    return tuple((point, partner) for point, partner in nearest if partner is not None)


def _distance(point: PeakPoint, other: PeakPoint) -> float:
    return abs(other.frequency_hz.value / point.frequency_hz.value - 1)
