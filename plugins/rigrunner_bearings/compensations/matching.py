"""Finds for each loaded point the no-load point of the same measured frequency."""

from __future__ import annotations

from typing import TYPE_CHECKING, TypeVar

from rigrunner.api import DataError
from rigrunner_bearings.api.points import PeakPoint

if TYPE_CHECKING:
    from collections.abc import Sequence

    from rigrunner_bearings.api.compensations import Sweep, SwingSweep
    from rigrunner_bearings.api.points import SwingPoint

Point = TypeVar("Point", bound=PeakPoint)


def pairs(sweep: SwingSweep, tolerance: float) -> tuple[tuple[SwingPoint, SwingPoint], ...]:
    """Return (loaded, no-load) for every loaded point, the nearest within the relative tolerance.

    By the measured frequency, never the entered one. Raises DataError that names the frequencies
    without a partner.
    """
    return _paired(sweep.loaded, sweep.no_load, tolerance)


def peak_pairs(sweep: Sweep, tolerance: float) -> tuple[tuple[PeakPoint, PeakPoint], ...]:
    """Return the same of points that need have no whole swings."""
    return _paired(sweep.loaded, sweep.no_load, tolerance)


def _paired(
    loaded: Sequence[Point], no_load: Sequence[Point], tolerance: float
) -> tuple[tuple[Point, Point], ...]:
    found = [(point, _nearest(point, no_load)) for point in loaded]
    missing = [
        f"{point.frequency_hz.value:.4g} Hz ({point.recording})"
        for point, partner in found
        if partner is None or _distance(point, partner) > tolerance
    ]
    if missing:
        raise DataError(
            f"no no-load recording within {tolerance:.1%} of {', '.join(missing)}; "
            f"the no-load run has {_listing(no_load)}",
            hint="record the no-load sweep at the same frequencies",
        )
    return tuple((point, partner) for point, partner in found if partner is not None)


def _nearest(point: Point, candidates: Sequence[Point]) -> Point | None:
    return min(candidates, key=lambda other: _distance(point, other), default=None)


def _distance(point: PeakPoint, other: PeakPoint) -> float:
    return abs(other.frequency_hz.value / point.frequency_hz.value - 1)


def _listing(points: Sequence[PeakPoint]) -> str:
    return ", ".join(f"{point.frequency_hz.value:.4g} Hz" for point in points) or "no points"
