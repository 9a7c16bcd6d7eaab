"""Diagnostics of a sweep compensated by whole swings."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from rigrunner.api.analysis import Check
from rigrunner.signal.uncertainty import coverage_factor

if TYPE_CHECKING:
    from collections.abc import Iterable, Sequence

    from rigrunner.api.analysis import CompensatedPoint, SwingPoint
    from rigrunner.api.data import Array

ASYMMETRY = 0.05
GOOD_CYCLES = 10
SAMPLES_PER_CYCLE = 280
MISFIT = 2.0
SLOPE_SIGNIFICANCE = 0.99
SLOPE_EFFECT = 0.02
"""Of the mean torque, at the highest frequency: less does not matter, however significant."""


def symmetry(points: Sequence[CompensatedPoint], asymmetry: Sequence[float]) -> Check:
    """Check how far each stroke is from the mean of both, as a part of it."""
    bad = [
        f"{point.frequency_hz:.4g} Hz: {value:+.1%}"
        for point, value in zip(points, asymmetry, strict=True)
        if abs(value) > ASYMMETRY
    ]
    return _check(
        "symmetry of the strokes",
        bad,
        f"each stroke within {ASYMMETRY:.0%} of the mean of both",
        "look for a bent mandrel, a load off centre, or a clamp that yields to one side",
    )


def enough_cycles(points: Iterable[SwingPoint]) -> Check:
    """Check the number of cycles that entered the mean."""
    bad = [f"{p.recording}: {p.kept.sum()}" for p in points if p.kept.sum() < GOOD_CYCLES]
    return _check(
        "cycles", bad, f"at least {GOOD_CYCLES} cycles in every mean", "record more cycles"
    )


def fast_enough(points: Iterable[SwingPoint]) -> Check:
    """Check that the samples lie close enough to follow the friction at a reversal."""
    samples = [(p.recording, p.sample_rate_hz / p.frequency_hz.value) for p in points]
    bad = [f"{name}: {count:.0f}" for name, count in samples if count < SAMPLES_PER_CYCLE]
    return _check(
        "samples per cycle",
        bad,
        f"at least {SAMPLES_PER_CYCLE} samples in every cycle",
        "sample faster, or leave out the highest frequencies",
    )


def positive(points: Sequence[CompensatedPoint], running_nm: Sequence[float]) -> Check:
    """Check that the bearing takes up energy: a torque of 0 or less is impossible.

    `running_nm` is each point's mean torque under way: a swapped pair of runs has a peak above zero
    too, but gives energy back.
    """
    bad = [
        f"{point.frequency_hz:.4g} Hz: {min(point.torque.value, running):.3f} N·m"
        for point, running in zip(points, running_nm, strict=True)
        if min(point.torque.value, running) <= 0
    ]
    return _check(
        "torque above zero", bad, "all torques are positive", "was the no-load run really unloaded?"
    )


def understood(misfit: float) -> Check:
    """Check that the drive line's equations explain the no-load sweep."""
    text = f"the no-load torque differs from inertia, resonance and friction by {misfit:.1f} times"
    return Check(
        "drive line",
        ok=misfit <= MISFIT,
        text=f"{text} its scatter ({MISFIT:g} allowed)",
        advice="" if misfit <= MISFIT else "look for a loose coupling, or play in the guide",
    )


def same_inertia(points: Sequence[CompensatedPoint], u_nm: Array) -> Check:
    """Check that the torque does not grow with f^2, as a wrong inertia would make it.

    `u_nm` are the points' uncertainties without what they have in common, shape (n,).
    """
    squares = np.array([point.frequency_hz**2 for point in points])
    name, good = "inertia of both runs", "no part of the torque grows with frequency squared"
    if len(points) < 3 or np.ptp(squares) == 0:  # noqa: PLR2004  (a line leaves no residual)
        return Check(name, ok=True, text="too few frequencies to tell")
    slope, u = _slope(squares, np.array([point.torque.value for point in points]), u_nm)
    effect = slope * squares.max()
    limit = coverage_factor(len(points) - 2, SLOPE_SIGNIFICANCE) * u
    mean = float(np.mean([point.torque.value for point in points]))
    significant = abs(slope) > limit and abs(effect) > SLOPE_EFFECT * abs(mean)
    bad = [f"{effect:+.3f} N·m of it at the highest frequency"] if significant else []
    return _check(name, bad, good, "same mandrel, fixture and coupling in both runs?")


def _slope(x: Array, y: Array, u: Array) -> tuple[float, float]:
    """Return the slope of the weighted line and its uncertainty, from the scatter if larger."""
    weight = 1 / np.maximum(u, 1e-6) ** 2
    x_mean, y_mean = np.average(x, weights=weight), np.average(y, weights=weight)
    spread = np.sum(weight * (x - x_mean) ** 2)
    slope = np.sum(weight * (x - x_mean) * (y - y_mean)) / spread
    residual = y - y_mean - slope * (x - x_mean)
    variance = np.sum(weight * residual**2) / (len(x) - 2)
    return float(slope), float(np.sqrt(max(variance, 1.0) / spread))


def _check(name: str, bad: Sequence[str], good: str, advice: str) -> Check:
    return Check(name, not bad, "; ".join(bad) or good, advice if bad else "")
