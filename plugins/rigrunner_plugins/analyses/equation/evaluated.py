"""A result of a model, with the model and its Monte Carlo trials."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property
from math import isnan, nan
from typing import TYPE_CHECKING

import numpy as np

from rigrunner.api import Effect as ToFirstOrder
from rigrunner.api.uncertainty import Corrected
from rigrunner.signal.coverage import expanded
from rigrunner.signal.monte_carlo.intervals import symmetric
from rigrunner.signal.monte_carlo.model import output_of
from rigrunner.signal.propagation import sensitivities

if TYPE_CHECKING:
    from collections.abc import Sequence

    from rigrunner.api import MeasurementModel, MeasurementResult

TRIALS = 50_000
SEED = 1
MOST_TRIED = 30
"""Most places checked by Monte Carlo, spread evenly over all places."""


@dataclass(frozen=True, eq=False)
class Trial:
    """What the Monte Carlo trials of one result show."""

    mean: float
    u: float
    low: float
    high: float
    coverage: float
    """The share of trials within y ± U."""
    coverage_if_linear: float
    """The same share for the model's tangent; the difference to `coverage` is due to curvature."""
    lost: int
    """The number of trials that gave no finite number."""


@dataclass(frozen=True, eq=False)
class Evaluated:
    """A result, its model and its Monte Carlo trials."""

    result: MeasurementResult
    model: MeasurementModel
    first_order_u: float
    added: float
    """Variance added by the second-order terms, in the result's unit squared."""

    @cached_property
    def trial(self) -> Trial | None:
        """The Monte Carlo trials; None if an uncertainty is unknown or zero."""
        estimate = self.result.estimate
        if isnan(estimate.u) or not estimate.u:
            return None
        values, straight = (
            # One seed for both: the same draws leave the curvature as their only difference.
            output_of(model)(np.random.default_rng(SEED), TRIALS)
            for model in (self.model, self._tangent)
        )
        good = np.sort(values[np.isfinite(values)])
        expanded_u = expanded(estimate)
        if len(good) < TRIALS / 2:  # most are lost: the others show no interval
            coverage = float(np.mean(np.abs(straight - estimate.value) <= expanded_u))
            return Trial(nan, nan, nan, nan, 0.0, coverage, TRIALS - len(good))
        interval = symmetric(good, 0.95)
        return Trial(
            mean=float(good.mean()),
            u=float(good.std(ddof=1)),
            low=interval.low,
            high=interval.high,
            coverage=float(np.sum(np.abs(good - estimate.value) <= expanded_u)) / TRIALS,
            coverage_if_linear=float(np.mean(np.abs(straight - estimate.value) <= expanded_u)),
            lost=TRIALS - len(good),
        )

    @property
    def _tangent(self) -> MeasurementModel:
        """The first-order model of the same inputs."""
        slopes = sensitivities(self.model)
        effects = tuple(
            ToFirstOrder(input_, float(c))
            for input_, c in zip(self.model.inputs, slopes, strict=True)
        )
        return replace(self.model, equation=Corrected(self.model.value, effects))


def names_of(results: Sequence[Evaluated]) -> list[str]:
    """Return the names of results without repetition."""
    return list(dict.fromkeys(evaluated.result.name for evaluated in results))


def to_try(results: Sequence[Evaluated]) -> list[Evaluated]:
    """Return the results to check by Monte Carlo: all, or some spread evenly."""
    if len(results) <= MOST_TRIED:
        return list(results)
    places = np.linspace(0, len(results) - 1, MOST_TRIED).round().astype(int)
    return [results[place] for place in places]
