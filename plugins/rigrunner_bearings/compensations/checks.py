"""Diagnostics of a sweep compensated by whole swings."""

from __future__ import annotations

from dataclasses import replace
from math import hypot, inf, sqrt
from typing import TYPE_CHECKING

import numpy as np
from scipy.special import chdtri

from rigrunner.api.analysis import Bias
from rigrunner.api.checks import ABOVE_ZERO, Limit, skipped
from rigrunner.signal.repeatability import effective_number
from rigrunner.signal.uncertainty import coverage_factor
from rigrunner_bearings.compensations.budget import LEARNED

if TYPE_CHECKING:
    from collections.abc import Iterable, Sequence

    from rigrunner.api import Array, Check
    from rigrunner_bearings.api.compensations import CompensatedPoint
    from rigrunner_bearings.api.points import SwingPoint
    from rigrunner_bearings.compensations.effects import BySpeed, Mismatch

SLOPE_SIGNIFICANCE = 0.99
GROWTH_SIGNIFICANCE = 0.998
"""Of both sides: a rig in order fails in one case of a thousand."""
REPEATABILITY = ("repeatability, loaded", "repeatability, no load")
"""Lines of the budget."""

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
    advice="are torque and angle of the right sign, and was the no-load run really unloaded?",
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
    good="nothing of the torque follows the acceleration: inertia and gain are alike in both",
    advice="same mandrel, fixture and coupling in both runs?",
    unit="1",
    upper=1.0,
)
UNDER_LOAD = Limit(
    name="drive line under load",
    good="the loaded run shows the same inertia, resonance and delay as the no-load run",
    advice="filters, sampling, cables, coupling and clamps the same in both runs? On rigs of "
    "other physics this differs without a fault: the other checks say what moves the torque",
    unit="1",
    upper=1.0,
)
GROWTH = Limit(
    name="torque that grows with speed",
    good="no torque grows with the speed of the swing by more than may be chance",
    advice="oil, grease or a seal of the support under load? the no-load run does not show it; nor "
    "can it be told from a bearing whose own friction grows",
    unit="1",
    upper=1.0,
)
BUILD_UP = Limit(
    name="build-up of the support's friction",
    good="at most 6 % of the torque may be the support's, or the station states what the support "
    "does under load",
    advice="a support whose friction builds up over a shorter way under load looks the same: "
    "measure it with a bearing of known friction",
    unit="%",
    upper=6.0,
)
BUILT_UP = 0.75
"""Of the support's dry friction: where so much is built up, the rest is no matter."""
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
    GROWTH,
    SPRING,
    BUILD_UP,
)


def independent_cycles(
    points: Sequence[CompensatedPoint], scattered_nm: Sequence[Iterable[Array]]
) -> Check:
    """Check that cycles which follow each other are more than a few independent ones.

    `scattered_nm` has for each point what every cycle of each of its runs moves the torque by, in
    the order of the cycles, shapes (cycles,). The uncertainty of a mean of correlated cycles is
    known only as well as their correlation is, and too few show too little of it: the mean may be
    off by as much as one cycle is.
    """
    counts = [
        (point, moved, number)
        for point, runs in zip(points, scattered_nm, strict=True)
        for moved in runs
        if (number := _effective_cycles(moved, point.torque.u)) < inf
    ]
    check = INDEPENDENT.check(
        (number, f"{point.frequency_hz:.4g} Hz: {number:.1f} of {len(moved)} cycles")
        for point, moved, number in counts
    )
    slow = [(point, moved) for point, moved, number in counts if number < INDEPENDENT.lower]
    biases = tuple(
        Bias(
            f"{point.frequency_hz:.4g} Hz",
            0.0,
            hypot(*(m.std(ddof=1) for p, m in slow if p is point)),
        )
        for point in points
    )
    return replace(check, biases=biases, common=False, covered_by=REPEATABILITY)


def _effective_cycles(moved_nm: Array, u_nm: float) -> float:
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


def drive_line(misfit: float, biases: tuple[Bias, ...]) -> Check:
    """Check that the drive line's equations explain the no-load sweep.

    `biases` are what the torques differ by as each half of the frequencies shows the drive line.
    """
    words = f"the no-load torque differs from inertia, resonance and friction by {misfit:.1f} times"
    check = DRIVE_LINE.check([(misfit, f"{words} its scatter")])
    return replace(check, biases=biases, covered_by=(LEARNED,))


