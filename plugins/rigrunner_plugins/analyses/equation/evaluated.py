"""A result of a model, the model it follows from, and what trials of the model say of it."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property
from math import isnan
from typing import TYPE_CHECKING

import numpy as np

from rigrunner.api import DataError
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
"""So many places are tried by Monte Carlo, spread evenly over all."""


@dataclass(frozen=True, eq=False)
class Trial:
    """What the trials of one result say."""

    mean: float
    u: float
    low: float
    high: float
    held: float
    """Which share of them is within y ± U."""
    held_if_straight: float
    """The same of the model's tangent: what it is less comes from the model's curvature."""
    lost: int
    """How many gave no number."""


@dataclass(frozen=True, eq=False)
class Evaluated:
    """A result, the model that it follows from, and what trials of it say."""

    result: MeasurementResult
    model: MeasurementModel
    first_order_u: float
    added: float
    """Variance that the terms of second order add, in the unit of the result, squared."""

    @cached_property
    def trial(self) -> Trial | None:
        """By Monte Carlo; None where an uncertainty is unknown, or there is none."""
        estimate = self.result.estimate
        if isnan(estimate.u) or not estimate.u:
            return None
        values, straight = (
            output_of(model)(np.random.default_rng(SEED), TRIALS)
            for model in (self.model, self._tangent)
        )
        good = np.sort(values[np.isfinite(values)])
        if len(good) < TRIALS / 2:
            raise DataError(f"the model of {self.result.name} has no value in most of its trials")
        interval = symmetric(good, 0.95)
        reach = expanded(estimate)
        return Trial(
            mean=float(good.mean()),
            u=float(good.std(ddof=1)),
            low=interval.low,
            high=interval.high,
            held=float(np.sum(np.abs(good - estimate.value) <= reach)) / TRIALS,
            held_if_straight=float(np.mean(np.abs(straight - estimate.value) <= reach)),
            lost=TRIALS - len(good),
        )

    @property
    def _tangent(self) -> MeasurementModel:
        """The model of first order, of the same inputs."""
        slopes = sensitivities(self.model)
        effects = tuple(
            ToFirstOrder(each, float(c)) for each, c in zip(self.model.inputs, slopes, strict=True)
        )
        return replace(self.model, equation=Corrected(self.model.value, effects))


def names_of(found: Sequence[Evaluated]) -> list[str]:
    """Return the names of results, each once."""
    return list(dict.fromkeys(each.result.name for each in found))


def tried(found: Sequence[Evaluated]) -> list[Evaluated]:
    """Return the results that are tried by Monte Carlo: all, or some that are spread evenly."""
    if len(found) <= MOST_TRIED:
        return list(found)
    places = np.linspace(0, len(found) - 1, MOST_TRIED).round().astype(int)
    return [found[place] for place in places]
