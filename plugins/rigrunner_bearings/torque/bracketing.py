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
"""Of a temperature in K, between before and after: of less, time tells more."""


@dataclass(frozen=True, eq=False)
class Recorded:
    """A prepared point with the recording that it is of."""

    recording: Recording
    point: PeakPoint

    def at(self, drift: str) -> float:
        """Return where it stands: its begin in s, or a value that was read beside it."""
        if drift == BY_TIME:
            return datetime.fromisoformat(self.recording.started_utc).timestamp()
        return self.recording.conditions[drift]

    def is_at(self, other: Recorded) -> bool:
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
        self, found: Compensation, before: Compensation, after: Compensation
    ) -> Compensation:
        """Return a compensation with a line for what the drift may have been besides."""
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
            for point, early, late in zip(found.points, before.points, after.points, strict=True)
        )
        return replace(found, points=points)


def bracket(loaded: Sequence[Recorded], no_load: Sequence[Recorded], drift: str) -> Bracket | None:
    """Return the bracket that a run's own no-load points make; None if they are on one side.

    Of each frequency the last before the loaded points and the first after them count. `drift` is
    BY_TIME, or a channel that was read beside the recordings; where that is not there, or did not
    change, time stands for it.
    """
    found = [_around(loaded, no_load, each) for each in _frequencies(no_load)]
    pairs = [each for each in found if each is not None]
    if not pairs:
        return None
    alone = [each for each in no_load if not any(each.is_at(early) for early, *_ in pairs)]
    by = drift if all(_tells(drift, *each) for each in pairs) else BY_TIME
    shares = [_share(by, *each) for each in pairs]
    between = [
        _between(early.point, late.point, share)
        for (early, late, _), share in zip(pairs, shares, strict=True)
    ]
    rest = tuple(each.point for each in alone)
    return Bracket(
        before=(*(early.point for early, *_ in pairs), *rest),
        after=(*(late.point for _, late, _ in pairs), *rest),
        between=(*between, *rest),
        beyond=max(0.5, *(abs(share - 0.5) for share in shares)),
        by=by if by == drift else f"by time, as {drift} does not tell",
    )


def _frequencies(points: Sequence[Recorded]) -> Iterator[Recorded]:
    """Yield one point of each set frequency."""
    seen: list[Recorded] = []
    for each in points:
        if not any(each.is_at(other) for other in seen):
            seen.append(each)
            yield each


def _around(
    loaded: Sequence[Recorded], no_load: Sequence[Recorded], like: Recorded
) -> tuple[Recorded, Recorded, tuple[Recorded, ...]] | None:
    inside = tuple(each for each in loaded if each.is_at(like)) or tuple(loaded)
    first, last = (pick(each.at(BY_TIME) for each in inside) for pick in (min, max))
    same = sorted((each for each in no_load if each.is_at(like)), key=lambda each: each.at(BY_TIME))
    before = [each for each in same if each.at(BY_TIME) < first]
    after = [each for each in same if each.at(BY_TIME) > last]
    return (before[-1], after[0], inside) if before and after else None


def _tells(drift: str, early: Recorded, late: Recorded, inside: Sequence[Recorded]) -> bool:
    """Say whether a channel was read with all of them, and changed."""
    if drift == BY_TIME:
        return True
    if not all(drift in each.recording.conditions for each in (early, late, *inside)):
        return False
    return abs(late.at(drift) - early.at(drift)) >= LEAST_CHANGE


def _share(by: str, early: Recorded, late: Recorded, inside: Sequence[Recorded]) -> float:
    """Return how far the loaded points lie from before to after: 0 to 1, or beyond."""
    mean = sum(each.at(by) for each in inside) / len(inside)
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
    peaks = _mixed(early.peak_nm[early.peak_kept], late.peak_nm[late.peak_kept], share)
    mixed = replace(
        early,
        frequency_hz=frequency,
        peak_nm=peaks,
        peak_kept=np.ones(len(peaks), dtype=bool),
        peak_rejections=early.peak_rejections + late.peak_rejections,
        spikes=early.spikes + late.spikes,
    )
    if not (isinstance(mixed, SwingPoint) and isinstance(late, SwingPoint)):
        return mixed
    torque = _mixed(mixed.torque_nm[mixed.kept], late.torque_nm[late.kept], share)
    return replace(
        mixed,
        torque_nm=torque,
        kept=np.ones(len(torque), dtype=bool),
        waveform_rejections=mixed.waveform_rejections + late.waveform_rejections,
        angle_rad=(1 - share) * mixed.angle_rad + share * late.angle_rad,
    )


def _mixed(early: Array, late: Array, share: float) -> Array:
    """Return the weighted mean of both, cycle by cycle, as far as there are of either."""
    count = min(len(early), len(late))
    return np.asarray((1 - share) * early[:count] + share * late[:count])
