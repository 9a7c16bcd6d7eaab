"""A run with no-load set-points before and after the loaded ones: the drift between is taken out.

Between the two the rig's own torque is taken to go in a straight line over time, or over a
temperature. It may have gone otherwise: the result may lie anywhere between that of the no-load
points before and that of those after (rectangular, GUM 4.3.7).
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from datetime import datetime
from math import hypot
from typing import TYPE_CHECKING

import numpy as np

from rigrunner.api import Effect, Estimate
from rigrunner.signal.inputs import limited
from rigrunner_bearings.api.points import PeakPoint, SwingPoint
from rigrunner_bearings.signal.mean_model import with_effects
from rigrunner_bearings.torque.settings import BY_TIME

if TYPE_CHECKING:
    from collections.abc import Iterator, Sequence

    from rigrunner.api import Array, Recording
    from rigrunner_bearings.api.compensations import Compensation

LINE = "drift between the no-load points"
SAME_FREQUENCY = 0.005
"""How far, relatively, set frequencies may differ and still be the same one."""
LEAST_CHANGE = 0.2
"""Of a temperature in K, from before to after: if it is less, time is the better measure."""


@dataclass(frozen=True, eq=False)
class RecordedPoint:
    """A prepared point with the recording that it is of."""

    recording: Recording
    point: PeakPoint

    def at(self, drift: str) -> float:
        """Return its place in the drift: its begin in s, or a value that was read beside it."""
        if drift == BY_TIME:
            return datetime.fromisoformat(self.recording.started_utc).timestamp()
        return self.recording.conditions[drift]

    def is_at(self, other: RecordedPoint) -> bool:
        """Say whether both have the same set frequency."""
        ours, theirs = self.point.set_frequency_hz, other.point.set_frequency_hz
        return abs(ours - theirs) <= SAME_FREQUENCY * max(ours, theirs)


@dataclass(frozen=True, eq=False)
class Bracket:
    """The no-load points of a run: as they were before and after, and between them."""

    before: tuple[PeakPoint, ...]
    after: tuple[PeakPoint, ...]
    between: tuple[PeakPoint, ...]
    """As they would have been while the loaded points of the same frequency were made."""
    beyond: float
    """How far that is from the middle, over the distance of both; at least a half."""
    by: str

    def widened(
        self, compensation: Compensation, before: Compensation, after: Compensation
    ) -> Compensation:
        """Return a compensation with a line for a drift that was not linear."""
        name = f"{LINE} ({self.by})"
        points = tuple(
            with_effects(
                point,
                [
                    Effect(
                        limited(name, 1.0, "1"),
                        self.beyond * (late.torque.value - early.torque.value),
                    )
                ],
            )
            for point, early, late in zip(
                compensation.points, before.points, after.points, strict=True
            )
        )
        return replace(compensation, points=points)


def bracket(
    loaded: Sequence[RecordedPoint], no_load: Sequence[RecordedPoint], drift: str
) -> Bracket | None:
    """Return the bracket that a run's own no-load points make; None if they are on one side.

    Of each frequency the last before the loaded points and the first after them count. `drift` is
    BY_TIME, or a channel that was read beside the recordings; where that is missing, or did not
    change, time is used.
    """
    brackets = [_around(loaded, no_load, point) for point in _one_per_frequency(no_load)]
    pairs = [pair for pair in brackets if pair is not None]
    if not pairs:
        return None
    unpaired = tuple(
        recorded.point
        for recorded in no_load
        if not any(recorded.is_at(early) for early, *_ in pairs)
    )
    by = drift if all(_has_changed(drift, *pair) for pair in pairs) else BY_TIME
    shares = [_share(by, *pair) for pair in pairs]
    between = [
        _between(early.point, late.point, share)
        for (early, late, _), share in zip(pairs, shares, strict=True)
    ]
    return Bracket(
        before=(*(early.point for early, *_ in pairs), *unpaired),
        after=(*(late.point for _, late, _ in pairs), *unpaired),
        between=(*between, *unpaired),
        beyond=max(0.5, *(abs(share - 0.5) for share in shares)),
        by=by if by == drift else f"by time, as {drift} does not tell",
    )


def _one_per_frequency(points: Sequence[RecordedPoint]) -> Iterator[RecordedPoint]:
    """Yield one point of each set frequency."""
    seen: list[RecordedPoint] = []
    for point in points:
        if not any(point.is_at(other) for other in seen):
            seen.append(point)
            yield point


def _around(
    loaded: Sequence[RecordedPoint], no_load: Sequence[RecordedPoint], example: RecordedPoint
) -> tuple[RecordedPoint, RecordedPoint, tuple[RecordedPoint, ...]] | None:
    inside = tuple(point for point in loaded if point.is_at(example)) or tuple(loaded)
    first, last = (pick(point.at(BY_TIME) for point in inside) for pick in (min, max))
    same = sorted(
        (point for point in no_load if point.is_at(example)), key=lambda point: point.at(BY_TIME)
    )
    before = [point for point in same if point.at(BY_TIME) < first]
    after = [point for point in same if point.at(BY_TIME) > last]
    return (before[-1], after[0], inside) if before and after else None


def _has_changed(
    drift: str, early: RecordedPoint, late: RecordedPoint, inside: Sequence[RecordedPoint]
) -> bool:
    """Say whether a channel was read with all of them, and changed."""
    if drift == BY_TIME:
        return True
    if not all(drift in point.recording.conditions for point in (early, late, *inside)):
        return False
    return abs(late.at(drift) - early.at(drift)) >= LEAST_CHANGE


def _share(
    by: str, early: RecordedPoint, late: RecordedPoint, inside: Sequence[RecordedPoint]
) -> float:
    """Return how far the loaded points lie from before to after: 0 to 1, or beyond."""
    mean = sum(point.at(by) for point in inside) / len(inside)
    return (mean - early.at(by)) / (late.at(by) - early.at(by))


def _between(early: PeakPoint, late: PeakPoint, share: float) -> PeakPoint:
    """Return the point in between: cycles of both, one by one, so that their scatter stays."""
    first, last = early.frequency_hz, late.frequency_hz
    frequency = Estimate(
        (1 - share) * first.value + share * last.value,
        hypot((1 - share) * first.u, share * last.u),
        min(first.dof, last.dof),
        first.unit,
    )
    peaks = _weighted_mean(early.peak_nm[early.peak_kept], late.peak_nm[late.peak_kept], share)
    between = replace(
        early,
        frequency_hz=frequency,
        peak_nm=peaks,
        peak_kept=np.ones(len(peaks), dtype=bool),
        peak_rejections=early.peak_rejections + late.peak_rejections,
        spikes=early.spikes + late.spikes,
    )
    if not (isinstance(between, SwingPoint) and isinstance(late, SwingPoint)):
        return between
    torque = _weighted_mean(between.torque_nm[between.kept], late.torque_nm[late.kept], share)
    return replace(
        between,
        torque_nm=torque,
        kept=np.ones(len(torque), dtype=bool),
        waveform_rejections=between.waveform_rejections + late.waveform_rejections,
        angle_rad=(1 - share) * between.angle_rad + share * late.angle_rad,
    )


def _weighted_mean(early: Array, late: Array, share: float) -> Array:
    """Return the weighted mean of both, cycle by cycle, as far as there are of either."""
    count = min(len(early), len(late))
    return np.asarray((1 - share) * early[:count] + share * late[:count])
