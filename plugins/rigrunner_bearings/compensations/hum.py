"""Hum of the mains, where a harmonic of the swing falls on it.

At most frequencies hum averages out over the cycles, and their scatter shows how large it is. At
10 Hz with mains of 50 Hz it does not: it is the fifth harmonic of every cycle. But the
bearing's harmonics are smooth functions of the frequency, so the neighbouring set-points show
that harmonic without hum. The hum is the difference, shrunk by how well either is known (best
linear prediction: Goldberger, J. Am. Stat. Assoc. 57, 1962, 369).
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from math import sqrt
from typing import TYPE_CHECKING

import numpy as np

from rigrunner_bearings.compensations.bearing import Pair, bearing_torque
from rigrunner_bearings.compensations.drive_line import HARMONICS
from rigrunner_bearings.compensations.response import Waveform

if TYPE_CHECKING:
    from collections.abc import Iterable, Iterator, Sequence

    from rigrunner.api import Array
    from rigrunner_bearings.api.points import SwingPoint
    from rigrunner_bearings.compensations.drive_line import DriveLine
    from rigrunner_bearings.compensations.harmonics import Complex
    from rigrunner_bearings.compensations.identification import Identified

ORDERS = (1, 2, 3)
"""Of the mains, at which there may be hum."""

LOCKED = 1.5
"""Turns that hum and harmonic come apart in a recording: with fewer they are taken for one."""

AROUND_HZ = np.linspace(-0.2, 0.2, 17)
"""The mains are that near to their nominal frequency."""

BESIDE_HZ = np.array([-7.3, -5.7, 5.7, 7.3])
"""From the mains: there is noise there, and no hum."""

CLEARLY = 8.0
"""Times the power of that noise: what noise alone does not reach in most recordings."""


@dataclass(frozen=True)
class _Prediction:
    """What is known of one harmonic of the bearing from its neighbours, and its variance."""

    value: complex
    variance: float


def without_hum(
    rig: Identified, pairs: Sequence[Pair], points: Iterable[SwingPoint], mains_hz: float
) -> tuple[list[Pair], list[float]]:
    """Return the pairs without hum, and the standard uncertainty that it leaves in each, in N·m.

    `points` are the recordings of both runs. Where they show no hum, nothing is changed.
    """
    cleaned, variances, points = list(pairs), np.zeros(len(pairs)), list(points)
    spectra = None
    for order in ORDERS:
        power = _power(points, order * mains_hz)
        if not power:
            continue
        if spectra is None:
            torques = [bearing_torque(rig.line, rig.friction, pair) for pair in pairs]
            spectra = np.array(
                [np.fft.rfft(torque)[: 2 * HARMONICS] / len(torque) for torque in torques]
            )
        for place, harmonic in _locked_pairs(pairs, order * mains_hz):
            pair = pairs[place]
            gain = _gain_to_load(rig.line, pair, harmonic)
            hum_variance = 2 * power * abs(gain) ** 2
            if not hum_variance:
                continue
            prediction = _from_neighbours(pairs, spectra[:, harmonic], place)
            if prediction is None:
                variances[place] += hum_variance
                continue
            share = hum_variance / (hum_variance + prediction.variance)
            hum = share * (spectra[place, harmonic] - prediction.value) / gain
            run = cleaned[place].loaded
            wave = _wave(hum, harmonic, len(run.torque_nm))
            run = replace(run, torque_nm=run.torque_nm - wave)
            cleaned[place] = replace(cleaned[place], loaded=run)
            variances[place] += share * prediction.variance
    return cleaned, [sqrt(2 * variance) for variance in variances]


def _power(points: Iterable[SwingPoint], mains_hz: float) -> float:
    """Return the mean square of the hum's complex amplitude in one recording, in (N·m)^2."""
    at_mains, noise = [], []
    for point in points:
        count, size = point.torque_nm.shape
        frequency = point.frequency_hz.value
        averaged = point.cycles != count  # a row of several cycles shows no hum
        if averaged or _turns_apart(mains_hz, frequency, count) < LOCKED:
            continue
        residual = point.torque_nm - point.torque_nm[point.kept].mean(axis=0)
        residual = np.where(point.kept[:, None], residual, 0.0)
        rate_hz = size * frequency
        at_mains.append(float(_powers(residual, rate_hz, mains_hz + AROUND_HZ).max()))
        noise.append(float(_powers(residual, rate_hz, mains_hz + BESIDE_HZ).mean()))
    if not at_mains or np.median(at_mains) < CLEARLY * np.median(noise):
        return 0.0
    return float(np.median(at_mains))


