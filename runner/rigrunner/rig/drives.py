"""What a drive's declaration says of its read-back, and of the time that it needs."""

from __future__ import annotations

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from rigrunner.api.devices import DriveInfo


def tolerance(info: DriveInfo) -> float:
    """Return how far a read-back may be from the set-point: declared, or 1 % of the range."""
    if info.tolerance is not None:
        return info.tolerance
    return 0.01 * (info.maximum - info.minimum)


def agrees(info: DriveInfo, actual: float, value: float) -> bool:
    """Return True if a drive's actual value is its set-point within the tolerance."""
    return abs(actual - value) <= tolerance(info)


def travel_s(info: DriveInfo) -> float:
    """Return how long the drive needs from one end of its range to the other, in seconds."""
    return (info.maximum - info.minimum) / info.rate_per_s if info.rate_per_s else 0.0
