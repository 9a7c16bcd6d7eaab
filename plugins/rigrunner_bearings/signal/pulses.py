"""Cuts a recording into cycles of the crank where no angle was recorded."""

from __future__ import annotations

from math import pi
from typing import TYPE_CHECKING

import numpy as np

from rigrunner.api import DataError
from rigrunner.signal.blocks import BLOCK, limits
from rigrunner.signal.crossings import rises
from rigrunner_bearings.signal.cycles import resample

if TYPE_CHECKING:
    from rigrunner.api import Array
    from rigrunner.api.data import Samples

LOW, HIGH = 0.25, 0.75
"""Shares of the signal's range: below LOW a pulse has ended, above HIGH the next has begun."""

UNEVEN = 0.25
"""Relative difference of a period from the usual one that only a lost or doubled pulse makes."""

FOLDED = 64
ENOUGH, THINNED = 64, 1 << 18
"""The cycles that are used of a recording too long for memory, and the most samples of them."""
SEARCH, PADDING, HARMONICS, REFINEMENTS = 0.15, 8, 9, 3


def pulse_edges(signal: Samples) -> Array:
    """Return where pulses rise in a signal of shape (n,), as fractional sample indices.

    The rise lies between two samples, and half way is taken: off by at most half a sample. Raises
    DataError for fewer than two pulses, and where one was lost or came twice.
    """
    low, high = limits(signal)
    rising = np.empty(0)
    if high > low:
        rising = rises(signal, low + LOW * (high - low), low + HIGH * (high - low))[1].astype(float)
    if len(rising) < 2:  # noqa: PLR2004  (a cycle has two ends)
        raise DataError(
            f"{len(rising)} pulses, but a cycle is from one to the next",
            hint="is the index sensor connected, and does it detect the mark?",
        )
    periods = np.diff(rising)
    usual = float(np.median(periods))
    odd = np.flatnonzero(np.abs(periods - usual) > UNEVEN * usual)
    if len(odd):
        raise DataError(
            f"from pulse {odd[0] + 1} to the next are {periods[odd[0]]:.0f} samples, usual are "
            f"{usual:.0f}: one was lost or came twice",
            hint="check the level and the wiring of the index sensor",
        )
    edges: Array = rising - 0.5
    return edges


def starts_from_edges(edges: Array, phase_rad: float, samples: int) -> Array:
    """Return where cycles start (crank phase 0) if the pulse rises at `phase_rad`.

    Fractional sample indices within the recording, in steps of the pulses' own periods.
    """
    periods = np.diff(edges)
    starts = edges - phase_rad / (2 * pi) * np.append(periods, periods[-1])
    return starts[(starts >= 0) & (starts <= samples - 1)]


def starts_by_frequency(torque_nm: Samples, rate_hz: float, frequency_hz: float) -> Array:
    """Return cycles cut at a stated frequency, as fractional sample indices.

    Their phase is arbitrary, so the cut is laid where the mean cycle of the torque, shape (n,), is
    least: as far as can be from the peak that is looked for. Raises DataError for no whole cycle.
    """
    period = rate_hz / frequency_hz
    starts = np.arange(0, len(torque_nm) - 1, period)
    if len(starts) < 2:  # noqa: PLR2004  (a cycle has two ends)
        raise DataError(
            f"no whole cycle of {frequency_hz:g} Hz in {len(torque_nm) / rate_hz:.3g} s",
            hint="record more cycles",
        )
    folded = resample(torque_nm, starts, FOLDED).mean(axis=0)
    return np.arange(period * np.argmin(folded) / FOLDED, len(torque_nm) - 1, period)


def repetition_frequency(values: Samples, rate_hz: float, near_hz: float) -> float:
    """Return how often per second values of shape (n,) repeat, within 15 % of `near_hz`.

    Found where the first harmonics together are strongest, then refined by how much the phase of
    the first one turns from one half to the other. It tells a wrong entry from a right one; where
    cycles begin it does not show. Some cycles are needed, and a first harmonic; of a recording that
    is too long for memory, as many as needed.
    """
    if len(values) > BLOCK:
        samples, rate_hz = _thinned(values, rate_hz, near_hz)
    else:
        samples = values[:]
    centred = samples - samples.mean()
    repetition_hz = _strongest(centred, rate_hz, near_hz)
    for _ in range(REFINEMENTS):
        # Halves of whole cycles: other harmonics sum to zero in each.
        half = round(int(len(samples) / 2 * repetition_hz / rate_hz) * rate_hz / repetition_hz)
        turning = np.exp(-2j * pi * repetition_hz / rate_hz * np.arange(2 * half))
        first, second = (centred[: 2 * half] * turning).reshape(2, half).sum(axis=1)
        repetition_hz += float(np.angle(second / first)) / (2 * pi) * rate_hz / half
    return repetition_hz


def _thinned(values: Samples, rate_hz: float, near_hz: float) -> tuple[Array, float]:
    """Return the first cycles with neighbouring samples averaged, and their rate."""
    count = min(len(values), round(ENOUGH * rate_hz / near_hz))
    averaged = -(-count // THINNED)
    step, end = BLOCK // averaged * averaged, count // averaged * averaged
    parts = (values[start : min(start + step, end)] for start in range(0, end, step))
    means = [part.reshape(-1, averaged).mean(axis=1) for part in parts]
    return np.concatenate(means), rate_hz / averaged


def _strongest(centred: Array, rate_hz: float, near_hz: float) -> float:
    bin_hz = rate_hz / (PADDING * len(centred))
    power = np.abs(np.fft.rfft(centred, PADDING * len(centred))) ** 2
    candidates = near_hz * np.arange(1 - SEARCH, 1 + SEARCH, bin_hz / near_hz)
    harmonics = np.arange(1, HARMONICS + 1)[:, None]
    bins = np.rint(harmonics * candidates / bin_hz).astype(int)
    total = power[np.minimum(bins, len(power) - 1)].sum(axis=0)
    return float(candidates[np.argmax(total)])