def delay(delay_s: float) -> Check:
    """Check that torque and angle belong to the same instant, in s."""
    delay_ms = 1000 * abs(delay_s)
    return DELAY.check([(delay_ms, f"{delay_ms:.2f} ms between torque and angle")])


def coupling(natural_hz: float, reference_hz: float | None) -> Check:
    """Check that the resonance has not come down from that of the rig in order, in Hz."""
    if reference_hz is None:
        return skipped(COUPLING.name, "the station's rig states no natural_frequency")
    percent = 100 * natural_hz / reference_hz
    words = f"resonance at {natural_hz:.0f} Hz, {percent:.0f} % of the {reference_hz:g} Hz in order"
    return COUPLING.check([(percent, words)])


def sampling(points: Iterable[SwingPoint], natural_hz: float) -> Check:
    """Check that the samples lie close enough to show the drive line's resonance."""
    rates = {point.recording: point.sample_rate_hz / natural_hz for point in points}
    return SAMPLING.check((rate, f"{name}: {rate:.1f}") for name, rate in rates.items())


def same_inertia(points: Sequence[CompensatedPoint], mismatches: Sequence[Mismatch]) -> Check:
    """Check that no inertia, and no gain, differs between the two runs.

    What is elastic in the torque is the same at all frequencies, and is taken out. What the points
    share enters all of them, what each recording has of its own enters its point: a mean of random
    effects, each point drawn to it by as much as its own scatter is greater than theirs
    (DerSimonian and Laird, Control. Clin. Trials 7, 1986, 177). Whether it is the inertia's or the
    gain's is not known: the bias is the mean of both, and their difference is in its uncertainty.
    """
    hertz = np.array([point.frequency_hz for point in points])
    if len(points) < 4 or np.ptp(hertz) == 0:  # noqa: PLR2004  (two unknowns, and what is chance)
        return skipped(INERTIA.name, "too few frequencies to tell")
    value, u, inertia, gain = (
        np.array([getattr(mismatch, name) for mismatch in mismatches])
        for name in ("value", "u", "by_inertia_nm", "by_gain_nm")
    )
    elastic = (hertz.max() / hertz) ** 2
    common, u_common, by_point, u_by_point, chance = _random_effects(value, u, elastic)
    bias = by_point * (inertia + gain) / 2
    u_bias = np.hypot(u_by_point * np.maximum(inertia, gain), by_point * (inertia - gain) / 2)
    allowed = coverage_factor(len(points) - 2, SLOPE_SIGNIFICANCE) * u_common
    words = f"{common:+.2%} of the inertia's torque is left, {allowed:.2%} may be chance"
    check = INERTIA.check([(max(abs(common) / allowed, chance), words)])
    return replace(
        check,
        biases=tuple(
            Bias(f"{point.frequency_hz:.4g} Hz", float(b), float(du))
            for point, b, du in zip(points, bias, u_bias, strict=True)
        ),
        covered_by=("gain and inertia between the runs",),
    )


def _random_effects(
    value: Array, u: Array, elastic: Array
) -> tuple[float, float, Array, Array, float]:
    """Return common value and its u, each one's and its u, and chi-squared over its 99 %.

    `elastic` is what a torque that is the same at all points makes of each value, but for its size.
    """
    design = np.stack([np.ones_like(value), elastic], axis=1)
    weight = u**-2
    normal = np.linalg.inv(design.T @ (weight[:, None] * design))
    residual = value - design @ (normal @ (design.T @ (weight * value)))
    excess, dof = float(weight @ residual**2), len(value) - 2
    spent = float(np.trace(normal @ (design.T @ ((weight**2)[:, None] * design))))
    between = max(excess - dof, 0.0) / (float(weight.sum()) - spent)
    weight = 1 / (u**2 + between)
    normal = np.linalg.inv(design.T @ (weight[:, None] * design))
    coefficients = normal @ (design.T @ (weight * value))
    common, u_common = float(coefficients[0]), float(np.sqrt(normal[0, 0]))
    trust = between / (u**2 + between)
    by_point = common + trust * (value - design @ coefficients)
    u_by_point = np.sqrt(trust * u**2 + ((1 - trust) * u_common) ** 2)
    chance = excess / float(chdtri(dof, 1 - SLOPE_SIGNIFICANCE))
    return common, u_common, by_point, u_by_point, chance


