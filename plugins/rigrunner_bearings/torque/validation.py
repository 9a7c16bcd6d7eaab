"""Validates the GUM's result by Monte Carlo: of the measurement equation, and of the pipeline.

The trials of the equation show what the law of propagation neglects: distributions that are not
Gaussian, an equation that is not linear. The draws of the recorded data also show whether the
budget states what its errors do to the torque.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
import scipy

from rigrunner.signal.monte_carlo.adaptive import Adaptive, propagate
from rigrunner.signal.monte_carlo.agreement import difference, gum_interval, tolerance
from rigrunner.signal.monte_carlo.intervals import Interval, symmetric
from rigrunner.signal.monte_carlo.model import output_of
from rigrunner_bearings.api.validation import Agreement, EquationTrials, PipelineDraws, Validation
from rigrunner_bearings.signal.mean_model import mean_model
from rigrunner_bearings.torque.draws import draw_pipeline

if TYPE_CHECKING:
    from collections.abc import Callable, Sequence

    from rigrunner.api import Array, Estimate
    from rigrunner.signal.monte_carlo.adaptive import Propagated
    from rigrunner_bearings.api.compensations import CompensatedPoint, CompensationMethod, Sweep
    from rigrunner_bearings.torque.settings import MonteCarloSpec

P = 0.95
CONFIDENCE = 0.999
"""Confidence that an end of an interval does not disagree by the chance of the draws alone."""

TRIALS, DRAWS = "Monte Carlo trials", "Monte Carlo draws"


def validate(
    method: CompensationMethod,
    sweep: Sweep,
    points: Sequence[CompensatedPoint],
    headline: Estimate,
    *,
    name: str,
    spec: MonteCarloSpec,
    zeroed: bool,
    progress: Callable[[str, int, int], None],
) -> Validation:
    """Return both checks of a method's points and of their mean, the headline.

    The same settings give the same numbers. Raises DataError where the model or the method does.
    """
    drawn = draw_pipeline(
        method,
        sweep,
        points,
        zeroed=zeroed,
        draws=spec.draws,
        seed=spec.seed,
        progress=lambda done, of: progress(DRAWS, done, of),
    )
    return Validation(
        method=name,
        digits=spec.digits,
        seed=spec.seed,
        equation=_equation(points, headline, spec, progress),
        pipeline=PipelineDraws(
            mean=_by_draws(None, headline, drawn.torque_nm.mean(axis=1), spec.digits),
            points=tuple(
                _by_draws(point.set_frequency_hz, point.torque, torques, spec.digits)
                for point, torques in zip(points, drawn.torque_nm.T, strict=True)
            ),
            draws=len(drawn.torque_nm),
            refused=drawn.refused,
            through_the_data=drawn.through_the_data,
            as_effects=drawn.as_effects,
        ),
    )


def _equation(
    points: Sequence[CompensatedPoint],
    headline: Estimate,
    spec: MonteCarloSpec,
    progress: Callable[[str, int, int], None],
) -> EquationTrials:
    adaptive = Adaptive(
        digits=spec.digits,
        least_trials=spec.trials,
        most_trials=max(spec.most_trials, spec.trials),
        p=P,
        seed=spec.seed,
    )
    groups = [tuple(points), *((point,) for point in points)]
    propagated: list[Propagated] = []
    for done, group in enumerate(groups, 1):
        propagated.append(propagate(output_of(mean_model(group)), adaptive))
        progress(TRIALS, done, len(groups))
    return EquationTrials(
        mean=_by_trials(None, headline, propagated[0], spec.digits),
        points=tuple(
            _by_trials(point.set_frequency_hz, point.torque, trials, spec.digits)
            for point, trials in zip(points, propagated[1:], strict=True)
        ),
        trials=max(trials.trials for trials in propagated),
        stable=all(trials.stable for trials in propagated),
    )


def _by_trials(
    set_frequency_hz: float | None, gum: Estimate, propagated: Propagated, digits: int
) -> Agreement:
    """Return the comparison of JCGM 101:2008, 8.1.3."""
    interval, allowed = gum_interval(gum, P), tolerance(gum, digits)
    return Agreement(
        set_frequency_hz=set_frequency_hz,
        gum=gum,
        gum_low=interval.low,
        gum_high=interval.high,
        mean=propagated.mean,
        u=propagated.u,
        low=propagated.symmetric.low,
        high=propagated.symmetric.high,
        tolerance=allowed,
        resolution=allowed / 5,
        agrees=difference(interval, propagated.symmetric).within(allowed),
    )


def _by_draws(
    set_frequency_hz: float | None, gum: Estimate, torques_nm: Array, digits: int
) -> Agreement:
    """Return the comparison with few draws: each end within what their number leaves open.

    An end agrees if the GUM's lies in the distribution-free confidence interval of the draws'
    quantile (order statistics: David and Nagaraja, Order Statistics, 7.1), widened by the
    numerical tolerance.
    """
    ordered, allowed = np.sort(torques_nm), tolerance(gum, digits)
    interval, drawn_interval = gum_interval(gum, P), symmetric(ordered, P)
    low, high = (_quantile_interval(ordered, share) for share in ((1 - P) / 2, (1 + P) / 2))
    return Agreement(
        set_frequency_hz=set_frequency_hz,
        gum=gum,
        gum_low=interval.low,
        gum_high=interval.high,
        mean=float(ordered.mean()),
        u=float(ordered.std(ddof=1)),
        low=drawn_interval.low,
        high=drawn_interval.high,
        tolerance=allowed,
        resolution=max(low.high - low.low, high.high - high.low) / 2,
        agrees=_within(interval.low, low, allowed) and _within(interval.high, high, allowed),
    )


def _quantile_interval(ordered: Array, share: float) -> Interval:
    """Return between which of the ordered draws their quantile lies, at the confidence."""
    n = len(ordered)
    below = int(scipy.stats.binom.ppf((1 - CONFIDENCE) / 2, n, share))
    above = int(scipy.stats.binom.ppf((1 + CONFIDENCE) / 2, n, share))
    return Interval(float(ordered[max(below - 1, 0)]), float(ordered[min(above, n - 1)]))


def _within(value: float, interval: Interval, tolerance_nm: float) -> bool:
    return interval.low - tolerance_nm <= value <= interval.high + tolerance_nm