def _powers(values: Array, rate_hz: float, hertz: Array) -> Array:
    """Return the power of samples at each of these frequencies, by their Fourier sums.

    `values` has a row for each cycle: a wave over all of them is the wave over the first one, times
    what it has turned by the beginning of each.
    """
    cycles, size = values.shape
    turn = -2j * np.pi * hertz[:, None] / rate_hz
    cycle_sums = values @ np.exp(turn * np.arange(size)).T
    sums = np.sum(np.exp(turn * size * np.arange(cycles)).T * cycle_sums, axis=0)
    return np.asarray(np.abs(sums / values.size) ** 2)


def _turns_apart(mains_hz: float, frequency_hz: float, cycles: int) -> float:
    """Return by how many turns the mains and the nearest harmonic come apart in a recording."""
    ratio = mains_hz / frequency_hz
    return abs(ratio - round(ratio)) * cycles


def _locked_pairs(pairs: Sequence[Pair], mains_hz: float) -> Iterator[tuple[int, int]]:
    """Yield the place of each pair whose cycles all have the same hum, and in which harmonic."""
    for place, pair in enumerate(pairs):
        run = pair.loaded
        harmonic = round(mains_hz / run.frequency_hz)
        turns = _turns_apart(mains_hz, run.frequency_hz, len(run.changes_nm))
        if 0 < harmonic < 2 * HARMONICS and turns < LOCKED:
            yield place, harmonic


def _gain_to_load(line: DriveLine, pair: Pair, harmonic: int) -> complex:
    """Return what a harmonic of the sensor's torque is multiplied by on its way to the load."""
    size = len(pair.loaded.torque_nm)
    shown = Waveform(_wave(1.0, harmonic, size))
    return complex(np.fft.rfft(line.at_load(shown, pair.loaded.frequency_hz))[harmonic] / size)


def _wave(amplitude: complex, harmonic: int, size: int) -> Array:
    phase = 2j * np.pi * harmonic * np.arange(size) / size
    return np.asarray(2 * np.real(amplitude * np.exp(phase)))


def _from_neighbours(pairs: Sequence[Pair], values: Complex, place: int) -> _Prediction | None:
    """Return one pair's harmonic by a line over the logarithm of the frequency to its neighbours.

    Its variance is that of such lines at the other pairs, or else of the neighbours themselves.
    """
    speed = np.log([pair.loaded.frequency_hz for pair in pairs])
    order = np.argsort(speed)
    rank = int(np.flatnonzero(order == place)[0])
    if not 0 < rank < len(pairs) - 1:
        return None
    residuals = []
    for middle in range(1, len(pairs) - 1):
        if abs(middle - rank) > 1:
            value, size = _between(speed[order], values[order], middle)
            residuals.append(abs(values[order[middle]] - value) ** 2 / size)
    value, size = _between(speed[order], values[order], rank)
    below, above = values[order[rank - 1]], values[order[rank + 1]]
    variance = size * float(np.mean(residuals)) if residuals else abs(above - below) ** 2
    return _Prediction(value, variance)


def _between(speed: Array, values: Complex, middle: int) -> tuple[complex, float]:
    """Return the line's value, and the variance of its rest over that of one value."""
    below, above = middle - 1, middle + 1
    width = speed[above] - speed[below]
    share = (speed[middle] - speed[below]) / width if width else 0.5
    value = (1 - share) * values[below] + share * values[above]
    return complex(value), 1 + share**2 + (1 - share) ** 2