def no_growth(points: Sequence[CompensatedPoint], by_speed: Sequence[BySpeed]) -> Check:
    """Check that no torque grows with the speed, as a viscous support under load makes it.

    It cannot be distinguished from a bearing whose friction grows. By the line over the frequencies
    from a quarter of the highest: below, friction that falls with speed does so the most.
    """
    hertz = np.array([point.frequency_hz for point in points])
    fast = hertz >= hertz.max() / 4
    if len(set(hertz[fast])) < 4:  # noqa: PLR2004  (a line leaves two degrees of freedom)
        return skipped(GROWTH.name, "too few frequencies to tell")
    ratio = np.array([speed.at_start for speed in by_speed])
    ways = (
        (np.array([speed.running_nm for speed in by_speed]), ratio),
        (np.array([point.torque.value for point in points]), np.ones_like(ratio)),
    )
    lines = [(*_line(hertz[fast], torque[fast]), scale) for torque, scale in ways]
    slope, u, scale = max(lines, key=lambda line: line[0] / line[1])
    allowed = coverage_factor(int(fast.sum()) - 2, GROWTH_SIGNIFICANCE) * u
    words = f"{slope * hertz.max():+.3f} N·m at {hertz.max():.4g} Hz"
    check = GROWTH.check([(max(slope, 0.0) / allowed, words)])
    return replace(
        check,
        biases=tuple(
            Bias(f"{f:.4g} Hz", float(slope * f * s), float(u * f * s))
            for f, s in zip(hertz, scale, strict=True)
        ),
    )


def support_has_built_up(
    points: Sequence[CompensatedPoint],
    frictions_nm: Sequence[tuple[float, float]],
    running_nm: Sequence[float],
) -> Check:
    """Check that the torque is read where the support's friction is built up.

    `frictions_nm` has what is built up of it at each point, and all of it. If under load it builds
    up over a shorter way, the torque is too great, by no more than what was not built up; nor by
    more than the running torque is less, which does not depend on the way. Anything between
    nothing and that: the middle, and half of it over the square root of 3 (GUM 4.3.7).
    """
    share = float(np.mean([built_up / full if full else 1.0 for built_up, full in frictions_nm]))
    most = [
        max(min(full - built_up, point.torque.value - running), 0.0) if share < BUILT_UP else 0.0
        for point, (built_up, full), running in zip(points, frictions_nm, running_nm, strict=True)
    ]
    torque = float(np.mean([point.torque.value for point in points]))
    percent = 100 * float(np.mean(most)) / torque if torque > 0 else 0.0
    words = f"{percent:.1f} % of the torque; {share:.0%} of the support's friction is built up"
    check = BUILD_UP.check([(percent, words)])
    return replace(
        check,
        biases=tuple(
            Bias(f"{point.frequency_hz:.4g} Hz", nm / 2, nm / sqrt(12))
            for point, nm in zip(points, most, strict=True)
        ),
    )


def _line(x: Array, y: Array) -> tuple[float, float]:
    """Return the slope of a line and its uncertainty by the scatter about it."""
    share = (x - x.mean()) / np.sum((x - x.mean()) ** 2)
    slope = float(share @ y)
    residual = y - y.mean() - slope * (x - x.mean())
    return slope, float(np.sqrt(residual @ residual / (len(x) - 2) * (share @ share)))


def same_drive_line(
    points: Sequence[CompensatedPoint], effects: Sequence[tuple[float, float]]
) -> Check:
    """Check that the drive line which the loaded sweep shows gives the same torque.

    `effects` has for each point the change of the torque by it, and its uncertainty, in N·m;
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
    """Check that the torque does not follow the angle: its median over the points, of the mean.

    At a reversal a spring pulls against the friction that begins: that is missing in the torque.
    """
    torque, spring = float(np.mean([p.torque.value for p in points])), float(np.median(spring_nm))
    percent = 100 * abs(spring / torque) if torque else inf
    u = float(np.median(np.abs(np.asarray(spring_nm) - spring)))
    check = SPRING.check([(percent, f"{spring:+.3f} N·m of it at the swing's ends")])
    biases = tuple(Bias(f"{point.frequency_hz:.4g} Hz", -spring, u) for point in points)
    return replace(check, biases=biases)
