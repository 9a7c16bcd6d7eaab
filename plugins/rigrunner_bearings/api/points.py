"""Set-points, as they are prepared for a compensation."""

from __future__ import annotations

from dataclasses import dataclass
from enum import StrEnum
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from rigrunner.api import Array, Estimate, Mask, Rejection


class MotionSource(StrEnum):
    """What a set-point's frequency and phase were taken from."""

    ANGLE = "angle"
    """The angle channel: frequency and phase."""
    TACHO = "tacho"
    """The swing's angular velocity, integrated: frequency and phase."""
    INDEX = "index"
    """One pulse in every turn of the crank: frequency, and phase by the kinematics."""
    ENTERED = "entered"
    """The entered frequency, nothing measured: no phase."""


@dataclass(frozen=True, eq=False, kw_only=True)
class PeakPoint:
    """One set-point with its raw peaks: all that a peak method needs."""

    recording: str
    """Its name; of a point from a `measure` step, that of the measurement."""
    set_frequency_hz: float
    frequency_hz: Estimate
    """Measured; only with `motion` ENTERED it is what was entered, with its uncertainty."""
    load_n: float
    peak_nm: Array
    """The raw maximum of each cycle as the paper takes it, shape (cycles,).

    Less the zero reading. One value only: a mean or a maximum whose scatter is not known.
    """
    peak_kept: Mask
    """Which peaks remain after the outlier rule (peak methods), shape (cycles,)."""
    peak_rejections: tuple[Rejection, ...] = ()
    spikes: int = 0
    """How many samples the spike filter replaced."""
    motion: MotionSource = MotionSource.ANGLE

    @property
    def cycles(self) -> int:
        """How many whole cycles were recorded."""
        return len(self.peak_nm)


@dataclass(frozen=True, eq=False, kw_only=True)
class SwingPoint(PeakPoint):
    """One set-point with whole swings: despiked, cut into cycles, gross errors marked.

    The crank phase phi runs over [0, 2 pi) in N equal steps from the middle of the forward stroke
    (theta = 0, rising). Torque is corrected for the zero reading.
    """

    sample_rate_hz: float
    angle_rad: Array
    """Mean swing angle over the kept cycles, shape (N,)."""
    torque_nm: Array
    """Torque of every cycle, resampled on the crank phase, shape (cycles, N).

    Of more than 1024 cycles neighbours are averaged: there are 1024 rows, and row k is the mean of
    the cycles i with floor(1024 i / cycles) = k.
    """
    kept: Mask
    """Which rows take part in a mean over cycles (waveform methods), shape (rows,)."""
    waveform_rejections: tuple[Rejection, ...] = ()
    """By the whole shape of a cycle; of a row of several, the index is that of its first one."""
    phase_u_rad: float = 0.0
    """Standard uncertainty of the crank phase, in this recording alone; 0 from an angle."""
    phase_common_u_rad: float = 0.0
    """The same, of what is common to all recordings of the rig."""
    alignment_u_s: float = 0.0
    """Standard uncertainty of the time between torque and motion in this recording; 0 from one
    clock."""


@dataclass(frozen=True, eq=False, kw_only=True)
class StartPoint(PeakPoint):
    """Starts from rest at one speed; each start counts as a cycle.

    Each peak is the greatest torque in a start's first travel. `set_frequency_hz` and
    `frequency_hz` are turns per second.
    """
