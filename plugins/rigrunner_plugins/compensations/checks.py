"""Diagnostics of a sweep compensated by whole swings."""

from __future__ import annotations

from math import inf
from typing import TYPE_CHECKING

import numpy as np

from rigrunner.api.checks import ABOVE_ZERO, Limit, skipped
from rigrunner.signal.repeatability import effective_number
from rigrunner.signal.uncertainty import coverage_factor

if TYPE_CHECKING:
    from collections.abc import Iterable, Sequence

    from rigrunner.api.analysis import Check, CompensatedPoint, SwingPoint
    from rigrunner.api.data import Array

SLOPE_SIGNIFICANCE = 0.99
SLOPE_EFFECT = 0.02
"""Of the mean torque, at the highest frequency: less does not matter, however significant."""
WEIGHT_FLOOR = 0.003
"""Of the mean torque; or slow points, which scatter less than the method errs, decide alone."""

CLEARLY = 0.001
"""Chance that independent cycles are taken for correlated ones, one point at a time."""
MATTERS = 1 / 3
"""Of a torque's u: cycles that scatter by less cannot make it too small, however correlated."""

INDEPENDENT = Limit(
    name="independent cycles",
    good="every mean is of as many as 5 cycles that are independent of each other",
    advice="let speed, load and temperature settle, and record longer: what changes as slowly as "
    "this shows no mean, and its uncertainty is too small",
    unit="1",
    lower=5.0,
    decisive=True,
)
SYMMETRY = Limit(
    name="symmetry of the strokes",
    good="each stroke within 5 % of the mean of both",
    advice="look for a bent mandrel, a load off centre, or a clamp that yields to one side",
    unit="%",
    upper=5.0,
)
POSITIVE = Limit(
    name="torque above zero",
    good="all torques are positive",
    advice="was the no-load run really unloaded?",
    unit="N·m",
    lower=ABOVE_ZERO,
    decisive=True,
)
DRIVE_LINE = Limit(
    name="drive line",
    good="inertia, resonance and friction explain the no-load torque within its scatter",
    advice="look for play in the guide or the coupling, and for a filter not as registered",
    unit="1",
    upper=1.0,
)
DELAY = Limit(
    name="delay of the torque",
    good="the torque lags behind the angle by less than 0.15 ms, less the registered filter",
    advice="is low_pass in the register right, and are both channels sampled at the same time?",
    unit="ms",
    upper=0.15,
)
COUPLING = Limit(
    name="coupling",
    good="the resonance is at least 90 % of the station's natural_frequency",
    advice="tighten coupling and clamps; if the rig was rebuilt, correct the station",
    unit="%",
    lower=90.0,
)
SAMPLING = Limit(
    name="sampling of the resonance",
    good="at least 25 samples per period of the resonance",
    advice="sample faster",
    unit="1",
    lower=25.0,
)
INERTIA = Limit(
    name="inertia of both runs",
    good="no part of the torque grows with frequency squared",
    advice="same mandrel, fixture and coupling in both runs?",
    unit="1",
    upper=1.0,
)
UNDER_LOAD = Limit(
    name="drive line under load",
    good="the loaded run shows the same inertia, resonance and delay as the no-load run",
    advice="filters, sampling, cables, coupling and clamps the same in both runs? The torque is "
    "wrong by about as much as this, and its uncertainty does not say so",
    unit="1",
    upper=1.0,
)
SPRING = Limit(
    name="torque that follows the angle",
    good="what is elastic in it comes to at most 5 % of the torque",
    advice="is the load off the swing's axis, or does a cable or hose pull? friction does not "
    "follow the angle, and what does is in the starting torque",
    unit="%",
    upper=5.0,
)
LIMITS = (
    INDEPENDENT,
    SYMMETRY,
    POSITIVE,
    DRIVE_LINE,
    DELAY,
    COUPLING,
    SAMPLING,
    INERTIA,
    UNDER_LOAD,
    SPRING,
)


def independent(
    points: Sequence[CompensatedPoint], scattered_nm: Sequence[Iterable[Array]]
) -> Check:
    """Check that cycles which follow each other are more than a few independent ones.

    `scattered_nm` has for each point what every cycle of each of its runs moves the torque by, in
    the order of the cycles, shapes (cycles,). The uncertainty of a mean of correlated cycles is
    known only as well as their correlation is, and too few show too little of it.
    """
    return INDEPENDENT.check(
        (number, f"{point.frequency_hz:.4g} Hz: {number:.1f} of {len(moved)} cycles")
        for point, runs in zip(points, scattered_nm, strict=True)
        for moved in runs
        if (number := _independent(moved, point.torque.u)) < inf
    )


def _independent(moved_nm: Array, u_nm: float) -> float:
    """Return the effective number of cycles; infinite where their scatter does not matter."""
    if moved_nm.std() < MATTERS * u_nm:
        return inf
    return effective_number(moved_nm, CLEARLY)


def symmetry(points: Sequence[CompensatedPoint], asymmetry: Sequence[float]) -> Check:
    """Check how far each stroke is from the mean of both, as a part of it."""
    return SYMMETRY.check(
        (100 * abs(value), f"{point.frequency_hz:.4g} Hz: {value:+.1%}")
        for point, value in zip(points, asymmetry, strict=True)
    )


