"""The effect of two clocks for torque and angle on a method, and the limit of their alignment."""

from __future__ import annotations

from dataclasses import dataclass
from math import hypot, inf, pi
from typing import TYPE_CHECKING

from rigrunner.api import DataError
from rigrunner.api.checks import Limit
from rigrunner_bearings.api.points import SwingPoint

if TYPE_CHECKING:
    from collections.abc import Iterable, Sequence

    from rigrunner.api import Array, Check, Recording
    from rigrunner_bearings.api.compensations import CompensatedPoint
    from rigrunner_bearings.api.points import PeakPoint

ALIGNMENT_U = "_alignment_u"
"""What the condition adds to a channel's name that gives the uncertainty of its time, in s."""

SHARE = 0.05
"""Of the torque: what a misalignment of one standard uncertainty may move it by. Up to there the
effect grows with the misalignment; beyond, the maximum is looked for at the wrong place, and no
uncertainty that is found by a small shift covers it (docs/evidence/clocks.md)."""

_NOTHING_NM = 1e-12
CLOCKS = Limit(
    name="clock alignment",
    good="what may be wrong between the clocks of torque and angle moves the torque by at most 5 %",
    advice="record torque and angle with one instrument, or let both record a common signal",
    unit="1",
    upper=1.0,
    decisive=True,
)


def alignment_u_s(recording: Recording, *channels: str) -> float:
    """Return the standard uncertainty of the time between channels of a recording, in s.

    As a device made of several stated it; 0 for channels of one clock.
    """
    return hypot(*(recording.conditions.get(name + ALIGNMENT_U, 0.0) for name in channels))


def shift_rad(point: PeakPoint) -> float:
    """Return that uncertainty as a crank phase."""
    if not isinstance(point, SwingPoint):
        return 0.0
    return 2 * pi * point.frequency_hz.value * point.alignment_u_s


@dataclass(frozen=True)
class Alignment:
    """At one set-point: the standard uncertainty of the alignment, and its effect on the method."""

    frequency_hz: float
    u_s: float
    effect: float
    """The change of the torque by that uncertainty, over the allowed change."""

    @property
    def allowed_s(self) -> float:
        """The greatest standard uncertainty that the method tolerates."""
        return self.u_s / self.effect if self.effect else inf


def alignments(
    points: Sequence[CompensatedPoint], sources: Iterable[PeakPoint], effects_nm: Array
) -> tuple[Alignment, ...]:
    """Return each point's alignment, of the worse of its two recordings.

    `effects_nm` is what a standard uncertainty moves each torque by, shape (points,).
    """
    worst_s = {
        source.set_frequency_hz: source.alignment_u_s
        for source in sorted(sources, key=shift_rad)
        if isinstance(source, SwingPoint)
    }
    return tuple(
        Alignment(
            point.frequency_hz,
            worst_s.get(point.set_frequency_hz, 0.0),
            float(effect) / max(SHARE * abs(point.torque.value), _NOTHING_NM),
        )
        for point, effect in zip(points, effects_nm, strict=True)
    )


def alignment_check(aligned: Iterable[Alignment]) -> Check:
    """Check that the method tolerates the alignment at every set-point."""
    return CLOCKS.check(
        (
            point.effect,
            f"{point.frequency_hz:.4g} Hz: {_ms(point.u_s)}, allowed {_ms(point.allowed_s)}",
        )
        for point in aligned
    )


def refusal(aligned: Iterable[Alignment]) -> str:
    """Return why there is no result, by the set-point where the alignment is worst."""
    worst = max(aligned, key=lambda point: point.effect)
    return (
        f"torque and angle were sampled by two clocks, aligned to {_ms(worst.u_s)} (standard"
        f" uncertainty); at {worst.frequency_hz:.4g} Hz {_ms(worst.allowed_s)} is allowed, for more"
        f" moves the torque by over {SHARE:.0%} ({CLOCKS.advice})"
    )


def with_clocks(error: DataError, points: Iterable[PeakPoint]) -> DataError:
    """Return a method's error; of clocks that are not well known, with that as a likely reason."""
    worst_s = max((p.alignment_u_s for p in points if isinstance(p, SwingPoint)), default=0.0)
    if not worst_s:
        return error
    reason = f"torque and angle were sampled by two clocks, aligned to {_ms(worst_s)}"
    return DataError(
        f"{error.message}; {reason}", hint=f"{error.hint}; {CLOCKS.advice}".lstrip("; ")
    )


def _ms(seconds: float) -> str:
    return f"{1e3 * seconds:.2g} ms"
