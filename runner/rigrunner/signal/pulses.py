"""Cuts a recording into cycles of the crank where no angle was recorded."""

from __future__ import annotations

from math import pi
from typing import TYPE_CHECKING

import numpy as np

from rigrunner.api.errors import DataError
from rigrunner.signal.cycles import resample

if TYPE_CHECKING:
    from rigrunner.api.data import Array

LOW, HIGH = 0.25, 0.75
"""Of the signal's range: below the one a pulse is over, above the other the next has come."""

UNEVEN = 0.25
"""Relative difference of a period from the usual one that only a lost or doubled pulse makes."""

FOLDED = 64


def pulse_edges(signal: Array) -> Array:
    """Return where pulses rise in a signal of shape (n,), as fractional sample indices.

    The rise lies between two samples, and half way is taken: off by at most half a sample. Raises
    DataError for fewer than two pulses, and where one was lost or came twice.
    """
    low, high = float(signal.min()), float(signal.max())
    above = signal >= low + HIGH * (high - low)
    outside = np.flatnonzero(above | (signal <= low + LOW * (high - low)))
    rising = outside[1:][above[outside[1:]] & ~above[outside[:-1]]].astype(float)
    if high == low or len(rising) < 2:  # noqa: PLR2004  (a cycle has two ends)
        raise DataError(
            f"{0 if high == low else len(rising)} pulses, but a cycle is from one to the next",
            hint="is the index sensor connected, and does it see the mark?",
        )
    _refuse_uneven(rising)
    edges: Array = rising - 0.5
    return edges


def _refuse_uneven(rising: Array) -> None:
    periods = np.diff(rising)
    usual = float(np.median(periods))
    odd = np.flatnonzero(np.abs(periods - usual) > UNEVEN * usual)
    if len(odd):
        raise DataError(
            f"from pulse {odd[0] + 1} to the next are {periods[odd[0]]:.0f} samples, usual are "
            f"{usual:.0f}: one was lost or came twice",
            hint="look at the index sensor's level and its wiring",
        )


def starts_from_edges(edges: Array, phase_rad: float, samples: int) -> Array:
    """Return where cycles start (crank phase 0) if the pulse rises at `phase_rad`.

    Fractional sample indices within the recording, in steps of the pulses' own periods.
    """
    periods = np.diff(edges)
    starts = edges - phase_rad / (2 * pi) * np.append(periods, periods[-1])
    return starts[(starts >= 0) & (starts <= samples - 1)]


def starts_by_frequency(torque_nm: Array, rate_hz: float, frequency_hz: float) -> Array:
    """Return cycles cut at a stated frequency, as fractional sample indices.

    Their phase is arbitrary, so the cut is laid where the mean cycle of the torque, shape (n,), is
    least: as far as can be from the peak that is looked for. Raises DataError for no whole cycle.
    """
    period = rate_hz / frequency_hz
    whole = np.arange(0, len(torque_nm) - 1, period)
    if len(whole) < 2:  # noqa: PLR2004  (a cycle has two ends)
        raise DataError(
            f"no whole cycle of {frequency_hz:g} Hz in {len(torque_nm) / rate_hz:.3g} s",
            hint="record more cycles",
        )
    folded = resample(torque_nm, whole, FOLDED).mean(axis=0)
    return np.arange(period * np.argmin(folded) / FOLDED, len(torque_nm) - 1, period)