def positive(points: Sequence[CompensatedPoint], running_nm: Sequence[float]) -> Check:
    """Check that the bearing takes up energy: a torque of 0 or less is impossible.

    `running_nm` is each point's mean torque under way: a swapped pair of runs has a peak above zero
    too, but gives energy back.
    """
    least = [min(p.torque.value, running) for p, running in zip(points, running_nm, strict=True)]
    return POSITIVE.check(
        (value, f"{point.frequency_hz:.4g} Hz: {value:.3f} N·m")
        for point, value in zip(points, least, strict=True)
    )


def understood(misfit: float) -> Check:
    """Check that the drive line's equations explain the no-load sweep."""
    words = f"the no-load torque differs from inertia, resonance and friction by {misfit:.1f} times"
    return DRIVE_LINE.check([(misfit, f"{words} its scatter")])


def simultaneous(delay_s: float) -> Check:
    """Check that torque and angle belong to the same instant, in s."""
    delay_ms = 1000 * abs(delay_s)
    return DELAY.check([(delay_ms, f"{delay_ms:.2f} ms between torque and angle")])


def tight(natural_hz: float, reference_hz: float | None) -> Check:
    """Check that the resonance has not come down from that of the rig in order, in Hz."""
    if reference_hz is None:
        return skipped(COUPLING.name, "the station's rig states no natural_frequency")
    percent = 100 * natural_hz / reference_hz
    words = f"resonance at {natural_hz:.0f} Hz, {percent:.0f} % of the {reference_hz:g} Hz in order"
    return COUPLING.check([(percent, words)])


def follows_resonance(points: Iterable[SwingPoint], natural_hz: float) -> Check:
    """Check that the samples lie close enough to show the drive line's resonance."""
    rates = {point.recording: point.sample_rate_hz / natural_hz for point in points}
    return SAMPLING.check((rate, f"{name}: {rate:.1f}") for name, rate in rates.items())


def same_inertia(points: Sequence[CompensatedPoint], u_nm: Array) -> Check:
    """Check that the torque does not grow with f^2, as a wrong inertia would make it.

    `u_nm` are the points' uncertainties without what they have in common, shape (n,).
    """
    squares = np.array([point.frequency_hz**2 for point in points])
    if len(points) < 3 or np.ptp(squares) == 0:  # noqa: PLR2004  (a line leaves no residual)
        return skipped(INERTIA.name, "too few frequencies to tell")
    torques = np.array([point.torque.value for point in points])
    slope, u = _slope(squares, torques, u_nm)
    effect = slope * squares.max()
    chance = coverage_factor(len(points) - 2, SLOPE_SIGNIFICANCE) * u * squares.max()
    allowed = max(chance, SLOPE_EFFECT * abs(float(torques.mean())))
    words = f"{effect:+.3f} N·m of it at the highest frequency, {allowed:.3f} N·m may be chance"
    return INERTIA.check([(abs(effect) / allowed, words)])


def same_drive_line(
    points: Sequence[CompensatedPoint], effects: Sequence[tuple[float, float]]
) -> Check:
    """Check that the drive line which the loaded sweep shows gives the same torque.

    `effects` has for each point what it makes of the torque, and the uncertainty of that, in N·m;
    it is empty where the loaded sweep shows too little.
    """
    if not effects:
        return skipped(
            UNDER_LOAD.name, "too few frequencies to tell, or too little known of the phase"
        )
    sure = coverage_factor(inf, SLOPE_SIGNIFICANCE)
    allowed = [max(sure * u, p.torque.u) for p, (_, u) in zip(points, effects, strict=True)]
    return UNDER_LOAD.check(
        (
            abs(effect) / allow,
            f"{point.frequency_hz:.4g} Hz: {effect:+.3f} N·m, {allow:.3f} N·m may be chance",
        )
        for point, (effect, _), allow in zip(points, effects, allowed, strict=True)
    )


def no_spring(points: Sequence[CompensatedPoint], spring_nm: Sequence[float]) -> Check:
    """Check that the torque does not follow the angle: its median over the points, of the mean."""
    torque, found = float(np.mean([p.torque.value for p in points])), float(np.median(spring_nm))
    percent = 100 * abs(found / torque) if torque else inf
    return SPRING.check([(percent, f"{found:+.3f} N·m of it at the swing's ends")])


def _slope(x: Array, y: Array, u: Array) -> tuple[float, float]:
    """Return the slope of the weighted line and its uncertainty, from the scatter if larger."""
    weight = 1 / np.maximum(u, WEIGHT_FLOOR * abs(y.mean())) ** 2
    x_mean, y_mean = np.average(x, weights=weight), np.average(y, weights=weight)
    share = weight * (x - x_mean) / np.sum(weight * (x - x_mean) ** 2)
    slope = share @ y
    residual = y - y_mean - slope * (x - x_mean)
    scatter = np.sum(weight * residual**2) / (len(x) - 2)
    return float(slope), float(np.sqrt(max(share**2 @ u**2, scatter * np.sum(share**2 / weight))))
