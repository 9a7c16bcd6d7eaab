"""The latest whole swings of a recording in progress, over the crank phase."""

from __future__ import annotations

from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]

PHASES = 256
LONGEST_S = 30.0
"""Longest swing in s; it bounds the memory."""
HYSTERESIS = 0.3
"""Hysteresis as a share of the half range, so that noise around zero is not taken for a swing."""
AGREE = 0.3
"""Largest relative difference from the set period; beyond it, a swing is rejected."""
_KEPT_SWINGS = 1.25


@dataclass(frozen=True, eq=False)
class Swing:
    """One swing, shape (PHASES,); at phase 0 the angle rises through its middle."""

    frequency_hz: float
    end_s: float
    """Time of its end in the recording, in s."""
    torque_nm: Floats


class SwingCutter:
    """Stores the last samples of one recording and cuts whole swings from them.

    With an angle, a swing starts when the angle rises through its middle. Without an angle, the set
    frequency gives the length of a swing, and its start is arbitrary.
    """

    def __init__(self, rate_hz: float, frequency_hz: float, first_sample: int = 0) -> None:
        self._rate_hz = rate_hz
        self._period = rate_hz / frequency_hz
        self._torque = np.empty(0, np.float64)
        self._angle = np.empty(0, np.float64)
        self._first = first_sample
        self._shown = float(first_sample)

    def take(self, torque_nm: Floats, angle_rad: Floats | None) -> list[Swing]:
        """Add consecutive samples of shape (n,); return the swings that they complete."""
        self._torque = np.concatenate((self._torque, torque_nm))
        if angle_rad is not None:
            self._angle = np.concatenate((self._angle, angle_rad))
        starts = (
            _rises(self._angle)
            if len(self._angle)
            else np.arange(self._shown - self._first, len(self._torque), self._period)
        )
        swings = []
        for start, end in pairwise(starts):
            is_swing = abs(end - start - self._period) <= AGREE * self._period
            # The middle of the range moves with further samples, so a swing that was yielded
            # before may be found again a little later.
            if is_swing and self._first + end > self._shown + AGREE * self._period:
                places = start + (end - start) * np.arange(PHASES) / PHASES
                torque = np.interp(places, np.arange(len(self._torque)), self._torque)
                end_s = (self._first + end) / self._rate_hz
                swings.append(Swing(self._rate_hz / (end - start), end_s, torque))
        if len(starts):
            self._shown = max(self._shown, self._first + float(starts[-1]))
        self._forget()
        return swings

    def _forget(self) -> None:
        """Drop all but one whole swing, whose range gives the middle."""
        keep = min(int(_KEPT_SWINGS * self._period), int(LONGEST_S * self._rate_hz))
        since = int(self._shown - self._first) if not len(self._angle) else len(self._torque)
        drop = max(min(since, len(self._torque) - keep), 0)
        self._torque, self._angle = self._torque[drop:], self._angle[drop:]
        self._first += drop


def _rises(angle: Floats) -> NDArray[np.float64]:
    """Return where the angle rises through the middle of its range, in fractional samples."""
    low, high = float(angle.min()), float(angle.max())
    centred = angle - (low + high) / 2
    outside = np.flatnonzero(np.abs(centred) > HYSTERESIS * (high - low) / 2)
    rising = np.flatnonzero(np.diff(np.sign(centred[outside])) > 0)
    before, after = outside[rising], outside[rising + 1]
    share = -centred[before] / (centred[after] - centred[before])
    return np.asarray(before + share * (after - before), np.float64)
